//! Random numbers keyed by (seed, stream, sample).

use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

mod forced;

/// The random numbers of one sample: a pure function of its key, so any sample can be drawn again on its own.
///
/// The key goes through the counter-based generator Philox4x32-10 (Salmon et al. 2011), whose output seeds a sequential
/// xoshiro256++ (Blackman & Vigna 2021): the counter makes streams independent, the sequence is cheap.
#[derive(Clone, Debug)]
pub struct Random {
    sequence: Xoshiro256PlusPlus,
}

impl Random {
    /// The numbers of sample number `sample` in stream number `stream` (for images: the pixel's index).
    #[must_use]
    #[inline]
    pub fn new(seed: u64, stream: u64, sample: u64) -> Self {
        let key = [low(seed), high(seed)];
        let block = |half: u32| {
            // Streams are below 2³² (pixels); their top bit tells the two halves of the state apart.
            rand_philox::philox4x32_10([low(sample), high(sample), low(stream), high(stream) ^ (half << 31)], key)
        };
        let ([a, b, c, d], [e, f, g, h]) = (block(0), block(1));
        let mut state = [0; 32];
        for (bytes, word) in state.chunks_exact_mut(4).zip([a, b, c, d, e, f, g, h]) {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
        Self { sequence: Xoshiro256PlusPlus::from_seed(state) }
    }

    /// The largest number that is drawn, 1 − 2⁻⁵³.
    pub const LARGEST: f64 = 1.0 - f64::EPSILON / 2.0;

    /// Uniform in `[0, 1)`, a multiple of 2⁻⁵³.
    #[inline]
    pub fn uniform(&mut self) -> f64 {
        const SCALE: f64 = 1.0 / (1_u64 << 53) as f64;
        (self.sequence.next_u64() >> 11) as f64 * SCALE
    }

    /// Uniform in `[0, 1)²`.
    #[inline]
    pub fn uniform2(&mut self) -> [f64; 2] {
        [self.uniform(), self.uniform()]
    }

    /// Uniform in `[0, 1)³`.
    #[inline]
    pub fn uniform3(&mut self) -> [f64; 3] {
        [self.uniform(), self.uniform(), self.uniform()]
    }

    /// Uniform in `[0, 1)⁴`.
    #[inline]
    pub fn uniform4(&mut self) -> [f64; 4] {
        [self.uniform(), self.uniform(), self.uniform(), self.uniform()]
    }

    /// Uniform in `[0, 1)⁵`.
    #[inline]
    pub fn uniform5(&mut self) -> [f64; 5] {
        [self.uniform(), self.uniform(), self.uniform(), self.uniform(), self.uniform()]
    }
}

fn low(word: u64) -> u32 {
    word as u32
}

fn high(word: u64) -> u32 {
    (word >> 32) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_key_decides_everything() {
        let draw = |seed, stream, sample| Random::new(seed, stream, sample).uniform();
        assert_eq!(draw(1, 2, 3).to_bits(), draw(1, 2, 3).to_bits());
        let mut seen = std::collections::HashSet::new();
        for (seed, stream, sample) in [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1 << 40, 0, 0), (0, 0, 1 << 40)] {
            assert!(seen.insert(draw(seed, stream, sample).to_bits()));
        }
    }

    /// First numbers of neighbouring keys, in 64 cells: χ² with 63 degrees of freedom below its 99.9 % point (103.4).
    /// A cell off by 6 % would have been seen with probability above 0.9.
    #[test]
    fn neighbouring_keys_are_uniform() {
        for axis in 0..3 {
            let mut cells = [0_u32; 64];
            let n = 1 << 16;
            for i in 0..n {
                let key = [(i, 7, 9), (7, i, 9), (7, 9, i)][axis];
                cells[(Random::new(key.0, key.1, key.2).uniform() * 64.0) as usize] += 1;
            }
            let expected = n as f64 / 64.0;
            let chi2: f64 = cells.iter().map(|&c| (f64::from(c) - expected).powi(2) / expected).sum();
            assert!(chi2 < 103.4, "axis {axis}: χ² = {chi2}");
        }
    }

    /// Pairs of numbers at the same place of keys that differ by 1, 2 or 256 in seed, stream or sample, and of neighbours within
    /// a sequence: in 16 × 16 cells χ² with 255 degrees of freedom, and the coefficient of correlation. With 34 pairs and two
    /// tests each, one of these numbers is beyond its bound in fewer than 1 of 400 right generators (χ² > 356: 3e-5, 4.2 standard
    /// errors: 3e-5). A correlation of 0.011 would have been seen with probability 0.9.
    #[test]
    fn pairs_are_uncorrelated() {
        const N: u64 = 1 << 18;
        let test = |what: &str, pair: &dyn Fn(u64) -> [f64; 2]| {
            let (mut cells, mut product) = ([0_u32; 256], 0.0);
            for [a, b] in (0..N).map(pair) {
                cells[(a * 16.0) as usize * 16 + (b * 16.0) as usize] += 1;
                product += (a - 0.5) * (b - 0.5) * 12.0;
            }
            let expected = N as f64 / 256.0;
            let chi2: f64 = cells.iter().map(|&c| (f64::from(c) - expected).powi(2) / expected).sum();
            let errors = product / (N as f64).sqrt();
            assert!(chi2 < 356.0 && errors.abs() < 4.2, "{what}: χ² = {chi2}, correlation {errors} standard errors");
        };
        let nth = |[seed, stream, sample]: [u64; 3], place: usize| {
            let mut random = Random::new(seed, stream, sample);
            (0..place).for_each(|_| _ = random.uniform());
            random.uniform()
        };
        for axis in 0..3 {
            for (lag, place) in [1, 2, 256].into_iter().flat_map(|lag| [0, 1, 4].map(|place| (lag, place))) {
                let key = |i: u64| std::array::from_fn(|at| if at == axis { i } else { 7 });
                test(&format!("axis {axis}, lag {lag}, place {place}"), &|i| {
                    [
                        nth(key(2 * lag * (i / lag) + i % lag), place),
                        nth(key(2 * lag * (i / lag) + i % lag + lag), place),
                    ]
                });
            }
        }
        for lag in 1..=7 {
            test(&format!("within, lag {lag}"), &|i| [nth([i, 5, 3], 0), nth([i, 5, 3], lag)]);
        }
    }
}
