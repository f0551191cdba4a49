//! `reference`: what errors are measured against, rendered once and kept.

mod bar;
mod show;

use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::anyhow;
use clap::Args;

use crate::estimator::Registry;
use crate::experiment::cache::{Cache, Kept, Until, Wanted, default_folder};
use crate::experiment::{MITSUBA, Manifest, Mitsuba, Plan, SceneEntry, Subject};
use crate::scene::description::FilmSize;

use super::args::{self, MaxLength, ParameterArgs};
use super::compare::{load, materials, tell_materials, usage};
use super::scene::LoadOptions;
use super::{Outcome, UsageError, complain, interrupt};
use bar::Bar;

const AFTER_HELP: &str = "\
References are kept in $PATHSPACE_CACHE/references, else in the user's folder for caches, by scene (its content, film and longest
path) and method. Each has the variance of its pixels, and every call goes on where the last one was: passes of other random
numbers are added to the same film. Ctrl-C keeps what is done, and exits with 130. Errors that are measured against a reference
have its noise taken off, if a manifest takes it with
  reference = { method = \"bdpt\", seconds = 600 }
which renders what is missing. It takes mitsuba:path and mitsuba:ptracer, too, where there is a Python with Mitsuba; their passes
have 16 samples per pixel.

Trust is good: render references with two methods that have little in common. Whether they are of the same image is tested
here and before use (false alarms: one pair in 1000), and with the result stands the smallest difference that would have been found
with probability 0.9. Noise is the root mean square of the pixels' standard errors over the mean of the image: it halves in
four times the time, and should be far below the errors to be measured.

Examples:
  pathspace reference cornell_box --add 10m                  ten minutes more
  pathspace reference cornell_box --method path --until 1h   at least one hour in all
  pathspace reference cornell_box --error 0.5%               until the noise is so small
  pathspace reference cornell_box --method mitsuba:path --add 5m
  pathspace reference cornell_box                            what there is, and whether methods agree
  pathspace reference cornell_box -o box.exr                 as a file for `compare --reference box.exr`

Exit code 3: references of two methods are of different images.";

/// Render a scene's reference or go on with it, show what is kept, compare methods
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct ReferenceArgs {
    /// .gltf, .glb or Mitsuba .xml file, folder with one, or name of a folder in scenes/
    scene: PathBuf,

    /// Integrator with settings, name:key=value:…, or mitsuba:path, mitsuba:ptracer
    #[arg(long, value_name = "METHOD", default_value = "bdpt")]
    method: String,

    /// Render so much longer: 90s, 10m, 1h30m
    #[arg(long, value_name = "TIME", value_parser = args::duration, group = "goal")]
    add: Option<f64>,

    /// Render until so much time is spent in all
    #[arg(long, alias = "seconds", value_name = "TIME", value_parser = args::duration, group = "goal")]
    until: Option<f64>,

    /// Render until there are so many samples per pixel in all; the same bits, however often it was interrupted
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1 << 31), group = "goal")]
    spp: Option<u64>,

    /// Render until the noise of a pixel is so small: 0.5%
    #[arg(long, value_name = "PERCENT", value_parser = args::percentage, group = "goal")]
    error: Option<f64>,

    /// Show what is kept, and nothing else
    #[arg(long)]
    list: bool,

    /// Show whether methods agree, and nothing else
    #[arg(long)]
    check: bool,

    /// Camera by name or number [default: the first]
    #[arg(long)]
    camera: Option<String>,

    #[command(flatten)]
    defined: ParameterArgs,

    /// Image size in pixels [default: the scene's]
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = args::film_size)]
    film: Option<FilmSize>,

    /// Longest path in edges, or none for unlimited [default: the scene's]
    #[arg(long, value_name = "EDGES")]
    max_length: Option<MaxLength>,

    /// Threads that render; 0 takes all that the machine has
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(..=1024))]
    threads: u16,

    /// Write the method's reference: mean, standard error of its pixels, and how it was made
    #[arg(short, long, value_name = "FILE.exr")]
    output: Option<PathBuf>,
}

