//! The stability suite finds what is planted, and its scenes render the same on any number of threads.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;

use pathspace::estimator::{
    Combination, Control, Entry, Estimator, Integrator, Registry, Settings, SettingsError, Sink, Term,
};
use pathspace::film::Film;
use pathspace::path::{Path, Roulette};
use pathspace::sampler::{Random, Tracer};
use pathspace::scene::description::FilmSize;
use pathspace::scene::sensor::Pixel;
use pathspace::scene::{LightSelection, Scene, SceneOptions};
use pathspace::testing::stability::{Case, Cell, Effort, Run, Subject, Verdict, all};
use pathspace_path::PathTracer;

/// What a bug does to a term.
type Bug = fn(&mut Term);

/// `path` with a bug in its terms.
struct Buggy {
    inner: PathTracer,
    bug: Bug,
}

struct Changed<'a, S> {
    bug: Bug,
    sink: &'a mut S,
}

impl<S: Sink> Sink for Changed<'_, S> {
    const RECORDS: bool = S::RECORDS;

    fn add(&mut self, mut term: Term, path: impl FnOnce() -> Option<Path>) {
        (self.bug)(&mut term);
        self.sink.add(term, path);
    }
}

impl Estimator for Buggy {
    type Scratch = ();

    fn sample<S: Sink>(&self, tracer: &mut Tracer<'_>, random: &mut Random, pixel: Pixel, (): &mut (), sink: &mut S) {
        self.inner.sample(tracer, random, pixel, &mut (), &mut Changed { bug: self.bug, sink });
    }

    fn definition(&self, longest: u32) -> Option<Combination> {
        Estimator::definition(&self.inner, longest)
    }
}

fn entry(name: &'static str, build: fn(&mut Settings) -> Result<Box<dyn Integrator>, SettingsError>) -> Entry {
    Entry { name, summary: "", build }
}

fn buggy(settings: &mut Settings, bug: Bug) -> Result<Box<dyn Integrator>, SettingsError> {
    let inner = PathTracer { roulette: Roulette::Throughput { start: 5, long: 100 }, ..PathTracer::new(settings)? };
    Ok(Box::new(Buggy { inner, bug }))
}

fn cells(registry: &Registry, methods: &[&str], cases: &[Case]) -> Vec<Cell> {
    let methods: Vec<String> = methods.iter().map(|&name| name.to_owned()).collect();
    let effort = Effort { rays: 200_000, ..Effort::QUICK };
    let run = Run { registry, methods: &methods, cases, effort, threads: 2 };
    run.cells(&|| false, &|_| ()).unwrap()
}

fn named(names: &[&str]) -> Vec<Case> {
    all().into_iter().filter(|case| names.contains(&case.name)).collect()
}

/// The verdicts of all values.
fn verdicts(cells: &[Cell], method: &str) -> Vec<Verdict> {
    cells.iter().filter(|cell| cell.method == method).map(|cell| cell.verdict).collect()
}

#[test]
fn planted_bugs_fail_and_path_holds() {
    let registry = pathspace_builtin::registry()
        .with(entry("too_dark", |settings| buggy(settings, |term| term.value *= 0.97)))
        .with(entry("too_bright", |settings| buggy(settings, |term| term.value *= 1.03)))
        .with(entry("no_number", |settings| {
            buggy(settings, |term| term.value = if term.value.r < 1e-12 { term.value * f64::NAN } else { term.value })
        }))
        .with(entry("panics", |settings| buggy(settings, |term| assert!(term.value.r > 1e-12, "planted"))));
    let cells = cells(&registry, &["path", "too_dark", "too_bright", "no_number", "panics"], &named(&["dark"]));
    let count = cells.iter().filter(|cell| cell.method == "path").count();
    assert_eq!(verdicts(&cells, "path"), vec![Verdict::Holds; count]);
    for method in ["too_dark", "too_bright"] {
        // The definition tells in any cell, the image wherever light is seen.
        assert!(verdicts(&cells, method)[..count - 1].iter().all(|&verdict| verdict == Verdict::Fails), "{method}");
    }
    for method in ["no_number", "panics"] {
        let found: BTreeSet<&str> = verdicts(&cells, method).into_iter().map(Verdict::name).collect();
        assert!(found.contains("fails") && found.contains("holds"), "{method}: {found:?}");
    }
}

#[test]
fn the_same_seed_gives_the_same_cells_on_any_number_of_threads() {
    let registry = pathspace_builtin::registry();
    let cases = named(&["slivers", "rough glass", "many"]);
    let run = |threads: usize| {
        let methods = ["path".to_owned(), "bdpt".to_owned()];
        let effort = Effort { rays: 50_000, ..Effort::QUICK };
        let cells = Run { registry: &registry, methods: &methods, cases: &cases, effort, threads }
            .cells(&|| false, &|_| ())
            .unwrap();
        // All but times.
        let timeless = |cell: Cell| Cell { seconds_per_sample: None, time_growth: None, ..cell };
        cells.into_iter().map(timeless).collect::<Vec<_>>()
    };
    assert_eq!(run(1), run(3));
}

struct Once;

impl Control for Once {
    fn next_passes(&mut self, film: &Film) -> u64 {
        1 - film.passes()
    }
}

/// Images of three tiles, so that threads have something to share.
#[test]
fn all_cases_render_the_same_bits_on_1_2_and_16_threads() {
    let pools = [1, 2, 16].map(|threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap());
    let registry = pathspace_builtin::registry();
    let size = FilmSize { width: 64, height: 40 };
    let options = SceneOptions { film: Some(size), light_selection: LightSelection::Power };
    let mut rendered = 0;
    for case in all() {
        let (Subject::Scene(stage), Some(&value)) = (case.subject, case.values.last()) else { continue };
        let scene = Scene::build(&stage(value).scene, options).unwrap().0;
        for name in registry.entries().iter().map(|entry| entry.name) {
            let method = registry.build(name, &[("max_length", "20".to_owned())]).unwrap();
            if method.integrator.supports(&scene).is_err() {
                continue;
            }
            let images = pools.each_ref().map(|pool| {
                let mut film = Film::new(size.width, size.height, None).unwrap();
                pool.install(|| method.integrator.render(&scene, 1, &mut film, &mut Once));
                let bits = |pixel: &pathspace::spectrum::Rgb| pixel.to_array().map(f64::to_bits);
                film.mean_image().pixels.iter().map(bits).collect::<Vec<_>>()
            });
            assert!(images[0] == images[1] && images[0] == images[2], "{} by {name}", case.full_name());
            rendered += 1;
        }
    }
    assert!(rendered > 150, "{rendered}");
}
