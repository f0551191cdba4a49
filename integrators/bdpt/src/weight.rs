//! MIS weights of a bidirectional path from the densities of its vertices in both walks.
//!
//! With `e_i` the density of x_i in the walk from the emitter and `c_i` in that from the sensor, the technique with s
//! vertices from the emitter has `p_s = ∏_{i<s} e_i ∏_{i≥s} c_i`, except that with s = 1 or t = 1 the end is drawn for its
//! neighbour. Ratios of neighbours, `p_s / p_{s+1} = c_s / e_s`, are all that the weights need.

use std::ops::Mul;

use pathspace::estimator::Heuristic;
use pathspace::wide::Wide;

/// Densities of the vertices x_0 … x_k of a path; kept from path to path for its memory.
#[derive(Debug, Default)]
pub(crate) struct Densities {
    vertices: Vec<VertexDensities>,
    /// `p(x_0 | x_1)` of s = 1, over `e_0`.
    pub direct_emitter: f64,
    /// `p(x_k | x_{k−1})` of t = 1, over `c_k`.
    pub direct_sensor: f64,
    /// The emitter can be met by chance: s = 0.
    pub emitter_can_be_hit: bool,
    /// The sensor can be met by chance: t = 0.
    pub sensor_can_be_hit: bool,
    /// Number of light walks that serve a pixel: n of the techniques with t ≤ 1.
    pub light_walks: f64,
    ratios: Vec<f64>,
}

/// One vertex in both walks.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct VertexDensities {
    /// `e_i`.
    pub emitter: f64,
    /// `c_i`.
    pub sensor: f64,
    /// The path takes a Dirac lobe here.
    pub dirac: bool,
}

impl Densities {
    /// Makes room for a path with k edges.
    pub fn reset(&mut self, k: usize) {
        self.vertices.clear();
        self.vertices.resize(k + 1, VertexDensities::default());
    }

    /// The vertices of the path in hand.
    pub fn vertices_mut(&mut self) -> &mut [VertexDensities] {
        &mut self.vertices
    }

    /// `p_{1,1}` of a path of one edge, where either end may have been drawn for the other.
    pub fn set_both_direct(&mut self, density: f64) {
        self.direct_emitter = density / self.vertices[0].emitter;
        self.direct_sensor = 1.0 / self.vertices[1].sensor;
    }

    /// The weight of the technique with s vertices from the emitter.
    pub fn weight(&mut self, heuristic: Heuristic, s: usize) -> f64 {
        let mut ratios = std::mem::take(&mut self.ratios);
        ratios.clear();
        ratios.resize(self.vertices.len() + 1, 0.0);
        if !self.fill(s, 1.0, &mut ratios, |ratio| ratio, |ratio| (1e-200..1e200).contains(&ratio)) {
            self.fill(s, Wide::ONE, &mut ratios, Wide::to_f64, |_| true);
        }
        let weight = heuristic.weight(ratios[..s].iter().copied(), ratios[s + 1..].iter().copied());
        self.ratios = ratios;
        weight
    }

    /// Ratios `n_j p_j / (n_s p_s)`; says no as soon as one is beyond what the number type holds.
    fn fill<T: Copy + Mul<f64, Output = T>>(
        &self,
        s: usize,
        one: T,
        ratios: &mut [f64],
        value: impl Fn(T) -> f64,
        in_range: impl Fn(T) -> bool,
    ) -> bool {
        let own = 1.0 / self.factor(s);
        let mut ratio = one;
        for j in (0..s).rev() {
            let x = self.vertices[j];
            ratio = ratio * (x.sensor / x.emitter);
            if !in_range(ratio) {
                return false;
            }
            ratios[j] = if self.possible(j) { value(ratio * (self.factor(j) * own)) } else { 0.0 };
        }
        let mut ratio = one;
        for (j, ratio_of_j) in ratios.iter_mut().enumerate().skip(s + 1) {
            let x = self.vertices[j - 1];
            ratio = ratio * (x.emitter / x.sensor);
            if !in_range(ratio) {
                return false;
            }
            *ratio_of_j = if self.possible(j) { value(ratio * (self.factor(j) * own)) } else { 0.0 };
        }
        true
    }

    /// `n_j p_j` over the plain product of densities.
    fn factor(&self, j: usize) -> f64 {
        let k = self.vertices.len() - 1;
        let mut factor = if j >= k { self.light_walks } else { 1.0 };
        if j == 1 {
            factor *= self.direct_emitter;
        }
        if j == k {
            factor *= self.direct_sensor;
        }
        factor
    }

    /// No Dirac distribution of the path is left undrawn by technique j.
    fn possible(&self, j: usize) -> bool {
        let k = self.vertices.len() - 1;
        match j {
            0 => self.emitter_can_be_hit,
            _ if j == k + 1 => self.sensor_can_be_hit,
            _ => !self.vertices[j - 1].dirac && !self.vertices[j].dirac,
        }
    }
}
