//! `direct`: the last edge of a path, the one that leaves the emitter, drawn in one of the ways of a first lecture on the
//! rendering equation: by directions or by areas. The vertices before it are those of a walk from the sensor by its BSDFs.
//!
//! With paths of two edges at most (`--max-length 2`) it is direct lighting, and the five ways can be compared on their own.

use std::f64::consts::{FRAC_1_PI, PI};
use std::ops::RangeInclusive;
use std::sync::Arc;

use glam::DVec3;
use pathspace::estimator::{SamplerEntry, Settings, SettingsError};
use pathspace::geometry::Frame;
use pathspace::measure::{Area, Density, SolidAngle};
use pathspace::path::{Edge, Path, Roulette, Technique, Vertex};
use pathspace::sampler::{PathSampler, Random, Tracer, walk_from_sensor};
use pathspace::scene::Scene;
use pathspace::scene::bsdf::Side;
use pathspace::scene::emitter::Emitter;
use pathspace::scene::sensor::Pixel;
use pathspace::warp;
use pathspace::wide::Wide;

/// For the registry.
pub const SAMPLER: SamplerEntry = SamplerEntry {
    name: "direct",
    summary: "the edge from the emitter by=hemisphere, cosine, bsdf, emitters (default) or surfaces",
    build: |settings| Ok(Arc::new(Direct::new(settings)?)),
};

/// How x_0 is drawn for x_1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum By {
    /// A direction of the hemisphere (of the sphere where light passes through): `p_σ = 1/2π` (`1/4π`).
    Hemisphere,
    /// A direction by its cosine: `p_σ = |cos θ|/π` (`|cos θ|/2π`).
    Cosine,
    /// A direction by the BSDF.
    Bsdf,
    /// A point of a chosen emitter, by area: `p = P(emitter)/A`. Emitters at infinity have no area: by direction.
    Emitters,
    /// A point of all surfaces, by area: `p = 1/A`.
    Surfaces,
}

/// The sampler and its settings.
#[derive(Clone, Copy, Debug)]
pub struct Direct {
    /// How the emitter is found.
    pub by: By,
    /// How walks end.
    pub roulette: Roulette,
}

impl Direct {
    /// From the user's settings.
    ///
    /// # Errors
    /// Where one makes no sense.
    pub fn new(settings: &mut Settings) -> Result<Self, SettingsError> {
        let by = settings.get("by", "emitters".to_owned(), "")?;
        let by = match by.as_str() {
            "hemisphere" => By::Hemisphere,
            "cosine" => By::Cosine,
            "bsdf" => By::Bsdf,
            "emitters" => By::Emitters,
            "surfaces" => By::Surfaces,
            _ => return Err(Settings::wrong("by", &by, "hemisphere, cosine, bsdf, emitters or surfaces")),
        };
        Ok(Self { by, roulette: settings.roulette(Roulette::Local { start: 3, long: Roulette::LONG_FOR_PAIRS })? })
    }

    /// x_0 is what a ray from x_1 meets.
    fn by_direction(&self) -> bool {
        matches!(self.by, By::Hemisphere | By::Cosine | By::Bsdf)
    }

    /// Draws x_0 for x_1, seen from `to_sensor`, with whether it takes a Dirac lobe at x_1.
    fn draw(
        &self,
        tracer: &mut Tracer<'_>,
        random: &mut Random,
        x1: &Vertex,
        to_sensor: DVec3,
    ) -> Option<(Vertex, bool)> {
        let scene = tracer.scene();
        let upper = if to_sensor.dot(x1.normal) < 0.0 { -x1.normal } else { x1.normal };
        let (u, side) = (random.uniform2(), random.uniform());
        let towards = |local: DVec3| {
            let down = scene.transmits(x1) && side < 0.5;
            Frame::around(if down { -upper } else { upper }).to_world(local)
        };
        match self.by {
            By::Hemisphere => Some((tracer.trace(x1, towards(warp::uniform_cone(u, 1.0)))?, false)),
            By::Cosine => Some((tracer.trace(x1, towards(warp::cosine_hemisphere(u)))?, false)),
            By::Bsdf => {
                let scattered = scene.sample_scatter(x1, Side::Sensor, to_sensor, [u[0], u[1], side])?;
                Some((tracer.trace(x1, scattered.to)?, scattered.is_dirac()))
            }
            By::Emitters => {
                let emitter = scene.emitter(scene.choose_emitter(side));
                let vertex = match emitter {
                    emitter if emitter.is_surface() => {
                        emitter.sample_emission(scene.accel(), [random.uniform(), u[0], u[1], 0.5, 0.5]).vertex
                    }
                    _ => emitter.sample_direct(scene.accel(), x1.position, [random.uniform(), u[0], u[1]])?.vertex,
                };
                Some((vertex, false))
            }
            By::Surfaces => Some((scene.surfaces()?.sample(scene, [side, u[0], u[1]]), false)),
        }
    }

