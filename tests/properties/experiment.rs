//! Experiments through the library: agreement, bias, repetition, and what is written.

use std::fs;
use std::path::Path;

use pathspace::estimator::{Control, Entry, Estimator, Integrator, Registry, Settings, SettingsError, Sink, Term};
use pathspace::experiment::manifest::MaxLength;
use pathspace::experiment::{
    Budget, ExperimentError, Folder, Manifest, Plan, ReferencePolicy, Renderers, Report, SceneEntry, Subject, collect,
    missing, run,
};
use pathspace::film::{Film, RenderInfo, write_image};
use pathspace::path::Path as LightPath;
use pathspace::sampler::{Random, Tracer};
use pathspace::scene::SceneDescription;
use pathspace::scene::description::{FilmSize, Reference};
use pathspace::scene::sensor::Pixel;
use pathspace::spectrum::Rgb;
use pathspace::testing::scenes;
use pathspace_path::PathTracer;

/// The path tracer with something done to its terms.
struct Biased {
    inner: PathTracer,
    bias: fn(Term) -> Option<Term>,
}

struct Through<'a, S> {
    sink: &'a mut S,
    bias: fn(Term) -> Option<Term>,
}

impl<S: Sink> Sink for Through<'_, S> {
    const RECORDS: bool = S::RECORDS;

    fn add(&mut self, term: Term, path: impl FnOnce() -> Option<LightPath>) {
        if let Some(term) = (self.bias)(term) {
            self.sink.add(term, path);
        }
    }
}

impl Estimator for Biased {
    type Scratch = ();

    fn sample<S: Sink>(&self, tracer: &mut Tracer<'_>, random: &mut Random, pixel: Pixel, (): &mut (), sink: &mut S) {
        self.inner.sample(tracer, random, pixel, &mut (), &mut Through { sink, bias: self.bias });
    }
}

fn biased(settings: &mut Settings, bias: fn(Term) -> Option<Term>) -> Result<Box<dyn Integrator>, SettingsError> {
    Ok(Box::new(Biased { inner: PathTracer::new(settings)?, bias }))
}

const PLANTED: [Entry; 4] = [
    Entry {
        name: "biased",
        summary: "2 % too bright",
        build: |settings| biased(settings, |term| Some(Term { value: term.value * 1.02, ..term })),
    },
    Entry {
        name: "slightly",
        summary: "1 % too bright",
        build: |settings| biased(settings, |term| Some(Term { value: term.value * 1.01, ..term })),
    },
    Entry {
        name: "lacking",
        summary: "without the emitters that are met by chance, which count most beside them",
        build: |settings| {
            biased(settings, |term| Some(term).filter(|term| term.technique.s > 0 || term.technique.t == 2))
        },
    },
    Entry { name: "honest", summary: "as it is", build: |settings| biased(settings, Some) },
];

pub fn registry() -> Registry {
    let shipped = [pathspace_path::ENTRY, pathspace_path_bsdf::ENTRY, pathspace_light::ENTRY];
    shipped.into_iter().chain(PLANTED).fold(Registry::default(), Registry::with)
}

fn enclosure() -> SceneDescription {
    let (emission, reflectance) = (Rgb::new(0.25, 0.5, 0.125), Rgb::new(0.5, 0.25, 0.75));
    let mut description = scenes::enclosure(emission, reflectance, FilmSize { width: 40, height: 33 });
    description.reference = Some(Reference::Enclosure { emission, reflectance });
    description
}

pub fn subject(description: SceneDescription) -> Subject {
    let scene = scenes::build(&description);
    Subject { scene, description, fingerprint: "it".into(), load_seconds: 0.5, build_seconds: 0.25 }
}

