//! `render`: one image by one integrator.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::{anyhow, bail};
use clap::Args;
use serde::{Deserialize, Serialize};

use crate::estimator::{Method, Registry};
use crate::film::{Film, OutputFormat, RenderInfo, ReplayKey, check_writable, state};
use crate::scene::LightSelection;
use crate::scene::description::{FilmSize, PixelFilter};
use crate::scene::gltf::MaterialModel;

use super::args::{self, MaxLength, SceneArgs};
use super::layers::{self, LayerArgs};
use super::progress::{mean_luminance, noise, percent, si};
use super::scene::{self, LoadOptions, LoadedScene};
use super::session::{Budget, Outputs, Session};
use super::{Outcome, UsageError, complain, interrupt, method, replay};

const EXAMPLES: &str = "\
Examples:
  pathspace render cornell_box -o box.exr                     64 samples per pixel with `path`
  pathspace render scene.glb -i light --seconds 30 -o a.png   half a minute of light tracing, to look at
  pathspace render cornell_box -i path:heuristic=power:exponent=2:roulette=off --max-length 8 -o box.exr
  pathspace render cornell_box --spp 256 --state box.film -o box.exr
  pathspace render cornell_box --spp 1024 --resume box.film -o box.exr      768 more: the bits of one go
  pathspace render cornell_box -i bdpt --layers length,technique -o box.exr      for `pathspace pyramid box.exr`
  pathspace render cornell_box --replay 0:12,34:567           the paths of a sample, in metres";

const DEFAULT_SPP: u64 = 64;

/// Render a scene into an EXR or PNG image
///
/// The image depends on scene, integrator, seed and number of samples alone: not on threads, batches or interruptions.
/// Ctrl-C finishes the present pass and writes the image and the state OUTPUT.film, from which --resume goes on.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct RenderArgs {
    /// A .gltf, .glb or Mitsuba .xml file, a folder with one, or the name of a folder in scenes/
    scene: PathBuf,

    /// Integrator, with settings if you like; `pathspace list` shows them [default: path]
    #[arg(short, long, value_name = "NAME[:setting=value…]")]
    integrator: Option<String>,

    /// Samples per pixel in all, those of a resumed film included [default: 64]
    #[arg(long, value_name = "N", conflicts_with = "seconds", value_parser = clap::value_parser!(u64).range(1..))]
    spp: Option<u64>,

    /// Rendering time in seconds in all, without loading and output, that of a resumed film included
    #[arg(long, value_name = "SECONDS", value_parser = args::seconds)]
    seconds: Option<f64>,

    /// Seed of the random numbers [default: 0]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,

    /// Threads; 0 takes all that the machine has
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(..=1024))]
    threads: u16,

    /// Longest path in edges, or none for unlimited; equals Mitsuba's max_depth [default: the scene's]
    #[arg(long, value_name = "EDGES", value_parser = args::max_length)]
    max_length: Option<MaxLength>,

    /// How one of several emitters is chosen: in proportion to its flux, or all alike [default: power]
    #[arg(long, value_name = "HOW", value_parser = args::light_selection())]
    light_selection: Option<LightSelection>,

    #[command(flatten)]
    take: SceneArgs,

    /// Image to write: .exr (linear, standard error as a layer, metadata) or .png (tone-mapped, for looking)
    #[arg(short, long, value_name = "FILE", required_unless_present = "replay")]
    output: Option<PathBuf>,

    /// Brightness of a PNG in stops
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true, value_parser = args::finite)]
    exposure: f64,

    /// Keep the state of the render in this .film file, for --resume. Without it, a state is written only with
    /// --checkpoints and on Ctrl-C: beside the image, ending with .film
    #[arg(long, value_name = "FILE")]
    state: Option<PathBuf>,

    /// Go on with the render in a .film file, with its seed, integrator and film; the new state goes back there unless
    /// --state names another file
    #[arg(long, value_name = "FILE", conflicts_with = "replay")]
    resume: Option<PathBuf>,

    #[command(flatten)]
    layers: LayerArgs,

    /// Write image and state at 1, 2, 4, 8, … seconds of rendering too, each over the one before
    #[arg(long)]
    checkpoints: bool,

    /// Render nothing; print the terms and paths of one sample, with positions in metres in the world
    #[arg(long, value_name = "SEED:X,Y:SAMPLE")]
    replay: Option<ReplayKey>,
}

/// What an image depends on beside seed and size; kept with it as JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct RunSettings {
    integrator: BTreeMap<String, String>,
    light_selection: LightSelection,
    camera: Option<String>,
    #[serde(default)]
    filter: PixelFilter,
    /// Of the scene.
    #[serde(default)]
    parameters: BTreeMap<String, String>,
    #[serde(default)]
    materials: MaterialModel,
    /// See [`scene::fingerprint`].
    scene: String,
}

/// A film that is to be gone on with.
struct Resumed {
    path: PathBuf,
    film: Film,
    info: RenderInfo,
    settings: RunSettings,
}

