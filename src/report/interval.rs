//! Estimates over replicas, with intervals.

use super::statistics::upper_quantile;

/// Two-sided probability that an interval misses.
pub const MISSES: f64 = 0.05;

/// A value with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Ends of the interval; `None` for a single replica.
    pub interval: Option<(f64, f64)>,
}

/// A quantity of any sign with a standard error over replicas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Jackknifed {
    pub value: f64,
    /// `√((n − 1)/n Σ (θ_(i) − θ_(·))²)` of the values θ_(i) without replica i; 0 for a single one.
    pub error: f64,
    /// n − 1.
    pub freedom: f64,
}

impl Jackknifed {
    /// Of a statistic of all replicas, and of all but one, for each. Where it has no value without one of them, it has none.
    pub fn new(value: Option<f64>, without: &[Option<f64>]) -> Option<Self> {
        let finite = |value: &f64| value.is_finite();
        let value = value.filter(finite)?;
        if without.len() < 2 {
            return Some(Self { value, error: 0.0, freedom: 0.0 });
        }
        let values = without.iter().map(|value| value.filter(finite)).collect::<Option<Vec<f64>>>()?;
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
        Some(Self { value, error: ((n - 1.0) / n * squares).sqrt(), freedom: n - 1.0 })
    }

    /// The difference of two that are independent; degrees of freedom after Welch and Satterthwaite.
    pub fn minus(self, other: Self) -> Self {
        let (a, b) = (self.error * self.error, other.error * other.error);
        let below = a * a / self.freedom + b * b / other.freedom;
        let freedom = if self.freedom.min(other.freedom) < 1.0 {
            0.0
        } else if below > 0.0 {
            (a + b) * (a + b) / below
        } else {
            f64::INFINITY
        };
        Self { value: self.value - other.value, error: (a + b).sqrt(), freedom }
    }

    /// Student's interval.
    pub fn estimate(self) -> Estimate {
        let reach = (self.freedom >= 1.0).then(|| upper_quantile(0.5 * MISSES, self.freedom) * self.error);
        let interval = reach.map(|reach| (self.value - reach, self.value + reach));
        Estimate { value: self.value, interval }
    }

    /// The same of the exponential.
    pub fn exponential(self) -> Estimate {
        let Estimate { value, interval } = self.estimate();
        let interval = interval.map(|(low, high)| (libm::exp(low), libm::exp(high)));
        Estimate { value: libm::exp(value), interval }
    }
}

/// The mean of replicas of a positive quantity, with Student's interval of its logarithm: as good as the mean's own where
/// replicas are normal, and better where they are skewed, as squared errors are (`tests/properties/coverage.rs` measures it).
#[must_use]
pub fn mean(replicas: &[f64]) -> Option<Estimate> {
    let (n, sum) = (replicas.len() as f64, replicas.iter().sum::<f64>());
    let log = |mean: f64| (mean > 0.0).then(|| libm::log(mean));
    let without: Vec<_> = replicas.iter().map(|replica| log((sum - replica) / (n - 1.0))).collect();
    if let Some(jackknifed) = Jackknifed::new(log(sum / n), &without) {
        return Some(jackknifed.exponential());
    }
    (sum / n).is_finite().then_some(Estimate { value: sum / n, interval: None })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_jackknife_of_a_mean_is_its_standard_error() {
        let replicas = [1.0, 4.0, 2.0, 5.0];
        let without: Vec<_> = replicas.iter().map(|replica| Some((12.0 - replica) / 3.0)).collect();
        let found = Jackknifed::new(Some(3.0), &without).unwrap();
        // Deviations −2, 1, −1, 2: s² = 10/3.
        assert!((found.value - 3.0).abs() < 1e-15 && (found.error - (10.0_f64 / 12.0).sqrt()).abs() < 1e-15);
        let (low, high) = found.estimate().interval.unwrap();
        // Student's quantile at 3 degrees of freedom: 3.1824.
        assert!((high - low - 2.0 * 3.1824 * found.error).abs() < 1e-3);
    }

    #[test]
    fn one_replica_has_no_interval_and_what_is_negative_none_in_logarithms() {
        assert_eq!(mean(&[2.0]), Some(Estimate { value: 2.0, interval: None }));
        assert_eq!(mean(&[2.0, -4.0]), Some(Estimate { value: -1.0, interval: None }));
        assert_eq!(mean(&[]), None);
        let exact = mean(&[3.0, 3.0, 3.0]).unwrap();
        let (low, high) = exact.interval.unwrap();
        assert!((low - 3.0).abs() < 1e-12 && (high - 3.0).abs() < 1e-12);
    }
}
