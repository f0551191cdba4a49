//! The checks of an integrator in one scene.

use std::collections::BTreeMap;

use crate::estimator::{Combination, Control, Integrator, Promises, RecordedTerm};
use crate::film::{Film, Moments};
use crate::report::statistics::Welch;
use crate::scene::Scene;
use crate::spectrum::Rgb;
use crate::testing::definition::Comparison;
use crate::testing::scenes;
use crate::wide::Wide;

use super::convergence::{self, TailIndex};
use super::densities::with_variance;
use super::report::{Check, POWER, SIGNIFICANCE};
use super::{Effort, LONGEST, Stage, densities};

/// Relative deviation of a value or a weight that is none: rounding of what the fast code computes in another order.
const ROUNDING: f64 = 1e-6;

/// Passes whose bits are compared for different numbers of threads.
const THREADED_PASSES: u64 = 3;

struct Passes(u64);

impl Control for Passes {
    fn next_passes(&mut self, film: &Film) -> u64 {
        self.0.saturating_sub(film.passes())
    }
}

pub(super) fn check(
    integrator: &dyn Integrator,
    reference: Option<&dyn Integrator>,
    stage: &Stage,
    effort: Effort,
) -> Vec<Check> {
    let name = stage.scene.name.as_str();
    let scene = scenes::build(&stage.scene);
    if let Err(why) = integrator.supports(&scene) {
        return vec![Check::open("all", name, why)];
    }
    let definition = integrator.definition(LONGEST);
    let mut run = Run::new(integrator, definition.as_ref(), &scene, effort);
    let tail = TailIndex::of(&mut run.values);
    let mut checks = vec![run.replays(integrator, &scene, name), threads(integrator, &scene, name, effort)];
    checks.push(run.terms_are_possible(name));
    let untested = if integrator.promises().unbiased {
        checks.push(convergence::check(name, &run.passes, tail));
        tail.filter(TailIndex::is_infinite).map(convergence::no_variance)
    } else {
        Some("it is consistent, not unbiased: its passes are no independent estimates of the image".to_owned())
    };
    if definition.is_some() {
        checks.extend(run.equals_its_definition(name));
        checks.extend(run.techniques_agree(name));
    } else {
        checks.push(Check::open("definition", name, "the integrator declares none"));
    }
    if let Some(mut combination) = definition {
        // Others that draw the same paths: a sampler alone has nothing to be compared with.
        let own = combination.samplers.len();
        let others = reference.and_then(|reference| reference.definition(LONGEST));
        combination.samplers.extend(others.into_iter().flat_map(|others| others.samplers));
        checks.extend(densities::check(&combination, own, &scene, name, effort));
    }
    if let Some(known) = stage.known {
        checks.push(match &untested {
            Some(why) => Check::open("known answer", name, why.clone()),
            None => mean_check("known answer", name, &run.image, &exactly(known, run.image.count)),
        });
    }
    match (untested.or_else(|| integrator.misses(&scene)), reference) {
        (Some(misses), _) => checks.push(Check::open("reference image", name, misses)),
        (None, Some(reference)) if reference.supports(&scene).is_ok() => {
            let mut film = empty(&scene);
            reference.render(&scene, effort.seed + 1, &mut film, &mut Passes(effort.passes));
            checks.push(mean_check("reference image", name, &run.image, &film.block_statistics().image()[3]));
        }
        _ => checks.push(Check::open("reference image", name, "there is no integrator to compare with")),
    }
    checks
}

fn empty(scene: &Scene) -> Film {
    let size = scene.sensor().film();
    Film::new(size.width, size.height, None).expect("the stages have pixels")
}

fn exactly(value: f64, count: u64) -> Moments {
    Moments { count, mean: value, ..Moments::default() }
}

/// Two means over independent passes are equal.
pub(super) fn mean_check(name: &'static str, scene: &str, a: &Moments, b: &Moments) -> Check {
    let welch = Welch::new(a, b);
    let scale = 0.5 * (a.mean.abs() + b.mean.abs());
    let tolerance = 1e-9 * scale;
    let relative = |x: f64| 100.0 * x / scale;
    let found = format!("{:+.2} ± {:.2} %", relative(welch.difference), relative(welch.standard_error));
    let power = format!("{:.1} %", relative(welch.detectable(SIGNIFICANCE, POWER, tolerance)));
    let p_value = Some(welch.p_value(tolerance));
    Check { p_value, ..Check::exact(name, scene, false, found, power) }
}

