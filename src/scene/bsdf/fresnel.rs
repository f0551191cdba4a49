//! Fresnel's equations for unpolarised light, arranged so that no digits cancel.

use glam::DVec3;

use crate::scene::description::ConductorFresnel;
use crate::spectrum::Rgb;

/// The shares of the flux that a smooth interface of dielectrics reflects and transmits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Split {
    /// F, 0 … 1.
    pub reflected: f64,
    /// 1 − F, accurate also where it is small.
    pub transmitted: f64,
}

/// An interface between two dielectrics, its outside on the normal's side; indices are relative to the outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    /// η = η_inside / η_outside.
    eta: f64,
    /// η − 1, which η itself rounds where the two are alike.
    eta_minus_one: f64,
}

impl Interface {
    /// Between finite positive indices of refraction.
    #[must_use]
    pub fn new(interior_ior: f64, exterior_ior: f64) -> Self {
        Self { eta: interior_ior / exterior_ior, eta_minus_one: (interior_ior - exterior_ior) / exterior_ior }
    }

    /// η − 1, zero where there is no interface.
    #[must_use]
    #[inline]
    pub fn contrast(&self) -> f64 {
        self.eta_minus_one
    }

    /// The index of refraction on the side that a direction with this cosine points to, relative to the outside.
    #[must_use]
    #[inline]
    pub fn index(&self, cos: f64) -> f64 {
        if cos > 0.0 { 1.0 } else { self.eta }
    }

    /// `(η_o/η_i)²` for directions with these cosines.
    #[must_use]
    #[inline]
    pub fn radiance_scale(&self, cos_emitter: f64, cos_sensor: f64) -> f64 {
        let ratio = self.index(cos_sensor) / self.index(cos_emitter);
        ratio * ratio
    }

    /// `(n, n² − 1)` with `n` the index beyond the interface relative to that on the side of the cosine.
    #[inline]
    fn relative(&self, cos: f64) -> (f64, f64) {
        let square_minus_one = self.eta_minus_one * (self.eta + 1.0);
        if cos > 0.0 {
            (self.eta, square_minus_one)
        } else {
            (1.0 / self.eta, -square_minus_one / (self.eta * self.eta))
        }
    }

    /// `cos θ_t = √(1 − sin²θ / n²)` beyond the interface; `None` for total reflection.
    #[must_use]
    #[inline]
    pub fn cos_refracted(&self, cos: f64) -> Option<f64> {
        let (n, n2_minus_one) = self.relative(cos);
        // n² − sin²θ, by whichever difference cancels less.
        let square = if n < 0.5 { n * n - (1.0 - cos.abs()) * (1.0 + cos.abs()) } else { n2_minus_one + cos * cos };
        (square > 0.0).then(|| square.sqrt() / n)
    }

    /// `F = (r_s² + r_p²) / 2` for light from the side of the cosine, with
    /// `r_s = (1 − n²) / (c + n c_t)²` and `r_p = (n² − 1) (n² c² − sin²θ) / (n (n c + c_t))²`,
    /// the usual ratios with their differences multiplied out, and `1 − F` from the products of the transmitted amplitudes.
    #[must_use]
    #[inline]
    pub fn fresnel(&self, cos: f64) -> Split {
        let (n, n2_minus_one) = self.relative(cos);
        if n2_minus_one == 0.0 {
            return Split { reflected: 0.0, transmitted: 1.0 };
        }
        let Some(ct) = self.cos_refracted(cos) else {
            return Split { reflected: 1.0, transmitted: 0.0 };
        };
        let c = cos.abs();
        let (s, p) = (c + n * ct, n * c + ct);
        let r_s = n2_minus_one / (s * s);
        let r_p = n2_minus_one * (n * n * c * c - (1.0 - c) * (1.0 + c)) / (n * n * p * p);
        Split {
            reflected: (0.5 * (r_s * r_s + r_p * r_p)).min(1.0),
            transmitted: (2.0 * n * c * ct * (1.0 / (s * s) + 1.0 / (p * p))).min(1.0),
        }
    }

    /// `1 − F` for a pair that a refraction joins, from the side where light is farther from total reflection: the same
    /// number for either direction of the walk.
    #[must_use]
    #[inline]
    pub fn transmittance(&self, cos_a: f64, cos_b: f64) -> f64 {
        let outside_is_thin = self.eta_minus_one >= 0.0;
        let thin = if (cos_a > 0.0) == outside_is_thin { cos_a } else { cos_b };
        self.fresnel(thin).transmitted
    }

    /// The direction of refraction at the normal `m`, `−v/n + k m` with `cos = v·m` and
    /// `k = c/n − c_t = (1 − n²) / (n² (c/n + c_t))` for c > 0, negated for c < 0; `None` for total reflection.
    #[must_use]
    #[inline]
    pub fn refract(&self, v: DVec3, m: DVec3, cos: f64) -> Option<DVec3> {
        let (n, n2_minus_one) = self.relative(cos);
        let ct = self.cos_refracted(cos)?;
        let k = -n2_minus_one / (n * n * (cos.abs() / n + ct));
        let to = m * (if cos > 0.0 { k } else { -k }) - v * (1.0 / n);
        // Small n magnifies the rounding of v, length included.
        Some(if n < 0.5 { to.normalize() } else { to })
    }
}

