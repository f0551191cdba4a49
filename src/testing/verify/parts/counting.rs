//! Does a sampler draw as its density claims? A test by counting, in any measure, without integrals.

use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};

use crate::sampler::Random;

use super::super::report::{Check, POWER, SIGNIFICANCE};

/// A sampler of X, its claim q, and another sampler of known density u that covers it.
pub(super) struct Claim<'a, X> {
    /// Draws, or ends without.
    pub draw: &'a dyn Fn(&mut Random) -> Option<X>,
    /// q(x).
    pub density: &'a dyn Fn(&X) -> f64,
    /// Draws with the density u.
    pub reference: &'a dyn Fn(&mut Random) -> X,
    /// u(x).
    pub reference_density: &'a dyn Fn(&X) -> f64,
    /// Where x is counted. How cells are cut does not matter for the test, only for what it sees.
    pub cell: &'a dyn Fn(&X) -> usize,
}

/// Fewer than this variance in a cell, and it is counted with others.
const FEWEST: f64 = 25.0;

#[derive(Clone, Copy, Default)]
struct Cell {
    /// Draws less claimed draws.
    difference: f64,
    /// Its variance if the claim is true.
    variance: f64,
}

impl Cell {
    fn add(&mut self, other: Self) {
        self.difference += other.difference;
        self.variance += other.variance;
    }
}

impl<X> Claim<'_, X> {
    /// Draws n of each. In a cell C the sampler draws `n ∫_C p`, and all draws of both, counted as `r = q / (q + u)`, add up to
    /// `n ∫_C (p + u) r`: the same if p = q. The difference has the variance `V = Σ r (1 − r)`, and if p = (1 ± δ) q the mean
    /// `± δ V`, so χ² = Σ D²/V gains `δ² Σ V`.
    pub fn check(&self, name: &'static str, place: &str, what: &str, n: u32, random: &mut Random) -> Check {
        let mut cells: Vec<Cell> = Vec::new();
        let (mut drawn, mut impossible) = (0_u32, 0_u32);
        let mut add = |x: &X, own: bool| {
            let (q, u) = ((self.density)(x), (self.reference_density)(x));
            let r = q / (q + u);
            // Drawn where the claim is zero, or a density that is none.
            impossible += u32::from((own && q <= 0.0) || !(0.0..=1.0).contains(&r));
            let place = (self.cell)(x);
            if cells.len() <= place {
                cells.resize(place + 1, Cell::default());
            }
            cells[place].add(Cell { difference: f64::from(u8::from(own)) - r, variance: r * (1.0 - r) });
        };
        for _ in 0..n {
            if let Some(x) = (self.draw)(random) {
                drawn += 1;
                add(&x, true);
            }
            add(&(self.reference)(random), false);
        }
        if impossible > 0 {
            let found = format!("{what}: {impossible} draws of {n} that its density denies");
            return Check::exact(name, place, true, found, "one".into());
        }
        let (kept, few): (Vec<Cell>, Vec<Cell>) = cells.into_iter().partition(|cell| cell.variance >= FEWEST);
        let mut rest = Cell::default();
        few.into_iter().for_each(|cell| rest.add(cell));
        let kept: Vec<Cell> = kept.into_iter().chain((rest.variance >= FEWEST).then_some(rest)).collect();
        let statistic: f64 = kept.iter().map(|cell| cell.difference * cell.difference / cell.variance).sum();
        let degrees = kept.len() as f64;
        let Ok(distribution) = ChiSquared::new(degrees) else {
            return Check::open(name, place, format!("{what}: too few draws"));
        };
        let variance: f64 = kept.iter().map(|cell| cell.variance).sum();
        let found = format!("{what}: χ² {statistic:.0} in {degrees} cells, {drawn} draws");
        let power = format!("a density off by {:.1} %", 100.0 * (gain(degrees) / variance).sqrt());
        Check { p_value: Some(distribution.sf(statistic)), ..Check::exact(name, place, false, found, power) }
    }
}

