//! Sequences in which given numbers come at a given place, for tests of what happens at the ends of `[0, 1)`.

use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::Random;

impl Random {
    /// A sequence like any other but for three numbers in a row, those after `before` others: they are `given`, to
    /// 53 bits, or drawn where nothing is. The generator is the same; it starts where these numbers come out of it.
    #[must_use]
    pub fn forced(mut self, before: u32, given: [Option<f64>; 3]) -> Self {
        let words = given.map(|number| {
            let drawn = self.sequence.next_u64();
            let bits = |number: f64| ((number * (1_u64 << 53) as f64) as u64) << 11;
            number.map_or(drawn, |number| bits(number.clamp(0.0, Self::LARGEST)) | (drawn & 0x7ff))
        });
        let mut state = before_outputs(words, self.sequence.next_u64());
        for _ in 0..before {
            state = step_back(state);
        }
        let mut bytes = [0; 32];
        for (bytes, word) in bytes.chunks_exact_mut(8).zip(state) {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
        Self { sequence: Xoshiro256PlusPlus::from_seed(bytes) }
    }
}

/// A state of xoshiro256++, `rotl(s₀ + s₃, 23) + s₀` being what comes next, from which these three numbers come; `free` is
/// the s₀ of the last of them. Each output gives s₃ from s₀; each step is a linear map that gives the rest.
fn before_outputs([o, p, q]: [u64; 3], free: u64) -> [u64; 4] {
    let fourth = |output: u64, first: u64| output.wrapping_sub(first).rotate_right(23).wrapping_sub(first);
    // s₃″ = rotl(s₃′ ⊕ s₁′, 45) and s₀″ = s₀′ ⊕ s₃′ ⊕ s₁′.
    let c = fourth(q, free).rotate_right(45);
    let first2 = free ^ c;
    let fourth2 = fourth(p, first2);
    let second2 = c ^ fourth2;
    let a = fourth2.rotate_right(45);
    let first = first2 ^ a;
    let last = fourth(o, first);
    let second = a ^ last;
    // s₁′ = s₁ ⊕ s₂ ⊕ s₀.
    [first, second, second2 ^ second ^ first, last]
}

/// The state before, of the map `t = s₁ ≪ 17, s₂ ⊕= s₀, s₃ ⊕= s₁, s₁ ⊕= s₂, s₀ ⊕= s₃, s₂ ⊕= t, s₃ = rotl(s₃, 45)`.
fn step_back([first, second, third, last]: [u64; 4]) -> [u64; 4] {
    let a = last.rotate_right(45);
    let s0 = first ^ a;
    let (e, f) = (second ^ s0, third ^ s0);
    // e ⊕ f = s₁ ⊕ (s₁ ≪ 17), 17 bits at a time.
    let s1 = (0..4).fold(e ^ f, |s1, _| (e ^ f) ^ (s1 << 17));
    [s0, s1, e ^ s1, a ^ s1]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn given_numbers_come_where_they_should() {
        let ends = [Some(0.0), Some(Random::LARGEST), None, Some(0.25)];
        for (sample, before) in [0, 1, 2, 3, 17, 1000].into_iter().enumerate() {
            for given in ends.into_iter().flat_map(|a| ends.into_iter().flat_map(move |b| ends.map(|c| [a, b, c]))) {
                let mut random = Random::new(1, 2, sample as u64).forced(before, given);
                let mut others: Vec<f64> = (0..before).map(|_| random.uniform()).collect();
                for number in given {
                    let drawn = random.uniform();
                    assert!(number.is_none_or(|number| number.to_bits() == drawn.to_bits()), "{given:?}: {drawn}");
                }
                others.extend((0..100).map(|_| random.uniform()));
                let mean = others.iter().sum::<f64>() / others.len() as f64;
                assert!((0.3..0.7).contains(&mean), "{given:?} before {before}: the others are not random, {mean}");
            }
        }
    }
}
