//! A cell of which nothing is known yet.

use super::case::Case;
use super::cell::{Cell, Verdict};

/// What a cell is called in file names.
#[must_use]
pub fn stage_name(case: &Case, value: f64) -> String {
    format!("{}-{}-{value:e}", case.group, case.name.replace(' ', "-"))
}

/// The cell's place in the table, of which nothing else is known.
#[must_use]
pub fn blank(case: &Case, value: f64, method: &str) -> Cell {
    Cell {
        schema: Cell::SCHEMA,
        group: case.group.into(),
        case: case.name.into(),
        parameter: case.parameter.into(),
        value,
        method: method.into(),
        verdict: Verdict::Missing,
        estimate: None,
        truth: None,
        z: None,
        difference: None,
        interval: None,
        detectable: None,
        passes: None,
        samples: None,
        variance: None,
        variance_growth: None,
        tail_index: None,
        invalid: None,
        negative: None,
        firefly: None,
        weights: None,
        definition: None,
        seconds_per_sample: None,
        time_growth: None,
        rays_per_sample: None,
        details: String::new(),
    }
}
