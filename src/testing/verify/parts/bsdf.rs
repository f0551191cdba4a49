//! Models of scattering.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::geometry::Frame;
use crate::sampler::Random;
use crate::scene::bsdf::{BsdfModel, LobeDensity, Side};
use crate::warp;

use super::super::report::Check;
use super::counting::{Claim, discrete};

/// Heights `1 − cos` over the peak of a lobe between which the reference is spread evenly in logarithms.
const LOWEST: f64 = 1e-9;
const HIGHEST: f64 = 2.0;

/// Below this height directions are counted around the peak.
const NEAR: f64 = 0.02;

/// Cosines of the directions that walks come from.
const COSINES: [f64; 4] = [0.95, 0.3, -0.7, -0.2];

/// Finite lobes by χ², Dirac lobes by their counts, and what samples say of themselves against `eval` and `density`.
pub(super) fn checks(model: &dyn BsdfModel, place: &str, what: &str, n: u32, random: &mut Random) -> Vec<Check> {
    let mut checks = Vec::new();
    for (cos, side) in COSINES.into_iter().zip([Side::Sensor, Side::Emitter].into_iter().cycle()) {
        if cos < 0.0 && !model.transmits() {
            continue;
        }
        let sine = (1.0 - cos * cos).sqrt();
        let from = DVec3::new(sine * libm::cos(0.4), sine * libm::sin(0.4), cos);
        let what =
            format!("{what}, from cos {cos} on the {}'s side", if side == Side::Sensor { "sensor" } else { "emitter" });
        if model.has_finite() {
            checks.push(finite(model, side, from, place, &what, n, random));
        }
        checks.extend(dirac(model, side, from, place, &what, n / 4, random));
        checks.push(consistent(model, side, from, place, &what, random));
    }
    checks
}

fn finite(
    model: &dyn BsdfModel,
    side: Side,
    from: DVec3,
    place: &str,
    what: &str,
    n: u32,
    random: &mut Random,
) -> Check {
    // Where lobes have their peaks: mirrored, and straight through.
    let peaks = [DVec3::new(-from.x, -from.y, from.z), -from];
    let height = |peak: DVec3, to: DVec3| 0.5 * (to - peak).length_squared();
    let claim = Claim {
        draw: &|random| match model.sample(side, from, random.uniform3())? {
            sample if matches!(sample.density, LobeDensity::Finite(_)) => Some(sample.to),
            _ => None,
        },
        density: &|&to| model.density(from, to).value(),
        reference: &|random| {
            let [choice, u, v] = random.uniform3();
            if choice < 0.5 {
                return warp::uniform_sphere([u, v]);
            }
            let h = LOWEST * libm::pow(HIGHEST / LOWEST, u);
            let (sine, (s, c)) = ((h * (2.0 - h)).max(0.0).sqrt(), libm::sincos(TAU * v));
            let peak = peaks[usize::from(choice > 0.75)];
            Frame::around(peak).to_world(DVec3::new(sine * c, sine * s, 1.0 - h))
        },
        reference_density: &|&to| {
            let around = |peak: DVec3| {
                let h = height(peak, to).clamp(LOWEST, HIGHEST);
                1.0 / (TAU * h * libm::log(HIGHEST / LOWEST))
            };
            0.5 / (4.0 * PI) + 0.25 * around(peaks[0]) + 0.25 * around(peaks[1])
        },
        cell: &|&to| {
            let sector = |x: f64, y: f64, sectors: f64| (libm::atan2(y, x).rem_euclid(TAU) / TAU * sectors) as usize;
            if let Some((i, &peak)) = peaks.iter().enumerate().find(|(_, peak)| height(**peak, to) < NEAR) {
                let ring = (-libm::log2(height(peak, to).max(LOWEST) / NEAR)) as usize;
                let local = Frame::around(peak).to_local(to);
                return 2 * (4 * ring + sector(local.x, local.y, 4.0)) + i + 96;
            }
            let band = ((to.z + 1.0) * 4.0).min(7.0) as usize;
            band * 12 + sector(to.x, to.y, 12.0).min(11)
        },
    };
    claim.check("BSDF", place, what, n, random)
}

/// Draws of Dirac lobes against their probabilities, the reflection's and the refraction's.
fn dirac(
    model: &dyn BsdfModel,
    side: Side,
    from: DVec3,
    place: &str,
    what: &str,
    n: u32,
    random: &mut Random,
) -> Option<Check> {
    let mut lobes: [Option<(u32, f64)>; 2] = [None; 2];
    for _ in 0..n {
        let Some(sample) = model.sample(side, from, random.uniform3()) else { continue };
        if let LobeDensity::Dirac(_) = sample.density {
            let (to_emitter, to_sensor) = side.by_role(from, sample.to);
            // The coefficient is that of the emitter's side.
            let scale = if side == Side::Emitter { model.radiance_scale(to_emitter, to_sensor) } else { 1.0 };
            let probability = model.density_dirac(side, from, sample.to).value() / scale;
            let lobe = &mut lobes[usize::from((sample.to.z > 0.0) != (from.z > 0.0))];
            lobe.get_or_insert((0, probability)).0 += 1;
        }
    }
    let lobes: Vec<(u32, f64)> = lobes.into_iter().flatten().collect();
    // What a finite lobe has drawn is none of these outcomes, so it counts as nothing.
    (!lobes.is_empty()).then(|| discrete("Dirac lobes", place, what, &lobes, n))
}

/// A sample's density and value are those that `density`, `eval` and their Dirac counterparts state.
fn consistent(model: &dyn BsdfModel, side: Side, from: DVec3, place: &str, what: &str, random: &mut Random) -> Check {
    let mut worst = 0.0_f64;
    for _ in 0..1000 {
        let Some(sample) = model.sample(side, from, random.uniform3()) else { continue };
        let (to_emitter, to_sensor) = side.by_role(from, sample.to);
        let (found, stated, value) = match sample.density {
            LobeDensity::Finite(density) => {
                (density.value(), model.density(from, sample.to).value(), model.eval(to_emitter, to_sensor))
            }
            LobeDensity::Dirac(density) => {
                let stated = model.density_dirac(side, from, sample.to).value();
                (density.value(), stated, model.eval_dirac(to_emitter, to_sensor))
            }
        };
        let relative = |a: f64, b: f64| (a - b).abs() / a.abs().max(b.abs()).max(f64::MIN_POSITIVE);
        let values = sample.value.to_array().into_iter().zip(value.to_array()).map(|(a, b)| relative(a, b));
        worst = values.fold(worst.max(relative(found, stated)), f64::max);
    }
    let found = format!("{what}: samples and eval, density differ by {worst:.1e}");
    Check::exact("BSDF's samples", place, worst > 1e-6 || worst.is_nan(), found, "1e-6 of a value".into())
}
