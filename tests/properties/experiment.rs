//! Experiments through the library: agreement, bias, repetition, and what is written.

use std::fs;
use std::path::Path;

use pathspace::estimator::{Entry, Estimator, Integrator, Registry, Settings, Sink, Term};
use pathspace::experiment::{Budget, Folder, Plan, ReferenceChoice, Report, Request, Subject, run};
use pathspace::path::Path as LightPath;
use pathspace::sampler::{Random, Tracer};
use pathspace::scene::description::{FilmSize, Reference};
use pathspace::scene::sensor::Pixel;
use pathspace::scene::{LightSelection, SceneDescription};
use pathspace::spectrum::Rgb;
use pathspace::testing::scenes;
use pathspace_path::PathTracer;

/// The path tracer, 2 % too bright.
struct Biased(PathTracer);

struct Scaled<'a, S>(&'a mut S);

impl<S: Sink> Sink for Scaled<'_, S> {
    const RECORDS: bool = S::RECORDS;

    fn add(&mut self, term: Term, path: impl FnOnce() -> Option<LightPath>) {
        self.0.add(Term { value: term.value * 1.02, ..term }, path);
    }
}

impl Estimator for Biased {
    type Scratch = ();

    fn sample<S: Sink>(&self, tracer: &mut Tracer<'_>, random: &mut Random, pixel: Pixel, (): &mut (), sink: &mut S) {
        self.0.sample(tracer, random, pixel, &mut (), &mut Scaled(sink));
    }
}

const BIASED: Entry = Entry {
    name: "biased",
    summary: "the path tracer, 2 % too bright",
    build: |settings: &mut Settings| Ok(Box::new(Biased(PathTracer::new(settings)?)) as Box<dyn Integrator>),
};

fn registry() -> Registry {
    Registry::default()
        .with(pathspace_path::ENTRY)
        .with(pathspace_path_bsdf::ENTRY)
        .with(pathspace_light::ENTRY)
        .with(BIASED)
}

fn enclosure() -> SceneDescription {
    let (emission, reflectance) = (Rgb::new(0.25, 0.5, 0.125), Rgb::new(0.5, 0.25, 0.75));
    let mut description = scenes::enclosure(emission, reflectance, FilmSize { width: 40, height: 33 });
    description.reference = Some(Reference::Enclosure { emission, reflectance });
    description
}

fn subject(description: SceneDescription) -> Subject {
    let scene = scenes::build(&description);
    Subject { scene, description, fingerprint: "it".into(), load_seconds: 0.5, build_seconds: 0.25 }
}

fn request(methods: &[&str], spp: u64) -> Request {
    Request {
        methods: methods.iter().map(|&method| method.to_owned()).collect(),
        budget: Budget::Spp(spp),
        seed: 1,
        seeds: 2,
        threads: 2,
        max_length: Some(Some(6)),
        light_selection: LightSelection::Power,
        command: "a test".into(),
    }
}

fn experiment(description: SceneDescription, methods: &[&str], spp: u64, reference: &ReferenceChoice) -> Report {
    let subjects = [subject(description)];
    let plan = Plan::resolve(&request(methods, spp), &subjects, &registry(), None).unwrap();
    run(plan, &subjects, &registry(), None, reference, None, &mut ()).unwrap()
}

fn verdicts(report: &Report) -> Vec<(&str, &str, &str)> {
    report.agreement.iter().map(|row| (row.method.as_str(), row.against.as_str(), row.verdict.as_str())).collect()
}

#[test]
fn methods_that_estimate_the_same_image_agree_and_meet_the_exact_answer() {
    let report = experiment(enclosure(), &["path", "path_bsdf", "light"], 128, &ReferenceChoice::Scene);
    let expected = [
        ("path", "exact", "agree"),
        ("path_bsdf", "exact", "agree"),
        ("light", "exact", "agree"),
        ("path_bsdf", "path", "agree"),
        ("light", "path", "agree"),
    ];
    assert_eq!(verdicts(&report), expected);
    assert!(!report.differs() && report.failed.is_empty() && !report.stopped);
}

/// Its power is all but one: 2 % is over ten standard errors of the image's mean.
#[test]
fn a_bias_of_two_percent_differs_from_other_methods_and_from_the_exact_answer() {
    let report = experiment(enclosure(), &["path", "biased"], 128, &ReferenceChoice::Scene);
    let expected = [("path", "exact", "agree"), ("biased", "exact", "differ"), ("biased", "path", "differ")];
    assert_eq!(verdicts(&report), expected);
    assert!(report.differs());
    let room = scenes::room(FilmSize { width: 32, height: 32 });
    let report = experiment(room, &["path", "biased"], 256, &ReferenceChoice::None);
    assert_eq!(verdicts(&report), [("biased", "path", "differ")]);
    assert!(report.rows.iter().all(|row| row.mse.is_none()));
}

#[test]
fn light_tracing_agrees_where_glass_is_seen_because_those_blocks_are_left_out_for_it_alone() {
    let film = FilmSize { width: 80, height: 48 };
    let mut description = scenes::enclosure(Rgb::WHITE, Rgb::grey(0.5), film);
    let glass = pathspace::scene::description::BsdfDescription::Dielectric { interior_ior: 1.5, exterior_ior: 1.0 };
    description.materials.push(scenes::material("glass", glass, Rgb::BLACK));
    let centre = glam::DVec3::new(-0.05, 0.0, 0.0);
    let ball = pathspace::scene::description::Sphere { name: "ball".into(), centre, radius: 0.1, material: 1 };
    description.spheres.push(ball);
    let report = experiment(description, &["path", "light", "path_bsdf"], 128, &ReferenceChoice::None);
    assert_eq!(verdicts(&report), [("light", "path", "agree"), ("path_bsdf", "path", "agree")]);
    let masked: Vec<usize> = report.agreement.iter().map(|row| row.blocks_masked).collect();
    assert!(masked[0] > 0 && masked[0] < 10 && masked[1] == 0, "{masked:?}");
}

