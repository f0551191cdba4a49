//! `measure`: radiometric quantities of a scene, each with its unit and confidence.

use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::anyhow;
use clap::Args;
use statrs::distribution::{ContinuousCDF, Normal};

use crate::estimator::{Control, Method, Registry};
use crate::film::Film;
use crate::names::did_you_mean;
use crate::scene::description::{FilmSize, PixelFilter, Projection};
use crate::scene::meter::{Aim, Meter, NamedMeter};
use crate::scene::{Scene, SceneDescription, SceneOptions};

use super::args::{self, MaxLength, ParameterArgs};
use super::scene::{self, LoadOptions};
use super::{Outcome, UsageError, complain};

const AFTER_HELP: &str = "\
Meters (numbers in the scene's coordinates [m]):
  irradiance:X,Y,Z:NX,NY,NZ             at a point, of a surface that faces N [W/m²]
  irradiance:X,Y,Z:UX,UY,UZ:VX,VY,VZ    its mean over the rectangle with a corner and two sides at right angles, of light
                                        that arrives on the side where U × V points [W/m²]
  irradiance:SURFACE                    its mean over the front of a flat rectangular mesh, by name
  flux:X,Y,Z:UX,UY,UZ:VX,VY,VZ          through such a rectangle [W]
  flux:SURFACE                          onto the front of such a surface
  flux:SURFACE:leaving                  what leaves it there, emitted and reflected
  radiance:X,Y,Z:DX,DY,DZ               that arrives at a point from the direction D [W/m²/sr]
  intensity:DX,DY,DZ                    of all that emits or scatters, seen from far away in the direction D [W/sr]
Each is a sensor of path space with its own importance function. Put points and rectangles a little in front of surfaces, not
on them. A scene can bring meters along, by name, as `sensors` in its extras: scenes/README.md.
The interval is that of the mean of independent passes, normally distributed; beware where single paths carry much.

Examples:
  pathspace measure cornell_box                   all that the scene brings along
  pathspace measure cornell_box --sensor lamp     one of them
  pathspace measure cornell_box --sensor irradiance:0.4,0.001,0.1:0,1,0 -i path -i light";

/// Measure irradiance, flux, radiance or intensity in a scene, with confidence intervals
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct MeasureArgs {
    /// A .gltf, .glb or Mitsuba .xml file, a folder with one, or the name of a folder in scenes/
    scene: PathBuf,

    /// What to measure, and where, or the name of one of the scene's sensors; may be repeated [default: all of the scene's]
    #[arg(long = "sensor", value_name = "METER|NAME")]
    sensors: Vec<String>,

    /// Integrators, with settings if you like; may be repeated [default: path]
    #[arg(short, long = "integrator", value_name = "NAME[:setting=value…]")]
    integrators: Vec<String>,

    #[command(flatten)]
    defined: ParameterArgs,

    /// Samples in all, at least
    #[arg(long, value_name = "N", default_value_t = 1_000_000, value_parser = clap::value_parser!(u64).range(64..))]
    samples: u64,

    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,

    /// Longest path in edges, or none [default: the scene's]
    #[arg(long, value_name = "EDGES", value_parser = args::max_length)]
    max_length: Option<MaxLength>,

    /// Probability that the interval holds the true value
    #[arg(long, value_name = "P", default_value_t = 0.95)]
    confidence: f64,
}

/// A meter with the scene that it is the sensor of.
struct Measurement {
    /// `floor: `, where the scene calls it that.
    prefix: String,
    aim: Aim,
    scene: Scene,
}

struct Passes(u64);

impl Control for Passes {
    fn next_passes(&mut self, film: &Film) -> u64 {
        self.0.saturating_sub(film.passes())
    }
}

pub(super) fn run(registry: &Registry, args: &MeasureArgs) -> anyhow::Result<Outcome> {
    if !(args.confidence > 0.0 && args.confidence < 1.0) {
        return Err(usage(format!("--confidence {}: expected a probability between 0 and 1", args.confidence)));
    }
    let parameters = args.defined.parameters.clone();
    let materials = args.defined.materials.unwrap_or_default();
    let options = LoadOptions { parameters, materials, ..LoadOptions::default() };
    let description = scene::load(&args.scene, &options)?.description;
    let asked = asked(&args.sensors, &description)?;
    let mut measurements = Vec::new();
    for asked in &asked {
        measurements.push(asked.measurement(&description)?);
    }
    let longest = args.max_length.map_or(description.render.max_length, |length| length.0);
    let defaults = [("max_length", longest.map_or("none".to_owned(), |k| k.to_string()))];
    let labels = if args.integrators.is_empty() { vec!["path".to_owned()] } else { args.integrators.clone() };
    let mut methods = Vec::new();
    for label in &labels {
        let method = registry.build(label, &defaults)?;
        for Measurement { prefix, scene, .. } in &measurements {
            let unsupported = |why| anyhow!("{}: {prefix}integrator {label}: {why}", scene.name());
            method.integrator.supports(scene).map_err(unsupported)?;
        }
        methods.push((label.as_str(), method));
    }
    let mut out = io::stdout().lock();
    for (number, measurement) in measurements.iter().enumerate() {
        if number > 0 {
            writeln!(out)?;
        }
        measurement.write(&mut out, args, &methods)?;
    }
    out.flush()?;
    Ok(Outcome::Done)
}

