//! Mean, variance and skewness of a stream of numbers.

use serde::{Deserialize, Serialize};

/// Central moments of the numbers seen so far, updated one number or one group at a time.
///
/// `mean = 1/n Σ x_i`, `second = Σ (x_i − mean)²`, `third = Σ (x_i − mean)³`. Unlike sums of powers, these keep their
/// precision where the spread is small beside the mean (Pébay 2008, *Formulas for robust, one-pass parallel
/// computation of covariances and arbitrary-order statistical moments*).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Moments {
    /// How many numbers, n.
    pub count: u64,
    /// Their mean, in their unit; zero without numbers.
    pub mean: f64,
    /// The sum of squared deviations from the mean, in their unit squared.
    pub second: f64,
    /// The sum of cubed deviations from the mean, in their unit cubed.
    pub third: f64,
    /// The largest magnitude `max |x_i|`.
    pub largest: f64,
}

impl Moments {
    /// Adds one number. NaN stays NaN: nothing is dropped.
    #[inline]
    pub fn push(&mut self, x: f64) {
        let before = self.count as f64;
        self.count += 1;
        let n = self.count as f64;
        let delta = x - self.mean;
        let step = delta / n;
        let growth = delta * step * before;
        self.third += growth * step * (n - 2.0) - 3.0 * step * self.second;
        self.second += growth;
        self.mean += step;
        self.largest = self.largest.max(x.abs());
    }

    /// Adds the numbers that `other` has seen.
    pub fn merge(&mut self, other: &Self) {
        if other.count == 0 {
            return;
        }
        if self.count == 0 {
            *self = *other;
            return;
        }
        let (a, b) = (self.count as f64, other.count as f64);
        let n = a + b;
        let delta = other.mean - self.mean;
        self.third += other.third
            + delta * delta * delta * a * b * (a - b) / (n * n)
            + 3.0 * delta * (a * other.second - b * self.second) / n;
        self.second += other.second + delta * delta * a * b / n;
        self.mean += delta * b / n;
        self.count += other.count;
        self.largest = self.largest.max(other.largest);
    }

    /// The unbiased sample variance `Σ (x_i − mean)² / (n − 1)`; NaN below two numbers.
    #[must_use]
    pub fn variance(&self) -> f64 {
        if self.count < 2 { f64::NAN } else { self.second / (self.count - 1) as f64 }
    }

    /// The estimated variance of the mean, `variance / n`; NaN below two numbers.
    #[must_use]
    pub fn variance_of_mean(&self) -> f64 {
        self.variance() / self.count as f64
    }

    /// The estimated third central moment of the mean, `Σ (x_i − mean)³ / n³`; NaN without numbers.
    #[must_use]
    pub fn third_of_mean(&self) -> f64 {
        let n = self.count as f64;
        self.third / (n * n * n)
    }

    /// All moments are finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.mean.is_finite() && self.second.is_finite() && self.third.is_finite()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn of(values: &[f64]) -> Moments {
        let mut moments = Moments::default();
        for &value in values {
            moments.push(value);
        }
        moments
    }

    fn close(a: f64, b: f64, scale: f64) -> bool {
        (a - b).abs() <= 1e-10 * scale
    }

    proptest! {
        #[test]
        fn moments_equal_their_definitions_in_any_grouping(
            values in prop::collection::vec(-10.0..10.0_f64, 1..40),
            split in 0_usize..40,
        ) {
            let n = values.len() as f64;
            let mean = values.iter().sum::<f64>() / n;
            let central = |power: i32| values.iter().map(|x| (x - mean).powi(power)).sum::<f64>();
            let (head, tail) = values.split_at(split.min(values.len()));
            let mut grouped = of(head);
            grouped.merge(&of(tail));
            for moments in [of(&values), grouped] {
                prop_assert_eq!(moments.count, values.len() as u64);
                prop_assert!(close(moments.mean, mean, 10.0));
                prop_assert!(close(moments.second, central(2), 100.0 * n));
                prop_assert!(close(moments.third, central(3), 1000.0 * n));
                prop_assert_eq!(moments.largest, values.iter().fold(0.0, |a: f64, x| a.max(x.abs())));
            }
        }
    }

    #[test]
    fn a_spread_of_a_billionth_of_the_mean_is_kept() {
        let moments = of(&[1.0 - 1e-9, 1.0, 1.0 + 1e-9, 1.0]);
        assert!((moments.variance() / (2e-18 / 3.0) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_nan_is_not_forgotten() {
        assert!(!of(&[1.0, f64::NAN, 2.0]).is_finite());
    }
}
