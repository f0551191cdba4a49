//! How often 95 % intervals hold the truth, on toy problems whose truth is known.
//!
//! 2000 repetitions each, fixed seed: the standard error of a coverage of 95 % is 0.5 %, so a true coverage below 92.2 % or above
//! 97 % leaves the allowed 93 to 97 % more often than not. `-- --nocapture coverage` prints the table of `src/docs/tables.md`.

use pathspace::report::interval::mean;
use pathspace::report::{Metric, Row, summarise, verdicts};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

const REPETITIONS: usize = 2000;

type Random = Xoshiro256PlusPlus;

fn normal(random: &mut Random) -> f64 {
    let [u, v] = [1.0 - random.random::<f64>(), random.random()];
    (-2.0 * libm::log(u)).sqrt() * libm::cos(std::f64::consts::TAU * v)
}

/// Errors of replicas around a mean of 1.
#[derive(Clone, Copy, Debug)]
enum Toy {
    /// Normal, of this standard deviation.
    Gaussian(f64),
    /// `exp(σ z − σ²/2)`.
    Lognormal(f64),
}

impl Toy {
    fn draw(self, random: &mut Random) -> f64 {
        match self {
            Self::Gaussian(sigma) => 1.0 + sigma * normal(random),
            Self::Lognormal(sigma) => libm::exp(sigma * normal(random) - 0.5 * sigma * sigma),
        }
    }
}

/// Means of resampled replicas, between their 2.5 % and 97.5 % quantiles.
fn percentile_bootstrap(replicas: &[f64], random: &mut Random) -> (f64, f64) {
    const RESAMPLES: usize = 400;
    let n = replicas.len();
    let mut means: Vec<f64> =
        (0..RESAMPLES).map(|_| (0..n).map(|_| replicas[random.random_range(0..n)]).sum::<f64>() / n as f64).collect();
    means.sort_by(f64::total_cmp);
    (means[RESAMPLES / 40], means[RESAMPLES - 1 - RESAMPLES / 40])
}

/// Shares of repetitions in which the band of a curve and the percentile bootstrap hold the mean.
fn of_bands(toy: Toy, seeds: usize) -> (f64, f64) {
    let mut random = Random::seed_from_u64(17);
    let (mut ours, mut bootstrap) = (0, 0);
    for _ in 0..REPETITIONS {
        let replicas: Vec<f64> = (0..seeds).map(|_| toy.draw(&mut random)).collect();
        let holds = |(low, high): (f64, f64)| usize::from(low <= 1.0 && 1.0 <= high);
        ours += mean(&replicas).and_then(|estimate| estimate.interval).map_or(0, holds);
        bootstrap += holds(percentile_bootstrap(&replicas, &mut random));
    }
    (ours as f64 / REPETITIONS as f64, bootstrap as f64 / REPETITIONS as f64)
}

/// Errors `constant / t`; those of a seed's checkpoints share half of their noise, as checkpoints of one render do.
fn render(method: &str, constant: f64, toy: Toy, seeds: usize, random: &mut Random) -> Vec<Row> {
    let mut rows = Vec::new();
    for seed in 0..seeds {
        let shared = toy.draw(random);
        rows.extend((0..8).map(|checkpoint| {
            let seconds = libm::exp2(0.5 * f64::from(checkpoint));
            Row {
                scene: "toy".into(),
                method: method.into(),
                seed: seed as u64,
                checkpoint,
                render_seconds: seconds,
                mse: Some(0.5 * (shared + toy.draw(random)) * constant / seconds),
                ..Row::default()
            }
        }));
    }
    rows
}

/// Shares of repetitions in which the verdict holds the ratio of times, which is 2; the summary the gain, and the slope, −1/2.
fn of_verdicts(toy: Toy, seeds: usize) -> [f64; 3] {
    let mut random = Random::seed_from_u64(23);
    let mut held = [0; 3];
    for _ in 0..REPETITIONS {
        let mut rows = render("slow", 2.0, toy, seeds, &mut random);
        rows.extend(render("fast", 1.0, toy, seeds, &mut random));
        let verdict = &verdicts(&rows, &[Metric::Mse])[0];
        let truth = if verdict.method == "fast" { 2.0 } else { 0.5 };
        let fast = &summarise(&rows)[1];
        let holds = |low: Option<f64>, high: Option<f64>, truth: f64| {
            usize::from(low.zip(high).is_some_and(|(low, high)| low <= truth && truth <= high))
        };
        held[0] += holds(verdict.low, verdict.high, truth);
        held[1] += holds(fast.relative_low, fast.relative_high, 2.0);
        held[2] += holds(fast.slope_low, fast.slope_high, -0.5);
    }
    held.map(|held| held as f64 / REPETITIONS as f64)
}

#[test]
fn coverage_of_bands_verdicts_gains_and_slopes() {
    println!("toy, seeds: band, (percentile bootstrap), verdict, gain, slope");
    for toy in [Toy::Gaussian(0.05), Toy::Gaussian(0.25), Toy::Lognormal(0.5), Toy::Lognormal(1.0)] {
        for seeds in [4, 8, 16] {
            let (band, bootstrap) = of_bands(toy, seeds);
            let others = of_verdicts(toy, seeds);
            let percent = |share: f64| format!("{:.1}", 100.0 * share);
            println!(
                "{toy:?}, {seeds}: {}, ({}), {}",
                percent(band),
                percent(bootstrap),
                others.map(percent).join(", ")
            );
            let all = [band].into_iter().chain(others);
            match toy {
                Toy::Gaussian(_) => {
                    let allowed = 0.93..=0.97;
                    assert!(all.clone().all(|share| allowed.contains(&share)), "{toy:?} {seeds}: {band} {others:?}");
                }
                Toy::Lognormal(sigma) => {
                    let least = if sigma > 0.5 { 0.86 } else { 0.91 };
                    assert!(all.clone().all(|share| share > least), "{toy:?} {seeds}: {band} {others:?}");
                }
            }
            assert!(seeds > 8 || bootstrap < 0.91, "{toy:?} {seeds}: the plain bootstrap is too narrow: {bootstrap}");
        }
    }
}