fn manifest(methods: &[&str], spp: u64, reference: ReferencePolicy) -> Manifest {
    let mut manifest = Manifest::new(vec![SceneEntry::default()], methods.iter().copied());
    manifest.budget = Budget::Spp(spp);
    manifest.seeds = 2;
    manifest.threads = 2;
    manifest.max_length = Some(MaxLength(Some(6)));
    manifest.reference = reference;
    manifest
}

/// Makes what is missing in a folder, and its tables.
fn complete(folder: &Path, manifest: Manifest, description: &SceneDescription) -> Result<Report, ExperimentError> {
    let subjects = [subject(description.clone())];
    let folder = Folder::open(folder, false)?;
    let plan = Plan::resolve(manifest, &subjects, &registry(), None, folder.manifest()?.as_ref(), "a test")?;
    let made = run(&plan, &subjects, Renderers { registry: &registry(), mitsuba: None }, &folder, &[], &mut ())?;
    assert!(made.failed.is_empty() && !made.stopped && made.elsewhere == 0);
    collect(&folder)
}

fn experiment(description: &SceneDescription, methods: &[&str], spp: u64, reference: ReferencePolicy) -> Report {
    let folder = tempfile::tempdir().unwrap();
    complete(folder.path(), manifest(methods, spp, reference), description).unwrap()
}

fn verdicts(report: &Report) -> Vec<(&str, &str, &str)> {
    report.agreement.iter().map(|row| (row.method.as_str(), row.against.as_str(), row.verdict.as_str())).collect()
}

#[test]
fn methods_that_estimate_the_same_image_agree_and_meet_the_exact_answer() {
    let report = experiment(&enclosure(), &["path", "path_bsdf", "light"], 128, ReferencePolicy::Scene);
    let expected = [
        ("path", "exact", "agree"),
        ("path_bsdf", "exact", "agree"),
        ("light", "exact", "agree"),
        ("path_bsdf", "path", "agree"),
        ("light", "path", "agree"),
    ];
    assert_eq!(verdicts(&report), expected);
    assert!(!report.differs() && report.missing == 0);
}

/// Its power is all but one: 2 % is over ten standard errors of the image's mean.
#[test]
fn a_bias_of_two_percent_differs_from_other_methods_and_from_the_exact_answer() {
    let report = experiment(&enclosure(), &["path", "biased"], 128, ReferencePolicy::Scene);
    let expected = [("path", "exact", "agree"), ("biased", "exact", "differ"), ("biased", "path", "differ")];
    assert_eq!(verdicts(&report), expected);
    assert!(report.differs());
    let room = scenes::room(FilmSize { width: 32, height: 32 });
    let report = experiment(&room, &["path", "biased"], 256, ReferencePolicy::None);
    assert_eq!(verdicts(&report), [("biased", "path", "differ")]);
    assert!(report.rows.iter().all(|row| row.mse.is_none()));
}

/// What is planted is found, and nothing else; the report says where. Passes are so many that 1 % of the image shows with the
/// probability that the test names.
#[test]
fn a_bias_of_one_percent_and_one_beside_the_lamp_are_named_and_an_honest_twin_is_not() {
    let room = scenes::room(FilmSize { width: 32, height: 32 });
    let report = experiment(&room, &["path", "honest", "slightly", "lacking"], 512, ReferencePolicy::None);
    let expected = [("honest", "path", "agree"), ("slightly", "path", "differ"), ("lacking", "path", "differ")];
    assert_eq!(verdicts(&report), expected);
    let [honest, slightly, lacking] = report.agreement.as_slice() else { panic!("three tests") };
    assert!(honest.image_detectable.unwrap() < 0.01 && honest.power >= 0.9, "{honest:?}");
    assert!((slightly.image_difference - 0.01).abs() < 4.0 * slightly.image_error, "{slightly:?}");
    assert!(lacking.worst_t.unwrap() < -6.0, "{lacking:?}");
}

