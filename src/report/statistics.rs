//! Tests of means, and the straight line of least squares.

use nalgebra::{Matrix2, Vector2};
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

use crate::film::Moments;

/// The difference of two means, each over independent passes of unknown and unequal variance (Welch 1947).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Welch {
    /// `mean_a − mean_b`.
    pub difference: f64,
    /// `√(s_a²/n_a + s_b²/n_b)`.
    pub standard_error: f64,
    /// Degrees of freedom after Welch and Satterthwaite; infinite where both variances are zero.
    pub freedom: f64,
    /// Estimated skewness of the difference, `(μ3_a/n_a² − μ3_b/n_b²) / standard_error³`.
    pub skewness: f64,
    /// The larger magnitude of its two terms: 1/√k where k equal outliers make up all of the variance.
    pub tail: f64,
}

impl Welch {
    pub fn new(a: &Moments, b: &Moments) -> Self {
        let (va, vb) = (a.variance_of_mean(), b.variance_of_mean());
        let variance = va + vb;
        let standard_error = variance.sqrt();
        let below = va * va / (a.count as f64 - 1.0) + vb * vb / (b.count as f64 - 1.0);
        let (third_a, third_b) = (a.third_of_mean(), b.third_of_mean());
        let cube = variance * standard_error;
        let relative = |third: f64| if cube > 0.0 { third / cube } else { 0.0 };
        Self {
            difference: a.mean - b.mean,
            standard_error,
            freedom: if below > 0.0 { variance * variance / below } else { f64::INFINITY },
            skewness: relative(third_a - third_b),
            tail: relative(third_a.abs().max(third_b.abs())),
        }
    }

    /// `t`: the difference beyond the tolerance over its standard error, with the sign of the difference.
    pub fn statistic(&self, tolerance: f64) -> f64 {
        let beyond = self.difference.abs() - tolerance;
        if beyond > 0.0 { self.difference.signum() * beyond / self.standard_error } else { 0.0 }
    }

    /// The two-sided p-value of [`Welch::statistic`], after Hall's monotone transformation
    /// `t + λt²/3 + λ²t³/27 + λ/6` with the skewness λ (Hall 1992): without it, skewed passes of a few hundred raise the
    /// rate of false alarms at small p by one to two orders of magnitude.
    pub fn p_value(&self, tolerance: f64) -> f64 {
        let t = self.statistic(tolerance);
        if t == 0.0 {
            return 1.0;
        }
        // Without variance there is no skewness to correct for.
        if t.is_infinite() {
            return 0.0;
        }
        let l = self.skewness;
        let corrected = t + l * t * t / 3.0 + l * l * t * t * t / 27.0 + l / 6.0;
        (2.0 * upper_tail(corrected.abs(), self.freedom)).min(1.0)
    }

    /// The difference that a two-sided test at `level` finds with probability `power`:
    /// `tolerance + (t_{1−level/2} + t_{power}) · standard_error`, with quantiles of Student's distribution.
    pub fn detectable(&self, level: f64, power: f64, tolerance: f64) -> f64 {
        let quantiles = upper_quantile(0.5 * level, self.freedom) + upper_quantile(1.0 - power, self.freedom);
        tolerance + quantiles * self.standard_error
    }
}

/// Beyond so many degrees of freedom Student's distribution is taken for the normal one.
const NORMAL_FREEDOM: f64 = 1e6;

/// `P(T > t)` of Student's distribution.
fn upper_tail(t: f64, freedom: f64) -> f64 {
    match StudentsT::new(0.0, 1.0, freedom) {
        Ok(student) if freedom < NORMAL_FREEDOM => student.sf(t),
        _ => Normal::standard().sf(t),
    }
}

/// The t with `P(T > t) = p`, for p in (0, 1).
pub(crate) fn upper_quantile(p: f64, freedom: f64) -> f64 {
    match StudentsT::new(0.0, 1.0, freedom) {
        // By symmetry; the lower tail keeps the precision of a small p.
        Ok(student) if freedom < NORMAL_FREEDOM => -student.inverse_cdf(p),
        _ => -Normal::standard().inverse_cdf(p),
    }
}

