//! Synthetic passes with known means. Seeds are fixed; limits on rates are four standard errors of a binomial count.

use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::*;
use crate::film::BlockGrid;
use crate::spectrum::Rgb;

/// 6 × 4 blocks of equal size.
const BLOCKS: usize = 24;

struct Random(Xoshiro256PlusPlus);

impl Random {
    fn new(seed: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(seed))
    }

    /// Uniform in (0, 1).
    fn uniform(&mut self) -> f64 {
        ((self.0.next_u64() >> 11) as f64 + 0.5) * 0.5_f64.powi(53)
    }

    fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }

    fn exponential(&mut self) -> f64 {
        -self.uniform().ln()
    }
}

fn grid() -> BlockGrid {
    BlockGrid::new(96, 64, None).unwrap()
}

/// Statistics of passes whose block means `value` draws.
fn statistics(passes: usize, mut value: impl FnMut(usize) -> f64) -> BlockStatistics {
    let mut statistics = BlockStatistics::new(grid());
    for _ in 0..passes {
        let means: Vec<Rgb> = (0..BLOCKS).map(|block| Rgb::from([0; 3].map(|_| value(block)))).collect();
        statistics.add_pass(&means).unwrap();
    }
    statistics
}

fn test(a: &BlockStatistics, b: &BlockStatistics, settings: &AgreementSettings) -> Agreement {
    Agreement::test(a, b, settings).unwrap()
}

const LOOSE: AgreementSettings = AgreementSettings {
    significance: 0.05,
    power: 0.9,
    tolerance: 0.0,
    smallest_passes: 2,
    largest_share: 0.2,
    largest_skewness: 0.4,
    largest_left_out: 1.0,
    image_limit: 1.0,
    block_limit: 10.0,
};

fn count_differ(repetitions: usize, mut once: impl FnMut() -> Agreement) -> usize {
    (0..repetitions).filter(|_| once().verdict == Verdict::Differ).count()
}

#[test]
fn equal_means_differ_at_most_at_the_stated_rate_and_not_much_below_it() {
    let mut random = Random::new(1);
    // Unequal variances and numbers of passes. Expected about 0.05 · 1000; four standard errors are 28.
    let differ = count_differ(1000, || {
        let a = statistics(40, |block| 1.0 + 0.2 * block as f64 + 0.1 * random.normal());
        let b = statistics(25, |block| 1.0 + 0.2 * block as f64 + 0.3 * random.normal());
        test(&a, &b, &LOOSE)
    });
    assert!((22..=78).contains(&differ), "{differ} of 1000");
}

#[test]
fn skewed_passes_do_not_raise_the_rate() {
    let mut random = Random::new(2);
    // Without the correction for skewness 114 of 1000.
    let differ = count_differ(1000, || {
        let a = statistics(128, |_| random.exponential());
        let b = statistics(128, |_| 1.0 + 0.2 * random.normal());
        test(&a, &b, &AgreementSettings { largest_skewness: 1.0, ..LOOSE })
    });
    assert!(differ <= 78, "{differ} of 1000");
}

#[test]
fn a_bias_of_the_whole_image_is_found_with_the_stated_power() {
    let mut random = Random::new(3);
    let settings = AgreementSettings::default();
    // Luminance weighs the three independent channels; its relative standard error follows from 24 · 100 values each.
    let weights = (0.2126_f64.powi(2) + 0.7152_f64.powi(2) + 0.0722_f64.powi(2)).sqrt();
    let error = 0.1 * weights * (2.0_f64 / 2400.0).sqrt();
    let bias = (3.48 + 1.28) * error;
    let mut detectable = 0.0;
    let differ = count_differ(400, || {
        let a = statistics(100, |_| 1.0 + bias + 0.1 * random.normal());
        let b = statistics(100, |_| 1.0 + 0.1 * random.normal());
        let agreement = test(&a, &b, &settings);
        detectable += agreement.image.detectable / 400.0;
        agreement
    });
    // Four standard errors of 0.9 · 400 are 24; blocks find a few more.
    assert!((336..=390).contains(&differ), "{differ} of 400");
    assert!((detectable / bias - 1.0).abs() < 0.05, "{detectable} {bias}");
}

#[test]
fn a_bias_of_one_block_is_found_with_the_stated_power() {
    let mut random = Random::new(4);
    let settings = AgreementSettings { image_limit: 1.0, block_limit: 1.0, ..AgreementSettings::default() };
    let mut once = |bias: f64| {
        let a = statistics(100, |block| 1.0 + if block == 8 { bias } else { 0.0 } + 0.1 * random.normal());
        let b = statistics(100, |_| 1.0 + 0.1 * random.normal());
        test(&a, &b, &settings)
    };
    let bias = once(0.0).block_detectable;
    // The bias is in all three channels, each of which finds it with probability 0.9, so nearly always one does.
    let found = (0..100).filter(|_| {
        let agreement = once(bias);
        agreement.verdict == Verdict::Differ && agreement.worst.unwrap().block == (2, 1)
    });
    assert!(found.count() >= 98);
    let half = (0..100).filter(|_| once(0.3 * bias).verdict == Verdict::Differ).count();
    assert!(half <= 20, "{half} of 100");
}

#[test]
fn enough_power_without_difference_is_agreement_and_too_little_is_not() {
    let mut random = Random::new(5);
    let mut once = |noise: f64| {
        let a = statistics(200, |_| 1.0 + noise * random.normal());
        let b = statistics(64, |_| 1.0 + 0.5 * noise * random.normal());
        test(&a, &b, &AgreementSettings::default()).verdict
    };
    let expected = |noise| if noise < 0.5 { Verdict::Agree } else { Verdict::Undecided(Doubt::LowPower) };
    for noise in [0.0, 0.01, 0.1, 1.0] {
        assert_eq!(once(noise), expected(noise), "noise {noise}");
    }
}

