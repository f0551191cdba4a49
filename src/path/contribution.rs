//! f(x̄), the measurement contribution of a path.

use crate::scene::Scene;
use crate::scene::sensor::Pixel;
use crate::spectrum::Rgb;
use crate::wide::Wide;

use super::{Edge, Path, Vertex, VertexKind};

/// What a path adds to the one pixel that sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contribution {
    /// The pixel j.
    pub pixel: Pixel,
    /// `f_j(x̄)` by channel, or the product of its Dirac distributions' coefficients; that of a long path, or of any in a scene
    /// whose unit is not of its size, is beyond every plain number.
    pub value: [Wide; 3],
}

impl Contribution {
    /// The path carries no light.
    #[must_use]
    pub fn is_black(&self) -> bool {
        self.value.iter().all(|value| value.is_zero())
    }

    /// `f_j(x̄) · scale / density`.
    #[must_use]
    pub fn over(&self, density: Wide, scale: f64) -> Rgb {
        Rgb::from(self.value.map(|f| (f * scale / density).to_f64()))
    }
}

impl Scene {
    /// `f_j(x̄) = L_e(x_0→x_1) ∏ G(x_i↔x_{i+1}) ∏ f_s(x_{i−1}→x_i→x_{i+1}) W_e^j(x_{k−1}→x_k)` (Veach 1997, eq. 8.7) with
    /// the visibility in G taken as one; [`unobstructed`](Self::unobstructed) tells it. `None` where no pixel sees the path.
    ///
    /// Dirac distributions enter by their coefficients, so f is to be divided only by a density of the same path.
    #[must_use]
    pub fn contribution(&self, path: &Path) -> Option<Contribution> {
        let mut value = [Wide::ONE; 3];
        let multiply = |factor: Rgb| {
            for (channel, factor) in value.iter_mut().zip(factor.to_array()) {
                *channel = *channel * factor;
            }
        };
        let pixel = self.multiply_factors(path, multiply)?;
        Some(Contribution { pixel, value })
    }

    /// Gives the factors of f(x̄) one after the other, and returns the pixel that sees the path.
    fn multiply_factors(&self, path: &Path, mut multiply: impl FnMut(Rgb)) -> Option<Pixel> {
        let k = path.edges();
        let edge = |i: usize| Edge::between(path.vertex(i), path.vertex(i + 1));
        let sensor = path.vertex(k);
        let importance = match sensor.kind {
            VertexKind::Sensor { .. } => self.sensor().importance(sensor, -edge(k - 1).direction)?,
            _ => return None,
        };
        let start = self.emitted(path.vertex(0), edge(0).direction, k) * importance.value;
        multiply(start);
        if start.is_black() {
            // Vertices drawn twice at one place have no direction and no geometry factor, but they emit nothing either.
            return Some(importance.pixel);
        }
        for i in 0..k {
            multiply(Rgb::grey(edge(i).geometry(path.vertex(i), path.vertex(i + 1))));
        }
        for i in 1..k {
            let (to_emitter, to_sensor) = (-edge(i - 1).direction, edge(i).direction);
            multiply(if !path.vertex(i).scatters() {
                Rgb::BLACK
            } else if path.is_dirac(i) {
                self.scatter_dirac(path.vertex(i), to_emitter, to_sensor)
            } else {
                self.scatter(path.vertex(i), to_emitter, to_sensor)
            });
        }
        Some(importance.pixel)
    }

    /// `L_e(x_0 → x_1)` in a path of `edges` edges. What is concentrated in a point or a direction is not seen directly.
    fn emitted(&self, x0: &Vertex, direction: glam::DVec3, edges: usize) -> Rgb {
        let Some(emitter) = x0.emitter().map(|id| self.emitter(id)) else { return Rgb::BLACK };
        if edges == 1 && !emitter.can_be_hit() { Rgb::BLACK } else { emitter.emission(self, x0, direction) }
    }

    /// `∏ V(x_i, x_{i+1})`: nothing lies between the path's vertices.
    #[must_use]
    pub fn unobstructed(&self, path: &Path) -> bool {
        path.vertices().windows(2).all(|edge| self.visible(&edge[0], &edge[1]))
    }
}
