//! `reference`: what errors are measured against, rendered once and kept.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use comfy_table::presets::NOTHING;
use comfy_table::{CellAlignment, Table};

use crate::estimator::Registry;
use crate::experiment::cache::{Cache, Kept, Wanted, compare, default_folder};
use crate::experiment::{Budget, Manifest, Plan, SceneEntry, Subject, write_reference};
use crate::report::{Verdict, cut};
use crate::scene::description::FilmSize;

use super::args::{self, MaxLength};
use super::compare::watch::Watch;
use super::compare::{load, usage};
use super::progress::{percent, time};
use super::scene::LoadOptions;
use super::{Outcome, UsageError, complain, interrupt};

const AFTER_HELP: &str = "\
References are kept in $PATHSPACE_CACHE/references, else in the user's folder for caches, by scene (its content, film and longest
path) and method. Ctrl-C keeps what is done, and the next call goes on there. An experiment takes them with
  reference = { method = \"bdpt\", seconds = 600 }
in its manifest, which renders what is missing; its errors have the noise of the reference taken off. References of a scene by
two methods are tested for being of the same image, here and before use.

Examples:
  pathspace reference cornell_box --add 10m                  ten minutes more
  pathspace reference cornell_box --method path --until 1h   at least one hour in all
  pathspace reference cornell_box                            what there is, and whether methods agree
  pathspace reference cornell_box -o box.exr                 as a file for `compare --reference box.exr`

Exit code 3: references of two methods are of different images.";

/// Render a scene's reference or go on with it, show what is kept, compare methods
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct ReferenceArgs {
    /// .gltf or .glb file, folder with one, or name of a folder in scenes/
    scene: PathBuf,

    /// Integrator with settings, name:key=value:…
    #[arg(long, value_name = "METHOD", default_value = "bdpt")]
    method: String,

    /// Render so much longer: 90s, 10m, 1h30m
    #[arg(long, value_name = "TIME", value_parser = args::duration, conflicts_with_all = ["until", "spp"])]
    add: Option<f64>,

    /// Render until so much time is spent in all
    #[arg(long, value_name = "TIME", value_parser = args::duration, conflicts_with = "spp")]
    until: Option<f64>,

    /// Render until there are so many samples per pixel in all; the same bits, however often it was interrupted
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1 << 31))]
    spp: Option<u64>,

    /// Camera by name or number [default: the first]
    #[arg(long)]
    camera: Option<String>,

    /// Image size in pixels [default: the scene's]
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = args::film_size)]
    film: Option<FilmSize>,

    /// Longest path in edges, or none for unlimited [default: the scene's]
    #[arg(long, value_name = "EDGES")]
    max_length: Option<MaxLength>,

    /// Threads that render; 0 takes all that the machine has
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(..=1024))]
    threads: u16,

    /// Write the method's reference with the standard error of its pixels
    #[arg(short, long, value_name = "FILE.exr")]
    output: Option<PathBuf>,
}

pub(super) fn run(registry: &Registry, args: &ReferenceArgs) -> anyhow::Result<Outcome> {
    interrupt::listen()?;
    let method = args.method.trim();
    if method.starts_with("mitsuba:") {
        let what = format!("reference by {method}: Mitsuba's image is given to compare with --reference FILE.exr");
        return Err(UsageError(what).into());
    }
    if let Some(output) = &args.output {
        crate::film::check_writable(output)?;
    }
    let options = LoadOptions { film: args.film, camera: args.camera.clone(), ..LoadOptions::default() };
    let subject = load(&args.scene, &options)?;
    let mut manifest = Manifest::new(vec![SceneEntry::from(args.scene.display().to_string())], [method]);
    manifest.max_length = args.max_length;
    manifest.threads = args.threads;
    let plan =
        Plan::resolve(manifest, std::slice::from_ref(&subject), registry, None, None, "reference").map_err(usage)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(plan.machine.threads).build()?;
    let cache = Cache { folder: default_folder(), registry, pool: &pool, observer: &mut () };
    let kept = cache.kept(&subject, &plan.scenes[0]).map_err(usage)?;
    let spent = kept.iter().find(|kept| kept.method == method).map_or(0.0, |kept| kept.info.render_seconds);
    let until = match args {
        ReferenceArgs { add: Some(more), .. } => Some(Budget::Seconds(spent + more)),
        ReferenceArgs { until: Some(all), .. } => Some(Budget::Seconds(*all)),
        ReferenceArgs { spp: Some(spp), .. } => Some(Budget::Spp(*spp)),
        _ => None,
    };
    if let Some(until) = until {
        let mut watch = Watch::new(until);
        let mut cache = Cache { folder: default_folder(), registry, pool: &pool, observer: &mut watch };
        let done = cache.extend(&Wanted { subject: &subject, plan: &plan.scenes[0], method, until });
        watch.close();
        done.map_err(usage)?;
    }
    show(&cache, &subject, &plan, args)
}

fn show(cache: &Cache<'_>, subject: &Subject, plan: &Plan, args: &ReferenceArgs) -> anyhow::Result<Outcome> {
    let scene = &plan.scenes[0];
    let kept = cache.kept(subject, scene).map_err(usage)?;
    let mut out = io::stdout().lock();
    let size = format!("{} × {}", scene.film.width, scene.film.height);
    let length = scene.longest().map_or_else(|| "any length".to_owned(), |edges| format!("up to {edges} edges"));
    writeln!(out, "{}, {size}, paths of {length}", cut(&scene.name, 40))?;
    if kept.is_empty() {
        writeln!(out, "  no reference is kept; render one with --add 10m")?;
    } else {
        write!(out, "{}", table(&kept))?;
    }
    let mut differs = false;
    for (i, a) in kept.iter().enumerate() {
        for b in &kept[i + 1..] {
            let names = format!("  {} and {}", cut(&a.method, 16), cut(&b.method, 16));
            let Some(test) = compare(a, b).map_err(usage)? else {
                writeln!(out, "{names}: too few samples to compare")?;
                continue;
            };
            let (difference, error) = (100.0 * test.image.relative_difference, 100.0 * test.image.relative_error);
            writeln!(out, "{names} {}: {difference:+.3} ± {error:.3} %", test.verdict)?;
            differs |= test.verdict == Verdict::Differ;
        }
    }
    writeln!(out, "  kept in {}", cache.folder_of(subject, scene).display())?;
    out.flush()?;
    if let Some(file) = &args.output {
        let method = args.method.trim();
        let Some(ours) = kept.iter().find(|kept| kept.method == method) else {
            let what = format!("there is no reference by {method} to write; render one with --add 10m");
            return Err(UsageError(what).into());
        };
        write_reference(file, &scene.name, &ours.words(), &ours.reference()).map_err(usage)?;
        complain("note", &format!("wrote {}", file.display()));
    }
    Ok(if differs { Outcome::Differ } else { Outcome::Done })
}

fn table(kept: &[Kept]) -> String {
    let mut table = Table::new();
    table.load_style(NOTHING).set_header(["  method", "spp", "time", "noise of a pixel"]);
    for kept in kept {
        let noise = kept.noise().map_or_else(|| "-".to_owned(), percent);
        let method = format!("  {}", cut(&kept.method, 40));
        table.add_row([method, kept.film.passes().to_string(), time(kept.info.render_seconds), noise]);
    }
    for (index, column) in table.column_iter_mut().enumerate() {
        column.set_padding((0, 2));
        column.set_cell_alignment(if index == 0 { CellAlignment::Left } else { CellAlignment::Right });
    }
    table.lines().map(|line| format!("{}\n", line.trim_end())).collect()
}