/// Cells of some columns, line by line.
fn cells(folder: &Path, columns: &[&str]) -> Vec<Vec<String>> {
    let text = fs::read_to_string(folder.join("rows.csv")).unwrap();
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().unwrap();
    let places: Vec<usize> = columns.iter().map(|c| header.iter().position(|h| h == c).unwrap()).collect();
    lines.map(|line| places.iter().map(|&place| line[place].to_owned()).collect()).collect()
}

const REPEATED: [&str; 9] = ["scene", "method", "seed", "checkpoint", "spp", "rays", "mse", "relmse", "mean_ratio"];

#[test]
fn the_written_experiment_repeats_the_same_bits_on_other_threads() {
    let temporary = tempfile::tempdir().unwrap();
    let subjects = [subject(enclosure())];
    let methods = ["path:roulette=off", "light:heuristic=power:exponent=3"];
    let plan = Plan::resolve(&request(&methods, 5), &subjects, &registry(), None).unwrap();
    let first = temporary.path().join("first");
    let folder = Folder::create(&first, false, true).unwrap();
    run(plan, &subjects, &registry(), None, &ReferenceChoice::Scene, Some(&folder), &mut ()).unwrap();

    let text = fs::read_to_string(first.join("experiment.toml")).unwrap();
    let mut plan = Plan::from_toml(&text).unwrap();
    assert_eq!(plan.scenes[0].settings[methods[1]]["exponent"], "3");
    plan.threads = 1;
    let second = temporary.path().join("second");
    let folder = Folder::create(&second, false, true).unwrap();
    run(plan, &subjects, &registry(), None, &ReferenceChoice::Scene, Some(&folder), &mut ()).unwrap();
    let rows = cells(&first, &REPEATED);
    assert_eq!(rows, cells(&second, &REPEATED));
    let spp: Vec<&str> = rows[..4].iter().map(|row| row[4].as_str()).collect();
    assert_eq!(spp, ["1", "2", "4", "5"]);
    let seeds: Vec<&str> = rows.iter().step_by(4).map(|row| row[2].as_str()).collect();
    assert_eq!(seeds, ["1", "3", "2", "4"]);

    for method in ["path_roulette_off", "light_heuristic_power_exponent_3"] {
        assert!(first.join(format!("images/enclosure/{method}/mean.png")).is_file());
    }
    assert!(matches!(Folder::create(&first, false, true), Err(error) if error.to_string().contains("--force")));
    fs::write(first.join("mine.txt"), "kept").unwrap();
    Folder::create(&first, true, true).unwrap();
    assert!(!first.join("rows.csv").exists() && !first.join("images").exists() && first.join("mine.txt").exists());
}

#[test]
fn the_tables_have_the_columns_that_are_documented() {
    let temporary = tempfile::tempdir().unwrap();
    let subjects = [subject(enclosure())];
    let plan = Plan::resolve(&request(&["path"], 2), &subjects, &registry(), None).unwrap();
    let folder = Folder::create(temporary.path(), false, false).unwrap();
    run(plan, &subjects, &registry(), None, &ReferenceChoice::Scene, Some(&folder), &mut ()).unwrap();
    let header =
        |file: &str| fs::read_to_string(temporary.path().join(file)).unwrap().lines().next().unwrap().to_owned();
    let rows = "scene,method,renderer,seed,threads,checkpoint,spp,render_seconds,cpu_seconds,setup_seconds,rays,mse,rmse,\
                relmse,smape,mean_ratio,invalid,";
    assert!(header("rows.csv").starts_with(rows));
    assert!(header("summary.csv").starts_with("scene,method,renderer,seeds,"));
    assert!(header("agreement.csv").starts_with("scene,method,against,verdict,image_difference,image_error,"));
    assert!(!temporary.path().join("images").exists());
    let apart = cells(temporary.path(), &["load_seconds", "setup_seconds", "renderer"]);
    assert!(apart.iter().all(|row| row[0] == "0.5" && row[1] == "0.25" && row[2].starts_with("pathspace ")));
}

#[test]
fn what_makes_no_sense_is_refused_before_anything_runs() {
    let subjects = [subject(enclosure())];
    let resolve = |methods: &[&str]| Plan::resolve(&request(methods, 2), &subjects, &registry(), None);
    for methods in [&["pth"][..], &["path:roulete=off"], &["path", "path"], &["mitsuba:bdpt"], &[]] {
        assert!(resolve(methods).is_err_and(|error| error.is_usage()), "{methods:?}");
    }
    let plan = resolve(&["path", "mitsuba:path"]).unwrap();
    assert!(plan.scenes[0].skipped["mitsuba:path"].contains("PATHSPACE_PYTHON"));

    let mut lengths = scenes::room(FilmSize { width: 8, height: 8 });
    let refused = |description: &SceneDescription, part: &str| {
        let subjects = [subject(description.clone())];
        let plan = Plan::resolve(&request(&["path"], 2), &subjects, &registry(), None).unwrap();
        let error = run(plan, &subjects, &registry(), None, &ReferenceChoice::Scene, None, &mut ()).unwrap_err();
        assert!(error.to_string().contains(part) && error.to_string().contains("--reference none"), "{error}");
    };
    refused(&lengths, "names no reference");
    lengths.reference = Some(Reference::Image { file: "none.exr".into(), max_length: None });
    refused(&lengths, "--max-length none");
    lengths.reference = Some(Reference::Image { file: "none.exr".into(), max_length: Some(6) });
    refused(&lengths, "none.exr");
}