/// All terms of an integrator in a scene, summed up.
struct Run {
    effort: Effort,
    promises: Promises,
    /// Mean luminance of the image over passes.
    image: Moments,
    /// The same of each pass.
    passes: Vec<f64>,
    /// Luminance of each term that is not black.
    values: Vec<f64>,
    /// Sum over passes by pixel.
    sum: Vec<Rgb>,
    width: usize,
    comparison: Comparison,
    /// Terms that are negative, not finite, or have a weight outside 0 … 1, with one of them.
    impossible: (usize, Option<RecordedTerm>),
    /// For two samplers i < j of the definition.
    pairs: BTreeMap<(usize, usize), Pair>,
}

impl Run {
    fn new(integrator: &dyn Integrator, definition: Option<&Combination>, scene: &Scene, effort: Effort) -> Self {
        let film = scene.sensor().film();
        let (width, height) = (film.width as usize, film.height as usize);
        let mut run = Self {
            effort,
            promises: integrator.promises(),
            image: Moments::default(),
            passes: Vec::new(),
            values: Vec::new(),
            sum: vec![Rgb::BLACK; width * height],
            width,
            comparison: Comparison::default(),
            impossible: (0, None),
            pairs: BTreeMap::new(),
        };
        let mut sample = 0;
        integrator.replay_passes(scene, effort.seed, effort.passes, &mut |terms| {
            let mut total = 0.0;
            for term in terms {
                let luminance = term.term.value.luminance();
                total += luminance;
                run.values.extend((luminance > 0.0).then_some(luminance));
                run.add(&term);
                let drawn = definition.and_then(|definition| run.comparison.add(definition, scene, &term));
                if let (Some((i, densities)), Some(definition)) = (drawn, definition) {
                    run.add_pairs(definition, luminance, i, &densities);
                }
            }
            run.passes.push(total / (width * height) as f64);
            run.image.push(total / (width * height) as f64);
            run.end_pass(sample);
            sample += 1;
        });
        run
    }

    fn add(&mut self, recorded: &RecordedTerm) {
        let term = &recorded.term;
        let positive = term.value.min_component() >= 0.0 && (0.0..=1.0 + 1e-12).contains(&term.weight);
        let possible = term.value.is_finite() && term.weight.is_finite() && (positive || !self.promises.positive);
        let index = term.pixel.y as usize * self.width + term.pixel.x as usize;
        match self.sum.get_mut(index).filter(|_| possible) {
            Some(pixel) => *pixel += term.value,
            None => {
                self.impossible.0 += 1;
                self.impossible.1.get_or_insert_with(|| recorded.clone());
            }
        }
    }

    /// A term by sampler i, for each other sampler of its path.
    fn add_pairs(&mut self, definition: &Combination, value: f64, i: usize, densities: &[Wide]) {
        let own = definition.weight(densities, i);
        let total = densities.iter().copied().sum::<Wide>();
        for j in (0..densities.len()).filter(|&j| j != i) {
            let other = definition.weight(densities, j);
            if other <= 0.0 || own <= 0.0 {
                continue;
            }
            let pair = self.pairs.entry((i.min(j), i.max(j))).or_default();
            let x = value * other;
            let (sum, sign) = if i < j { (&mut pair.first, 1.0) } else { (&mut pair.second, -1.0) };
            *sum += x;
            pair.pass += sign * x;
            // h²/p_i + h²/p_j with h = x p_i, for a path of density Σ p.
            let (to_other, to_total) = ((densities[i] / densities[j]).to_f64(), (densities[i] / total).to_f64());
            pair.variance += x * x * (1.0 + to_other) * to_total;
        }
    }

    fn end_pass(&mut self, sample: u64) {
        for pair in self.pairs.values_mut() {
            // A pair that is seen for the first time had nothing in the passes before.
            (pair.difference.count..sample).for_each(|_| pair.difference.push(0.0));
            pair.difference.push(pair.pass);
            pair.pass = 0.0;
        }
    }

    /// The image is the sum of the terms that a replay gives.
    fn replays(&self, integrator: &dyn Integrator, scene: &Scene, name: &str) -> Check {
        let mut film = empty(scene);
        integrator.render(scene, self.effort.seed, &mut film, &mut Passes(self.effort.passes));
        let mean = film.mean_image();
        let passes = self.effort.passes as f64;
        let largest = mean.pixels.iter().map(|p| p.max_component()).fold(f64::MIN_POSITIVE, f64::max);
        let difference = |(image, sum): (&Rgb, &Rgb)| {
            let difference = *image - *sum / passes;
            difference.to_array().into_iter().map(f64::abs).fold(0.0, f64::max) / largest
        };
        let worst = mean.pixels.iter().zip(&self.sum).map(difference).fold(0.0, f64::max);
        let found = format!("image and replayed terms differ by {worst:.1e}");
        Check::exact("replay", name, worst > 1e-9 || worst.is_nan(), found, "1e-9 of the brightest pixel".into())
    }