/// The gain λ of χ² that is found with probability [`POWER`], in the normal approximation
/// `λ − z_α √(2k) = z_power √(2k + 4λ)`.
fn gain(degrees: f64) -> f64 {
    let quantile = |p: f64| Normal::standard().inverse_cdf(p);
    let start = quantile(1.0 - SIGNIFICANCE) * (2.0 * degrees).sqrt();
    let step = |gain: f64| start + quantile(POWER) * (2.0 * degrees + 4.0 * gain).sqrt();
    (0..30).fold(start, |gain, _| step(gain))
}

/// Counts of outcomes against their probabilities; what they leave of one is the probability that nothing happens.
pub(super) fn discrete(name: &'static str, place: &str, what: &str, outcomes: &[(u32, f64)], n: u32) -> Check {
    let n = f64::from(n);
    let total: f64 = outcomes.iter().map(|(_, p)| p).sum();
    let counted: f64 = outcomes.iter().map(|&(count, _)| f64::from(count)).sum();
    let nothing = (n - counted, (1.0 - total).max(0.0));
    let cells = outcomes.iter().map(|&(count, p)| (f64::from(count), p)).chain([nothing]);
    let (mut statistic, mut degrees, mut impossible) = (0.0, -1.0, total > 1.0 + 1e-9);
    let mut rest = (0.0, 0.0);
    for (count, p) in cells {
        impossible |= count > 0.0 && p <= 1e-12;
        if n * p >= FEWEST {
            statistic += (count - n * p) * (count - n * p) / (n * p);
            degrees += 1.0;
        } else {
            rest = (rest.0 + count, rest.1 + n * p);
        }
    }
    if rest.1 >= 1.0 {
        statistic += (rest.0 - rest.1) * (rest.0 - rest.1) / rest.1;
        degrees += 1.0;
    }
    let found = format!("{what}: χ² {statistic:.0} for {} outcomes, {n} draws", degrees + 1.0);
    if impossible {
        return Check::exact(name, place, true, format!("{what}: {counted} of {n} against {total}"), "one".into());
    }
    match ChiSquared::new(degrees) {
        Ok(distribution) => {
            let power = format!("probabilities off by {:.1} %", 100.0 * (gain(degrees) / n).sqrt());
            Check { p_value: Some(distribution.sf(statistic)), ..Check::exact(name, place, false, found, power) }
        }
        // One outcome, and it is certain.
        Err(_) => Check::exact(name, place, (counted - n * total).abs() > 0.5, found, "one draw".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Draws x² of a uniform x with density `1 / (2 √y)`, or claims another exponent.
    fn claimed(exponent: f64, n: u32) -> f64 {
        let claim = Claim {
            draw: &|random| Some(random.uniform()).map(|x| x * x),
            density: &|&y: &f64| (1.0 - exponent) * libm::pow(y, -exponent),
            reference: &Random::uniform,
            reference_density: &|_| 1.0,
            cell: &|&y| (y * 16.0) as usize,
        };
        let check = claim.check("toy", "nowhere", "", n, &mut Random::new(3, 0, 0));
        check.p_value.unwrap()
    }

    /// The density with exponent 0.48 is off by up to 7 %, by 3 % on average.
    #[test]
    fn a_true_claim_holds_and_one_that_is_off_by_three_percent_does_not() {
        assert!(claimed(0.5, 300_000) > 1e-3);
        assert!(claimed(0.48, 300_000) < 1e-6);
    }

    #[test]
    fn impossible_draws_and_wrong_probabilities_are_told() {
        let holds = |outcomes: &[(u32, f64)]| {
            let check = discrete("toy", "nowhere", "", outcomes, 10_000);
            check.verdict == super::super::super::report::Verdict::Holds && check.p_value.is_none_or(|p| p > 1e-3)
        };
        assert!(holds(&[(3030, 0.3), (6970, 0.7)]) && holds(&[(10_000, 1.0)]) && holds(&[(3030, 0.3)]));
        assert!(!holds(&[(3300, 0.3), (6700, 0.7)]) && !holds(&[(9_999, 1.0)]) && !holds(&[(3030, 0.3), (1, 0.0)]));
    }
}
