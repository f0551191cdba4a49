//! Weight and value of a term follow from its line of the path log alone, for every way to draw, to share and to estimate
//! lengths. The reader below knows the documentation of the schema and the JSON, and nothing of the library.

use std::collections::BTreeMap;

use pathspace::estimator::{Integrator, Registry};
use pathspace::film::ReplayKey;
use pathspace::report::paths::{Origin, PathRecord};
use pathspace::scene::Scene;
use pathspace::scene::description::FilmSize;
use pathspace::spectrum::Rgb;
use pathspace::testing::scenes;
use serde_json::Value;

const FILM: FilmSize = FilmSize { width: 12, height: 9 };
const HEURISTICS: [&str; 6] = [
    "heuristic=balance",
    "heuristic=power",
    "heuristic=power:exponent=3.7",
    "heuristic=maximum",
    "heuristic=cutoff",
    "heuristic=cutoff:threshold=0.6",
];

fn integrator(text: &str) -> Box<dyn Integrator> {
    let registry = Registry::default()
        .with(pathspace_bdpt::ENTRY)
        .with(pathspace_path::ENTRY)
        .with_sampler(pathspace_direct::SAMPLER)
        .with_sampler(pathspace_walks::SAMPLER);
    registry.build(text, &[("max_length", "5".into())]).unwrap_or_else(|error| panic!("{text}: {error}")).integrator
}

