//! `measure`: radiometric quantities of a scene, each with its unit and confidence.

use std::f64::consts::PI;
use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::anyhow;
use clap::Args;
use glam::DVec3;
use statrs::distribution::{ContinuousCDF, Normal};

use crate::estimator::{Control, Registry};
use crate::film::Film;
use crate::scene::description::{FilmSize, LightKind, Projection, SensorDescription};
use crate::scene::{Scene, SceneDescription, SceneOptions};

use super::args::{self, MaxLength};
use super::scene::{self, LoadOptions};
use super::{Outcome, UsageError};

const AFTER_HELP: &str = "\
Meters (numbers in the scene's coordinates [m]):
  irradiance:X,Y,Z:NX,NY,NZ             at a point, of a surface that faces N [W/m²]
  flux:X,Y,Z:UX,UY,UZ:VX,VY,VZ          through the rectangle with a corner and two sides at right angles, of light that
                                        arrives on the side where U × V points [W]
  radiance:X,Y,Z:DX,DY,DZ               that arrives at a point from the direction D [W/m²/sr]
  intensity:DX,DY,DZ                    of all that emits or scatters, seen from far away in the direction D [W/sr]
Each is a sensor of path space with its own importance function. Put meters a little in front of surfaces, not on them.
The interval is that of the mean of independent passes, normally distributed; beware where single paths carry much.

Example:
  pathspace measure cornell_box --sensor irradiance:0.4,0.001,0.1:0,1,0 -i path -i light";

