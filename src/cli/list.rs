//! `list`: what can be asked for by name.

use std::io::{self, Write};

use clap::Args;

use crate::estimator::optimal::Form;
use crate::estimator::{Heuristic, Lengths, Registry};

use super::Outcome;

/// Show integrators, heuristics and error metrics, one line each
#[derive(Debug, Args)]
pub(super) struct ListArgs {}

/// Columns that `compare` writes; the formulas are those of [`crate::report`].
const METRICS: [(&str, &str); 9] = [
    ("mse", "mean squared error, without the noise of the reference"),
    ("rmse", "its square root, in the unit of the image"),
    ("relmse", "mean of (x − r)² / (r² + 0.01): bright and dark pixels count alike"),
    ("mape", "mean of |x − r| / (|r| + 0.01)"),
    ("smape", "mean of |x − r| / (|x| + |r|), 0 to 1: fireflies count little"),
    ("trimmed_mse", "mse without the 0.1 % worst pixels"),
    ("trimmed_relmse", "relmse without the 0.1 % worst pixels"),
    ("flip", "what an eye sees flipping between the images, 0 to 1 (slow: only where --metrics names it)"),
    ("mean_ratio", "mean of the image over that of the reference: 1 where energy is right"),
];

pub(super) fn run(registry: &Registry) -> anyhow::Result<Outcome> {
    let integrators: Vec<_> = registry.entries().iter().map(|entry| (entry.name, entry.summary)).collect();
    let mut samplers: Vec<_> = registry.samplers().iter().map(|entry| (entry.name, entry.summary)).collect();
    if !samplers.is_empty() {
        samplers.push(("mis", "several at once: 'mis:samplers=walks(s=0)+walks(s=1)+direct(by=cosine)'"));
    }
    let sections: [(&str, &[(&str, &str)]); 6] = [
        ("integrators (--integrator NAME:setting=value…)", &integrators),
        ("samplers, integrators by the definition of f and p: general and slow", &samplers),
        ("lengths of samplers' paths (setting terms=NAME)", &Lengths::NAMES),
        ("heuristics (setting heuristic=NAME)", &Heuristic::NAMES),
        ("optimal weights (setting weights=NAME of mis; alpha=block or image shares coefficients)", &Form::NAMES),
        ("metrics (columns of compare)", &METRICS),
    ];
    let width = sections.iter().flat_map(|(_, rows)| rows.iter()).map(|(name, _)| name.len()).max().unwrap_or(0);
    let mut out = io::stdout().lock();
    for (i, (title, rows)) in sections.iter().enumerate() {
        if i > 0 {
            writeln!(out)?;
        }
        writeln!(out, "{title}")?;
        for (name, summary) in *rows {
            writeln!(out, "  {name:width$}  {summary}")?;
        }
    }
    out.flush()?;
    Ok(Outcome::Done)
}