impl Resumed {
    fn load(path: &Path) -> anyhow::Result<Self> {
        let (film, info) = state::load(path)?;
        let settings = serde_json::from_value(info.settings.clone()).map_err(|error| {
            anyhow!("{}: was not written by `pathspace render` ({error}); render anew", path.display())
        })?;
        Ok(Self { path: path.to_owned(), film, info, settings })
    }

    /// The integrator as a user would ask for it.
    fn method(&self) -> String {
        let settings = self.settings.integrator.iter().map(|(key, value)| format!(":{key}={value}"));
        std::iter::once(self.info.integrator.clone()).chain(settings).collect()
    }

    /// Refuses to mix two renders.
    fn check(&self, info: &RenderInfo, settings: &RunSettings, size: FilmSize) -> anyhow::Result<()> {
        let film = FilmSize { width: self.film.width(), height: self.film.height() };
        let size_of = |size: FilmSize| format!("{}x{}", size.width, size.height);
        let methods = |settings: &RunSettings, name: &str| format!("{name} {:?}", settings.integrator);
        let lights = |settings: &RunSettings| format!("{:?}", settings.light_selection).to_lowercase();
        let pairs = [
            ("scene", self.info.scene.clone(), info.scene.clone()),
            ("film", size_of(film), size_of(size)),
            ("seed", self.info.seed.to_string(), info.seed.to_string()),
            ("integrator", methods(&self.settings, &self.info.integrator), methods(settings, &info.integrator)),
            ("light selection", lights(&self.settings), lights(settings)),
            ("pixel filter", self.settings.filter.to_string(), settings.filter.to_string()),
            ("content of the scene", self.settings.scene.clone(), settings.scene.clone()),
        ];
        match pairs.into_iter().find(|(_, theirs, ours)| theirs != ours) {
            None => Ok(()),
            Some((what, theirs, ours)) => bail!(
                "{}: {what}: the film was rendered with {theirs}, now it is {ours}; make them equal or render anew",
                self.path.display()
            ),
        }
    }
}

pub(super) fn run(registry: &Registry, args: &RenderArgs) -> anyhow::Result<Outcome> {
    args.layers.check(args.output.as_deref(), args.resume.as_deref())?;
    let resumed = args.resume.as_deref().map(Resumed::load).transpose()?;
    let loaded = load_scene(args, resumed.as_ref())?;
    let method = make_method(registry, args, resumed.as_ref(), &loaded)?;
    scene::show(&loaded.notes);
    if let Some(key) = args.replay {
        return replay::run(&loaded.scene, &method, key);
    }
    let Some(outputs) = outputs(args)? else { bail!(UsageError("say where the image goes: -o FILE".into())) };

    let size = loaded.scene.sensor().film();
    let settings = RunSettings {
        integrator: method.settings.clone(),
        light_selection: light_selection_of(args, resumed.as_ref()),
        camera: camera_of(args, resumed.as_ref()),
        filter: loaded.description.filter,
        parameters: loaded.description.parameters.clone(),
        materials: materials_of(args, resumed.as_ref()),
        scene: scene::fingerprint(&loaded.description),
    };
    let mut info = RenderInfo {
        scene: loaded.scene.name().to_owned(),
        integrator: method.name.to_owned(),
        settings: serde_json::to_value(&settings)?,
        seed: args.seed.or(resumed.as_ref().map(|r| r.info.seed)).unwrap_or(0),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        ..RenderInfo::default()
    };
    let mut film = match resumed {
        None => Film::new(size.width, size.height, None)
            .map_err(|error| anyhow!("{}: film: {error}", loaded.scene.source().display()))?,
        Some(resumed) => {
            resumed.check(&info, &settings, size)?;
            (info.render_seconds, info.cpu_seconds) = (resumed.info.render_seconds, resumed.info.cpu_seconds);
            resumed.film
        }
    };

    args.layers.keep_in(&mut film)?;

    interrupt::listen()?;
    let threads = rayon::ThreadPoolBuilder::new().num_threads(args.threads.into()).build();
    let threads = threads.map_err(|error| anyhow!("threads: {error}; ask for fewer with --threads"))?;
    let budget = args.seconds.map_or(Budget::Passes(args.spp.unwrap_or(DEFAULT_SPP)), Budget::Seconds);
    let (seed, before) = (info.seed, film.passes());
    let mut session = Session::new(budget, outputs.clone(), info, &film, args.checkpoints);
    threads.install(|| method.integrator.render(&loaded.scene, seed, &mut film, &mut session));
    session.end();
    if film.passes() == 0 {
        layers::check_kept(method.name, &film, &outputs.image)?;
    }
    let outcome = finish(&loaded, &method, &film, &session, &outputs, before)?;
    layers::check_kept(method.name, &film, &outputs.image)?;
    Ok(outcome)
}

fn light_selection_of(args: &RenderArgs, resumed: Option<&Resumed>) -> LightSelection {
    args.light_selection.or(resumed.map(|r| r.settings.light_selection)).unwrap_or_default()
}

