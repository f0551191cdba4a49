//! Where numbers hold, and where they stop holding.
//!
//! A [`Case`] is a small scene swept over a parameter from tame to extreme, with the truth for each value from a closed form
//! or a scaling law. A [`Cell`] is what one method makes of one value. Work is counted in rays, not in seconds, so that the
//! same seed gives the same cells on every machine but for their times.

mod case;
mod cases;
mod cell;
mod external;
mod journal;
mod judge;
mod measure;
mod run;
mod summary;
mod sweep;
mod truth;

pub use case::{Case, Exact, Limit, Stage, Subject, Truth};
pub use cases::all;
pub use cell::{Cell, Verdict};
pub use external::External;
pub use journal::Journal;
pub use judge::{POWER, SIGNIFICANCE};
pub use run::{Progress, Run, beyond};
pub use summary::{Outcome, outcome};

/// How much is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Rays of a cell.
    pub rays: u64,
    /// Times as many where it takes so many to find a bias of 8 %.
    pub patience: f64,
    /// All values of a parameter rather than three of them.
    pub all_values: bool,
    /// Seed of the random numbers.
    pub seed: u64,
}

impl Effort {
    /// Minutes on one core.
    pub const QUICK: Self = Self { rays: 1_000_000, patience: 8.0, all_values: false, seed: 1 };
    /// An hour.
    pub const FULL: Self = Self { rays: 4_000_000, patience: 50.0, all_values: true, seed: 1 };

    /// The values of a case that are looked at: all, or the tame one, one between and the most extreme.
    #[must_use]
    pub fn values(self, case: &Case) -> Vec<f64> {
        let all = &case.values;
        match all.len() {
            n if self.all_values || n <= 3 => all.clone(),
            n => vec![all[0], all[n / 2], all[n - 1]],
        }
    }
}