impl Measurement {
    fn write(&self, out: &mut impl Write, args: &MeasureArgs, methods: &[(&str, Method)]) -> anyhow::Result<()> {
        let Self { prefix, aim, scene } = self;
        let FilmSize { width, height } = scene.sensor().film();
        let passes = args.samples.div_ceil(u64::from(width * height)).max(16);
        let quantile = Normal::standard().inverse_cdf(0.5 + 0.5 * args.confidence);
        let (quantity, unit, confidence) = (aim.quantity, aim.unit, 100.0 * args.confidence);
        writeln!(out, "{prefix}{quantity} [{unit}] in {}, {confidence} % confidence", scene.name())?;
        writeln!(out, "{:<20} {:>20} {:>20} {:>20}", "integrator", "red", "green", "blue")?;
        for (label, method) in methods {
            let mut film = Film::new(width, height, None)?;
            method.integrator.render(scene, args.seed, &mut film, &mut Passes(passes));
            write!(out, "{:<20}", label.chars().take(20).collect::<String>())?;
            for moments in &film.block_statistics().image()[..3] {
                let half = quantile * moments.variance_of_mean().sqrt() * aim.scale;
                write!(out, " {:>20}", format!("{:.5e} ± {half:.0e}", moments.mean * aim.scale))?;
            }
            writeln!(out)?;
            if let Some(misses) = method.integrator.misses(scene) {
                complain("note", &format!("{prefix}{label}: {misses}"));
            }
            let invalid = film.counters.invalid;
            if invalid > 0 {
                complain("note", &format!("{prefix}{label}: {invalid} values are not finite and not counted"));
            }
        }
        Ok(())
    }
}

/// A meter, and where it is from.
enum Asked<'a> {
    /// The command line.
    Here(&'a str, Meter),
    /// The scene.
    Scene(&'a NamedMeter),
}

impl Asked<'_> {
    fn measurement(&self, description: &SceneDescription) -> anyhow::Result<Measurement> {
        let (prefix, aim) = match self {
            Self::Here(text, meter) => {
                (String::new(), meter.aim(description).map_err(|error| usage(format!("--sensor {text}: {error}")))?)
            }
            Self::Scene(NamedMeter { name, meter }) => {
                let file = description.source.display();
                (
                    format!("{name}: "),
                    meter.aim(description).map_err(|error| anyhow!("{file}: sensor {name}: {error}"))?,
                )
            }
        };
        let ray = aim.sensor.projection == Projection::Ray;
        let film = if ray { FilmSize { width: 1, height: 1 } } else { FilmSize { width: 64, height: 64 } };
        let description =
            SceneDescription { sensor: Some(aim.sensor.clone()), filter: PixelFilter::Box, ..description.clone() };
        let (scene, _) = Scene::build(&description, SceneOptions { film: Some(film), ..SceneOptions::default() })?;
        Ok(Measurement { prefix, aim, scene })
    }
}

/// The meters that the user asks for: all of the scene's without a word.
fn asked<'a>(words: &'a [String], scene: &'a SceneDescription) -> anyhow::Result<Vec<Asked<'a>>> {
    if words.is_empty() && scene.meters.is_empty() {
        return Err(usage(format!(
            "{} has no sensors of its own: name a meter with --sensor; `pathspace measure --help` shows the forms",
            scene.name
        )));
    }
    if words.is_empty() {
        return Ok(scene.meters.iter().map(Asked::Scene).collect());
    }
    words.iter().map(|word| one(word, scene)).collect()
}

fn one<'a>(word: &'a str, scene: &'a SceneDescription) -> anyhow::Result<Asked<'a>> {
    if let Some(named) = scene.meters.iter().find(|named| named.name == word) {
        return Ok(Asked::Scene(named));
    }
    // Names have no colons.
    if word.contains(':') || Meter::is_kind(word) {
        let wrong = |error| usage(format!("--sensor {word}: {error}; `pathspace measure --help` shows the forms"));
        return word.parse().map(|meter| Asked::Here(word, meter)).map_err(wrong);
    }
    let names = || scene.meters.iter().map(|named| named.name.as_str());
    let suggestion = did_you_mean(word, names());
    let listed = match scene.meters.len() {
        0 => "it has none of its own".to_owned(),
        _ => format!("it has {}", names().collect::<Vec<_>>().join(", ")),
    };
    Err(usage(format!(
        "--sensor {word}: {} has no such sensor{suggestion}; {listed}, and `pathspace measure --help` shows how to write others",
        scene.name
    )))
}

fn usage(text: String) -> anyhow::Error {
    UsageError(text).into()
}
