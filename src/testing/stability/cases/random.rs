//! Random numbers of many seeds, streams and samples.

use super::super::case::{Case, Exact, Subject};
use super::case;
use crate::sampler::Random;

pub(super) fn cases() -> Vec<Case> {
    let new = |name, sweep: (&'static str, &[f64]), compute| case("random", name, sweep, Subject::Number(compute));
    const COUNTS: &[f64] = &[1e2, 1e3, 1e4, 1e5, 1e6];
    vec![
        new("seeds", ("seeds", COUNTS), |n| correlation(n, |i| Random::new(i, 3, 5)))
            .about("numbers of neighbouring seeds: none of sixteen correlations is beyond 5.4 standard errors (one in a million)"),
        new("streams", ("streams", COUNTS), |n| correlation(n, |i| Random::new(5, i, 3)))
            .about("the same for neighbouring pixels"),
        new("samples", ("samples", COUNTS), |n| correlation(n, |i| Random::new(3, 5, i)))
            .about("the same for neighbouring samples of a pixel"),
        new("far seeds", ("log2 of the seed", &[0.0, 8.0, 16.0, 32.0, 48.0, 63.0]), |bits| {
            let far = 1_u64 << bits as u32;
            correlation(1e5, |i| Random::new(i / 2 + (i % 2) * far, i / 2, 0))
        })
        .about("the same for seeds that differ in one bit"),
    ]
}

/// Of the first four numbers of a key with the first four of the next: the correlation of all sixteen pairs that deviates most.
fn correlation(count: f64, key: impl Fn(u64) -> Random) -> Exact {
    let n = count as u64;
    let centred = |random: &mut Random| random.uniform4().map(|u| u - 0.5);
    let mut before = centred(&mut key(0));
    let mut sums = [[0.0; 4]; 4];
    for i in 1..=n {
        let now = centred(&mut key(i));
        for (row, a) in sums.iter_mut().zip(before) {
            row.iter_mut().zip(now).for_each(|(sum, b)| *sum += a * b);
        }
        before = now;
    }
    // Each product has the variance 1/144; a correlation is twelve times its mean.
    let correlations = sums.iter().flatten().map(|sum| 12.0 * sum / count);
    let estimate = correlations.fold(0.0, |worst: f64, c| if c.abs() > worst.abs() { c } else { worst });
    // Of sixteen: 5.4 standard errors for one in a million.
    Exact { estimate, truth: 0.0, tolerance: 5.4 / count.sqrt() }
}
