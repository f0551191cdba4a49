//! The bugs.

use pathspace::estimator::{Combination, Heuristic, RecordedTerm};
use pathspace::measure::Jacobian;
use pathspace::path::{Edge, Path, VertexKind};
use pathspace::scene::Scene;
use pathspace::scene::bsdf::Side;
use pathspace::wide::Wide;

use super::buggy::{Bug, Claim};

fn edge(path: &Path, i: usize) -> Edge {
    Edge::between(path.vertex(i), path.vertex(i + 1))
}

fn scale(term: &mut RecordedTerm, factor: f64) {
    term.term.value *= factor;
}

/// The weight that a term would have if the densities were these.
fn reweigh(scene: &Scene, definition: &Combination, term: &mut RecordedTerm, wrong: impl Fn(&mut Vec<Wide>, usize)) {
    let mut densities = definition.densities(scene, &term.path);
    let edges = term.path.edges() as u32;
    let drawn = |i: &usize| definition.samplers[*i].technique(edges) == term.term.technique && !densities[*i].is_zero();
    let Some(i) = (0..densities.len()).find(drawn) else { return };
    wrong(&mut densities, i);
    let weight = definition.weight(&densities, i);
    let factor = weight / term.term.weight;
    term.term.weight = weight;
    scale(term, factor);
}

fn emitter_choice(scene: &Scene, path: &Path) -> f64 {
    path.vertex(0).emitter().map_or(1.0, |id| scene.emitter_probability(id).value())
}

/// η² of the first refraction of a path: over all of them it is one where light and camera are in the same medium.
fn refraction(scene: &Scene, path: &Path) -> f64 {
    let at = |i: usize| scene.radiance_scale(path.vertex(i), -edge(path, i - 1).direction, edge(path, i).direction);
    (1..path.edges()).filter(|&i| path.vertex(i).scatters()).map(at).find(|&scale| scale != 1.0).unwrap_or(1.0)
}

/// |ω·N_s| / |ω·N_g| at x_1, towards the emitter.
fn leaning(path: &Path) -> f64 {
    let (x1, to_emitter) = (path.vertex(1), -edge(path, 0).direction);
    to_emitter.dot(x1.shading_normal).abs() / to_emitter.dot(x1.normal).abs()
}

