//! Deterministic rules on the unit interval: nodes and weights, computed and not copied.

use std::f64::consts::{FRAC_PI_2, PI};

/// Nodes in (0, 1) and weights: `∫₀¹ f ≈ Σ w f(t)`.
pub(crate) type Rule = Vec<(f64, f64)>;

/// Gauss–Legendre with n nodes, exact for polynomials of degree 2n − 1. Nodes are the zeros of Pₙ by Newton's method.
pub(crate) fn gauss_legendre(n: u32) -> Rule {
    let count = f64::from(n);
    let node = |i: u32| {
        let mut x = libm::cos(PI * (f64::from(i) + 0.75) / (count + 0.5));
        let mut slope = 1.0;
        // The start is so good that Newton's method has converged long before.
        for _ in 0..20 {
            let (mut before, mut p) = (1.0, x);
            for k in 2..=n {
                let k = f64::from(k);
                (before, p) = (p, ((2.0 * k - 1.0) * x * p - (k - 1.0) * before) / k);
            }
            slope = count * (x * p - before) / (x * x - 1.0);
            x -= p / slope;
        }
        (0.5 + 0.5 * x, 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..n).map(node).collect()
}

/// The double exponential rule `t = ½ + ½ tanh(π/2 sinh τ)` with equal steps of τ, which does not mind singularities at
/// the ends (Takahasi & Mori 1974).
pub(crate) fn double_exponential(step: f64) -> Rule {
    let last = (3.2 / step) as i32;
    let node = |k: i32| {
        let tau = f64::from(k) * step;
        let s = FRAC_PI_2 * libm::sinh(tau);
        let weight = step * 0.5 * FRAC_PI_2 * libm::cosh(tau) / libm::cosh(s).powi(2);
        (1.0 / (1.0 + libm::exp(-2.0 * s)), weight)
    };
    (-last..=last).map(node).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn integral(rule: &Rule, f: impl Fn(f64) -> f64) -> f64 {
        rule.iter().map(|&(t, w)| w * f(t)).sum()
    }

    #[test]
    fn gauss_legendre_is_exact_for_its_degree() {
        for n in 2..=12 {
            let degree = 2 * n as i32 - 1;
            let error = integral(&gauss_legendre(n), |t| t.powi(degree)) * f64::from(degree + 1) - 1.0;
            assert!(error.abs() < 1e-13, "{n} nodes: {error:e}");
            let beyond = integral(&gauss_legendre(n), |t| t.powi(degree + 1)) * f64::from(degree + 2) - 1.0;
            assert!(beyond.abs() > error.abs(), "{n} nodes are exact beyond their degree: {beyond:e}");
        }
    }

    /// `∫₀¹ ln t dt = −1`.
    #[test]
    fn double_exponential_integrates_a_logarithm() {
        let error = integral(&double_exponential(0.2), libm::log) + 1.0;
        assert!(error.abs() < 1e-9, "{error:e}");
    }
}
