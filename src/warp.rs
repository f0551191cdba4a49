//! Maps from the unit square to the domains that samplers draw from, each beside its density.
//!
//! All take `u` uniform in `[0, 1)²`. Angles go through a polynomial on an eighth of a turn: it needs no reduction of its
//! argument and no branches, and the maps with it are nearly twice as fast as those with `libm::sincos`.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_4};

use glam::{DVec2, DVec3};

use crate::measure::{Area, Density, ProjectedSolidAngle, SolidAngle};

/// `(π/4)^(first + 2j) / (first + 2j)! · (−1)^j`: the Taylor coefficients of sine (first = 1) or cosine (first = 0) in
/// units of an eighth of a turn.
const fn eighth_turn_series<const N: usize>(first: usize) -> [f64; N] {
    let mut coefficients = [0.0; N];
    let mut term = if first == 1 { FRAC_PI_4 } else { 1.0 };
    let mut j = 0;
    while j < N {
        coefficients[j] = term;
        let n = first + 2 * j;
        term = -term * (FRAC_PI_4 * FRAC_PI_4) / ((n + 1) * (n + 2)) as f64;
        j += 1;
    }
    coefficients
}

const SINE: [f64; 8] = eighth_turn_series(1);
const COSINE: [f64; 9] = eighth_turn_series(0);

/// `(sin, cos)` of `t` eighths of a turn, that is of the angle `t π/4`, for `t` in `[−1, 1]`; absolute error below 1e-15.
#[must_use]
#[inline]
pub fn sin_cos_eighths(t: f64) -> (f64, f64) {
    // Pairs of terms first: half the latency of Horner's rule.
    let x = t * t;
    let x2 = x * x;
    let x4 = x2 * x2;
    let s = &SINE;
    let sine = ((s[0] + s[1] * x) + (s[2] + s[3] * x) * x2) + ((s[4] + s[5] * x) + (s[6] + s[7] * x) * x2) * x4;
    let c = &COSINE;
    let cosine =
        ((c[0] + c[1] * x) + (c[2] + c[3] * x) * x2) + (((c[4] + c[5] * x) + (c[6] + c[7] * x) * x2) + c[8] * x4) * x4;
    (t * sine, cosine)
}

/// `(sin 2πu, cos 2πu)` for `u` in `[0, 1]`; absolute error below 1e-15.
#[must_use]
#[inline]
pub fn sin_cos_turn(u: f64) -> (f64, f64) {
    let quarter = (4.0 * u + 0.5).floor();
    let (s, c) = sin_cos_eighths(2.0 * (4.0 * u - quarter));
    let q = quarter as i32;
    let (s, c) = if q & 1 == 0 { (s, c) } else { (c, s) };
    (if q & 2 == 0 { s } else { -s }, if (q + 1) & 2 == 0 { c } else { -c })
}

/// A point of the unit disk, uniform by area, by the concentric map: squares around the centre become circles.
///
/// `(r, φ) = (a, π/4 · b/a)` where `|a| > |b|`, else `(b, π/2 − π/4 · a/b)`, with `(a, b) = 2u − 1`
/// (Shirley and Chiu 1997).
#[must_use]
#[inline]
pub fn concentric_disk(u: [f64; 2]) -> DVec2 {
    disk_and_radius(u).0
}

/// The point of [`concentric_disk`] and its signed distance from the centre, which the map knows exactly.
#[inline]
fn disk_and_radius(u: [f64; 2]) -> (DVec2, f64) {
    let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    let wide = a.abs() > b.abs();
    let (r, other) = if wide { (a, b) } else { (b, a) };
    let (s, c) = sin_cos_eighths(if r == 0.0 { 0.0 } else { other / r });
    (if wide { DVec2::new(r * c, r * s) } else { DVec2::new(r * s, r * c) }, r)
}

/// The inverse of [`concentric_disk`].
#[must_use]
pub fn concentric_square(p: DVec2) -> [f64; 2] {
    let r = p.length();
    // The angle within the eighth of a turn on either side of the nearest axis, in eighths.
    let eighths = |across: f64, along: f64| libm::atan2(across, along.abs()) / FRAC_PI_4;
    let (a, b) = if p.x.abs() > p.y.abs() {
        (r.copysign(p.x), r * eighths(p.y, p.x))
    } else {
        (r * eighths(p.x, p.y), r.copysign(p.y))
    };
    [0.5 * (a + 1.0), 0.5 * (b + 1.0)].map(|u| u.clamp(0.0, 1.0 - f64::EPSILON))
}