/// What, in which integrator, and how.
pub const BUGS: [(&str, &str, Bug); 20] = [
    ("a cosine left out at x_1", "path", |_, _, t| {
        if t.path.edges() >= 2 {
            let cos = t.path.vertex(1).abs_cos(edge(&t.path, 0).direction);
            scale(t, 1.0 / cos);
        }
    }),
    ("the emitter's cosine squared", "path", |_, _, t| {
        let cos = t.path.vertex(0).abs_cos(edge(&t.path, 0).direction);
        scale(t, cos);
    }),
    ("a Jacobian squared", "path", |_, _, t| {
        let (first, x0) = (edge(&t.path, 0), *t.path.vertex(0));
        scale(t, Jacobian::solid_angle_to_area(x0.abs_cos(first.direction), first.length_squared).value());
    }),
    ("the distance squared forgotten", "light", |_, _, t| {
        let last = edge(&t.path, t.path.edges() - 1);
        scale(t, last.length_squared);
    }),
    ("a weight from the wrong side's density", "path", |_, _, t| {
        let wrong = 1.0 - t.term.weight;
        let factor = wrong / t.term.weight;
        t.term.weight = wrong;
        scale(t, factor);
    }),
    ("s = 1 missing in the weights", "bdpt", |scene, definition, t| {
        reweigh(scene, definition, t, |p, i| {
            if i != 1 {
                p[1] = Wide::ZERO;
            }
        });
    }),
    ("the emitter walk's density for s = 1", "bdpt", |scene, definition, t| {
        let ratio = {
            let (x0, x1) = (t.path.vertex(0), t.path.vertex(1));
            x0.emitter().map_or(1.0, |id| {
                let emission = scene.emitter(id).emission_density(x0, edge(&t.path, 0).direction).position.value();
                let back = edge(&t.path, 0).reversed();
                emission / scene.emitter(id).direct_density(scene.accel(), x1.position, x0, &back).value()
            })
        };
        reweigh(scene, definition, t, |p, _| p[1] = p[1] * if ratio.is_finite() { ratio } else { 1.0 });
    }),
    ("roulette not divided by", "path:roulette=local:roulette_start=1", |scene, _, t| {
        let path = t.path.clone();
        for i in 2..path.edges() {
            let step =
                scene.step(Side::Sensor, path.vertex(i + 1), path.vertex(i), path.vertex(i - 1), path.is_dirac(i));
            scale(t, step.map_or(1.0, |step| step.energy.max_component().min(1.0)));
        }
    }),
    ("the choice of the light forgotten", "path", |scene, _, t| {
        if t.term.technique.s == 1 {
            scale(t, emitter_choice(scene, &t.path));
        }
    }),
    ("the choice of the light divided by twice", "light", |scene, _, t| {
        scale(t, 1.0 / emitter_choice(scene, &t.path));
    }),
    ("η² left out at one refraction", "path", |scene, _, t| {
        let eta2 = refraction(scene, &t.path);
        scale(t, 1.0 / eta2);
    }),
    ("the shading normal's correction left out", "bdpt", |_, _, t| {
        if t.path.edges() >= 2 && t.path.vertex(1).scatters() {
            let ratio = leaning(&t.path);
            scale(t, 1.0 / ratio);
        }
    }),
    ("one technique counted doubly", "bdpt", |_, _, t| {
        if t.term.technique.s == 2 {
            scale(t, 2.0);
        }
    }),
    ("one technique without its weight", "path", |_, _, t| {
        if t.term.technique.s == 1 {
            let weight = t.term.weight;
            scale(t, 1.0 / weight);
        }
    }),
    ("the number of light walks forgotten in the weights", "bdpt", |scene, definition, t| {
        let count: Vec<f64> = definition.samplers.iter().map(|sampler| sampler.count(scene)).collect();
        reweigh(scene, definition, t, |p, _| {
            p.iter_mut().zip(&count).for_each(|(p, n)| *p = *p * (1.0 / n));
        });
    }),
    ("Dirac densities replaced by one", "bdpt", |scene, definition, t| {
        let factor: f64 = (1..t.path.edges())
            .filter(|&i| t.path.is_dirac(i))
            .map(|i| edge(&t.path, i).geometry(t.path.vertex(i), t.path.vertex(i + 1)))
            .product();
        reweigh(scene, definition, t, |p, i| {
            if i == 0 {
                p[0] = p[0] * (1.0 / factor);
            }
        });
    }),
    ("another exponent than claimed", "bdpt:heuristic=power", |scene, definition, t| {
        let other = Combination { heuristic: Heuristic::Power { exponent: 3.0 }, ..definition.clone() };
        reweigh(scene, &other, t, |_, _| {});
    }),
    ("the longest paths left out", "bdpt", |_, _, t| {
        if t.path.edges() == 5 {
            t.term.weight = f64::NEG_INFINITY;
        }
    }),
    ("the pixel one too far to the right", "path_bsdf", |scene, _, t| {
        t.term.pixel.x = (t.term.pixel.x + 1) % scene.sensor().film().width;
    }),
    ("NaN where the emitter is seen edge on", "path", |_, _, t| {
        if t.path.vertex(0).abs_cos(edge(&t.path, 0).direction) < 0.01 {
            scale(t, f64::NAN);
        }
    }),
];

/// Wrong densities: what the samplers draw is right, what they claim is not.
pub const CLAIMS: [(&str, &str, Claim); 4] = [
    ("a claimed density 10 % too large", "path", |_, _| 1.1),
    ("a claimed density without the light's choice", "bdpt", |scene, path| 1.0 / emitter_choice(scene, path)),
    ("a claimed density that takes roulette for certain", "walks:roulette=local:roulette_start=1", |scene, path| {
        let survival = |i: usize| {
            let step =
                scene.step(Side::Sensor, path.vertex(i + 1), path.vertex(i), path.vertex(i - 1), path.is_dirac(i));
            step.map_or(1.0, |step| step.energy.max_component().min(1.0))
        };
        1.0 / (1..path.edges()).map(survival).product::<f64>()
    }),
    ("a claimed density of points on the sphere for directions", "light", |_, path| match path.vertex(0).kind {
        VertexKind::Infinite(_) => 0.25,
        _ => 1.0,
    }),
];
