//! p_{s,t}(x̄), the density with which a bidirectional technique draws a path.

use serde::{Deserialize, Serialize};

use crate::measure::{Area, Density, Jacobian};
use crate::sampler::Random;
use crate::scene::bsdf::{LobeDensity, Side};
use crate::scene::emitter::Emitter;
use crate::scene::{EmitterId, Scene};
use crate::spectrum::Rgb;
use crate::wide::Wide;

use super::{Edge, Path, Roulette, Technique, Vertex};

/// How the walks of an integrator end: part of what its densities depend on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WalkRules {
    /// Roulette of walks from the sensor.
    pub sensor: Roulette,
    /// Roulette of walks from the emitters.
    pub emitter: Roulette,
}

/// One step of a walk, evaluated for given vertices.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Density of the direction of the next vertex, without roulette.
    pub direction: LobeDensity,
    /// Density of the next vertex, without roulette.
    pub density: Density<Area>,
    /// `f_s |cos θ| / p_σ` without the radiance's η²: what roulette decides by.
    pub energy: Rgb,
}

impl Scene {
    /// `p_{s,t}(x̄)` in area measure, for one walk of each kind: what pixel j's own walks from the sensor, or any walk from
    /// the emitters, draw. Zero where the technique cannot draw the path. Dirac distributions enter by their coefficients.
    #[must_use]
    pub fn path_density(&self, path: &Path, technique: Technique, rules: &WalkRules) -> Wide {
        let k = path.edges();
        let (s, t) = (technique.s as usize, technique.t as usize);
        assert_eq!(s + t, k + 1, "a technique has as many vertices as the path");
        if !self.can_draw(path, s, t) {
            return Wide::ZERO;
        }
        if (s, t) == (1, 1) {
            return Wide::new(self.density_of_two(path.vertex(0), path.vertex(1)));
        }
        self.emitter_walk_density(path, s, rules.emitter) * self.sensor_walk_density(path, t, rules.sensor)
    }

    /// No Dirac distribution of the path is left undrawn by the technique.
    fn can_draw(&self, path: &Path, s: usize, t: usize) -> bool {
        let k = path.edges();
        let emitter = path.vertex(0).emitter().map(|id| self.emitter(id));
        let hit_at_start = emitter.is_some_and(Emitter::can_be_hit);
        if emitter.is_none() || (k == 1 && !hit_at_start) {
            return false;
        }
        match (s, t) {
            (0, _) => hit_at_start,
            (_, 0) => self.sensor().can_be_hit(),
            _ => !path.is_dirac(s - 1) && !path.is_dirac(s),
        }
    }

    /// Draws x_0 x_1, with x_1 on the sensor, by s = t = 1 for an emitter already chosen, whose walk starts at `walk`: the end
    /// that has a density of its own is first, then the other for it. Its density is
    /// [`density_of_two`](Self::density_of_two).
    #[must_use]
    pub fn sample_two(&self, id: EmitterId, walk: &Vertex, random: &mut Random) -> Option<(Vertex, Vertex)> {
        let (emitter, sensor) = (self.emitter(id), self.sensor());
        if !emitter.can_be_hit() {
            return None;
        }
        if emitter.is_local() {
            Some((*walk, sensor.sample_direct(self, walk, random)?.vertex))
        } else {
            let xk = sensor.sample_position(self, random)?;
            Some((emitter.sample_direct(self.accel(), xk.position, random.uniform3())?.vertex, xk))
        }
    }

    /// `p_{1,1}(x_0 x_1)`, with x_1 on the sensor: the end that has a density of its own is drawn first, then the other
    /// for it. Zero where neither has.
    #[must_use]
    pub fn density_of_two(&self, x0: &Vertex, x1: &Vertex) -> f64 {
        let Some((id, emitter)) = x0.emitter().map(|id| (id, self.emitter(id))) else { return 0.0 };
        let choice = self.emitter_probability(id).value();
        let edge = Edge::between(x0, x1);
        if emitter.is_local() {
            let position = emitter.emission_density(x0, edge.direction).position;
            choice * position.value() * self.sensor().direct_density(x0, x1).value()
        } else if self.sensor().has_position() {
            let back = edge.reversed();
            let direct = emitter.direct_density(self.accel(), x1.position, x0, &back);
            choice * direct.value() * self.sensor().density(x1, back.direction).position.value()
        } else {
            0.0
        }
    }

