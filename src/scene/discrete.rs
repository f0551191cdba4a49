//! Choosing one of several things with given probabilities.

use crate::measure::Probability;

/// A discrete distribution over `0 … len`, sampled by inversion so that neighbouring numbers give neighbouring choices.
#[derive(Clone, Debug)]
pub struct Discrete {
    /// `cumulative[i]` is the probability of a choice up to and including `i`; the last is exactly one.
    cumulative: Vec<f64>,
}

impl Discrete {
    /// In proportion to the weights; uniform where all are zero. `None` where one is negative, NaN or infinite.
    #[must_use]
    pub fn new(weights: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut weights: Vec<f64> = weights.into_iter().collect();
        if weights.iter().any(|w| !(0.0..f64::INFINITY).contains(w)) {
            return None;
        }
        let largest = weights.iter().copied().fold(0.0, f64::max);
        // Scaled first: the sum of huge weights must not overflow.
        let scaled = |w: f64| if largest > 0.0 { w / largest } else { 1.0 };
        let total: f64 = weights.iter().copied().map(scaled).sum();
        let has_weight: Vec<bool> = weights.iter().map(|&w| w > 0.0 || largest == 0.0).collect();
        let (mut sum, mut before) = (0.0, 0.0_f64);
        for (w, &has_weight) in weights.iter_mut().zip(&has_weight) {
            sum += scaled(*w) / total;
            // What has weight can be chosen, however little it is beside the sum.
            before = if has_weight { f64::max(sum, before.next_up()) } else { before };
            *w = before;
        }
        // Rounding must leave no room after the last choice that has weight.
        let last = has_weight.iter().rposition(|&has| has).unwrap_or(0);
        weights.iter_mut().skip(last).for_each(|w| *w = 1.0);
        for i in (0..last).rev() {
            let after = weights[i + 1];
            weights[i] = weights[i].min(if has_weight[i + 1] { after.next_down() } else { after });
        }
        Some(Self { cumulative: weights })
    }

    /// The choice for `u` uniform in `[0, 1)`.
    #[must_use]
    #[inline]
    pub fn sample(&self, u: f64) -> usize {
        if self.cumulative.len() == 1 {
            return 0;
        }
        self.cumulative.partition_point(|&c| c <= u)
    }

    /// The choice for `u`, and where within its share `u` lies: a number that is again uniform in `[0, 1)`, with fewer digits.
    #[must_use]
    pub fn split(&self, u: f64) -> (usize, f64) {
        let index = self.sample(u);
        let within = (u - self.below(index)) / self.probability(index).value();
        (index, within.clamp(0.0, 1.0 - f64::EPSILON / 2.0))
    }

    /// The probability of a choice.
    #[must_use]
    #[inline]
    pub fn probability(&self, index: usize) -> Probability {
        Probability::new(self.cumulative[index] - self.below(index))
    }

    /// The probability of all choices before one.
    #[must_use]
    #[inline]
    pub fn below(&self, index: usize) -> f64 {
        if index == 0 { 0.0 } else { self.cumulative[index - 1] }
    }

    /// Number of choices.
    #[must_use]
    pub fn len(&self) -> usize {
        self.cumulative.len()
    }

    /// There is nothing to choose.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.cumulative.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn follows_its_weights() {
        let d = Discrete::new([1.0, 0.0, 3.0]).expect("valid");
        assert_eq!([0.0, 0.2499, 0.25, 0.999].map(|u| d.sample(u)), [0, 0, 2, 2]);
        assert_eq!([0, 1, 2].map(|i| d.probability(i).value()), [0.25, 0.0, 0.75]);
    }

    #[test]
    fn splitting_a_number_leaves_a_uniform_one() {
        let d = Discrete::new([1.0, 0.0, 3.0]).expect("valid");
        assert_eq!([0.0, 0.125, 0.25, 0.625].map(|u| d.split(u)), [(0, 0.0), (0, 0.5), (2, 0.0), (2, 0.5)]);
        assert!(d.split(1.0 - f64::EPSILON / 2.0).1 < 1.0);
    }

    #[test]
    fn is_uniform_without_weights_and_refuses_impossible_ones() {
        assert_eq!(Discrete::new([0.0, 0.0]).expect("valid").probability(1).value(), 0.5);
        assert!(Discrete::new([1.0, f64::NAN]).is_none());
        assert!(Discrete::new([1.0, -1.0]).is_none());
        let huge = Discrete::new([1e300, 1e300, 1e300]).expect("valid");
        assert!((huge.probability(2).value() - 1.0 / 3.0).abs() < 1e-15);
    }

    #[test]
    fn the_least_weight_can_be_chosen_wherever_it_stands() {
        for weights in [[1e-30, 1.0, 1e-300], [1.0, 1e-30, 1e-30], [1e-25, 1e-30, 1.0], [0.0, 1.0, 1e-17]] {
            let d = Discrete::new(weights).expect("valid");
            for (i, &weight) in weights.iter().enumerate() {
                let probability = d.probability(i).value();
                assert_eq!(probability > 0.0, weight > 0.0, "{weights:?}: {i} has {probability}");
                assert!(probability <= weight + 2.0 * f64::EPSILON, "{weights:?}: {i} has {probability}");
            }
            assert_eq!(d.below(2) + d.probability(2).value(), 1.0);
        }
    }

    #[test]
    fn never_chooses_what_has_no_weight() {
        let d = Discrete::new([0.1, 0.2, 0.3, 0.0]).expect("valid");
        assert_eq!(d.sample(1.0 - f64::EPSILON / 2.0), 2);
    }
}
