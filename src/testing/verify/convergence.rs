//! How the error falls with the number of samples, and whether there is a variance at all.

use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::report::statistics::fitted_slope;

use super::report::{Check, POWER, SIGNIFICANCE};

/// Parts of the passes that the uncertainty of the slope comes from.
const REPLICAS: usize = 8;

/// Fewer passes in a replica, and there is no slope.
const FEWEST: usize = 6;

/// The largest of so many terms are what a tail is told from: one in `TAIL`.
const TAIL: usize = 100;

/// Fewer than this many, and nothing is told.
const SHORTEST_TAIL: usize = 100;

/// The tail of `P(X > x) ~ x^(−α)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TailIndex {
    /// α; infinite for numbers that are bounded by one that many reach.
    pub alpha: f64,
    /// Its standard error.
    pub error: f64,
    /// It is below 2 however far out one looks: what is bounded after all looks steeper further out.
    goes_on: bool,
}

impl TailIndex {
    /// Hill's estimate (1975) `1/α = 1/k Σ ln(x_i / x_{k+1})` from the k largest numbers, of standard error `α/√k`; `None`
    /// where there are too few.
    pub fn of(values: &mut [f64]) -> Option<Self> {
        let k = values.len() / TAIL;
        if k < SHORTEST_TAIL {
            return None;
        }
        values.sort_unstable_by(|a, b| b.total_cmp(a));
        let alpha = |k: usize| {
            let threshold = values[k];
            let logarithms: f64 = values[..k].iter().map(|x| libm::log(x / threshold)).sum();
            k as f64 / logarithms
        };
        let goes_on = [2, 4, 8].into_iter().all(|part| alpha(k / part) < 2.0);
        (values[k] > 0.0).then(|| Self { alpha: alpha(k), error: alpha(k) / (k as f64).sqrt(), goes_on })
    }

    /// There is no finite variance, as far as these numbers show: α is below 2 by two standard errors, and stays below.
    pub fn is_infinite(&self) -> bool {
        self.goes_on && self.alpha + 2.0 * self.error < 2.0
    }

    /// The exponent of the error over the number of samples: a sum of n such numbers is of the size `n^(1/α)`,
    /// and nothing is gained by more of them where α is below 1.
    pub fn exponent(&self) -> f64 {
        (1.0 / self.alpha - 1.0).clamp(-0.5, 0.0)
    }
}

/// The slope of log error over log N, and its standard error by leaving out one replica after the other (Quenouille 1956).
pub(super) fn slope(passes: &[f64]) -> Option<(f64, f64)> {
    let length = passes.len() / REPLICAS;
    if length < FEWEST {
        return None;
    }
    let mean = passes.iter().sum::<f64>() / passes.len() as f64;
    let sizes: Vec<usize> = (0..).map(|j| 1 << j).take_while(|&n| n <= length / 3).collect();
    // Of each replica and group size: the mean squared deviation of a group's mean.
    let squared = |replica: &[f64], n: usize| {
        let groups = replica.chunks_exact(n).map(|group| group.iter().sum::<f64>() / n as f64 - mean);
        let squares: Vec<f64> = groups.map(|deviation| deviation * deviation).collect();
        squares.iter().sum::<f64>() / squares.len() as f64
    };
    let table: Vec<Vec<f64>> =
        passes.chunks_exact(length).map(|replica| sizes.iter().map(|&n| squared(replica, n)).collect()).collect();
    let without = |left_out: Option<usize>| {
        let kept = || table.iter().enumerate().filter(|(i, _)| Some(*i) != left_out).map(|(_, row)| row);
        let point = |(j, &n): (usize, &usize)| {
            (libm::log(n as f64), 0.5 * libm::log(kept().map(|row| row[j]).sum::<f64>() / kept().count() as f64))
        };
        let points: Vec<(f64, f64)> = sizes.iter().enumerate().map(point).collect();
        fitted_slope(&points).map(|(slope, _)| slope).filter(|slope| slope.is_finite())
    };
    let slopes = (0..table.len()).map(|i| without(Some(i))).collect::<Option<Vec<f64>>>()?;
    let count = slopes.len() as f64;
    let centre = slopes.iter().sum::<f64>() / count;
    let spread: f64 = slopes.iter().map(|slope| (slope - centre) * (slope - centre)).sum();
    Some((without(None)?, (spread * (count - 1.0) / count).sqrt()))
}

