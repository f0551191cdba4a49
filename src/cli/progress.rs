//! What a render shows while it runs. In a pipe: nothing.

use std::io::{self, IsTerminal, Write};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::film::Film;

/// The noise of a whole image takes a look at every pixel, so it is not computed more often.
const NOISE_INTERVAL: Duration = Duration::from_secs(1);

/// Where a render stands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Standing {
    /// Share of the budget that is spent, 0 … 1.
    pub share: f64,
    /// Rendering time left, as far as can be told \[s\].
    pub seconds_left: f64,
    /// Speed of this run \[1/s\].
    pub samples_per_second: f64,
    /// Speed of this run \[1/s\].
    pub rays_per_second: f64,
}

/// A progress bar on stderr, where that is a terminal.
pub(crate) struct Progress {
    bar: ProgressBar,
    noise: Option<f64>,
    noise_of: Option<Instant>,
}

impl Progress {
    /// For something called `name`.
    pub(crate) fn new(name: &str) -> Self {
        const STEPS: u64 = 1000;
        let bar = if io::stderr().is_terminal() { ProgressBar::new(STEPS) } else { ProgressBar::hidden() };
        let style = ProgressStyle::with_template("{prefix} [{bar:24}] {msg}");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "));
        bar.set_prefix(name.to_owned());
        Self { bar, noise: None, noise_of: None }
    }

    /// Shows where the render stands.
    pub(crate) fn update(&mut self, film: &Film, standing: &Standing) {
        if self.bar.is_hidden() {
            return;
        }
        if self.noise_of.is_none_or(|time| time.elapsed() > NOISE_INTERVAL) {
            (self.noise, self.noise_of) = (noise(film), Some(Instant::now()));
        }
        let noise = self.noise.map_or_else(String::new, |noise| format!(", noise {}", percent(noise)));
        self.bar.set_position((standing.share.clamp(0.0, 1.0) * 1000.0) as u64);
        self.bar.set_message(format!(
            "{} spp, {}samples/s, {}rays/s{noise}, {} left",
            film.passes(),
            si(standing.samples_per_second),
            si(standing.rays_per_second),
            time(standing.seconds_left)
        ));
    }

    /// Removes the bar.
    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// How far a comparison of many cases is, on stderr: a bar in a terminal, in a pipe a line for each step.
pub(crate) struct CaseProgress {
    bar: ProgressBar,
    start: Instant,
}

impl CaseProgress {
    pub(crate) fn new() -> Self {
        let bar = if io::stderr().is_terminal() { ProgressBar::new(1000) } else { ProgressBar::hidden() };
        let style = ProgressStyle::with_template("[{bar:16}] {msg}").unwrap_or_else(|_| ProgressStyle::default_bar());
        bar.set_style(style.progress_chars("=> "));
        Self { bar, start: Instant::now() }
    }

    /// So many of all cases are done; `what` has been said of the last.
    pub(crate) fn show(&self, done: usize, of: usize, what: &str) {
        let left = self.start.elapsed().as_secs_f64() * (of as f64 / done as f64 - 1.0);
        self.bar.set_position((1000 * done / of.max(1)) as u64);
        self.say(format!("{done}/{of} {what}, {} left", time(left)));
    }

    /// Says something else.
    pub(crate) fn say(&self, text: String) {
        if self.bar.is_hidden() {
            let _ = writeln!(io::stderr(), "{text}");
        }
        self.bar.set_message(text);
    }

    /// Removes the bar.
    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// Mean of the pixels' estimated standard errors over mean of the image; `None` where either is unknown or zero.
pub(crate) fn noise(film: &Film) -> Option<f64> {
    let error = film.standard_error_image()?.mean().luminance();
    let noise = error / film.mean_image().mean().luminance();
    noise.is_finite().then_some(noise)
}

/// Mean luminance of the image, and its estimated standard error relative to it where that is known.
pub(crate) fn mean_luminance(film: &Film) -> (f64, Option<f64>) {
    let moments = &film.block_statistics().image()[3];
    let relative = moments.variance_of_mean().sqrt() / moments.mean;
    (moments.mean, relative.is_finite().then_some(relative))
}

/// `0.012` as `1.2 %`.
pub(crate) fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    let digits = if percent >= 10.0 {
        0
    } else if percent >= 1.0 {
        1
    } else {
        3
    };
    format!("{percent:.digits$} %")
}

/// `1.23e6` as `1.23 M`, with a space where no letter is needed.
pub(crate) fn si(value: f64) -> String {
    let (scale, letter) = match value {
        v if v >= 1e9 => (1e9, " G"),
        v if v >= 1e6 => (1e6, " M"),
        v if v >= 1e3 => (1e3, " k"),
        _ => (1.0, " "),
    };
    format!("{:.2}{letter}", value / scale)
}

/// A time to the next second below an hour, to the next minute above.
pub(crate) fn time(seconds: f64) -> String {
    if !seconds.is_finite() {
        return "?".into();
    }
    let seconds = seconds.max(0.0).ceil() as u64;
    match seconds {
        0..60 => format!("{seconds} s"),
        60..3600 => format!("{}:{:02} min", seconds / 60, seconds % 60),
        _ => format!("{}:{:02} h", seconds / 3600, seconds % 3600 / 60),
    }
}
