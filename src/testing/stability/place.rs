//! A cell of which nothing is known yet.

use super::case::Case;
use super::cell::{Cell, Verdict};

/// The cell's place in the table.
pub(super) fn blank(case: &Case, value: f64, method: &str) -> Cell {
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