    fn terms_are_possible(&self, name: &str) -> Check {
        let (count, example) = &self.impossible;
        let found = format!("{count} terms that cannot be");
        let check = Check::exact(
            "terms",
            name,
            *count > 0,
            found,
            if self.promises.positive { "NaN, ∞, negative, weight beyond 1" } else { "NaN, ∞" }.into(),
        );
        Check { example: example.as_ref().map(ToString::to_string), ..check }
    }

    fn equals_its_definition(&self, name: &str) -> [Check; 4] {
        let Comparison { terms, value, weight, hidden, partition } = &self.comparison;
        let check = |which, (deviation, example): &(f64, Option<RecordedTerm>)| {
            let wrong = *deviation > ROUNDING || *terms == 0;
            let found = format!("off by {deviation:.1e} in {terms} terms");
            let check = Check::exact(which, name, wrong, found, format!("{ROUNDING:.0e} of any term"));
            Check { example: example.as_ref().map(ToString::to_string), ..check }
        };
        let sums = format!("weights add up to 1 ± {partition:.1e}");
        [
            check("value is w f / p", value),
            check("weight", weight),
            Check::exact("partition of one", name, *partition > 1e-9, sums, "1e-9".into()),
            Check::exact("visibility", name, *hidden > 0, format!("{hidden} hidden edges"), "one".into()),
        ]
    }

    /// ∫ w_i w_j f dμ is the same whether technique i or j draws the paths; balance weights bound the integrand.
    fn techniques_agree(&self, name: &str) -> Vec<Check> {
        let pairs = self.pairs.iter().map(|((i, j), pair)| {
            let passes = self.effort.passes;
            let difference = with_variance(pair.difference, pair.variance / passes as f64);
            let scale = pair.first.max(pair.second) / passes as f64;
            let welch = Welch::new(&difference, &exactly(0.0, passes));
            let relative = |x: f64| 100.0 * x / scale;
            let found = format!(
                "samplers {i}, {j}: {:+.2} ± {:.2} %",
                relative(welch.difference),
                relative(welch.standard_error)
            );
            if scale * passes as f64 <= 5.0 * pair.variance.sqrt() || welch.tail > 0.4 {
                return Check::open("w_i w_j f", name, format!("{found}: too few such paths"));
            }
            let power = format!("{:.1} %", relative(welch.detectable(SIGNIFICANCE, POWER, 0.0)));
            let check = Check::exact("w_i w_j f", name, false, found, power);
            Check { p_value: Some(welch.p_value(1e-9 * scale)), ..check }
        });
        pairs.collect()
    }
}

/// What two samplers i < j make of the paths that both can draw.
#[derive(Default)]
struct Pair {
    /// Over passes: `Σ w_j · term` of those by i, less `Σ w_i · term` of those by j.
    difference: Moments,
    /// Of the pass in hand.
    pass: f64,
    /// The first sum of all passes.
    first: f64,
    /// The second.
    second: f64,
    /// Variance of the difference over all passes if it is zero in expectation and paths are independent:
    /// `∫ h² (1/n_i p_i + 1/n_j p_j) dμ` with h = w_i w_j f, of which what was measured misses rare paths.
    variance: f64,
}

/// One and three threads give the same bits.
fn threads(integrator: &dyn Integrator, scene: &Scene, name: &str, effort: Effort) -> Check {
    let render = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().ok()?;
        let mut film = empty(scene);
        pool.install(|| integrator.render(scene, effort.seed, &mut film, &mut Passes(THREADED_PASSES)));
        Some(film.mean_image())
    };
    match (render(1), render(3)) {
        (Some(one), Some(three)) => {
            let bits = |p: &Rgb| p.to_array().map(f64::to_bits);
            let differing = one.pixels.iter().zip(&three.pixels).filter(|(a, b)| bits(a) != bits(b)).count();
            Check::exact("threads", name, differing > 0, format!("{differing} pixels differ"), "one bit".into())
        }
        _ => Check::open("threads", name, "no threads to be had"),
    }
}
