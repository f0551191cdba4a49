//! How a reference that is rendered is shown. In a pipe: not at all.

use std::io::{self, IsTerminal};

use indicatif::{ProgressBar, ProgressStyle};

use crate::cli::interrupt;
use crate::cli::progress::{percent, time};
use crate::experiment::{Observer, RunId, Standing};
use crate::report::cut;

/// A bar on stderr, where that is a terminal.
pub(super) struct Bar(ProgressBar);

impl Bar {
    pub(super) fn new() -> Self {
        let bar = if io::stderr().is_terminal() { ProgressBar::new(1000) } else { ProgressBar::hidden() };
        let style = ProgressStyle::with_template("{prefix} [{bar:16}] {msg}");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "));
        Self(bar)
    }

    /// Takes the bar away.
    pub(super) fn close(&self) {
        self.0.finish_and_clear();
    }
}

impl Observer for Bar {
    fn begin(&mut self, run: &RunId) {
        self.0.set_prefix(cut(&run.scene, 20));
        self.0.set_message(run.method.clone());
    }

    fn progress(&mut self, standing: &Standing) {
        let noise = standing.noise.map_or_else(String::new, |noise| format!(", noise {}", percent(noise)));
        let left = standing.seconds_left.map_or_else(String::new, |left| format!(", {} left", time(left)));
        self.0.set_position((1000.0 * standing.share.clamp(0.0, 1.0)) as u64);
        self.0.set_message(format!("{} spp, {}{noise}{left}", standing.spp, time(standing.seconds)));
    }

    fn stopped(&self) -> bool {
        interrupt::requested()
    }
}