/// P-values adjusted for many tests (Holm 1979): the probability of any false alarm is at most the level, whatever the
/// dependence between the tests. `adjusted_(i) = max_{j≤i} min(1, (m − j + 1) p_(j))` in ascending order, j from 1.
pub(crate) fn holm(p_values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p_values.len()).collect();
    order.sort_by(|&i, &j| p_values[i].total_cmp(&p_values[j]));
    let mut adjusted = vec![1.0; p_values.len()];
    let mut largest = 0.0_f64;
    for (rank, &index) in order.iter().enumerate() {
        largest = largest.max((p_values.len() - rank) as f64 * p_values[index]).min(1.0);
        adjusted[index] = largest;
    }
    adjusted
}

/// Slope of the straight line of least squares through points (x, y) and its standard error `√(s² / Σ(x − x̄)²)`, `s²` with
/// n − 2 degrees of freedom. `None` below two points of different x; the error is `None` below three.
pub(crate) fn fitted_slope(points: &[(f64, f64)]) -> Option<(f64, Option<f64>)> {
    let mut normal = Matrix2::zeros();
    let mut right = Vector2::zeros();
    // Centred, so that the matrix is well conditioned however far the points are from the origin.
    let centre = points.iter().map(|&(x, _)| x).sum::<f64>() / points.len() as f64;
    for &(x, y) in points {
        let row = Vector2::new(1.0, x - centre);
        normal += row * row.transpose();
        right += row * y;
    }
    let spread: f64 = normal.m22;
    if points.len() < 2 || spread <= 1e-12 {
        return None;
    }
    let line = normal.cholesky()?.solve(&right);
    let residual = |&(x, y): &(f64, f64)| y - line.x - line.y * (x - centre);
    let squares: f64 = points.iter().map(|point| residual(point) * residual(point)).sum();
    let error = (points.len() > 2).then(|| (squares / (points.len() - 2) as f64 / spread).sqrt());
    Some((line.y, error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_invert_tails_from_few_to_many_degrees_of_freedom() {
        for freedom in [3.0, 15.0, 200.0, 1e4, 5e5, 1e9, f64::INFINITY] {
            for p in [0.1, 1e-3, 1e-6, 1e-8] {
                let back = upper_tail(upper_quantile(p, freedom), freedom);
                assert!((back / p - 1.0).abs() < 1e-4, "freedom {freedom}, p {p}: {back}");
            }
        }
        // Tables of Student's distribution: 3.055 at 12 degrees of freedom and one-sided 0.005.
        assert!((upper_quantile(0.005, 12.0) - 3.0545).abs() < 1e-4);
    }

    #[test]
    fn holm_orders_multiplies_and_never_falls() {
        assert_eq!(holm(&[0.04, 0.01, 0.03]), [0.06, 0.03, 0.06]);
        assert_eq!(holm(&[0.5, 0.9]), [1.0, 1.0]);
    }

    #[test]
    fn outliers_that_make_up_the_variance_show_as_their_inverse_root() {
        let moments = |spikes: u32| {
            let mut moments = Moments::default();
            (0..10_000).for_each(|i| moments.push(if i < spikes { 1000.0 } else { 0.0 }));
            moments
        };
        for spikes in [1, 4, 25] {
            let tail = Welch::new(&moments(spikes), &moments(0)).tail;
            assert!((tail * f64::from(spikes).sqrt() - 1.0).abs() < 0.01, "{tail}");
        }
    }

    #[test]
    fn a_line_is_fitted_with_its_standard_error() {
        let (slope, error) = fitted_slope(&[(0.0, 1.0), (1.0, 0.0), (2.0, 2.0)]).unwrap();
        // By hand: Σ(x−1)(y−1) / 2 = 1/2; residuals ½, −1, ½; s² = 1.5, error √(1.5/2).
        assert!((slope - 0.5).abs() < 1e-14);
        assert!((error.unwrap() - 0.75_f64.sqrt()).abs() < 1e-14);
        let far: Vec<_> = (0..5).map(|i| (1e6 + f64::from(i), -0.5 * f64::from(i))).collect();
        assert!((fitted_slope(&far).unwrap().0 + 0.5).abs() < 1e-9);
        assert_eq!(fitted_slope(&[(1.0, 2.0)]), None);
        assert_eq!(fitted_slope(&[(1.0, 2.0), (1.0, 3.0)]), None);
        assert_eq!(fitted_slope(&[(1.0, 2.0), (2.0, 3.0)]).unwrap().1, None);
    }
}