#[test]
fn light_tracing_agrees_where_glass_is_seen_because_those_blocks_are_left_out_for_it_alone() {
    let film = FilmSize { width: 80, height: 48 };
    let mut description = scenes::enclosure(Rgb::WHITE, Rgb::grey(0.5), film);
    let glass = pathspace::scene::description::BsdfDescription::dielectric(1.5, 1.0);
    description.materials.push(scenes::material("glass", glass, Rgb::BLACK));
    let centre = glam::DVec3::new(-0.05, 0.0, 0.0);
    let ball = pathspace::scene::description::Sphere::new("ball", centre, 0.1, 1);
    description.spheres.push(ball);
    let report = experiment(&description, &["path", "light", "path_bsdf"], 128, ReferencePolicy::None);
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
    let methods = ["path:roulette=off", "light:heuristic=power:exponent=3"];
    let first = temporary.path().join("first");
    complete(&first, manifest(&methods, 5, ReferencePolicy::Scene), &enclosure()).unwrap();

    let mut again = Manifest::read(&first.join("experiment.toml")).unwrap();
    let record = again.record.as_ref().unwrap();
    assert_eq!(record.scenes[0].settings[methods[1]]["exponent"], "3");
    again.threads = 1;
    let second = temporary.path().join("second");
    complete(&second, again, &enclosure()).unwrap();
    let rows = cells(&first, &REPEATED);
    assert_eq!(rows, cells(&second, &REPEATED));
    let spp: Vec<&str> = rows[..4].iter().map(|row| row[4].as_str()).collect();
    assert_eq!(spp, ["1", "2", "4", "5"]);
    let seeds: Vec<&str> = rows.iter().step_by(4).map(|row| row[2].as_str()).collect();
    assert_eq!(seeds, ["1", "3", "2", "4"]);
    for method in ["path_roulette_off", "light_heuristic_power_exponent_3"] {
        assert!(first.join(format!("images/enclosure/{method}.png")).is_file());
        assert!(first.join(format!("images/enclosure/{method}.exr")).is_file());
    }
    fs::write(first.join("mine.txt"), "kept").unwrap();
    Folder::open(&first, true).unwrap();
    assert!(!first.join("rows.csv").exists() && !first.join("runs").exists() && first.join("mine.txt").exists());
}

#[test]
fn an_experiment_grows_by_seeds_and_methods_and_keeps_what_is_there() {
    let temporary = tempfile::tempdir().unwrap();
    let of = |methods: &[&str]| manifest(methods, 3, ReferencePolicy::Scene);
    complete(temporary.path(), of(&["path"]), &enclosure()).unwrap();
    let before = cells(temporary.path(), &["seed", "render_seconds"]);
    let mut more = of(&["light", "path"]);
    more.seeds = 3;
    let report = complete(temporary.path(), more.clone(), &enclosure()).unwrap();
    assert_eq!((report.missing, report.summary.len()), (0, 2));
    let after = cells(temporary.path(), &["seed", "render_seconds"]);
    assert_eq!(before, after[..before.len()], "the same runs, not others with the same seeds");
    assert_eq!(after.len(), before.len() / 2 * 6);

    // All at once gives the same.
    let other = tempfile::tempdir().unwrap();
    let mut at_once = of(&["path", "light"]);
    at_once.seeds = 3;
    complete(other.path(), at_once, &enclosure()).unwrap();
    assert_eq!(cells(temporary.path(), &REPEATED), cells(other.path(), &REPEATED));

    // Fewer methods than there are: the tables still tell of all.
    let report = complete(temporary.path(), of(&["light"]), &enclosure()).unwrap();
    assert_eq!((report.missing, report.summary.len()), (0, 2));

    let refused = |manifest: Manifest, part: &str| {
        let error = complete(temporary.path(), manifest, &enclosure()).unwrap_err().to_string();
        assert!(error.contains(part) && error.contains("--force"), "{error}");
    };
    refused(manifest(&["path"], 4, ReferencePolicy::Scene), "budget { spp = 3 }, not { spp = 4 }");
    refused(manifest(&["path"], 3, ReferencePolicy::None), "reference");
    let mut other_settings = of(&["path:roulette=off"]);
    other_settings.methods[0].0.name = Some("path".into());
    refused(other_settings, "settings");
}

