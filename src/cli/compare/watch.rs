//! How an experiment that runs is shown.

use std::io::{self, IsTerminal, Write};
use std::time::Instant;

use indicatif::{ProgressBar, ProgressStyle};

use crate::cli::progress::{percent, time};
use crate::cli::{complain, interrupt};
use crate::experiment::{Budget, Observer, RunId, Standing, Unfinished};
use crate::report::Row;

/// Shows a bar in a terminal, and in a pipe a line for each finished run.
pub(in crate::cli) struct Watch {
    bar: ProgressBar,
    budget: Budget,
    run: Option<(RunId, Instant)>,
    rmse: Option<f64>,
    /// Wall-clock time of all finished runs \[s\].
    spent: f64,
    finished: u32,
}

impl Watch {
    pub(in crate::cli) fn new(budget: Budget) -> Self {
        let bar = if io::stderr().is_terminal() { ProgressBar::new(1000) } else { ProgressBar::hidden() };
        let style = ProgressStyle::with_template("[{bar:16}] {msg}").unwrap_or_else(|_| ProgressStyle::default_bar());
        bar.set_style(style.progress_chars("=> "));
        Self { bar, budget, run: None, rmse: None, spent: 0.0, finished: 0 }
    }

    fn end(&mut self) {
        if let Some((_, start)) = self.run.take() {
            self.spent += start.elapsed().as_secs_f64();
            self.finished += 1;
        }
    }

    /// Takes the bar away.
    pub(in crate::cli) fn close(&self) {
        self.bar.finish_and_clear();
    }

    fn tell(&self, line: &str) {
        if self.bar.is_hidden() {
            let _ = writeln!(io::stderr(), "{line}");
        }
    }

    /// For this run and all that follow \[s\].
    fn seconds_left(&self, run: &RunId, standing: &Standing) -> f64 {
        let of_a_run = match self.budget.seconds() {
            Some(seconds) => seconds,
            None if self.finished > 0 => self.spent / f64::from(self.finished),
            None => standing.seconds / standing.share,
        };
        of_a_run * ((1.0 - standing.share).max(0.0) + (run.of - run.number) as f64)
    }
}

fn title(run: &RunId) -> String {
    format!("{}/{} {} {} seed {}", run.number, run.of, run.scene, run.method, run.seed)
}

impl Observer for Watch {
    fn kept(&mut self, finished: usize) {
        if finished > 0 {
            let runs = if finished == 1 { "run is" } else { "runs are" };
            complain("note", &format!("{finished} {runs} there already"));
        }
    }

    fn begin(&mut self, run: &RunId) {
        self.run = Some((run.clone(), Instant::now()));
        self.rmse = None;
        self.bar.set_position(1000 * (run.number as u64 - 1) / run.of as u64);
        self.bar.set_message(title(run));
    }

    fn progress(&mut self, standing: &Standing) {
        let Some((run, _)) = &self.run else { return };
        if self.bar.is_hidden() {
            return;
        }
        let done = (run.number as f64 - 1.0 + standing.share.clamp(0.0, 1.0)) / run.of as f64;
        self.bar.set_position((1000.0 * done) as u64);
        let rmse = standing.rmse.map_or_else(String::new, |rmse| format!(", RMSE {rmse:.2e}"));
        let noise = standing.noise.map_or_else(String::new, |noise| format!(", noise {}", percent(noise)));
        let left = time(standing.seconds_left.unwrap_or_else(|| self.seconds_left(run, standing)));
        self.bar.set_message(format!("{}: {} spp{rmse}{noise}, {left} left", title(run), standing.spp));
    }

    fn finished(&mut self, run: &RunId, row: &Row) {
        self.end();
        let rmse = row.rmse.map_or_else(String::new, |rmse| format!(", RMSE {rmse:.3e}"));
        self.tell(&format!("{}: {} spp in {:.2} s{rmse}", title(run), row.spp, row.render_seconds));
    }

    fn unfinished(&mut self, run: &RunId, why: &Unfinished) {
        self.end();
        let (what, why) = match why {
            Unfinished::Unsupported(why) => ("is skipped", why),
            Unfinished::Failed(why) => ("failed", why),
        };
        self.bar.suspend(|| complain("note", &format!("{}: {} {what}: {why}", run.scene, run.method)));
    }

    fn stopped(&self) -> bool {
        interrupt::requested()
    }
}