pub(super) fn run(registry: &Registry, args: &ReferenceArgs) -> anyhow::Result<Outcome> {
    interrupt::listen()?;
    let method = args.method.trim();
    if let Some(output) = &args.output {
        if output.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case("exr")) {
            return Err(UsageError(format!("-o {}: a reference is written as .exr", output.display())).into());
        }
        crate::film::check_writable(output)?;
    }
    let options = LoadOptions {
        film: args.film,
        camera: args.camera.clone(),
        parameters: args.defined.parameters.clone(),
        materials: materials(args.defined.materials, method.starts_with(MITSUBA)),
        ..LoadOptions::default()
    };
    let subject = load(&args.scene, &options)?;
    tell_materials(args.defined.materials, std::slice::from_ref(&subject));
    let mut manifest = Manifest::new(vec![SceneEntry::from(args.scene.display().to_string())], [method]);
    manifest.max_length = args.max_length;
    manifest.threads = args.threads;
    manifest.materials = Some(options.materials);
    let plan =
        Plan::resolve(manifest, std::slice::from_ref(&subject), registry, None, None, "reference").map_err(usage)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(plan.machine.threads).build()?;
    let cache = Cache { folder: default_folder(), registry, mitsuba: None, pool: &pool, observer: &mut () };
    if let Some(until) = until(args, &cache, &subject, &plan)? {
        let mitsuba = method.starts_with(MITSUBA).then(|| Mitsuba::find(interrupt::requested)).transpose();
        let mitsuba = mitsuba.map_err(|why| anyhow!("reference by {method}: {why}"))?;
        let mut bar = Bar::new();
        let observer = &mut bar;
        let mut cache = Cache { folder: default_folder(), registry, mitsuba: mitsuba.as_ref(), pool: &pool, observer };
        let done = cache.extend(&Wanted { subject: &subject, plan: &plan.scenes[0], method, until });
        bar.close();
        done.map_err(usage)?;
    }
    show(&cache, &subject, &plan, args)
}

/// How far the method's reference is to go, if it is.
fn until(args: &ReferenceArgs, cache: &Cache<'_>, subject: &Subject, plan: &Plan) -> anyhow::Result<Option<Until>> {
    Ok(match args {
        ReferenceArgs { add: Some(more), .. } => {
            let kept = cache.kept(subject, &plan.scenes[0]).map_err(usage)?;
            Some(Until::Seconds(more + of(&kept, args).map_or(0.0, |kept| kept.info.render_seconds)))
        }
        ReferenceArgs { until: Some(all), .. } => Some(Until::Seconds(*all)),
        ReferenceArgs { spp: Some(spp), .. } => Some(Until::Spp(*spp)),
        ReferenceArgs { error: Some(noise), .. } => Some(Until::Noise(*noise)),
        _ => None,
    })
}

fn of<'a>(kept: &'a [Kept], args: &ReferenceArgs) -> Option<&'a Kept> {
    kept.iter().find(|kept| kept.method == args.method.trim())
}

fn show(cache: &Cache<'_>, subject: &Subject, plan: &Plan, args: &ReferenceArgs) -> anyhow::Result<Outcome> {
    let scene = &plan.scenes[0];
    let kept = cache.kept(subject, scene).map_err(usage)?;
    if let Some(file) = &args.output {
        let Some(ours) = of(&kept, args) else {
            let method = args.method.trim();
            let what = format!("there is no reference by {method} to write; render one with --add 10m");
            return Err(UsageError(what).into());
        };
        ours.write(file).map_err(usage)?;
        complain("note", &format!("wrote {}", file.display()));
    }
    let mut out = io::stdout().lock();
    let all = args.list == args.check;
    show::title(&mut out, scene)?;
    if args.list || all {
        show::list(&mut out, &kept)?;
    }
    let differs = (args.check || all) && show::check(&mut out, &kept)?;
    writeln!(out, "  kept in {}", cache.folder_of(subject, scene).display())?;
    out.flush()?;
    Ok(if differs { Outcome::Differ } else { Outcome::Done })
}
