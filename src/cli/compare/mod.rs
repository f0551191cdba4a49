//! `compare`: scenes × methods × seeds, beside Mitsuba.

pub(super) mod tables;
pub(super) mod watch;

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;

use super::args::{MaxLength, ParameterArgs};
use crate::estimator::Registry;
use crate::experiment::{
    self, Budget, ExperimentError, Folder, MITSUBA, Made, Manifest, Mitsuba, Plan, ReferencePolicy, Renderers, Report,
    SceneEntry, Subject, collect,
};
use crate::report::Metric;
use crate::scene::description::{BsdfDescription, FilmSize, Material};
use crate::scene::gltf::MaterialModel;
use crate::scene::{LightSelection, Scene, SceneOptions};

use super::scene::{self, LoadOptions};
use super::{Outcome, UsageError, args, complain, interrupt};
use watch::Watch;

const AFTER_HELP: &str = "\
Methods: an integrator of `pathspace list` with settings (bdpt:heuristic=power), mitsuba:path, mitsuba:ptracer; Mitsuba's
take variant=auto|scalar_rgb|llvm_ad_rgb, rr_depth=N, max_length=N. A method that cannot render a scene is skipped and told.

DIR holds the experiment: experiment.toml, tables (rows.csv, curves.csv, summary.csv, verdicts.csv, agreement.csv; their columns
stand in src/docs/tables.md), references/, images/, and each finished run in runs/SCENE/METHOD/SEED. Called again, after an interruption or a crash or with more seeds, methods and scenes, it makes the
runs that are missing and keeps the others. Several processes, on machines that share DIR, make different runs.