/// The error falls as N^(−1/2): passes are independent and have a variance.
pub(super) fn check(name: &str, passes: &[f64], tail: Option<TailIndex>) -> Check {
    const WHICH: &str = "error ~ N^(-1/2)";
    let largest = passes.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    if passes.iter().all(|pass| (pass - passes[0]).abs() <= 1e-12 * largest) {
        return Check::exact(WHICH, name, false, "no error at all".into(), "any".into());
    }
    if let Some(tail) = tail.filter(TailIndex::is_infinite) {
        return Check::open(WHICH, name, no_variance(tail));
    }
    let Some((slope, error)) = slope(passes) else {
        return Check::open(WHICH, name, format!("{} passes are too few", passes.len()));
    };
    let Ok(student) = StudentsT::new(0.0, 1.0, REPLICAS as f64 - 1.0) else {
        return Check::open(WHICH, name, "no distribution");
    };
    let p_value = 2.0 * student.sf(((slope + 0.5) / error).abs());
    let quantiles = -student.inverse_cdf(0.5 * SIGNIFICANCE) - student.inverse_cdf(1.0 - POWER);
    let found = format!("slope {slope:.3} ± {error:.3}");
    let power = format!("a slope off by {:.2}", quantiles * error);
    Check { p_value: Some(p_value), ..Check::exact(WHICH, name, false, found, power) }
}

/// Why no test of a mean applies.
pub(super) fn no_variance(tail: TailIndex) -> String {
    let TailIndex { alpha, error, .. } = tail;
    let exponent = tail.exponent();
    format!("no variance in sight: tail index {alpha:.2} ± {error:.2}, error ~ N^({exponent:.2}); no test of means")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::Random;

    fn numbers(n: usize, mut draw: impl FnMut(&mut Random) -> f64) -> Vec<f64> {
        let mut random = Random::new(9, 0, 0);
        (0..n).map(|_| draw(&mut random)).collect()
    }

    #[test]
    fn tails_are_told_by_their_index() {
        for alpha in [1.2, 1.5, 3.0] {
            let mut values = numbers(200_000, |random| libm::pow(1.0 - random.uniform(), -1.0 / alpha));
            let tail = TailIndex::of(&mut values).unwrap();
            assert!((tail.alpha - alpha).abs() < 4.0 * tail.error, "{alpha}: {tail:?}");
            assert_eq!(tail.is_infinite(), alpha < 2.0);
        }
        assert!((TailIndex { alpha: 1.5, error: 0.1, goes_on: true }.exponent() + 1.0 / 3.0).abs() < 1e-12);
        // The same tail up to a bound that one in 500 reaches.
        let mut cut = numbers(200_000, |random| libm::pow(1.0 - random.uniform(), -1.0 / 1.5).min(63.0));
        assert!(!TailIndex::of(&mut cut).unwrap().is_infinite());
        assert!(!TailIndex::of(&mut numbers(200_000, Random::uniform)).unwrap().is_infinite());
    }

    #[test]
    fn independent_numbers_give_one_half_and_repeated_ones_do_not() {
        let check = |passes: &[f64]| check("nowhere", passes, None).p_value.unwrap();
        assert!(check(&numbers(300, Random::uniform)) > 1e-3);
        // Each pass four times over.
        let repeated: Vec<f64> = numbers(75, Random::uniform).into_iter().flat_map(|x| [x; 4]).collect();
        assert!(check(&repeated) < 1e-3);
    }
}