#[test]
fn rare_spikes_leave_it_undecided_however_much_blocks_seem_to_differ() {
    let mut random = Random::new(6);
    for expected_spikes in [0.3, 1.0, 3.0, 6.0] {
        let probability = expected_spikes / 1000.0;
        let mut naive = 0;
        for _ in 0..60 {
            let a = statistics(1000, |_| {
                let spike = if random.uniform() < probability { 0.3 / probability } else { 0.0 };
                1.0 + spike + 0.1 * random.normal()
            });
            let b = statistics(100, |_| 1.3 + 0.1 * random.normal());
            assert_eq!(
                test(&a, &b, &AgreementSettings::default()).verdict,
                Verdict::Undecided(Doubt::HeavyTails),
                "{expected_spikes} spikes expected"
            );
            let blind = AgreementSettings { largest_skewness: 2.0, largest_share: 2.0, ..AgreementSettings::default() };
            naive += usize::from(test(&a, &b, &blind).verdict == Verdict::Differ);
        }
        // Without the care for heavy tails, blocks that saw no spike seem to differ.
        assert!(expected_spikes > 3.0 || naive > 30, "{naive}");
    }
}

#[test]
fn heavy_tails_in_a_corner_are_left_out_with_their_neighbours_and_the_rest_is_judged() {
    let mut random = Random::new(7);
    for (bias, verdict) in [(0.0, Verdict::Agree), (0.3, Verdict::Differ)] {
        let mut passes = 0;
        let a = statistics(400, |block| {
            passes += usize::from(block == 0);
            let spike = if block == 0 && passes < 4 { 20.0 } else { 0.0 };
            1.0 + spike + if block == 23 { bias } else { 0.0 } + 0.1 * random.normal()
        });
        let b = statistics(400, |_| 1.0 + 0.1 * random.normal());
        let agreement = test(&a, &b, &AgreementSettings::default());
        assert_eq!((agreement.left_out, agreement.tested), (4, 20));
        // The spike also makes the image's mean heavy-tailed, so blocks alone can tell.
        let expected = if bias > 0.0 { verdict } else { Verdict::Undecided(Doubt::HeavyTails) };
        assert_eq!(agreement.verdict, expected);
    }
}

#[test]
fn exact_methods_agree_up_to_rounding_and_differ_beyond_it() {
    let exact = |value: f64| statistics(20, |_| value);
    let verdict = |a: f64, b: f64| test(&exact(a), &exact(b), &AgreementSettings::default()).verdict;
    assert_eq!(verdict(1.0, 1.0), Verdict::Agree);
    assert_eq!(verdict(1.0, 1.0 + 1e-6), Verdict::Agree);
    assert_eq!(verdict(1.0, 1.0 + 1e-4), Verdict::Differ);
    assert_eq!(verdict(0.0, 0.0), Verdict::Agree);
    assert_eq!(verdict(0.0, 1e-6), Verdict::Differ);
}

#[test]
fn few_passes_and_values_that_are_not_finite_leave_it_undecided() {
    let (few, many) = (statistics(3, |_| 1.0), statistics(100, |_| 1.0));
    let verdict = |a: &BlockStatistics| test(a, &many, &AgreementSettings::default()).verdict;
    assert_eq!(verdict(&few), Verdict::Undecided(Doubt::FewPasses));
    let broken = statistics(100, |block| if block == 3 { f64::NAN } else { 1.0 });
    assert_eq!(verdict(&broken), Verdict::Undecided(Doubt::NotFinite));
}

#[test]
fn masked_blocks_are_neither_tested_nor_left_out_and_masks_must_be_equal() {
    let mask: Vec<bool> = (0..96 * 64).map(|pixel| pixel % 96 < 48).collect();
    let masked = |random: &mut Random| {
        let mut statistics = BlockStatistics::new(BlockGrid::new(96, 64, Some(&mask)).unwrap());
        for _ in 0..50 {
            let means: Vec<Rgb> = (0..BLOCKS).map(|_| Rgb::grey(1.0 + 0.05 * random.normal())).collect();
            statistics.add_pass(&means).unwrap();
        }
        statistics
    };
    let mut random = Random::new(8);
    let (a, b) = (masked(&mut random), masked(&mut random));
    let agreement = test(&a, &b, &AgreementSettings::default());
    assert_eq!((agreement.verdict, agreement.tested, agreement.left_out), (Verdict::Agree, 12, 0));
    let whole = statistics(50, |_| 1.0);
    assert_eq!(Agreement::test(&a, &whole, &AgreementSettings::default()), Err(FilmError::Incompatible));
}

#[test]
fn repeated_seeds_and_dependent_passes_show_in_the_variance_between_seeds() {
    let mut random = Random::new(9);
    let mut render = |shift: f64| statistics(50, |_| 1.0 + shift + 0.1 * random.normal());
    let independent: Vec<_> = (0..6).map(|_| render(0.0)).collect();
    assert!(between_seeds_p_value(&independent).unwrap() > 1e-3);
    let shifted: Vec<_> = (0..6).map(|i| render(0.01 * f64::from(i))).collect();
    assert!(between_seeds_p_value(&shifted).unwrap() < 1e-6);
    let repeated = vec![independent[0].clone(); 6];
    assert!(between_seeds_p_value(&repeated).unwrap() < 1e-6);
    assert_eq!(between_seeds_p_value(&independent[..1]), None);
    assert_eq!(between_seeds_p_value(&[]), None);
}