A manifest says the same and more (names, settings and films of one's own for each scene and method):
  scenes = [\"cornell_box\", { file = \"hall.gltf\", film = \"320x180\", max_length = 8 }]
  methods = [\"path\", { name = \"power\", integrator = \"bdpt\", settings = { heuristic = \"power\" } }, \"mitsuba:path\"]
  seeds = 8
  metrics = [\"mse\", \"relmse\", \"flip\"]
  budget = { seconds = 10 }        # or { spp = 64 }, or { error = { metric = \"relmse\", target = 0.01, seconds = 60 } }
  reference = \"scene\"              # or \"none\", \"FILE.exr\", or { method = \"bdpt\", seconds = 600 }: rendered once and kept
DIR/experiment.toml is one, too, so it repeats the experiment.

Every run has a seed of its own, so that methods are independent. Exit code 3: a method estimates another image (DIFFER) than the
reference or Mitsuba. Before speed is compared, that has to be understood. Where only Mitsuba's own methods miss the reference,
as ptracer does by some 0.1 % in long runs, it is told, and the exit code is 0.

Examples:
  pathspace compare cornell_box veach_mis --seconds 30 --seeds 4 -o results/two
  pathspace compare exp.toml";

const OWN_METHODS: [&str; 3] = ["path", "light", "bdpt"];
const MITSUBA_METHODS: [&str; 2] = ["mitsuba:path", "mitsuba:ptracer"];

/// Compare methods on scenes: error against rendering time, beside Mitsuba
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct CompareArgs {
    /// .gltf, .glb or Mitsuba .xml files, folders with one, or names of folders in scenes/; or a manifest, exp.toml
    #[arg(required = true)]
    scenes: Vec<PathBuf>,

    /// Methods [default: path,light,bdpt, and mitsuba:path,mitsuba:ptracer where there is a Python with Mitsuba]
    #[arg(long, value_name = "METHOD,…", value_delimiter = ',')]
    methods: Vec<String>,

    /// Rendering time of each run in seconds [default: 5]
    #[arg(long, value_name = "SECONDS", value_parser = args::seconds)]
    seconds: Option<f64>,

    /// Samples per pixel of each run instead; with it, images are the same every time
    #[arg(long, value_name = "N", conflicts_with = "seconds", value_parser = clap::value_parser!(u64).range(1..=1 << 31))]
    spp: Option<u64>,

    /// Runs of each method on each scene; intervals of fewer than 4 are of little use [default: 4]
    #[arg(long, value_name = "R", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    seeds: Option<u32>,

    /// The first seed [default: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..1 << 61))]
    seed: Option<u64>,

    /// Threads that render; 0 takes all that the machine has [default: 0]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(..=1024))]
    threads: Option<u16>,

    /// Longest path in edges, or none for unlimited; equals Mitsuba's max_depth [default: each scene's]
    #[arg(long, value_name = "EDGES")]
    max_length: Option<MaxLength>,

    /// How one of several emitters is chosen: in proportion to its flux, or all alike as Mitsuba does [default: power]
    #[arg(long, value_name = "HOW", value_parser = args::light_selection())]
    light_selection: Option<LightSelection>,

    /// Image size in pixels [default: each scene's]
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = args::film_size)]
    film: Option<FilmSize>,

    #[command(flatten)]
    defined: ParameterArgs,

    /// What errors are measured against: an EXR file, or none [default: what each scene names]
    #[arg(long, value_name = "FILE.exr|none")]
    reference: Option<ReferencePolicy>,

    /// Errors that curves and verdicts are made of, see `pathspace list` [default: all but flip]
    #[arg(long, value_name = "METRIC,…", value_delimiter = ',', value_parser = args::metric())]
    metrics: Vec<Metric>,

    /// Folder to write into, made where it is missing [default for a manifest: its name without .toml]
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,

    /// Clear away the experiment that is in the folder, and start anew
    #[arg(long)]
    force: bool,

    /// Write no images
    #[arg(long)]
    no_images: bool,

    /// Make only this run, and no tables; SCENE/METHOD/SEED as --list-jobs shows it. May be repeated
    #[arg(long, value_name = "JOB")]
    job: Vec<String>,

    /// List the runs that are missing, one a line, and make none
    #[arg(long, conflicts_with = "job")]
    list_jobs: bool,
}

pub(super) fn run(registry: &Registry, args: &CompareArgs) -> anyhow::Result<Outcome> {
    interrupt::listen()?;
    let (mut manifest, output) = manifest(args)?;
    let mitsuba = methods(&mut manifest);
    let asked = manifest.materials;
    let earlier = if args.force { None } else { Folder::materials_in(&output) };
    let chosen = materials(asked.or(earlier), mitsuba.is_some() && wants_mitsuba(&manifest));
    manifest.materials = Some(chosen);
    let subjects = load_all(&manifest)?;
    tell_materials(asked, &subjects);
    let folder = Folder::open(&output, args.force).map_err(usage)?;
    let earlier = folder.manifest().map_err(usage)?;
    let command = std::env::args().collect::<Vec<_>>().join(" ");
    let plan =
        Plan::resolve(manifest, &subjects, registry, mitsuba.as_ref(), earlier.as_ref(), &command).map_err(usage)?;
    if args.list_jobs {
        let mut out = io::stdout().lock();
        for job in experiment::missing(&plan, &folder).map_err(usage)? {
            writeln!(out, "{job}")?;
        }
        return Ok(Outcome::Done);
    }
    for scene in &plan.scenes {
        for (method, why) in &scene.skipped {
            complain("note", &format!("{}: {method} is skipped: {why}", scene.name));
        }
    }
    let mut watch = Watch::new(plan.manifest.budget);
    let renderers = Renderers { registry, mitsuba: mitsuba.as_ref() };
    let made = experiment::run(&plan, &subjects, renderers, &folder, &args.job, &mut watch);
    watch.close();
    let made = made.map_err(usage)?;
    if !args.job.is_empty() {
        return Ok(outcome(&made, None));
    }
    let report = collect(&folder).map_err(usage)?;
    tables::show(&report, &output)?;
    Ok(outcome(&made, Some(&report)))
}

fn outcome(made: &Made, report: Option<&Report>) -> Outcome {
    for row in report.iter().flat_map(|report| &report.agreement).filter(|row| row.differs()) {
        complain("DIFFER", &format!("{}: {} against {}: {}", row.scene, row.method, row.against, row.details));
    }
    for (run, why) in &made.failed {
        complain("error", &format!("{}: {}, seed {}: {why}", run.scene, run.method, run.seed));
    }
    if made.elsewhere > 0 {
        let what = format!("{} runs are being made by others; call again for tables with them", made.elsewhere);
        complain("note", &what);
    }
    if made.stopped {
        Outcome::Interrupted
    } else if report.is_some_and(Report::differs) {
        Outcome::Differ
    } else if made.failed.is_empty() {
        Outcome::Done
    } else {
        Outcome::Failed
    }
}

/// An error that the user's words have caused is told apart by the exit code.
pub(super) fn usage(error: ExperimentError) -> anyhow::Error {
    match error {
        error if error.is_usage() => UsageError(error.to_string()).into(),
        ExperimentError::Stopped(what) => super::Stopped(what).into(),
        error => error.into(),
    }
}

/// What the command line asks for, as a manifest, and where it goes.
fn manifest(args: &CompareArgs) -> anyhow::Result<(Manifest, PathBuf)> {
    let is_manifest = |file: &PathBuf| file.extension().is_some_and(|ending| ending == "toml");
    let (mut manifest, default) = match args.scenes.as_slice() {
        [file] if is_manifest(file) => (from_file(file, args)?, Some(file.with_extension(""))),
        files if files.iter().any(is_manifest) => {
            return Err(UsageError("a manifest names the scenes; give it alone".into()).into());
        }
        files => (from_flags(files, args)?, None),
    };
    if let Some(threads) = args.threads {
        manifest.threads = threads;
    }
    manifest.images &= !args.no_images;
    let Some(output) = args.output.clone().or(default) else {
        return Err(UsageError("name the folder to write into with -o DIR".into()).into());
    };
    Ok((manifest, output))
}

fn from_file(file: &Path, args: &CompareArgs) -> anyhow::Result<Manifest> {
    let given = [
        ("--methods", !args.methods.is_empty()),
        ("--seconds", args.seconds.is_some()),
        ("--spp", args.spp.is_some()),
        ("--seed", args.seed.is_some()),
        ("--max-length", args.max_length.is_some()),
        ("--light-selection", args.light_selection.is_some()),
        ("--film", args.film.is_some()),
        ("-D", !args.defined.parameters.is_empty()),
        ("--materials", args.defined.materials.is_some()),
        ("--reference", args.reference.is_some()),
        ("--metrics", !args.metrics.is_empty()),
    ];
    if let Some((flag, _)) = given.into_iter().find(|(_, given)| *given) {
        let what = format!("{flag} is for scenes on the command line; write it into {}", file.display());
        return Err(UsageError(what).into());
    }
    let mut manifest = Manifest::read(file).map_err(usage)?;
    // What lies beside the manifest is meant from there.
    let beside = file.parent().unwrap_or(Path::new(""));
    let resolve = |path: &mut PathBuf| {
        if beside.join(&*path).exists() {
            *path = beside.join(&*path);
        }
    };
    for experiment::StringOr(entry) in &mut manifest.scenes {
        resolve(&mut entry.file);
        if let Some(ReferencePolicy::File(file)) = &mut entry.reference {
            resolve(file);
        }
    }
    if let ReferencePolicy::File(file) = &mut manifest.reference {
        resolve(file);
    }
    manifest.seeds = args.seeds.unwrap_or(manifest.seeds);
    Ok(manifest)
}

fn from_flags(files: &[PathBuf], args: &CompareArgs) -> anyhow::Result<Manifest> {
    if files.len() > 1 && matches!(args.reference, Some(ReferencePolicy::File(_))) {
        return Err(UsageError("--reference FILE serves one scene; compare the others apart".into()).into());
    }
    let film = args.film.map(|film| format!("{}x{}", film.width, film.height));
    let scene = |file: &PathBuf| SceneEntry {
        file: file.clone(),
        film: film.clone(),
        parameters: args.defined.parameters.iter().cloned().collect(),
        ..SceneEntry::default()
    };
    let methods = args.methods.iter().map(|method| method.trim());
    let mut manifest = Manifest::new(files.iter().map(scene).collect(), methods);
    let default = manifest.budget;
    manifest.budget = args.spp.map(Budget::Spp).or(args.seconds.map(Budget::Seconds)).unwrap_or(default);
    manifest.seed = args.seed.unwrap_or(manifest.seed);
    manifest.seeds = args.seeds.unwrap_or(manifest.seeds);
    manifest.max_length = args.max_length;
    manifest.light_selection = args.light_selection.unwrap_or_default();
    manifest.materials = args.defined.materials;
    manifest.reference = args.reference.clone().unwrap_or_default();
    if !args.metrics.is_empty() {
        manifest.metrics.clone_from(&args.metrics);
    }
    Ok(manifest)
}

/// Completes the methods. Mitsuba is looked for where it is wanted; where it is only the default, its absence is told.
fn methods(manifest: &mut Manifest) -> Option<Mitsuba> {
    let entries = |names: &[&str]| Manifest::new(Vec::new(), names.iter().copied()).methods;
    let is_default = manifest.methods.is_empty();
    if is_default {
        manifest.methods = entries(&OWN_METHODS);
    } else if !wants_mitsuba(manifest) {
        return None;
    }
    match Mitsuba::find(interrupt::requested) {
        Ok(mitsuba) => {
            if let Some(advice) = mitsuba.advice() {
                complain("note", advice);
            }
            if is_default {
                manifest.methods.extend(entries(&MITSUBA_METHODS));
            }
            Some(mitsuba)
        }
        Err(why) => {
            complain("note", &format!("without Mitsuba: {why}"));
            None
        }
    }
}

/// As a method, or for a reference.
fn wants_mitsuba(manifest: &Manifest) -> bool {
    let by_mitsuba = |policy: &ReferencePolicy| match policy {
        ReferencePolicy::Rendered(reference) => reference.method.starts_with(MITSUBA),
        _ => false,
    };
    let mut policies = manifest.scenes.iter().filter_map(|scene| scene.reference.as_ref());
    manifest.methods.iter().any(|method| method.integrator.starts_with(MITSUBA))
        || by_mitsuba(&manifest.reference)
        || policies.any(by_mitsuba)
}

fn load_all(manifest: &Manifest) -> anyhow::Result<Vec<Subject>> {
    let load = |entry: &SceneEntry| {
        let film = entry.film.as_deref().map(args::film_size).transpose();
        let film = film.map_err(|expected| UsageError(format!("film of {}: {expected}", entry.file.display())))?;
        let camera = entry.camera.clone();
        let light_selection = manifest.light_selection;
        let parameters = entry.parameters.clone().into_iter().collect();
        let materials = manifest.materials.unwrap_or_default();
        let options = LoadOptions { film, camera, light_selection, parameters, materials, ..LoadOptions::default() };
        let subject = load(&entry.file, &options)?;
        let is_xml = subject.scene.source().extension().is_some_and(|ending| ending == "xml");
        if is_xml && wants_mitsuba(manifest) {
            let name = subject.scene.name();
            complain("note", &format!("{name}: Mitsuba renders it by our export, not from the file itself"));
        }
        Ok(subject)
    };
    manifest.scenes.iter().map(|entry| load(entry)).collect()
}

/// What glTF's materials become: as was asked for, or Mitsuba's model where Mitsuba takes part.
pub(super) fn materials(asked: Option<MaterialModel>, with_mitsuba: bool) -> MaterialModel {
    asked.unwrap_or(if with_mitsuba { MaterialModel::Principled } else { MaterialModel::Gltf })
}

/// Says so where nobody asked for it.
pub(super) fn tell_materials(asked: Option<MaterialModel>, subjects: &[Subject]) {
    for subject in subjects.iter().filter(|_| asked.is_none()) {
        let is_gltf = !subject.scene.source().extension().is_some_and(|ending| ending.eq_ignore_ascii_case("xml"));
        let turned =
            |material: &Material| material.bsdf.contains(&|bsdf| matches!(bsdf, BsdfDescription::Principled(_)));
        if is_gltf && subject.description.materials.iter().any(turned) {
            let what = "its materials are Mitsuba's principled, so that all methods render the same; --materials gltf \
                        keeps glTF's own, which Mitsuba does not have";
            complain("note", &format!("{}: {what}", subject.scene.name()));
        }
    }
}

pub(super) fn load(word: &Path, options: &LoadOptions) -> anyhow::Result<Subject> {
    let start = Instant::now();
    let loaded = scene::load(word, options)?;
    let all = start.elapsed().as_secs_f64();
    scene::show(&loaded.notes);
    // Built once more, to tell its time from that of reading.
    let start = Instant::now();
    let again = SceneOptions { film: options.film, light_selection: options.light_selection };
    Scene::build(&loaded.description, again)?;
    let build_seconds = start.elapsed().as_secs_f64();
    let load_seconds = (all - build_seconds).max(0.0);
    let fingerprint = scene::fingerprint(&loaded.description);
    Ok(Subject { scene: loaded.scene, description: loaded.description, fingerprint, load_seconds, build_seconds })
}
