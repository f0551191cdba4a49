//! Samples follow the density that their model states.

use std::f64::consts::{FRAC_PI_2, TAU};

use rand::RngExt;
use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::*;
use crate::geometry::Frame;

const SAMPLES: usize = 400_000;

/// One hemisphere in cells of the height `ρ = 1 − cos` over an axis and of the azimuth.
struct Cells {
    /// Whether directions here have z > 0.
    up: bool,
    frame: Frame,
    /// Edges of the cells in ρ, from 0 up.
    heights: Vec<f64>,
    sectors: usize,
}

impl Cells {
    /// Around the normal, for lobes wide enough; the horizon is an edge.
    fn around_normal(up: bool) -> Self {
        let axis = if up { DVec3::Z } else { -DVec3::Z };
        // Closer towards the horizon, where densities change fast.
        let heights = (0..=20).map(|i| 1.0 - (1.0 - f64::from(i) / 20.0).powi(2)).collect();
        Self { up, frame: Frame::around(axis), heights, sectors: 24 }
    }

    /// Around the peak of a narrow lobe, with edges at multiples of its width `alpha` \[rad\].
    fn around_peak(up: bool, peak: DVec3, alpha: f64) -> Self {
        let mut heights = vec![0.0];
        heights.extend((0..).map(|i| 0.1 * alpha * alpha * 2.0_f64.powi(i)).take_while(|&h| h < 1.0));
        heights.push(2.0);
        Self { up, frame: Frame::around(peak), heights, sectors: 8 }
    }

    fn len(&self) -> usize {
        (self.heights.len() - 1) * self.sectors
    }

    fn locate(&self, to: DVec3) -> Option<usize> {
        if (to.z > 0.0) != self.up {
            return None;
        }
        // 1 − cos from the chord, because cos has no digits near the peak.
        let chord = to - self.frame.z;
        let height = 0.5 * chord.length_squared();
        let row = self.heights.partition_point(|&h| h <= height).clamp(1, self.heights.len() - 1) - 1;
        let local = self.frame.to_local(to);
        let phi = libm::atan2(local.y, local.x).rem_euclid(TAU);
        let sector = ((phi / TAU * self.sectors as f64) as usize).min(self.sectors - 1);
        Some(row * self.sectors + sector)
    }

    /// The probability of a cell by Gauss's three-point rule on 24 × 24 parts.
    fn probability(&self, cell: usize, density: &impl Fn(DVec3) -> f64) -> f64 {
        const PARTS: usize = 24;
        let nodes = [(-0.6_f64.sqrt(), 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.6_f64.sqrt(), 5.0 / 18.0)];
        let rule = |low: f64, high: f64| {
            let step = (high - low) / PARTS as f64;
            (0..PARTS).flat_map(move |i| nodes.map(|(x, w)| (low + step * (i as f64 + 0.5 + 0.5 * x), step * w)))
        };
        let (row, sector) = (cell / self.sectors, cell % self.sectors);
        let width = TAU / self.sectors as f64;
        let mut sum = 0.0;
        for (height, weight) in rule(self.heights[row], self.heights[row + 1]) {
            let sine = (height * (2.0 - height)).max(0.0).sqrt();
            for (phi, phi_weight) in rule(width * sector as f64, width * (sector + 1) as f64) {
                let (s, c) = libm::sincos(phi);
                let to = self.frame.to_world(DVec3::new(sine * c, sine * s, 1.0 - height));
                if (to.z > 0.0) == self.up {
                    sum += weight * phi_weight * density(to);
                }
            }
        }
        sum
    }
}

