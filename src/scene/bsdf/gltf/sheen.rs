//! The fibres of KHR_materials_sheen.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::LazyLock;

use glam::DVec3;

use crate::spectrum::Rgb;

/// Below this the power of the sine in the distribution is a step.
const SMALLEST_ROUGHNESS: f64 = 0.1;

/// Sheen of Estevez and Kulla (2017): `f_s = colour · D / (4 (1 + Λ(i) + Λ(o)) cos θ_i cos θ_o)` with
/// `D(h) = (2 + 1/α) sin^(1/α) θ_h / 2π`, and what is below it scaled by what it leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sheen {
    pub(super) colour: Rgb,
    roughness: f64,
}

impl Sheen {
    pub(super) fn new(colour: Rgb, roughness: f64) -> Self {
        Self { colour, roughness: roughness.clamp(SMALLEST_ROUGHNESS, 1.0) }
    }

    /// Both directions in front \[1/sr\].
    pub(super) fn eval(&self, i: DVec3, o: DVec3) -> Rgb {
        self.colour * lobe(self.roughness * self.roughness, i, o)
    }

    /// `E(cos θ)`: the share of the flux from there that white fibres reflect.
    pub(super) fn albedo(&self, cos: f64) -> f64 {
        ALBEDO.get(cos.abs(), self.roughness)
    }

    /// What is left to the layers below: `min(1 − max(colour) E(i), 1 − max(colour) E(o))`.
    pub(super) fn scale(&self, i: DVec3, o: DVec3) -> f64 {
        (1.0 - self.colour.max_component() * self.albedo(i.z).max(self.albedo(o.z))).max(0.0)
    }
}

fn lobe(alpha: f64, i: DVec3, o: DVec3) -> f64 {
    let h = i + o;
    let sin2 = ((h.x * h.x + h.y * h.y) / h.length_squared()).min(1.0);
    let d = (2.0 + 1.0 / alpha) * libm::pow(sin2, 0.5 / alpha) / TAU;
    d / ((1.0 + lambda(i.z, alpha) + lambda(o.z, alpha)) * 4.0 * i.z * o.z)
}

/// Their fit to Λ of the distribution, mirrored around cos θ = 1/2.
fn lambda(cos: f64, alpha: f64) -> f64 {
    // Rounded directions may exceed one, and the power of what is negative is no number.
    let cos = cos.min(1.0);
    libm::exp(if cos < 0.5 { fit(cos, alpha) } else { 2.0 * fit(0.5, alpha) - fit(1.0 - cos, alpha) })
}

fn fit(x: f64, alpha: f64) -> f64 {
    let t = (1.0 - alpha) * (1.0 - alpha);
    let mix = |a: f64, b: f64| a * (1.0 - t) + b * t;
    let (a, b, c) = (mix(21.5473, 25.3245), mix(3.82987, 3.32435), mix(0.19823, 0.16801));
    a / (1.0 + b * libm::pow(x, c)) + mix(-1.97760, -1.27393) * x + mix(-4.32054, -4.85967)
}

/// `E` at equal steps of θ and of the roughness, interpolated.
struct Table(Vec<f64>);

const ANGLES: usize = 32;
const ROUGHNESSES: usize = 24;

static ALBEDO: LazyLock<Table> = LazyLock::new(Table::new);

impl Table {
    fn new() -> Self {
        let entry = |index: usize| {
            let (row, column) = (index / ANGLES, index % ANGLES);
            let step = row as f64 / (ROUGHNESSES - 1) as f64;
            let roughness = SMALLEST_ROUGHNESS + (1.0 - SMALLEST_ROUGHNESS) * step;
            // The last angle stands for the horizon, where the lobe has no finite value.
            let theta = FRAC_PI_2 * (column as f64 / (ANGLES - 1) as f64).min(0.9999);
            albedo(theta, roughness * roughness)
        };
        Self((0..ROUGHNESSES * ANGLES).map(entry).collect())
    }

    fn get(&self, cos: f64, roughness: f64) -> f64 {
        let x = libm::acos(cos.min(1.0)) / FRAC_PI_2 * (ANGLES - 1) as f64;
        let y = (roughness - SMALLEST_ROUGHNESS) / (1.0 - SMALLEST_ROUGHNESS) * (ROUGHNESSES - 1) as f64;
        let (column, row) = ((x as usize).min(ANGLES - 2), (y as usize).min(ROUGHNESSES - 2));
        let (fx, fy) = (x - column as f64, y - row as f64);
        let at = |row: usize, column: usize| self.0[row * ANGLES + column];
        let along = |row: usize| at(row, column) * (1.0 - fx) + at(row, column + 1) * fx;
        // The fit exceeds one close to the horizon.
        (along(row) * (1.0 - fy) + along(row + 1) * fy).min(1.0)
    }
}

/// `∫ f_s cos θ dσ` by the midpoint rule in θ and φ; both are smooth, and φ is periodic.
fn albedo(theta: f64, alpha: f64) -> f64 {
    const STEPS: usize = 48;
    let (s, c) = libm::sincos(theta);
    let o = DVec3::new(s, 0.0, c);
    let mut sum = 0.0;
    for row in 0..STEPS {
        let (s, c) = libm::sincos((row as f64 + 0.5) / STEPS as f64 * FRAC_PI_2);
        for column in 0..STEPS {
            let (y, x) = libm::sincos((column as f64 + 0.5) / STEPS as f64 * PI);
            sum += lobe(alpha, DVec3::new(s * x, s * y, c), o) * c * s;
        }
    }
    sum * (FRAC_PI_2 / STEPS as f64) * (TAU / STEPS as f64)
}
