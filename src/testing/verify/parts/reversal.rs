//! Exchange emitter and sensor, turn a path around, and its densities must be those of before with s and t exchanged.
//!
//! A rectangle that emits diffusely and a window that measures irradiance start walks alike: uniform by area, with directions
//! by the cosine. So a scene with a lamp and a window has a counterpart with the lamp where the window was and the window where
//! the lamp was, and `p_{s,t}(x_0 … x_k)` in the one is `p_{t,s}(x_k … x_0)` in the other (Veach 1997, chapter 10, of walks that
//! differ in nothing but what they carry). Refraction between is no exception: Dirac coefficients carry `(η_o/η_i)²`, whose
//! product over a path that starts and ends outside is one.

use glam::{DVec2, DVec3};

use crate::path::{Path, Roulette, Technique, Vertex, VertexKind, WalkRules};
use crate::sampler::{Random, Tracer, walk_from_sensor};
use crate::scene::description::{FilmSize, Projection, SensorDescription};
use crate::scene::sensor::Pixel;
use crate::scene::{EmitterId, Scene, SceneDescription};
use crate::spectrum::Rgb;
use crate::testing::scenes;

use super::super::report::Check;
use super::super::{Effort, LONGEST};

/// Directions between near vertices lose digits when they are moved; a cosine or an index of refraction is no rounding.
const ROUNDING: f64 = 1e-6;

/// Walks whose paths are turned around.
const DRAWS: u32 = 20_000;

/// A rectangle by its centre and half its sides; its front is where `u × v` points.
#[derive(Clone, Copy)]
struct Plate {
    centre: DVec3,
    u: DVec3,
    v: DVec3,
}

const LAMP: Plate =
    Plate { centre: DVec3::new(0.1, 1.93, -0.1), u: DVec3::new(0.3, 0.0, 0.0), v: DVec3::new(0.0, 0.0, 0.25) };
const WINDOW: Plate =
    Plate { centre: DVec3::new(-0.05, 1.0, 0.97), u: DVec3::new(0.0, 0.4, 0.0), v: DVec3::new(0.5, 0.0, 0.0) };

impl Plate {
    fn normal(self) -> DVec3 {
        self.u.cross(self.v).normalize()
    }
}

/// The cabinet with one diffuse emitter, and a window of a single pixel.
fn cabinet(lamp: Plate, window: Plate) -> SceneDescription {
    let mut scene = scenes::cabinet(FilmSize { width: 1, height: 1 });
    scene.lights.clear();
    scene.meshes.retain(|mesh| mesh.name != "lamp");
    scene.materials.iter_mut().for_each(|material| material.emission = Rgb::BLACK.into());
    let emitting = scene.materials.len();
    scene.materials.push(scenes::diffuse("emitting", Rgb::BLACK, Rgb::WHITE));
    let corner = lamp.centre - lamp.u - lamp.v;
    // The last mesh, so that all else has the same numbers in both scenes.
    scene.meshes.push(scenes::rectangle("lamp", corner, 2.0 * lamp.u, 2.0 * lamp.v, emitting));
    let (up, forward) = (window.v.normalize(), window.normal());
    scene.sensor = Some(SensorDescription {
        window: SensorDescription::WHOLE,
        name: "window".into(),
        position: window.centre,
        forward,
        up,
        projection: Projection::Window { half_width: window.u.length(), half_height: window.v.length() },
    });
    scene
}

/// The same point on what the other scene has there.
fn moved(vertex: &Vertex, from: &Scene, to: &Scene, template: &Vertex) -> Vertex {
    Vertex { position: vertex.position + from.centre() - to.centre(), ..*template }
}

pub(super) fn checks(effort: Effort) -> Vec<Check> {
    let scene = scenes::build(&cabinet(LAMP, WINDOW));
    let exchanged = scenes::build(&cabinet(WINDOW, LAMP));
    [("off", Roulette::Off), ("local", Roulette::Local { start: 2, long: Roulette::LONG })]
        .map(|(name, roulette)| check(&scene, &exchanged, name, roulette, effort))
        .into()
}

fn check(scene: &Scene, exchanged: &Scene, name: &str, roulette: Roulette, effort: Effort) -> Check {
    let rules = WalkRules { sensor: roulette, emitter: roulette };
    let mut random = Random::new(effort.seed, 0, 1);
    let mut tracer = Tracer::new(scene);
    let (mut compared, mut dirac, mut worst) = (0, 0, 0.0_f64);
    let pixel = Pixel { x: 0, y: 0 };
    for _ in 0..DRAWS {
        let walk = walk_from_sensor(&mut tracer, &mut random, pixel, Roulette::Off, LONGEST as usize);
        let emission = scene.emitter(EmitterId(0)).sample_emission(scene.accel(), random.uniform5());
        let inner = &walk.vertices[1..];
        // The lamp is a surface of one scene only.
        if inner.iter().any(|(vertex, _)| vertex.emitter().is_some() || !vertex.scatters()) {
            continue;
        }
        let mut open: Vec<(Vertex, bool)> = walk.vertices.clone();
        if let Some(last) = open.last_mut() {
            last.1 = false;
        }
        let path = Path::new(std::iter::once((emission.vertex, false)).chain(open.iter().rev().copied()));
        let lamp = exchanged.emitter(EmitterId(0)).sample_emission(exchanged.accel(), [0.5; 5]).vertex;
        let (window, _) = exchanged.sensor().through(DVec2::splat(0.5), [0.5; 2]);
        let to = |vertex: &Vertex| match vertex.kind {
            VertexKind::Sensor { .. } => moved(vertex, scene, exchanged, &lamp),
            _ if vertex.emitter().is_some() => moved(vertex, scene, exchanged, &window),
            _ => moved(vertex, scene, exchanged, vertex),
        };
        let back = open.iter().map(|(vertex, dirac)| (to(vertex), *dirac));
        let reversed = Path::new(back.chain(std::iter::once((to(&emission.vertex), false))));
        let (Some(path), Some(reversed)) = (path, reversed) else { continue };
        // A hidden edge may lead out of glass without refraction, and so may one from glass itself.
        if !scene.unobstructed(&path) || !scene.has_finite(path.vertex(1)) {
            continue;
        }
        dirac += usize::from(open.iter().any(|(_, dirac)| *dirac));
        for Technique { s, t } in Technique::all(path.edges() as u32) {
            let there = scene.path_density(&path, Technique { s, t }, &rules);
            let back = exchanged.path_density(&reversed, Technique { s: t, t: s }, &rules);
            if there.is_zero() && back.is_zero() {
                continue;
            }
            compared += 1;
            let ratio = if there.is_zero() { 0.0 } else { (back / there).to_f64() };
            worst = worst.max((ratio - 1.0).abs());
        }
    }
    let found = format!("roulette {name}: off by {worst:.1e} in {compared} densities, {dirac} paths with Dirac lobes");
    let wrong = worst > ROUNDING || worst.is_nan() || compared < 100 || dirac < 10;
    Check::exact("p_s,t reversed", scene.name(), wrong, found, format!("{ROUNDING:.0e} of any density"))
}
