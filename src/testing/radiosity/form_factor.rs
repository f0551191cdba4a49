//! Form factors of unobstructed polygons: of a point in closed form, of a pair by the double contour integral.

use std::f64::consts::PI;
use std::sync::LazyLock;

use glam::DVec3;

use super::polygon::{Plane, Polygon, area_vector, centroid, edges, radius};
use super::quadrature::triangle;
use crate::quadrature::{Rule, double_exponential, gauss_legendre};

/// For edges that touch or nearly do.
static SINGULAR: LazyLock<Rule> = LazyLock::new(|| double_exponential(0.2));
/// For edges at a distance of their length or more.
static NEAR: LazyLock<Rule> = LazyLock::new(|| gauss_legendre(8));
/// Distance in radii from which the kernel itself is so smooth that it is integrated directly.
const FAR: f64 = 12.0;

/// The form factor of a surface element at `x` with unit normal `normal` towards a convex polygon:
/// `F = 1/(2π) Σ_i γ_i Γ_i · n`, where γ_i is the angle that edge i fills seen from x and Γ_i the unit normal of the plane
/// through x and that edge (Lambert 1760), clipped at the horizon of x. Zero behind the polygon. The irradiance is `F B`
/// where the polygon's radiosity is B. Nothing is taken to lie between.
#[must_use]
pub fn point_form_factor(x: DVec3, normal: DVec3, polygon: &[DVec3]) -> f64 {
    if polygon.len() < 3 || Plane::of(polygon).height(x) <= 0.0 {
        return 0.0;
    }
    let above = Plane::at(x, normal).clip(polygon);
    let sum: f64 = edges(&above)
        .map(|[a, b]| {
            let (a, b) = (a - x, b - x);
            let cross = a.cross(b);
            let sine = cross.length();
            if sine > 0.0 { libm::atan2(sine, a.dot(b)) * cross.dot(normal) / sine } else { 0.0 }
        })
        .sum();
    // The corners go round the other way seen from x as its normal has it.
    (-sum / (2.0 * PI)).max(0.0)
}

/// The form factor `F = 1/A_p ∫∫ cos θ_p cos θ_q / (π r²) dA_q dA_p` from one convex polygon to another, of the parts that
/// face each other. Nothing is taken to lie between.
///
/// By Stokes' theorem it is `1/(2π A_p) ∮∮ ln r dx·dy` (Moon 1936; Goral et al. 1984); the inner integral is closed, the
/// outer one is by quadrature that resolves the logarithms of edges that touch.
#[must_use]
pub fn form_factor(p: &[DVec3], q: &[DVec3]) -> f64 {
    match facing_parts(p, q) {
        Some((part_p, part_q)) => exchange_area(&part_p, &part_q) / area_vector(p).length(),
        None => 0.0,
    }
}

/// The parts of both that are in front of each other; the sign of a cosine depends on one of the two points only.
pub(super) fn facing_parts(p: &[DVec3], q: &[DVec3]) -> Option<(Polygon, Polygon)> {
    let (plane_p, plane_q) = (Plane::of(p), Plane::of(q));
    // Flat surfaces of single precision corners are flat up to this part of their size.
    let flat = 1e-6 * (radius(p) + radius(q) + centroid(p).distance(centroid(q)));
    let behind = |plane: Plane, polygon: &[DVec3]| polygon.iter().all(|&c| plane.height(c) <= flat);
    if behind(plane_p, q) || behind(plane_q, p) {
        return None;
    }
    let parts = (plane_q.clip(p), plane_p.clip(q));
    (parts.0.len() > 2 && parts.1.len() > 2).then_some(parts)
}

/// `A_p F_pq = A_q F_qp` \[m²\] of polygons that face each other with all of their points.
pub(super) fn exchange_area(p: &[DVec3], q: &[DVec3]) -> f64 {
    let (rp, rq) = (radius(p), radius(q));
    let between = centroid(p).distance(centroid(q));
    if let (&[a, b, c], &[d, e, f]) = (p, q)
        && between > FAR * rp.max(rq)
    {
        return far_exchange_area([a, b, c], [d, e, f]);
    }
    // A constant factor of r leaves closed contours unchanged, and this one keeps the logarithms small.
    let unit = between.max(rp).max(rq);
    let mut sum = 0.0;
    for [a, b] in edges(p) {
        for [c, d] in edges(q) {
            let along = (b - a).dot(d - c);
            if along != 0.0 {
                sum += along * mean_log_of_edges([a, b], [c, d], unit);
            }
        }
    }
    (sum / (2.0 * PI)).max(0.0)
}

fn far_exchange_area(p: [DVec3; 3], q: [DVec3; 3]) -> f64 {
    let (area_p, area_q) = (area_vector(&p), area_vector(&q));
    let points = triangle(q);
    let mut sum = 0.0;
    for (x, wx) in triangle(p) {
        for (y, wy) in points {
            sum += wx * wy * kernel(x, area_p, y, area_q);
        }
    }
    sum
}

/// `cos θ_x cos θ_y / (π r²)`, times the lengths of the normals; zero where one is behind the other.
fn kernel(x: DVec3, normal_x: DVec3, y: DVec3, normal_y: DVec3) -> f64 {
    let offset = y - x;
    let squared = offset.length_squared();
    normal_x.dot(offset).max(0.0) * (-normal_y.dot(offset)).max(0.0) / (PI * squared * squared)
}

/// `∫₀¹ ∫₀¹ ln(r / unit) ds dt` over two segments.
fn mean_log_of_edges([a, b]: [DVec3; 2], [c, d]: [DVec3; 2], unit: f64) -> f64 {
    let (direction, length) = (b - a, a.distance(b));
    let apart = (a + b).distance(c + d) * 0.5 - 0.5 * (length + c.distance(d));
    let at = |s: f64| mean_log_of_point(a + direction * s, c, d, unit);
    if apart > length {
        return NEAR.iter().map(|&(s, w)| w * at(s)).sum();
    }
    // The integrand is singular, or nearly so, beside the ends of the other segment.
    let beside = |x: DVec3| ((x - a).dot(direction) / (length * length)).clamp(0.0, 1.0);
    let (first, second) = (beside(c).min(beside(d)), beside(c).max(beside(d)));
    let piece = |from: f64, to: f64| -> f64 {
        let width = to - from;
        if width > 0.0 { SINGULAR.iter().map(|&(s, w)| w * width * at(from + s * width)).sum() } else { 0.0 }
    };
    piece(0.0, first) + piece(first, second) + piece(second, 1.0)
}

/// `∫₀¹ ln(‖x − a − t (b − a)‖ / unit) dt`, in closed form.
fn mean_log_of_point(x: DVec3, a: DVec3, b: DVec3, unit: f64) -> f64 {
    let (from, to) = (a - x, b - x);
    let length = a.distance(b);
    let direction = (b - a) / length;
    let (s, t) = (from.dot(direction), to.dot(direction));
    let height = from.cross(direction).length();
    let log = |along: f64, offset: DVec3| {
        let squared = offset.length_squared() / (unit * unit);
        if squared > 0.0 { 0.5 * along * libm::log(squared) } else { 0.0 }
    };
    let angle = libm::atan2(height * length, height * height + s * t);
    (log(t, to) - log(s, from) + height * angle) / length - 1.0
}