/// Measure irradiance, flux, radiance or intensity in a scene, with confidence intervals
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct MeasureArgs {
    /// A .gltf or .glb file, a folder with one, or the name of a folder in scenes/
    scene: PathBuf,

    /// What to measure, and where
    #[arg(long, value_name = "METER")]
    sensor: String,

    /// Integrators, with settings if you like; may be repeated [default: path]
    #[arg(short, long = "integrator", value_name = "NAME[:setting=value…]")]
    integrators: Vec<String>,

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

/// What is measured: a sensor, and what its mean pixel is multiplied by.
struct Meter {
    name: &'static str,
    unit: &'static str,
    sensor: SensorDescription,
    scale: f64,
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
    let mut description = scene::load(&args.scene, &LoadOptions::default())?.description;
    let meter = meter(&args.sensor, &description)?;
    description.sensor = Some(meter.sensor.clone());
    let ray = meter.sensor.projection == Projection::Ray;
    let film = if ray { FilmSize { width: 1, height: 1 } } else { FilmSize { width: 64, height: 64 } };
    let (scene, _) = Scene::build(&description, SceneOptions { film: Some(film), ..SceneOptions::default() })?;
    let longest = args.max_length.map_or(scene.hints().max_length, |length| length.0);
    let defaults = [("max_length", longest.map_or("none".to_owned(), |k| k.to_string()))];
    let labels = if args.integrators.is_empty() { vec!["path".to_owned()] } else { args.integrators.clone() };
    let passes = args.samples.div_ceil(u64::from(film.width * film.height)).max(16);
    let quantile = Normal::standard().inverse_cdf(0.5 + 0.5 * args.confidence);
    let mut methods = Vec::new();
    for label in &labels {
        let method = registry.build(label, &defaults)?;
        let unsupported = |why| anyhow!("{}: integrator {label}: {why}", scene.name());
        method.integrator.supports(&scene).map_err(unsupported)?;
        methods.push((label, method));
    }
    let mut out = io::stdout().lock();
    writeln!(out, "{} [{}] in {}, {} % confidence", meter.name, meter.unit, scene.name(), 100.0 * args.confidence)?;
    writeln!(out, "{:<20} {:>20} {:>20} {:>20}", "integrator", "red", "green", "blue")?;
    for (label, method) in &methods {
        let mut film = Film::new(film.width, film.height, None)?;
        method.integrator.render(&scene, args.seed, &mut film, &mut Passes(passes));
        write!(out, "{:<20}", label.chars().take(20).collect::<String>())?;
        for moments in &film.block_statistics().image()[..3] {
            let half = quantile * moments.variance_of_mean().sqrt() * meter.scale;
            write!(out, " {:>20}", format!("{:.5e} ± {half:.0e}", moments.mean * meter.scale))?;
        }
        writeln!(out)?;
        if let Some(misses) = method.integrator.misses(&scene) {
            super::complain("note", &format!("{label}: {misses}"));
        }
        if film.counters.invalid > 0 {
            super::complain(
                "note",
                &format!("{label}: {} values are not finite and not counted", film.counters.invalid),
            );
        }
    }
    out.flush()?;
    Ok(Outcome::Done)
}

fn usage(text: String) -> anyhow::Error {
    UsageError(text).into()
}

fn meter(text: &str, scene: &SceneDescription) -> anyhow::Result<Meter> {
    let wrong = |what: &str| usage(format!("--sensor {text}: {what}; `pathspace measure --help` shows the forms"));
    let (kind, rest) = text.split_once(':').ok_or_else(|| wrong("names a meter, then numbers after a colon"))?;
    let vectors = rest.split(':').map(vector).collect::<Option<Vec<DVec3>>>();
    let vectors = vectors.ok_or_else(|| wrong("expected three finite numbers with commas between"))?;
    let unit = |v: DVec3| v.try_normalize().ok_or_else(|| wrong("a direction must not be zero"));
    let sensor = |position: DVec3, forward: DVec3, right: DVec3, projection: Projection| SensorDescription {
        name: kind.into(),
        position,
        forward,
        up: right.cross(forward),
        projection,
    };
    match (kind, &vectors[..]) {
        ("irradiance", &[position, normal]) => {
            let normal = unit(normal)?;
            let sensor = sensor(position, normal, normal.any_orthonormal_vector(), Projection::Hemisphere);
            Ok(Meter { name: "irradiance", unit: "W/m²", sensor, scale: PI })
        }
        ("flux", &[corner, u, v]) => {
            let forward = unit(u.cross(v))?;
            if u.dot(v).abs() > 1e-9 * u.length() * v.length() {
                return Err(wrong("the sides must be at right angles"));
            }
            let (half_width, half_height) = (0.5 * u.length(), 0.5 * v.length());
            let centre = corner + 0.5 * (u + v);
            let sensor = sensor(centre, forward, unit(u)?, Projection::Window { half_width, half_height });
            Ok(Meter { name: "flux", unit: "W", sensor, scale: PI * u.length() * v.length() })
        }
        ("radiance", &[position, direction]) => {
            let forward = unit(direction)?;
            for light in &scene.lights {
                let (LightKind::Point { position: at, .. } | LightKind::Spot { position: at, .. }) = light.kind else {
                    continue;
                };
                let along = (at - position).dot(forward);
                let beside = (at - position - forward * along).length();
                if along > 0.0 && beside < 1e-9 * along {
                    return Err(wrong(&format!(
                        "the ray meets the point light '{}', whose radiance is no number but a Dirac distribution: ask for \
                         its irradiance",
                        light.name
                    )));
                }
            }
            let sensor = sensor(position, forward, forward.any_orthonormal_vector(), Projection::Ray);
            Ok(Meter { name: "radiance", unit: "W/m²/sr", sensor, scale: 1.0 })
        }
        ("intensity", &[direction]) => intensity(unit(direction)?, scene).map_err(|what| wrong(&what)),
        ("irradiance" | "flux" | "radiance" | "intensity", _) => Err(wrong("another number of vectors is expected")),
        _ => Err(wrong("known meters are irradiance, flux, radiance, intensity")),
    }
}

/// A parallel projection of everything: `I(ω) = ∫ L cos θ dA` over its film.
fn intensity(direction: DVec3, scene: &SceneDescription) -> Result<Meter, String> {
    if let Some(light) = scene.lights.first() {
        return Err(format!(
            "the light '{}' has no surface, so nothing sees it from afar: its intensity is its own",
            light.name
        ));
    }
    if scene.environment.is_some() {
        return Err("the environment would be seen behind everything".into());
    }
    let bounds = scene.bounds().ok_or("the scene has no surfaces")?;
    let (centre, radius) = (bounds.centre(), bounds.radius() * 1.001);
    let right = direction.any_orthonormal_vector();
    let sensor = SensorDescription {
        name: "intensity".into(),
        position: centre + direction * (2.0 * radius),
        forward: -direction,
        up: right.cross(-direction),
        projection: Projection::Orthographic { half_width: radius, half_height: radius },
    };
    Ok(Meter { name: "intensity", unit: "W/sr", sensor, scale: 4.0 * radius * radius })
}

fn vector(text: &str) -> Option<DVec3> {
    let numbers = text.split(',').map(|x| x.trim().parse().ok().filter(|x: &f64| x.is_finite()));
    match numbers.collect::<Option<Vec<f64>>>()?[..] {
        [x, y, z] => Some(DVec3::new(x, y, z)),
        _ => None,
    }
}
