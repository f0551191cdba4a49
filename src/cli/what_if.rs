//! `whatif`: one set of samples under several weights.

use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::{anyhow, bail};
use clap::Args;
use comfy_table::presets::NOTHING;
use comfy_table::{CellAlignment, ContentArrangement, Table};

use crate::estimator::{Registry, Reweighted, Weights, what_if};

use super::args::{self, MaxLength, SceneArgs};
use super::scene::{self, LoadOptions};
use super::{Outcome, UsageError, complain};

const AFTER_HELP: &str = "\
The samples are drawn once; each line of the table weighs them anew. So the lines share their chance, and small
differences between them are real. Columns:
  mean        mean luminance of the image [W/m²/sr], with its standard error over passes
  variance    of one sample in one pixel, mean over pixels and channels
  efficiency  variance of the balance heuristic over that of this line: above 1 is better, 2 saves half of the samples
The coefficients of optimal weights are learnt from the passes: progressive ones from earlier passes, direct ones from the
same pass too, which makes them consistent but not unbiased. Their first passes count in the table.

Examples:
  pathspace whatif cornell_box --samplers 'walks(s=0)+walks(s=1)'
  pathspace whatif hidden_lamps --samplers 'walks(s=0)+walks(s=1)+walks(t=1)' --passes 64 --film 128x128";

/// Weigh one set of samples by every heuristic and by optimal weights, and compare the variances
#[derive(Debug, Args)]
#[command(name = "whatif", after_help = AFTER_HELP)]
pub(super) struct WhatIfArgs {
    /// A .gltf, .glb or Mitsuba .xml file, a folder with one, or the name of a folder in scenes/
    scene: PathBuf,

    /// What draws the paths: names joined by +, settings in parentheses; `pathspace list` shows them. Settings of `mis` may
    /// follow after a colon, such as :terms=apart
    #[arg(long, value_name = "NAME(setting=value …)+…")]
    samplers: String,

    /// Samples per pixel of each sampler
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u64).range(2..))]
    passes: u64,

    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,

    /// Longest path in edges, or none for unlimited [default: the scene's]
    #[arg(long, value_name = "EDGES", value_parser = args::max_length)]
    max_length: Option<MaxLength>,

    #[command(flatten)]
    take: SceneArgs,
}

pub(super) fn run(registry: &Registry, args: &WhatIfArgs) -> anyhow::Result<Outcome> {
    let options = LoadOptions {
        camera: args.take.camera.clone(),
        film: args.take.film,
        environment: args.take.environment.clone(),
        filter: args.take.pixel_filter,
        parameters: args.take.defined.parameters.clone(),
        materials: args.take.defined.materials.unwrap_or_default(),
        ..LoadOptions::default()
    };
    let loaded = scene::load(&args.scene, &options)?;
    scene::show(&loaded.notes);
    let length = args.max_length.unwrap_or(MaxLength(loaded.scene.hints().max_length)).to_string();
    let method = registry.build(&format!("mis:samplers={}", args.samplers), &[("max_length", length)])?;
    let Some(combination) = method.integrator.definition(u32::MAX) else {
        bail!(UsageError(format!("--samplers {}: they are no combination of samplers", args.samplers)));
    };
    let outcomes = what_if(&combination, &loaded.scene, args.seed, args.passes, &Weights::all())
        .map_err(|error| anyhow!("{}: film: {error}", loaded.scene.source().display()))?;
    let mut out = io::stdout().lock();
    let size = loaded.scene.sensor().film();
    writeln!(out, "{}, {}, {}x{}, {} spp", loaded.scene.name(), args.samplers, size.width, size.height, args.passes)?;
    writeln!(out, "{}", table(&outcomes))?;
    out.flush()?;
    let invalid = outcomes.first().map_or(0, |outcome| outcome.film.counters.invalid);
    if invalid > 0 {
        complain("warning", &format!("{invalid} contributions were NaN or infinite and are left out"));
    }
    Ok(Outcome::Done)
}

fn table(outcomes: &[Reweighted]) -> Table {
    let mut table = Table::new();
    table.load_style(NOTHING).set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(["weights", "mean", "std. error", "variance", "efficiency"]);
    let base = outcomes.first().map_or(f64::NAN, Reweighted::variance);
    for outcome in outcomes {
        let (mean, error) = outcome.mean();
        let variance = outcome.variance();
        table.add_row([
            outcome.weights.to_string(),
            format!("{mean:.6}"),
            format!("{error:.2e}"),
            format!("{variance:.4e}"),
            format!("{:.3}", base / variance),
        ]);
    }
    table.column_iter_mut().skip(1).for_each(|column| column.set_cell_alignment(CellAlignment::Right));
    table
}
