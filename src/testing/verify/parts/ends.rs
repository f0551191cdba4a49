//! What parts draw where random numbers are 0 or the largest below one.

use glam::DVec3;

use crate::path::{Edge, Vertex};
use crate::sampler::Random;
use crate::scene::bsdf::{BsdfModel, LobeDensity, Side};
use crate::scene::sensor::Pixel;
use crate::scene::{EmitterId, Scene};
use crate::testing::ends::rows;

use super::super::report::Check;

const NAME: &str = "ends of [0, 1)";

/// Cosines of the directions that walks come from.
const COSINES: [f64; 8] = [1.0, 0.95, 0.3, 1e-9, -1e-9, -0.3, -0.95, -1.0];

/// Random numbers that are left as they are.
const OTHERS: [f64; 5] = [0.37, 0.61, 0.83, 0.29, 0.53];

/// Draws and what was wrong with one.
#[derive(Default)]
struct Draws {
    count: u32,
    fault: Option<String>,
}

impl Draws {
    fn add(&mut self, u: &[f64], faults: &[(&str, bool)]) {
        self.count += 1;
        if let Some((fault, _)) = faults.iter().find(|(_, wrong)| *wrong) {
            self.fault.get_or_insert_with(|| format!("{fault} of u = {u:?}"));
        }
    }

    fn check(self, place: &str, what: &str) -> Check {
        let found = self.fault.clone().unwrap_or_else(|| format!("{} draws", self.count));
        Check::exact(NAME, place, self.fault.is_some(), format!("{what}: {found}"), "one wrong draw".into())
    }
}

fn unit(direction: DVec3) -> bool {
    (direction.length() - 1.0).abs() < 1e-12
}

fn positive(density: f64) -> bool {
    density.is_finite() && density > 0.0
}

fn amount(value: crate::spectrum::Rgb) -> bool {
    value.to_array().into_iter().all(|value| value.is_finite() && value >= 0.0)
}

fn numbers<const N: usize>(row: [Option<f64>; N]) -> [f64; N] {
    std::array::from_fn(|i| row[i].unwrap_or(OTHERS[i]))
}

/// A model of scattering, from directions of both sides down to grazing ones.
pub(super) fn of_bsdf(model: &dyn BsdfModel, place: &str, what: &str) -> Check {
    let mut draws = Draws::default();
    for cos in COSINES {
        let sine = (1.0 - cos * cos).sqrt();
        let from = DVec3::new(sine * libm::cos(0.4), sine * libm::sin(0.4), cos);
        for (side, u) in [Side::Sensor, Side::Emitter].into_iter().flat_map(|side| rows().map(move |row| (side, row))) {
            let u = numbers::<3>(u);
            let Some(sample) = model.sample(side, from, u) else { continue };
            let density = match sample.density {
                LobeDensity::Finite(density) => density.value(),
                LobeDensity::Dirac(density) => density.value(),
            };
            draws.add(
                &u,
                &[
                    ("a direction that is not of length one", !unit(sample.to)),
                    ("a density that is none", !positive(density)),
                    ("a value that is none", !amount(sample.value)),
                ],
            );
        }
    }
    draws.check(place, what)
}

/// The first edge of an emitter's walks, and the points that it draws for others.
pub(super) fn of_emitter(scene: &Scene, id: EmitterId, seen_from: &[DVec3], place: &str, what: &str) -> Check {
    let emitter = scene.emitter(id);
    let mut draws = Draws::default();
    for u in rows().map(numbers::<5>) {
        let sample = emitter.sample_emission(scene.accel(), u);
        let density = emitter.emission_density(&sample.vertex, sample.direction);
        draws.add(
            &u,
            &[
                ("a direction that is not of length one", !unit(sample.direction)),
                ("a point that is none", !sample.vertex.position.is_finite()),
                ("a density of points that is none", !positive(density.position.value())),
                ("a density of directions that is none", !positive(density.direction.value())),
                ("an emission that is none", !amount(emitter.emission(scene, &sample.vertex, sample.direction))),
            ],
        );
    }
    for &x1 in seen_from {
        for u in rows().map(numbers::<3>) {
            let Some(sample) = emitter.sample_direct(scene.accel(), x1, u) else { continue };
            let edge = Edge::from_to(x1, sample.vertex.position);
            let stated = emitter.direct_density(scene.accel(), x1, &sample.vertex, &edge).value();
            draws.add(
                &u,
                &[
                    ("a point that is none, seen from another,", !sample.vertex.position.is_finite()),
                    ("a density that is none, seen from another,", !positive(sample.density.value())),
                    ("another density than the stated one", (stated / sample.density.value() - 1.0).abs() > 1e-6),
                ],
            );
        }
    }
    draws.check(place, what)
}

/// The first edge of walks from the sensor, in the pixels of the film's corners, and its points drawn for `x`.
pub(super) fn of_sensor(scene: &Scene, x: &Vertex, place: &str) -> Check {
    let sensor = scene.sensor();
    let film = sensor.film();
    let mut draws = Draws::default();
    let corners = [(0, 0), (film.width - 1, 0), (0, film.height - 1), (film.width - 1, film.height - 1)];
    let numbered = (0..4).flat_map(|before| rows::<3>().map(move |row| (before, row)));
    for (before, row) in numbered {
        let random = || Random::new(7, before.into(), 0).forced(before, row);
        let u: Vec<f64> = (0..7).scan(random(), |random, _| Some(random.uniform())).collect();
        for (x, y) in corners {
            let pixel = Pixel { x, y };
            let (xk, direction) = sensor.sample(scene, pixel, &mut random());
            let density = sensor.density(&xk, direction);
            let importance = sensor.importance(&xk, direction);
            draws.add(
                &u,
                &[
                    ("a direction that is not of length one", !unit(direction)),
                    ("a point that is none", !xk.position.is_finite()),
                    ("a density of points that is none", !positive(density.position.value())),
                    ("a density of directions that is none", !positive(density.direction.value())),
                    ("a point that another pixel sees", importance.is_none_or(|importance| importance.pixel != pixel)),
                ],
            );
        }
        if let Some(sample) = sensor.sample_direct(scene, x, &mut random()) {
            draws.add(
                &u,
                &[
                    ("a point that is none, drawn for another,", !sample.vertex.position.is_finite()),
                    ("a density that is none, drawn for another,", !positive(sample.density.value())),
                ],
            );
        }
        if let Some(xk) = sensor.sample_position(scene, &mut random()) {
            draws.add(&u, &[("a point alone that is none", !xk.position.is_finite())]);
        }
    }
    draws.check(place, "sensor")
}