    /// The density with which [`draw`](Self::draw) draws x_0.
    fn drawn_density(&self, scene: &Scene, path: &Path) -> Density<Area> {
        let (x0, x1, x2) = (path.vertex(0), path.vertex(1), path.vertex(2));
        let Some(id) = x0.emitter() else { return Density::ZERO };
        let (probability, emitter) = (scene.emitter_probability(id).value(), scene.emitter(id));
        if self.by_direction() && !emitter.can_be_hit() {
            return Density::ZERO;
        }
        if path.is_dirac(1) {
            let step = scene.step(Side::Sensor, x2, x1, x0, true);
            return step.filter(|_| self.by == By::Bsdf).map_or(Density::ZERO, |step| step.density);
        }
        let (edge, to_sensor) = (Edge::between(x1, x0), x1.direction_to(x2));
        let cos = edge.direction.dot(x1.normal) * to_sensor.dot(x1.normal).signum();
        let both = scene.transmits(x1);
        let by_direction = |density: f64| {
            let found = if both { 0.5 * density } else { density };
            Density::<SolidAngle>::new(if both || cos > 0.0 { found } else { 0.0 }) * edge.solid_angle_to_area(x0)
        };
        match self.by {
            By::Hemisphere => by_direction(0.5 / PI),
            By::Cosine => by_direction(cos.abs() * FRAC_1_PI),
            By::Bsdf => scene.step(Side::Sensor, x2, x1, x0, false).map_or(Density::ZERO, |step| step.density),
            By::Emitters => match emitter {
                emitter if emitter.is_surface() => probability * emitter.emission_density(x0, -edge.direction).position,
                _ => probability * emitter.direct_density(scene.accel(), x1.position, x0, &edge),
            },
            By::Surfaces if x0.scatters() => {
                scene.surfaces().map_or(Density::ZERO, pathspace::scene::Surfaces::density)
            }
            By::Surfaces => Density::ZERO,
        }
    }
}

impl PathSampler for Direct {
    fn sample(
        &self,
        lengths: RangeInclusive<u32>,
        tracer: &mut Tracer<'_>,
        random: &mut Random,
        pixel: Pixel,
        give: &mut dyn FnMut(Path),
    ) {
        let walk = walk_from_sensor(tracer, random, pixel, self.roulette, (*lengths.end() as usize).max(2));
        let z = walk.vertices;
        if lengths.contains(&1)
            && let [xk, x0, ..] = z[..]
            && let Some(path) = Path::new([x0, xk].map(|(vertex, _)| (vertex, false)))
        {
            give(path);
        }
        for t in 2..=z.len() {
            let (x1, to_sensor) = (&z[t - 1].0, z[t - 1].0.direction_to(&z[t - 2].0));
            if !lengths.contains(&(t as u32)) || !x1.scatters() {
                continue;
            }
            let Some((x0, dirac)) = self.draw(tracer, random, x1, to_sensor) else { continue };
            let before = z[..t - 1].iter().rev().copied();
            if let Some(path) = Path::new([(x0, false), (*x1, dirac)].into_iter().chain(before)) {
                give(path);
            }
        }
    }

    fn density(&self, scene: &Scene, path: &Path) -> Wide {
        let k = path.edges();
        if k == 1 {
            return scene.sensor_walk_density(path, 2, self.roulette);
        }
        if !path.vertex(1).scatters() {
            return Wide::ZERO;
        }
        scene.sensor_walk_density(path, k, self.roulette) * self.drawn_density(scene, path).value()
    }

    fn technique(&self, edges: u32) -> Technique {
        let s = u32::from(!self.by_direction() && edges > 1);
        Technique { s, t: edges + 1 - s }
    }

    fn ends(&self) -> bool {
        self.roulette.ends()
    }

    fn covers(&self, scene: &Scene) -> Result<(), String> {
        let all = |found: fn(&Emitter) -> bool| scene.emitters().iter().all(found);
        let on_surface = Emitter::is_surface;
        match self.by {
            _ if self.by_direction() && !all(Emitter::can_be_hit) => {
                Err("direct by directions meets no point, spot or directional lights, which the scene has".into())
            }
            By::Surfaces if !all(on_surface) => {
                Err("direct(by=surfaces) finds light that surfaces emit, and the scene has other lights".into())
            }
            By::Bsdf => Ok(()),
            _ if scene.has_dirac_surfaces() => {
                Err("direct draws the emitter's edge over no mirror or smooth glass but with by=bsdf".into())
            }
            _ => Ok(()),
        }
    }
}