fn camera_of(args: &RenderArgs, resumed: Option<&Resumed>) -> Option<String> {
    args.take.camera.clone().or_else(|| resumed.and_then(|r| r.settings.camera.clone()))
}

/// Those of the image that is gone on with, and what the command line says instead.
fn parameters_of(args: &RenderArgs, resumed: Option<&Resumed>) -> Vec<(String, String)> {
    let resumed = resumed.map(|r| r.settings.parameters.clone()).unwrap_or_default();
    resumed.into_iter().chain(args.take.defined.parameters.clone()).collect()
}

/// Those of the image that is gone on with, unless the command line says others.
fn materials_of(args: &RenderArgs, resumed: Option<&Resumed>) -> MaterialModel {
    let resumed = resumed.map(|resumed| resumed.settings.materials);
    args.take.defined.materials.or(resumed).unwrap_or_default()
}

fn load_scene(args: &RenderArgs, resumed: Option<&Resumed>) -> anyhow::Result<LoadedScene> {
    let size = resumed.map(|r| FilmSize { width: r.film.width(), height: r.film.height() });
    let options = LoadOptions {
        camera: camera_of(args, resumed),
        film: args.take.film.or(size),
        environment: args.take.environment.clone(),
        filter: args.take.pixel_filter.or(resumed.map(|r| r.settings.filter)),
        light_selection: light_selection_of(args, resumed),
        parameters: parameters_of(args, resumed),
        materials: materials_of(args, resumed),
    };
    scene::load(&args.scene, &options)
}

fn make_method(
    registry: &Registry,
    args: &RenderArgs,
    resumed: Option<&Resumed>,
    loaded: &LoadedScene,
) -> anyhow::Result<Method> {
    let text = args.integrator.clone().or_else(|| resumed.map(Resumed::method));
    method::build(registry, text.as_deref(), args.max_length, &loaded.scene)
}

/// Checked before the first pass: nobody wants to learn afterwards that the image has no place.
fn outputs(args: &RenderArgs) -> anyhow::Result<Option<Outputs>> {
    let Some(image) = args.output.clone() else { return Ok(None) };
    check_writable(&image)?;
    OutputFormat::from_path(&image)?;
    let asked = args.state.clone().or_else(|| args.resume.clone());
    let keep_state = asked.is_some() || args.checkpoints;
    let state = asked.unwrap_or_else(|| image.with_extension("film"));
    if state.extension().is_none_or(|ending| ending != "film") {
        bail!(UsageError(format!("{}: the name of a state must end with .film", state.display())));
    }
    if keep_state {
        check_writable(&state)?;
    }
    Ok(Some(Outputs { image, state, keep_state, exposure: args.exposure }))
}

/// Writes what there is, and says what it is worth.
fn finish(
    loaded: &LoadedScene,
    method: &Method,
    film: &Film,
    session: &Session,
    outputs: &Outputs,
    before: u64,
) -> anyhow::Result<Outcome> {
    let outcome = if session.interrupted() { Outcome::Interrupted } else { Outcome::Done };
    if film.passes() == 0 {
        complain("note", "interrupted before the first pass was finished: nothing is written");
        return Ok(outcome);
    }
    let with_state = outputs.keep_state || session.interrupted();
    let (info, standing) = (session.info(), session.standing(film));
    outputs.write(film, &info, with_state)?;
    if film.passes() == before {
        complain("note", &format!("the film holds {before} samples per pixel already: raise --spp or --seconds"));
    }
    warn_of_impossible_values(loaded, method, film);

    let (mean, relative) = mean_luminance(film);
    let error = relative.map_or_else(String::new, |relative| format!(" ± {}", percent(relative)));
    let noise = noise(film).map_or_else(String::new, |noise| format!(", noise per pixel {}", percent(noise)));
    let mut out = io::stdout().lock();
    writeln!(
        out,
        "{}, {}, {}x{}: {} spp in {:.2} s, {}samples/s, {}rays/s",
        info.scene,
        method.label,
        film.width(),
        film.height(),
        film.passes(),
        info.render_seconds,
        si(standing.samples_per_second),
        si(standing.rays_per_second)
    )?;
    writeln!(out, "mean luminance {mean:.6}{error}{noise} (standard errors)")?;
    write!(out, "wrote {}{}", outputs.image.display(), layers::told(film))?;
    if with_state {
        write!(out, " and {}", outputs.state.display())?;
    }
    writeln!(out)?;
    out.flush()?;
    Ok(outcome)
}

fn warn_of_impossible_values(loaded: &LoadedScene, method: &Method, film: &Film) {
    let counters = &film.counters;
    if counters.invalid == 0 && counters.negative == 0 {
        return;
    }
    let keys: Vec<String> = counters.replay.iter().map(ToString::to_string).collect();
    complain(
        "warning",
        &format!(
            "{}, {}: {} contributions were NaN or infinite and are left out, {} were negative: the image cannot be right; \
             look at one with --replay: {}",
            loaded.scene.name(),
            method.label,
            counters.invalid,
            counters.negative,
            keys.join(" ")
        ),
    );
}