/// The density of [`concentric_disk`], `1/π` on the unit disk.
pub const CONCENTRIC_DISK_DENSITY: Density<Area> = Density::new(FRAC_1_PI);

/// A direction of the hemisphere around +z, distributed as its cosine: the unit disk, projected up (Malley's method).
///
/// `z = √(1 − r²)`, from 1.5e-8 up: the rim itself, which `u[0] = 0` and `u[1] = 0` stand for, has density zero, and is
/// drawn half a rounding of u inwards.
#[must_use]
#[inline]
pub fn cosine_hemisphere(u: [f64; 2]) -> DVec3 {
    let (p, r) = disk_and_radius(u);
    p.extend(((1.0 - r) * (1.0 + r)).max(f64::EPSILON).sqrt())
}

/// The density of [`cosine_hemisphere`], `1/π` in projected solid angle \[1/sr\].
pub const COSINE_HEMISPHERE_DENSITY: Density<ProjectedSolidAngle> = Density::new(FRAC_1_PI);

/// The density of [`cosine_hemisphere`], `p_σ = cos θ / π` where `cos θ > 0` \[1/sr\].
#[must_use]
#[inline]
pub fn cosine_hemisphere_density(cos: f64) -> Density<SolidAngle> {
    Density::new(cos.max(0.0) * FRAC_1_PI)
}

/// A direction of the whole sphere, uniform by solid angle: `z = 1 − 2u₀`, `φ = 2πu₁`.
#[must_use]
#[inline]
pub fn uniform_sphere(u: [f64; 2]) -> DVec3 {
    uniform_cone(u, 2.0)
}

/// The density of [`uniform_sphere`], `1/4π` \[1/sr\].
pub const UNIFORM_SPHERE_DENSITY: Density<SolidAngle> = Density::new(0.25 * FRAC_1_PI);

/// A direction within `θ ≤ θ_max` of +z, uniform by solid angle: `1 − cos θ = u₀ (1 − cos θ_max)`, `φ = 2πu₁`.
///
/// The cone is given by `1 − cos θ_max` in `(0, 2]`, because `cos θ_max` alone cannot tell narrow cones apart.
#[must_use]
#[inline]
pub fn uniform_cone(u: [f64; 2], one_minus_cos_max: f64) -> DVec3 {
    let below = u[0] * one_minus_cos_max;
    let sine = (below * (2.0 - below)).max(0.0).sqrt();
    let (s, c) = sin_cos_turn(u[1]);
    DVec3::new(sine * c, sine * s, 1.0 - below)
}

/// The density of [`uniform_cone`] inside the cone, `p_σ = 1 / (2π (1 − cos θ_max))` \[1/sr\].
#[must_use]
#[inline]
pub fn uniform_cone_density(one_minus_cos_max: f64) -> Density<SolidAngle> {
    Density::new(0.5 * FRAC_1_PI / one_minus_cos_max)
}

/// Barycentric coordinates, uniform by area: `(1 − √u₀, √u₀ (1 − u₁), √u₀ u₁)` (Turk 1990).
#[must_use]
#[inline]
pub fn uniform_triangle(u: [f64; 2]) -> [f64; 3] {
    let root = u[0].sqrt();
    [1.0 - root, root * (1.0 - u[1]), root * u[1]]
}