/// The share of diffuse light that an interface of dielectrics reflects, `∫ 2 cos θ F(cos θ) dcos θ`, for an index beyond it
/// relative to that on the light's side.
///
/// From a half to two the fits that Mitsuba has, of Egan and Hilgeman (1973) below one and of d'Eon and Irving (2011) above:
/// within 0.6 %. The exact integral elsewhere, where the first of them soon exceeds one.
#[must_use]
pub fn diffuse_reflectance(index: f64) -> f64 {
    let inverse = 1.0 / index;
    if (0.5..1.0).contains(&index) {
        0.0636 * inverse + (0.6681 + index * (0.7099 - 1.4399 * index))
    } else if (1.0..=2.0).contains(&index) {
        let fit = [0.919_317, -3.4793, 6.753_35, -7.809_89, 4.985_54, -1.368_81];
        fit.iter().rev().fold(0.0, |sum, coefficient| sum * inverse + coefficient)
    } else {
        exact_diffuse_reflectance(index)
    }
}

/// The integral of [`diffuse_reflectance`] (Walsh 1926), and by `1 − R(1/n) = (1 − R(n)) / n²` from the denser side.
fn exact_diffuse_reflectance(index: f64) -> f64 {
    if index < 1.0 {
        return 1.0 - (1.0 - exact_diffuse_reflectance(1.0 / index)) * (index * index);
    }
    let n = index;
    let (n2, n4) = (n * n, n * n * n * n);
    let (less, more) = (n2 - 1.0, n2 + 1.0);
    0.5 + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0) * (n + 1.0))
        + n2 * less * less / (more * more * more) * libm::log((n - 1.0) / (n + 1.0))
        - 2.0 * n * n2 * (n2 + 2.0 * n - 1.0) / (more * (n4 - 1.0))
        + 8.0 * n4 * (n4 + 1.0) / (more * (n4 - 1.0) * (n4 - 1.0)) * libm::log(n)
}

/// The share of the flux that a metal reflects at the angle with this cosine.
#[must_use]
#[inline]
pub fn conductor(fresnel: &ConductorFresnel, cos: f64) -> Rgb {
    match fresnel {
        ConductorFresnel::Tint { specular_tint } => *specular_tint,
        ConductorFresnel::Ior { eta, k } => Rgb::new(
            conductor_channel(eta.r, k.r, cos),
            conductor_channel(eta.g, k.g, cos),
            conductor_channel(eta.b, k.b, cos),
        ),
    }
}

/// `F = (|(c − w)/(c + w)|² + |(ε c − w)/(ε c + w)|²) / 2` with `ε = (η + ik)²` and `w = √(ε − sin²θ)` (Born and Wolf 1999,
/// Fresnel's formulae with a complex index).
#[must_use]
pub fn conductor_channel(eta: f64, k: f64, cos: f64) -> f64 {
    let c = cos.abs();
    let (re, im) = ((eta - k) * (eta + k), 2.0 * eta * k);
    // Re ε − sin²θ, by whichever difference cancels less.
    let below = if c < 0.7 { (re - 1.0) + c * c } else { re - (1.0 - c) * (1.0 + c) };
    let modulus = (below * below + im * im).sqrt();
    // w = a + ib. The larger part has no cancellation; the other one follows from 2ab = Im ε.
    let large = (0.5 * (modulus + below.abs())).sqrt();
    let small = if large > 0.0 { 0.5 * im / large } else { 0.0 };
    let (a, b) = if below >= 0.0 { (large, small) } else { (small, large) };
    let ratio = |x: f64, y: f64| {
        let difference = (x - a) * (x - a) + (y - b) * (y - b);
        let sum = (x + a) * (x + a) + (y + b) * (y + b);
        if sum > 0.0 { (difference / sum).min(1.0) } else { 1.0 }
    };
    0.5 * (ratio(c, 0.0) + ratio(re * c, im * c))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the midpoint rule in cos², on which the integrand's kink at the critical angle costs little.
    #[test]
    fn diffuse_reflectances_are_integrals() {
        for index in [0.1, 0.3, 0.51, 0.6, 0.75, 1.2, 1.5, 1.9, 2.4, 9.0, 12.0] {
            let n = 1_000_000;
            let interface = Interface::new(index, 1.0);
            let f = |i: i32| interface.fresnel(((f64::from(i) + 0.5) / f64::from(n)).sqrt()).reflected;
            let expected = (0..n).map(f).sum::<f64>() / f64::from(n);
            assert!((exact_diffuse_reflectance(index) / expected - 1.0).abs() < 1e-6, "{index}: not {expected}");
            assert!((diffuse_reflectance(index) / expected - 1.0).abs() < 6e-3, "{index}: not {expected}");
        }
    }
}
