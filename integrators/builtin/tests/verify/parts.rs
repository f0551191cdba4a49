//! What samplers draw with is checked on its own, and wrong models are caught.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::DVec3;
use pathspace::measure::{Density, ProjectedSolidAngle, SolidAngle};
use pathspace::scene::bsdf::{BsdfModel, BsdfSample, LobeDensity, Side};
use pathspace::spectrum::Rgb;
use pathspace::testing::verify::{Effort, verify_bsdf, verify_parts};
use pathspace::warp;

/// Sees a density that is off by 4 %.
const EFFORT: Effort = Effort { passes: 600, seed: 11, scenes: usize::MAX };

/// Half diffuse, half mirror; with what may be wrong with it.
#[derive(Clone, Copy, Debug)]
struct Varnish {
    /// Probability of the mirror.
    mirror: f64,
    /// What it claims of that.
    claimed: f64,
    /// Factor of the claimed density.
    factor: f64,
    /// Draws directions without the cosine.
    uniform: bool,
    /// Samples leave the cosine in their value.
    value: f64,
}

const RIGHT: Varnish = Varnish { mirror: 0.3, claimed: 0.3, factor: 1.0, uniform: false, value: 1.0 };

impl BsdfModel for Varnish {
    fn eval(&self, to_emitter: DVec3, to_sensor: DVec3) -> Rgb {
        if to_emitter.z > 0.0 && to_sensor.z > 0.0 { Rgb::grey(0.4 * FRAC_1_PI) } else { Rgb::BLACK }
    }

    fn density(&self, from: DVec3, to: DVec3) -> Density<SolidAngle> {
        let inside = from.z > 0.0 && to.z > 0.0;
        Density::new(if inside { self.factor * (1.0 - self.claimed) * to.z / PI } else { 0.0 })
    }

    fn eval_dirac(&self, _: DVec3, _: DVec3) -> Rgb {
        Rgb::grey(0.5)
    }

    fn density_dirac(&self, _: Side, _: DVec3, _: DVec3) -> Density<ProjectedSolidAngle> {
        Density::new(self.claimed)
    }

    fn sample(&self, side: Side, from: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        if from.z <= 0.0 {
            return None;
        }
        if u[0] < self.mirror {
            let to = DVec3::new(-from.x, -from.y, from.z);
            let (to_emitter, to_sensor) = side.by_role(from, to);
            let density = LobeDensity::Dirac(self.density_dirac(side, from, to));
            return Some(BsdfSample { to, density, value: self.eval_dirac(to_emitter, to_sensor) });
        }
        let mut to = warp::cosine_hemisphere([u[1], u[2]]);
        if self.uniform {
            to = warp::uniform_sphere([u[1], u[2]]);
            to.z = to.z.abs();
        }
        let (to_emitter, to_sensor) = side.by_role(from, to);
        let value = self.eval(to_emitter, to_sensor) * self.value;
        // The rim of the hemisphere, u = 0, has density zero.
        (to.z > 0.0).then(|| BsdfSample { to, density: LobeDensity::Finite(self.density(from, to)), value })
    }
}

fn caught_by(model: Varnish) -> Vec<&'static str> {
    let report = verify_bsdf("varnish", &model, EFFORT);
    let mut names: Vec<_> = report.failures().map(|check| check.name).collect();
    names.dedup();
    names.sort_unstable();
    names.dedup();
    names
}

#[test]
fn a_model_of_ones_own_holds_and_each_wrong_one_is_caught() {
    assert_eq!(caught_by(RIGHT), [""; 0]);
    assert_eq!(caught_by(Varnish { factor: 1.05, ..RIGHT }), ["BSDF"]);
    assert_eq!(caught_by(Varnish { uniform: true, ..RIGHT }), ["BSDF"]);
    assert_eq!(caught_by(Varnish { claimed: 0.33, ..RIGHT }), ["BSDF", "Dirac lobes"]);
    assert_eq!(caught_by(Varnish { value: 1.01, ..RIGHT }), ["BSDF's samples"]);
}

#[test]
fn all_parts_of_the_small_scenes_hold() {
    let report = verify_parts(Effort::default());
    assert!(report.holds(), "{report}");
    assert!(report.checks.len() > 60);
}