#[test]
fn half_a_run_does_not_count_and_a_damaged_one_is_told() {
    let temporary = tempfile::tempdir().unwrap();
    let of = || manifest(&["path"], 3, ReferencePolicy::Scene);
    complete(temporary.path(), of(), &enclosure()).unwrap();
    let rows = cells(temporary.path(), &REPEATED);
    let run = temporary.path().join("runs/enclosure/path/1");
    // As a process leaves it that was killed while it wrote.
    let part = temporary.path().join("runs/enclosure/path/.1.part");
    fs::rename(&run, &part).unwrap();
    fs::remove_file(part.join("run.json")).unwrap();
    let subjects = [subject(enclosure())];
    let folder = Folder::open(temporary.path(), false).unwrap();
    let plan = Plan::resolve(of(), &subjects, &registry(), None, None, "a test").unwrap();
    assert_eq!(missing(&plan, &folder).unwrap(), ["enclosure/path/1"]);
    assert_eq!(collect(&folder).unwrap().missing, 1);
    complete(temporary.path(), of(), &enclosure()).unwrap();
    assert_eq!(cells(temporary.path(), &REPEATED), rows);
    assert!(!part.exists());
    fs::write(run.join("run.json"), "{").unwrap();
    let error = complete(temporary.path(), of(), &enclosure()).unwrap_err().to_string();
    assert!(error.contains("run.json") && error.contains("remove"), "{error}");
}

/// 2 % are over five standard errors of the image's mean, the reference's included.
#[test]
fn a_biased_method_is_named_beside_a_reference_that_is_an_image_with_its_error() {
    let (temporary, room) = (tempfile::tempdir().unwrap(), scenes::room(FilmSize { width: 32, height: 32 }));
    let scene = scenes::build(&room);
    let mut film = Film::new(32, 32, None).unwrap();
    let path = registry().build("path", &[("max_length", "6".to_owned())]).unwrap();
    path.integrator.render(&scene, 1 << 60, &mut film, &mut Passes(4096));
    let file = temporary.path().join("reference.exr");
    write_image(&file, &film, &RenderInfo::default(), 0.0).unwrap();
    let report = experiment(&room, &["path", "biased"], 1024, ReferencePolicy::File(file));
    let against: Vec<_> = verdicts(&report).into_iter().filter(|(_, against, _)| *against == "reference").collect();
    assert_eq!(against, [("path", "reference", "agree"), ("biased", "reference", "differ")]);
}

struct Passes(u64);

impl Control for Passes {
    fn next_passes(&mut self, film: &Film) -> u64 {
        self.0 - film.passes()
    }
}

#[test]
fn the_tables_have_the_columns_that_are_documented() {
    let temporary = tempfile::tempdir().unwrap();
    let mut few = manifest(&["path", "light"], 2, ReferencePolicy::Scene);
    few.images = false;
    complete(temporary.path(), few, &enclosure()).unwrap();
    let header =
        |file: &str| fs::read_to_string(temporary.path().join(file)).unwrap().lines().next().unwrap().to_owned();
    let documented = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/src/docs/tables.md")).unwrap();
    for table in ["rows", "curves", "summary", "verdicts"] {
        let header = header(&format!("{table}.csv"));
        assert!(header.starts_with("schema,scene,"), "{header}");
        let columns =
            header.split(',').filter(|column| !["mape", "smape", "trimmed_mse", "trimmed_relmse"].contains(column));
        for column in columns {
            assert!(documented.contains(&format!("`{column}`")), "{table}.csv: {column} is not documented");
        }
    }
    assert!(header("agreement.csv").starts_with("schema,scene,method,against,verdict,image_difference,image_error,"));
    assert!(!temporary.path().join("images").exists());
    assert!(!temporary.path().join("runs/enclosure/path/1/image.exr").exists());
    let apart = cells(temporary.path(), &["load_seconds", "setup_seconds", "renderer"]);
    assert!(apart.iter().all(|row| row[0] == "0.5" && row[1] == "0.25" && row[2].starts_with("pathspace ")));
}