/// The density of [`uniform_triangle`], `1 / area` \[1/m²\].
#[must_use]
#[inline]
pub fn uniform_triangle_density(area: f64) -> Density<Area> {
    Density::new(1.0 / area)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;

    /// The centres of `n²` cells of the unit square: a rule whose error for smooth integrands is `O(n⁻²)`.
    fn lattice(n: usize) -> impl Iterator<Item = [f64; 2]> {
        let at = move |i: usize| (i as f64 + 0.5) / n as f64;
        (0..n * n).map(move |i| [at(i % n), at(i / n)])
    }

    fn mean(n: usize, f: impl Fn([f64; 2]) -> f64) -> f64 {
        lattice(n).map(f).sum::<f64>() / (n * n) as f64
    }

    #[test]
    fn sines_agree_with_libm() {
        for i in 0..=100_000 {
            let u = f64::from(i) / 100_000.0;
            let (s, c) = sin_cos_eighths(2.0 * u - 1.0);
            let (s0, c0) = libm::sincos((2.0 * u - 1.0) * FRAC_PI_4);
            assert!((s - s0).abs() < 1e-15 && (c - c0).abs() < 1e-15, "eighths at {u}");
            let (s, c) = sin_cos_turn(u);
            let (s0, c0) = libm::sincos(TAU * u);
            // 2πu itself is rounded by up to 4.4e-16 before libm sees it.
            assert!((s - s0).abs() < 1.5e-15 && (c - c0).abs() < 1.5e-15, "turn at {u}");
        }
    }

    #[test]
    fn second_moments_are_those_of_the_density() {
        let n = 400;
        let near = |a: f64, b: f64| assert!((a - b).abs() < 2e-5 * b.abs().max(1.0), "{a} is not {b}");
        near(mean(n, |u| concentric_disk(u).x.powi(2)), 0.25);
        near(mean(n, |u| concentric_disk(u).y.powi(2)), 0.25);
        near(mean(n, |u| concentric_disk(u).length().powi(4)), 1.0 / 3.0);
        near(mean(n, |u| cosine_hemisphere(u).z.powi(2)), 0.5);
        near(mean(n, |u| uniform_sphere(u).z.powi(2)), 1.0 / 3.0);
        near(mean(n, |u| uniform_sphere(u).x.powi(2)), 1.0 / 3.0);
        near(mean(n, |u| uniform_cone(u, 0.3).z), 0.85);
        near(mean(n, |u| uniform_triangle(u)[0].powi(2)), 1.0 / 6.0);
        near(mean(n, |u| uniform_triangle(u)[2].powi(2)), 1.0 / 6.0);
    }

    #[test]
    fn densities_integrate_to_one() {
        let n = 400;
        // ∫ p dσ by uniform directions of the upper hemisphere, 2π sr.
        let cosine = TAU * mean(n, |u| cosine_hemisphere_density(uniform_cone(u, 1.0).z).value());
        assert!((cosine - 1.0).abs() < 1e-9);
        assert!((UNIFORM_SPHERE_DENSITY.value() * 4.0 * PI - 1.0).abs() < 1e-15);
        assert!((uniform_cone_density(2.0) / UNIFORM_SPHERE_DENSITY - 1.0).abs() < 1e-15);
        assert!((uniform_triangle_density(4.0).value() * 4.0 - 1.0).abs() < 1e-15);
        assert_eq!(cosine_hemisphere_density(-0.5), Density::ZERO);
    }

    #[test]
    fn results_stay_in_the_domain_at_the_ends_of_the_unit_square() {
        let ends = [0.0, f64::MIN_POSITIVE, 0.5, 1.0 - f64::EPSILON / 2.0];
        for u in ends.into_iter().flat_map(|a| ends.map(|b| [a, b])) {
            assert!(concentric_disk(u).length() <= 1.0 + 1e-15, "{u:?}");
            let unit = |v: DVec3| (v.length() - 1.0).abs() < 1e-15;
            assert!(unit(cosine_hemisphere(u)) && cosine_hemisphere(u).z > 1e-8, "{u:?}");
            assert!(unit(uniform_sphere(u)) && unit(uniform_cone(u, 1e-20)), "{u:?}");
            let b = uniform_triangle(u);
            assert!(b.iter().all(|&x| x >= 0.0) && (b.iter().sum::<f64>() - 1.0).abs() < 1e-15, "{u:?}");
        }
    }

    #[test]
    fn the_concentric_map_has_an_inverse() {
        for u in lattice(64) {
            let back = concentric_square(concentric_disk(u));
            assert!((back[0] - u[0]).abs() < 1e-14 && (back[1] - u[1]).abs() < 1e-14, "{u:?}: {back:?}");
        }
    }

    #[test]
    fn the_concentric_map_keeps_squares_and_their_areas() {
        // The square of half side r/2 becomes the disk of radius r.
        for u in lattice(64) {
            let square = (2.0 * u[0] - 1.0).abs().max((2.0 * u[1] - 1.0).abs());
            assert!((concentric_disk(u).length() - square).abs() < 1e-15);
        }
    }
}