/// `(p-value, standardised deviation of the number of ended walks)` of samples against a density.
fn compare(sampled: &Bsdf, stated: &Bsdf, from: DVec3, cells: &[Cells], seed: u64) -> (f64, f64) {
    let mut rng = random_numbers(seed);
    let mut counts: Vec<Vec<u32>> = cells.iter().map(|c| vec![0; c.len()]).collect();
    let mut ended = 0_u32;
    for i in 0..SAMPLES {
        match sampled.sample(SIDES[i % 2], from, rng.random()) {
            Some(sample) if matches!(sample.density, LobeDensity::Finite(_)) => {
                let (part, cell) = cells
                    .iter()
                    .enumerate()
                    .find_map(|(part, c)| c.locate(sample.to).map(|cell| (part, cell)))
                    .unwrap();
                counts[part][cell] += 1;
            }
            _ => ended += 1,
        }
    }
    let n = SAMPLES as f64;
    let density = |to: DVec3| stated.density(from, to).value();
    let (mut statistic, mut degrees, mut total) = (0.0, -1.0, 0.0);
    let (mut rest_expected, mut rest_count) = (0.0, 0.0);
    let mut add = |expected: f64, count: f64| {
        if expected >= 10.0 {
            statistic += (count - expected).powi(2) / expected;
            degrees += 1.0;
        }
    };
    for (cells, counts) in cells.iter().zip(&counts) {
        for (cell, &count) in counts.iter().enumerate() {
            let expected = n * cells.probability(cell, &density);
            total += expected / n;
            add(expected, f64::from(count));
            if expected < 10.0 {
                rest_expected += expected;
                rest_count += f64::from(count);
            }
        }
    }
    if total == 0.0 {
        // Nothing but Dirac lobes on this side.
        return (1.0, f64::from(ended) - n);
    }
    let missing = (1.0 - total).max(0.0);
    add(rest_expected, rest_count);
    add(n * missing, f64::from(ended));
    // One count is the least spread, for models that never end a walk.
    let deviation = (f64::from(ended) - n * (1.0 - total)) / (n * missing * total).sqrt().max(1.0);
    (ChiSquared::new(degrees).unwrap().sf(statistic), deviation)
}

fn cells(from: DVec3, alpha: f64, ior: f64) -> Vec<Cells> {
    if alpha >= 0.1 {
        return [true, false].map(Cells::around_normal).into();
    }
    let up = from.z > 0.0;
    let through = refracted(from, ior).unwrap_or(DVec3::Z.copysign(-from));
    vec![Cells::around_peak(up, mirrored(from), alpha), Cells::around_peak(!up, through.normalize(), alpha)]
}

/// χ² of 400 000 samples on 160 to 960 cells and one for the ended walks, both sides of the path mixed.
///
/// Significance 1e-3 for all set-ups together (Bonferroni). Power: where half of the samples follow a density that is wrong
/// by 5 %, the statistic's mean rises by 400 000 · 0.05² / 2 = 500, eleven of its standard deviations with 960 cells.
/// The number of ended walks is also tested on its own against `1 − ∫ p dσ`, at 5.5 standard deviations.
#[test]
fn samples_follow_their_density() {
    let mut set_ups = vec![(diffuse(), 1.0, 1.0, 0.3)];
    for (alpha, cosines) in
        [(1e-3, &[0.9, 0.4][..]), (0.02, &[0.9, 0.4]), (0.1, &[0.9, 0.15]), (0.5, &[1.0, 0.05]), (1.0, &[0.5])]
    {
        set_ups.extend(cosines.iter().map(|&cos| (metal(alpha, gold()), alpha, 1.0, cos)));
        for ior in [1.5, 0.7] {
            set_ups.extend(cosines.iter().flat_map(|&c| [c, -c]).map(|cos| (rough_glass(alpha, ior), alpha, ior, cos)));
        }
    }
    let wide = others().into_iter().chain(composites::all()).chain(gltf::wide());
    for (i, model) in wide.filter(Bsdf::has_finite).enumerate() {
        // Steep and flat in turn.
        let cosines = if model.transmits() { &[0.7, -0.6][..] } else { &[0.8, 0.3][i % 2..][..1] };
        set_ups.extend(cosines.iter().map(|&cos| (model.clone(), 1.0, 1.0, cos)));
    }
    let threshold = 1e-3 / set_ups.len() as f64;
    set_ups.par_iter().enumerate().for_each(|(i, (bsdf, alpha, ior, cos))| {
        let from = direction(*cos, 0.4 + FRAC_PI_2);
        let (p, ended) = compare(bsdf, bsdf, from, &cells(from, *alpha, *ior), i as u64 + 1);
        assert!(p > threshold, "{bsdf:?} from cos {cos}: p = {p:e}");
        assert!(ended.abs() < 5.5, "{bsdf:?} from cos {cos}: ended walks off by {ended} standard deviations");
    });
}

/// The same statistic rejects samples whose roughness, or index of refraction, is off by 2 %.
#[test]
fn the_test_would_see_a_wrong_density() {
    for (sampled, stated) in [
        (metal(0.5, gold()), metal(0.51, gold())),
        (rough_glass(0.5, 1.5), rough_glass(0.51, 1.5)),
        (rough_glass(0.2, 1.5), rough_glass(0.2, 1.53)),
        (tinted_metal(MicrofacetKind::Beckmann, [0.3, 0.5]), tinted_metal(MicrofacetKind::Beckmann, [0.3, 0.51])),
    ] {
        let from = direction(0.6, 1.0);
        let (p, _) = compare(&sampled, &stated, from, &cells(from, 0.5, 1.5), 7);
        assert!(p < 1e-6, "{stated:?}: p = {p:e}");
    }
}