#[test]
fn what_makes_no_sense_is_refused_before_anything_runs() {
    let subjects = [subject(enclosure())];
    let resolve = |methods: &[&str]| {
        Plan::resolve(manifest(methods, 2, ReferencePolicy::Scene), &subjects, &registry(), None, None, "a test")
    };
    for methods in [&["pth"][..], &["path:roulete=off"], &["path", "path"], &["mitsuba:bdpt"], &[]] {
        assert!(resolve(methods).is_err_and(|error| error.is_usage()), "{methods:?}");
    }
    let plan = resolve(&["path", "mitsuba:path"]).unwrap();
    assert!(plan.scenes[0].skipped["mitsuba:path"].contains("PATHSPACE_PYTHON"));

    let mut lengths = scenes::room(FilmSize { width: 8, height: 8 });
    let refused = |description: &SceneDescription, part: &str| {
        let folder = tempfile::tempdir().unwrap();
        let error = complete(folder.path(), manifest(&["path"], 2, ReferencePolicy::Scene), description).unwrap_err();
        assert!(error.to_string().contains(part) && error.to_string().contains("--reference none"), "{error}");
        assert!(!folder.path().join("experiment.toml").exists());
    };
    refused(&lengths, "names no reference");
    lengths.reference = Some(Reference::Image { file: "none.exr".into(), max_length: None });
    refused(&lengths, "--max-length none");
    lengths.reference = Some(Reference::Image { file: "none.exr".into(), max_length: Some(6) });
    refused(&lengths, "none.exr");
}

#[test]
fn a_manifest_names_the_place_and_the_nearest_valid_name() {
    let whole = r#"
        scenes = ["box", { file = "hall.gltf", name = "hall", film = "8x8", max_length = 3, reference = "none" }]
        methods = ["path", { name = "power", integrator = "bdpt", settings = { heuristic = "power", exponent = 3 } }]
        max_length = "none"
        reference = { method = "bdpt", seconds = 5 }
        budget = { error = { metric = "relmse", target = 0.01, seconds = 5 } }
    "#;
    let manifest = Manifest::parse(whole).unwrap();
    assert_eq!(manifest.methods[1].text(), "bdpt:exponent=3:heuristic=power");
    assert_eq!(manifest.scenes[0].file, Path::new("box"));
    assert_eq!(Manifest::parse(&toml::to_string(&manifest).unwrap()).unwrap(), manifest);
    for (from, to, parts) in [
        ("max_length = \"none\"", "max_lenght = 1", ["line 4", "did you mean 'max_length'"]),
        ("film = \"8x8\"", "fim = \"8x8\"", ["line 2", "did you mean 'film'"]),
        ("settings", "setings", ["line 3", "did you mean 'settings'"]),
        ("relmse", "relmsee", ["line 6", "did you mean 'relmse'"]),
        ("error = {", "eror = {", ["line 6", "did you mean 'error'"]),
        ("target = 0.01", "target = -1", ["budget", "above 0"]),
        ("seconds = 5 }\n        budget", "seconds = -5 }\n        budget", ["reference", "expected"]),
        ("max_length = 3", "max_length = 0", ["line 2", "from 1 on"]),
        ("scenes = [", "scenes = [[],", ["line 2", "a string or a table"]),
    ] {
        let error = Manifest::parse(&whole.replacen(from, to, 1)).unwrap_err();
        assert!(parts.iter().all(|part| error.contains(part)) && !error.contains('\n'), "{to}: {error}");
    }
}