/// The lines of some samples in every pixel.
fn lines(scene: &Scene, text: &str, samples: u64) -> Vec<Value> {
    let integrator = integrator(text);
    let mut lines = Vec::new();
    for pixel in (0..FILM.height).flat_map(|y| (0..FILM.width).map(move |x| (x, y))) {
        for sample in 0..samples {
            let key = ReplayKey { seed: 11, sample, pixel };
            for (index, term) in integrator.replay(scene, key).iter().enumerate() {
                let definition = integrator.definition(term.path.edges() as u32);
                let origin = Origin { scene, integrator: text, definition: definition.as_ref() };
                let line = serde_json::to_string(&PathRecord::new(&origin, key, index, term)).unwrap();
                lines.push(serde_json::from_str(&line).unwrap());
            }
        }
    }
    assert!(lines.len() > 100, "{text}: only {} lines", lines.len());
    lines
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// What a line says, recomputed from its `techniques`.
struct Recomputed {
    /// Place of the line's own sampler in `techniques`.
    own: usize,
    /// `n_j p_j / (n_i p_i)`, 1 at `own`.
    ratios: Vec<f64>,
    weight: f64,
    contribution: [f64; 3],
}

impl Recomputed {
    fn new(line: &Value) -> Self {
        let techniques = line["techniques"].as_array().unwrap();
        let own = techniques.iter().position(|by| by["sampler"] == line["sampler"]).expect("it has drawn the path");
        let np = |by: &Value| (number(&by["p"]["mantissa"]) * number(&by["n"]), by["p"]["exponent"].as_i64().unwrap());
        let (mantissa, exponent) = np(&techniques[own]);
        let ratio = |by: &Value| {
            let (m, e) = np(by);
            m / mantissa * 2f64.powi((e - exponent) as i32)
        };
        let ratios: Vec<f64> = techniques.iter().map(ratio).collect();
        let weight = weight(&line["heuristic"], &ratios, own);
        let by = &techniques[own];
        let scale = weight / (number(&by["n"]) * number(&by["length_probability"]));
        Self { own, weight, contribution: [0, 1, 2].map(|c| scale * number(&by["f_over_p"][c])), ratios }
    }

    /// Another sampler has the same s and t.
    fn shares_its_technique(&self, line: &Value) -> bool {
        let techniques = line["techniques"].as_array().unwrap();
        let own = &techniques[self.own];
        techniques.iter().filter(|by| (&by["s"], &by["t"]) == (&own["s"], &own["t"])).count() > 1
    }
}

fn weight(heuristic: &Value, ratios: &[f64], own: usize) -> f64 {
    match heuristic["kind"].as_str().unwrap() {
        "balance" => 1.0 / ratios.iter().sum::<f64>(),
        "power" => 1.0 / ratios.iter().map(|r| r.powf(number(&heuristic["exponent"]))).sum::<f64>(),
        "maximum" => {
            let beaten = ratios[..own].iter().any(|&r| r >= 1.0) || ratios[own + 1..].iter().any(|&r| r > 1.0);
            f64::from(u8::from(!beaten))
        }
        "cutoff" => {
            let least = number(&heuristic["threshold"]) * ratios.iter().copied().fold(0.0, f64::max);
            let sum: f64 = ratios.iter().filter(|&&r| r >= least).sum();
            if 1.0 < least { 0.0 } else { 1.0 / sum }
        }
        other => panic!("unknown heuristic {other}"),
    }
}

fn assert_close(found: f64, expected: f64, line: &Value) {
    assert!((found - expected).abs() <= 1e-9 * expected.abs(), "{found} is not {expected}: {line}");
}

/// How often what makes a line harder to read has occurred.
#[derive(Debug, Default)]
struct Seen {
    lines: usize,
    /// Another sampler has the same s and t.
    same_technique: usize,
    /// Exactly equal densities.
    ties: usize,
    /// The weight is neither 0 nor 1.
    shared: usize,
    /// The length had a probability below one.
    drawn_lengths: usize,
    by_sampler: BTreeMap<u64, usize>,
}

fn check(scene: &Scene, text: &str, samples: u64) -> Seen {
    let mut seen = Seen::default();
    for line in &lines(scene, text, samples) {
        let recomputed = Recomputed::new(line);
        assert_close(recomputed.weight, number(&line["weight"]), line);
        for c in 0..3 {
            assert_close(recomputed.contribution[c], number(&line["contribution"][c]), line);
        }
        let others = recomputed.ratios.iter().enumerate().filter(|&(j, _)| j != recomputed.own);
        seen.lines += 1;
        seen.same_technique += usize::from(recomputed.shares_its_technique(line));
        seen.ties += others.filter(|&(_, &r)| r == 1.0).count();
        seen.shared += usize::from(recomputed.weight > 0.0 && recomputed.weight < 1.0);
        seen.drawn_lengths += usize::from(number(&line["techniques"][recomputed.own]["length_probability"]) < 1.0);
        *seen.by_sampler.entry(line["sampler"].as_u64().unwrap()).or_default() += 1;
    }
    seen
}

#[test]
fn a_line_of_path_and_bdpt_recomputes_itself() {
    for description in
        [scenes::room, scenes::cabinet, scenes::gallery, scenes::veneer, scenes::vignette, scenes::photometer]
    {
        let description = description(FILM);
        let scene = scenes::build(&description);
        for heuristic in HEURISTICS {
            for (name, samplers, samples) in [("path", 2, 8), ("bdpt", 5, 4)] {
                let seen = check(&scene, &format!("{name}:{heuristic}"), samples);
                assert!(seen.by_sampler.len() >= samplers, "{}: {name}:{heuristic}: {seen:?}", description.name);
                // The others give all weight to one of two samplers more often than not.
                let shares = heuristic.contains("balance") || heuristic.contains("power");
                assert!(!shares || seen.shared > 20, "{}: {name}:{heuristic}: {seen:?}", description.name);
            }
        }
    }
}

/// Two samplers of the same (s, t) beside one of another: by cosine and by BSDF they have equal densities over diffuse
/// surfaces, so what compares densities has to get ties right.
#[test]
fn a_line_of_samplers_that_share_a_technique_recomputes_itself() {
    let samplers = "direct(by=cosine)+direct(by=emitters)+direct(by=bsdf)+direct(by=surfaces)";
    let enclosure = scenes::enclosure(Rgb::new(0.5, 0.7, 0.9), Rgb::new(0.3, 0.5, 0.8), FILM);
    for (description, samples) in [(scenes::room(FILM), 12), (enclosure, 2)] {
        let scene = scenes::build(&description);
        for heuristic in HEURISTICS {
            for terms in ["together", "apart", "single", "up_to:further=0.6"] {
                let text = format!("mis:samplers={samplers}:{heuristic}:terms={terms}");
                let seen = check(&scene, &text, samples);
                assert!(seen.same_technique > seen.lines / 2, "{}: {text}: {seen:?}", description.name);
                assert!(seen.ties > 5, "{}: {text}: {seen:?}", description.name);
                assert_eq!(seen.by_sampler.len(), 4, "{}: {text}: {seen:?}", description.name);
                let drawn = terms.starts_with("single") || terms.starts_with("up_to");
                assert_eq!(drawn, seen.drawn_lengths > seen.lines / 10, "{}: {text}: {seen:?}", description.name);
            }
        }
    }
}

/// Families of walks, light walks for all pixels (n = 108) among them, with lengths drawn in advance.
#[test]
fn a_line_of_walks_with_lengths_drawn_in_advance_recomputes_itself() {
    let scene = scenes::build(&scenes::cabinet(FILM));
    for heuristic in HEURISTICS {
        for terms in ["apart", "single:further=0.8", "up_to"] {
            let text = format!("mis:samplers=walks(s=0)+walks(s=1)+walks(t=1):{heuristic}:terms={terms}");
            let seen = check(&scene, &text, 30);
            assert_eq!(seen.by_sampler.len(), 3, "{text}: {seen:?}");
        }
    }
}