    /// The density with which a walk from the emitters draws the first s vertices x_0 … x_{s−1}; with s = 1 that of a point
    /// drawn for x_1.
    #[must_use]
    pub fn emitter_walk_density(&self, path: &Path, s: usize, roulette: Roulette) -> Wide {
        if s == 0 {
            return Wide::ONE;
        }
        let (x0, x1) = (path.vertex(0), path.vertex(1));
        let edge = Edge::between(x0, x1);
        let Some(id) = x0.emitter() else { return Wide::ZERO };
        let choice = Wide::new(self.emitter_probability(id).value());
        if s == 1 {
            let back = edge.reversed();
            return choice * self.emitter(id).direct_density(self.accel(), x1.position, x0, &back).value();
        }
        let first = self.emitter(id).emission_density(x0, edge.direction);
        let to_area = edge.solid_angle_to_area(x1);
        let start = choice * first.position.value() * (first.direction * to_area).value();
        let vertices: Vec<(&Vertex, bool)> = (0..s).map(|i| (path.vertex(i), path.is_dirac(i))).collect();
        start * self.walk_density(&vertices, Side::Emitter, roulette)
    }

    /// The density with which a walk from the sensor draws the last t vertices x_k … x_{k−t+1}, for the pixel that they
    /// belong to; with t = 1 that of a point drawn for x_{k−1}.
    #[must_use]
    pub fn sensor_walk_density(&self, path: &Path, t: usize, roulette: Roulette) -> Wide {
        if t == 0 {
            return Wide::ONE;
        }
        let k = path.edges();
        let (xk, before) = (path.vertex(k), path.vertex(k - 1));
        if t == 1 {
            return Wide::new(self.sensor().direct_density(before, xk).value());
        }
        let edge = Edge::between(xk, before);
        let last = self.sensor().density(xk, edge.direction);
        let to_area = edge.solid_angle_to_area(before);
        let start = Wide::new(last.position.value()) * (last.direction * to_area).value();
        let vertices: Vec<(&Vertex, bool)> = (0..t).map(|i| (path.vertex(k - i), path.is_dirac(k - i))).collect();
        start * self.walk_density(&vertices, Side::Sensor, roulette)
    }

    /// Density of the third and later vertices of a walk, given its first two.
    fn walk_density(&self, walk: &[(&Vertex, bool)], side: Side, roulette: Roulette) -> Wide {
        let mut density = Wide::ONE;
        let complete = self.each_step(walk, side, roulette, |step, survival| {
            density = density * step.density.value() * survival;
        });
        if complete { density } else { Wide::ZERO }
    }

    /// Visits the steps of a walk from its second vertex on, each with the probability that roulette lets it happen. False
    /// where the walk does not go on, which ends the visit.
    pub(super) fn each_step(
        &self,
        walk: &[(&Vertex, bool)],
        side: Side,
        roulette: Roulette,
        mut visit: impl FnMut(&Step, f64),
    ) -> bool {
        let mut throughput = Rgb::WHITE;
        for i in 1..walk.len() - 1 {
            let (at, dirac) = walk[i];
            let Some(step) = self.step(side, walk[i - 1].0, at, walk[i + 1].0, dirac) else { return false };
            throughput *= step.energy;
            let survival = roulette.survival(i as u32, || step.energy, || throughput);
            throughput = throughput / survival;
            visit(&step, survival);
        }
        true
    }

    /// How a walk that started on `side` and came from `previous` goes on from `at` to `next`. `None` where it never does.
    #[must_use]
    pub fn step(&self, side: Side, previous: &Vertex, at: &Vertex, next: &Vertex, dirac: bool) -> Option<Step> {
        if !at.scatters() {
            return None;
        }
        let from = at.direction_to(previous);
        let edge = Edge::between(at, next);
        let to = edge.direction;
        let (to_emitter, to_sensor) = side.by_role(from, to);
        let (cos_at, cos_next) = (at.abs_cos(to), next.abs_cos(to));
        let (direction, density, weight) = if dirac {
            let density = self.scatter_dirac_density(at, side, from, to);
            let area = density * Jacobian::projected_to_area(cos_at, cos_next, edge.length_squared);
            (LobeDensity::Dirac(density), area, self.scatter_dirac(at, to_emitter, to_sensor) / density.value())
        } else {
            let density = self.scatter_density(at, from, to);
            let area = density * edge.solid_angle_to_area(next);
            let weight = self.scatter(at, to_emitter, to_sensor) * (cos_at / density.value());
            (LobeDensity::Finite(density), area, weight)
        };
        let scale = match side {
            Side::Sensor => self.radiance_scale(at, to_emitter, to_sensor),
            Side::Emitter => 1.0,
        };
        (density.value() > 0.0).then(|| Step { direction, density, energy: weight / scale })
    }
}
