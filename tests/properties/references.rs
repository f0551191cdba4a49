//! References that are kept: whether their variance is what it says, and what becomes of them when they go on.

use std::path::Path;

use pathspace::estimator::{Control, Integrator, Registry, Settings};
use pathspace::experiment::cache::{Cache, Kept, Until, Wanted, compare};
use pathspace::experiment::{ExperimentError, Manifest, Observer, Plan, SceneEntry, Standing, Subject};
use pathspace::film::{Film, Image, RenderInfo};
use pathspace::report::{Reference, Verdict};
use pathspace::scene::description::FilmSize;
use pathspace::testing::scenes;
use pathspace_path::PathTracer;

use crate::experiment::{registry, subject};

const FILM: FilmSize = FilmSize { width: 16, height: 16 };

struct Passes(u64);

impl Control for Passes {
    fn next_passes(&mut self, film: &Film) -> u64 {
        self.0 - film.passes()
    }
}

/// 200 references of 16 passes against one of 3200, less both variances: the mean over pixels has the expectation 0. At
/// significance 10⁻³, its standard error finds the variance wrong by 6 %, as if divided by n and not by n − 1, with a
/// probability above 0.999.
#[test]
fn squared_errors_of_references_are_what_their_variances_say() {
    const REPETITIONS: u64 = 200;
    let scene = scenes::build(&scenes::room(FILM));
    let integrator = PathTracer::new(&mut Settings::parse("max_length=4").unwrap()).unwrap();
    let reference = |seed: u64, passes: u64| {
        let mut film = Film::new(FILM.width, FILM.height, None).unwrap();
        integrator.render(&scene, seed, &mut film, &mut Passes(passes));
        let Reference { mean, variance } =
            Kept { method: "path".into(), film, info: RenderInfo::default() }.reference();
        (numbers(&mean), numbers(&variance.unwrap()))
    };
    let (truth, noise) = reference(1 << 62, 16 * REPETITIONS);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let mut excess = Vec::new();
    let mut variances = Vec::new();
    for seed in 0..REPETITIONS {
        let (image, variance) = reference(seed, 16);
        let squares = image.iter().zip(&truth).map(|(x, r)| (x - r) * (x - r)).collect::<Vec<_>>();
        variances.push(mean(&variance));
        excess.push(mean(&squares) - mean(&variance) - mean(&noise));
    }
    let (found, variance) = (mean(&excess), mean(&variances));
    let spread = mean(&excess.iter().map(|x| (x - found) * (x - found)).collect::<Vec<_>>());
    let error = (spread / (REPETITIONS - 1) as f64).sqrt();
    println!("squared error over variance: {:.4} ± {:.4}", 1.0 + found / variance, error / variance);
    assert!(found.abs() < 3.29 * error, "{found} ± {error}, of {variance}");
    assert!(variance / 16.0 > (3.29 + 3.29) * error, "the test sees too little: {error} of {variance}");
}

fn numbers(image: &Image) -> Vec<f64> {
    image.pixels.iter().flat_map(|pixel| pixel.to_array()).collect()
}

/// A room's references in a folder.
struct Room {
    subject: Subject,
    plan: Plan,
    registry: Registry,
    pool: rayon::ThreadPool,
}

impl Room {
    fn new() -> Self {
        let subject = subject(scenes::room(FilmSize { width: 32, height: 32 }));
        let manifest = Manifest::new(vec![SceneEntry::default()], ["path"]);
        let plan = Plan::resolve(manifest, std::slice::from_ref(&subject), &registry(), None, None, "a test").unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        Self { subject, plan, registry: registry(), pool }
    }

    fn extend(
        &self,
        folder: &Path,
        method: &str,
        until: Until,
        observer: &mut (dyn Observer + Send),
    ) -> Result<Vec<Kept>, ExperimentError> {
        let plan = &self.plan.scenes[0];
        let (registry, pool) = (&self.registry, &self.pool);
        let mut cache = Cache { folder: folder.into(), registry, mitsuba: None, pool, observer };
        let done = cache.extend(&Wanted { subject: &self.subject, plan, method, until });
        done.and(cache.kept(&self.subject, plan))
    }
}

/// 2 % is over ten standard errors of the image's mean; an honest twin, with other random numbers, does not differ.
#[test]
fn a_reference_that_is_two_percent_too_bright_differs_from_others() {
    let (room, folder) = (Room::new(), tempfile::tempdir().unwrap());
    let extend = |method: &str| room.extend(folder.path(), method, Until::Spp(256), &mut ()).unwrap();
    extend("biased");
    extend("honest");
    let kept = extend("path");
    let [biased, honest, path] = kept.as_slice() else { panic!("three methods") };
    assert_eq!((biased.method.as_str(), honest.method.as_str(), path.method.as_str()), ("biased", "honest", "path"));
    assert!(honest.info.seed != path.info.seed && honest.film != path.film);
    assert_eq!(compare(path, biased).unwrap().unwrap().verdict, Verdict::Differ);
    assert_eq!(compare(honest, biased).unwrap().unwrap().verdict, Verdict::Differ);
    assert_eq!(compare(honest, path).unwrap().unwrap().verdict, Verdict::Agree);
}

/// Stops at its third look, and remembers what it was told.
#[derive(Default)]
struct Impatient {
    looks: u32,
    last: Option<Standing>,
}

impl Observer for Impatient {
    fn progress(&mut self, standing: &Standing) {
        self.looks += 1;
        self.last = Some(*standing);
    }

    fn stopped(&self) -> bool {
        self.looks >= 3
    }
}

#[test]
fn what_was_stopped_is_kept_and_goes_on_with_the_same_bits() {
    let room = Room::new();
    let (parts, whole) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let mut impatient = Impatient::default();
    let stopped = room.extend(parts.path(), "path", Until::Seconds(1e6), &mut impatient);
    assert!(matches!(stopped, Err(ExperimentError::Stopped(_))));
    let told = impatient.last.unwrap();
    let kept = room.extend(parts.path(), "path", Until::Spp(1), &mut ()).unwrap();
    assert_eq!((kept[0].spp(), kept[0].noise()), (told.spp, kept[0].noise()));
    assert!(told.spp > 1 && (told.seconds_left.unwrap() - 1e6).abs() < 100.0);

    let all = told.spp + 10;
    let kept = room.extend(parts.path(), "path", Until::Spp(all), &mut ()).unwrap();
    let unbroken = room.extend(whole.path(), "path", Until::Spp(all), &mut ()).unwrap();
    assert_eq!(kept[0].film, unbroken[0].film);
}

/// Half the noise takes four times the passes, so it is not reached by chance or at once.
#[test]
fn rendering_ends_where_the_noise_is_small_enough() {
    let (room, folder) = (Room::new(), tempfile::tempdir().unwrap());
    let first = room.extend(folder.path(), "path", Until::Spp(64), &mut ()).unwrap();
    let goal = 0.5 * first[0].noise().unwrap();
    let kept = room.extend(folder.path(), "path", Until::Noise(goal), &mut ()).unwrap();
    assert!(kept[0].noise().unwrap() <= goal && kept[0].spp() > 200, "{} spp", kept[0].spp());
}
