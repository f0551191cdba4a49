//! Which seed a run has.
//!
//! Runs that are compared must be independent, so no two runs on a scene share a seed; and an experiment may grow by seeds and
//! by methods, so a seed depends on neither of their numbers. Repetition r of the method that joined as the i-th has the seed
//! `first + z(i, r)`, where z interleaves the bits of both (Morton order): unlike `i + r · 1000` it stays small and nearly
//! without gaps, which Mitsuba's scalar variants need, whose usable seeds are few (see `scripts/pathspace/seeds.py`).

/// An experiment has fewer methods, and at most so many seeds.
pub const MOST: u32 = 1 << 16;

/// The seed of a repetition of a method, both counted from 0.
#[must_use]
pub fn seed_of(first: u64, method: u32, repetition: u32) -> u64 {
    first.wrapping_add(spread(method) | spread(repetition) << 1)
}

/// Zeros between the bits.
fn spread(number: u32) -> u64 {
    (0..32).map(|bit| u64::from(number >> bit & 1) << (2 * bit)).sum()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn no_two_runs_share_a_seed_and_seeds_stay_small() {
        let seeds: BTreeSet<u64> = (0..8).flat_map(|i| (0..16).map(move |r| seed_of(5, i, r))).collect();
        assert_eq!(seeds.len(), 8 * 16);
        assert!(seeds.first() == Some(&5) && seeds.last().is_some_and(|&last| last < 5 + 256));
        assert_ne!(seed_of(0, MOST, 0), seed_of(0, 0, MOST));
    }
}
