//! Weights of densities that differ beyond all measure.

use super::super::case::{Case, Exact, Subject};
use super::case;
use crate::estimator::Heuristic;
use crate::wide::Wide;

pub(super) fn cases() -> Vec<Case> {
    let new = |name, sweep: (&'static str, &[f64]), compute| case("algebra", name, sweep, Subject::Number(compute));
    vec![
        new("ratios", ("decades", &[1.0, 10.0, 100.0, 300.0, 3000.0]), |decades| partition(decades, 2.0))
            .about("densities spread over so many decades either way: the weights of all techniques add up to one"),
        new("exponents", ("exponent", &[1.0, 2.0, 10.0, 100.0]), |exponent| partition(300.0, exponent))
            .about("the power heuristic of 300 decades either way: the same"),
    ]
}

/// The sum of the weights of ten techniques under the heuristic that deviates most.
fn partition(decades: f64, exponent: f64) -> Exact {
    let power = |i: i32| {
        let ten = Wide::new(10.0);
        let times = (decades * f64::from(i) / 4.5 - decades).abs().round() as u32;
        let size = (0..times).fold(Wide::ONE, |product, _| product * ten);
        if 2 * i < 9 { Wide::ONE / size } else { size }
    };
    let densities: Vec<Wide> = (0..10).map(power).collect();
    let heuristics =
        [Heuristic::Balance, Heuristic::Power { exponent }, Heuristic::Maximum, Heuristic::Cutoff { threshold: 0.1 }];
    let sum = |heuristic: &Heuristic| -> f64 {
        let weight = |i: usize| {
            let ratio = |j: usize| (densities[j] / densities[i]).to_f64();
            heuristic.weight((0..i).map(ratio), (i + 1..densities.len()).map(ratio))
        };
        (0..densities.len()).map(weight).sum()
    };
    let sums = heuristics.iter().map(sum);
    let estimate =
        sums.fold(
            1.0,
            |worst: f64, sum| if (sum - 1.0).abs() > (worst - 1.0_f64).abs() || sum.is_nan() { sum } else { worst },
        );
    Exact { estimate, truth: 1.0, tolerance: 1e-14 }
}
