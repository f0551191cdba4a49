//! A rule on triangles.

use glam::DVec3;

use super::polygon::Corners;

/// The seven points of a triangle, with weights that sum to one: exact for polynomials of degree 5 (Radon 1948).
pub(super) fn triangle([a, b, c]: Corners) -> [(DVec3, f64); 7] {
    let root = 15.0_f64.sqrt();
    let near = |p: DVec3, q: DVec3, r: DVec3, t: f64| (p + q) * t + r * (1.0 - 2.0 * t);
    let (inner, outer) = ((6.0 - root) / 21.0, (6.0 + root) / 21.0);
    let (light, heavy) = ((155.0 - root) / 1200.0, (155.0 + root) / 1200.0);
    [
        ((a + b + c) / 3.0, 9.0 / 40.0),
        (near(a, b, c, inner), light),
        (near(b, c, a, inner), light),
        (near(c, a, b, inner), light),
        (near(a, b, c, outer), heavy),
        (near(b, c, a, outer), heavy),
        (near(c, a, b, outer), heavy),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `∫ xᵐ yⁿ dA / A = 2 m! n! / (m + n + 2)!` over the unit triangle.
    #[test]
    fn the_triangle_rule_has_degree_five() {
        let points = triangle([DVec3::ZERO, DVec3::X, DVec3::Y]);
        let factorial = |n: i32| (1..=n).map(f64::from).product::<f64>();
        for (m, n) in (0..=5).flat_map(|m| (0..=5 - m).map(move |n| (m, n))) {
            let sum: f64 = points.iter().map(|(p, w)| w * p.x.powi(m) * p.y.powi(n)).sum();
            let exact = 2.0 * factorial(m) * factorial(n) / factorial(m + n + 2);
            assert!((sum - exact).abs() < 1e-15, "x^{m} y^{n}: {sum} is not {exact}");
        }
    }
}
