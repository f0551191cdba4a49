//! `verify`: are integrators what they claim to be.

use std::io::{self, Write};

use clap::Args;

use crate::estimator::Registry;
use crate::testing::verify::{Effort, SIGNIFICANCE, verify, verify_parts};

use super::Outcome;

const AFTER_HELP: &str = "\
Each integrator runs on small scenes with a bit of everything: closed diffuse box with a known answer, room, leaning normals
under 241 lights, all BSDFs with point, spot, sphere and mesh lights under a thin lens, environment and sun, orthographic camera,
textured materials, disks, cylinders and textured light, an image of the sky and a projector,
films with a window and wide filters, an irradiance meter and a distant sensor.
Checks, for paths of up to 5 edges:
  replay            the image is the sum of the terms that --replay shows
  threads           any number of threads gives the same bits
  terms             no term is NaN, infinite or negative, no weight outside 0 … 1
  value is w f / p  each term is what the definition says of its path
  weight, partition each weight is, and those of all techniques add up to one
  visibility        no edge of a path is hidden
  w_i w_j f         two techniques that make the same paths agree on their integral
  density           samplers draw as many paths as their densities claim
  error ~ N^(-1/2)  it falls so; where there is no variance, which is told, no mean is tested
  known answer      the image meets the closed form
  reference image   it is that of an integrator made of bare samplers
With them come the parts that all of them draw with (`verify parts`): BSDFs, emitters and sensors draw as their densities
claim, and the density of a walk is that of the path turned around, with emitter and sensor exchanged.
P-values are corrected for their number (Holm): one of 1000 reports on a faultless integrator has a failure.
Exit code 0: all hold; 1: one fails.";

/// What is not an integrator: all that they draw with.
const PARTS: &str = "parts";

/// Check integrators against the definition of f, p and w, known answers and each other
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct VerifyArgs {
    /// Integrators, with settings if you like, or `parts` for BSDFs, emitters and sensors [default: all]
    #[arg(value_name = "NAME[:setting=value…]")]
    integrators: Vec<String>,

    /// Passes over a film of 12 × 9 pixels in each scene: four times as many see half the deviation
    #[arg(long, value_name = "N", default_value_t = Effort::default().passes, value_parser = clap::value_parser!(u64).range(16..))]
    passes: u64,

    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = Effort::default().seed)]
    seed: u64,

    /// List every check with what it found and what it would have seen
    #[arg(long)]
    all: bool,
}

pub(super) fn run(registry: &Registry, args: &VerifyArgs) -> anyhow::Result<Outcome> {
    let all: Vec<String> = registry.entries().iter().map(|entry| entry.name.to_owned()).collect();
    let samplers = registry.samplers().iter().map(|entry| entry.name.to_owned());
    let labels = match args.integrators.as_slice() {
        [] => std::iter::once(PARTS.to_owned()).chain(all).chain(samplers).collect(),
        named => named.to_vec(),
    };
    let effort = Effort { passes: args.passes, seed: args.seed, ..Effort::default() };
    let mut failed = 0;
    for (i, label) in labels.iter().enumerate() {
        let report = if label == PARTS { verify_parts(effort) } else { verify(registry, label, effort)? };
        failed += usize::from(!report.holds());
        let mut out = io::stdout().lock();
        if i > 0 {
            writeln!(out)?;
        }
        write!(out, "{report}")?;
        if args.all {
            write!(out, "\n{}", report.list())?;
        }
        out.flush()?;
    }
    let mut out = io::stdout().lock();
    match failed {
        0 => writeln!(out, "\nall hold (false alarms: one report in {:.0})", 1.0 / SIGNIFICANCE)?,
        _ => writeln!(out, "\n{failed} of {} integrators fail", labels.len())?,
    }
    out.flush()?;
    Ok(if failed > 0 { Outcome::Failed } else { Outcome::Done })
}
