//! `compare`: scenes × methods × seeds, beside Mitsuba.

use std::io::{self, IsTerminal, Write};
use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use crate::estimator::Registry;
use crate::experiment::{
    self, AgreementRow, Budget, Folder, Mitsuba, Observer, Plan, ReferenceChoice, Report, Request, RunId, Standing,
    Subject, Unfinished,
};
use crate::report::{Row, tables};
use crate::scene::description::FilmSize;
use crate::scene::{LightSelection, Scene, SceneOptions};

use super::args::{self, MaxLength};
use super::progress::time;
use super::scene::{self, LoadOptions};
use super::{Outcome, UsageError, complain, interrupt};

const AFTER_HELP: &str = "\
Methods: an integrator of `pathspace list` with settings (bdpt:heuristic=power), mitsuba:path, mitsuba:ptracer; Mitsuba's
take variant=auto|scalar_rgb|llvm_ad_rgb, rr_depth=N, max_length=N. A method that cannot render a scene is skipped and told.

Every run has a seed of its own, --seed and the numbers after it in the order of the runs, so that methods are independent.
Written into DIR: experiment.toml, rows.csv (after every run), summary.csv, agreement.csv, images/.

Exit code 3: two methods estimate different images (verdict `differ`), or one misses an exact reference by more than 4
standard errors. Before speed is compared, that has to be understood.

Example:
  pathspace compare cornell_box veach_mis --seconds 30 --seeds 4 -o results/two";

const OWN_METHODS: [&str; 3] = ["path", "light", "bdpt"];
const MITSUBA_METHODS: [&str; 2] = ["mitsuba:path", "mitsuba:ptracer"];
const DEFAULT_SECONDS: f64 = 8.0;

/// Compare methods on scenes: error against rendering time, beside Mitsuba
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct CompareArgs {
    /// .gltf or .glb files, folders with one, or names of folders in scenes/
    #[arg(required = true)]
    scenes: Vec<PathBuf>,

    /// Methods [default: path,light,bdpt, and mitsuba:path,mitsuba:ptracer where there is a Python with Mitsuba]
    #[arg(long, value_name = "METHOD,…", value_delimiter = ',')]
    methods: Vec<String>,

    /// Rendering time of each run in seconds [default: 8]
    #[arg(long, value_name = "SECONDS", value_parser = args::seconds)]
    seconds: Option<f64>,

    /// Samples per pixel of each run instead; with it, images are the same every time
    #[arg(long, value_name = "N", conflicts_with = "seconds", value_parser = clap::value_parser!(u64).range(1..=1 << 31))]
    spp: Option<u64>,

    /// Runs of each method on each scene
    #[arg(long, value_name = "R", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    seeds: u32,

    /// The first seed
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(..1 << 62))]
    seed: u64,

    /// Threads that render; 0 takes all that the machine has
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(..=1024))]
    threads: u16,

    /// Longest path in edges, or none for unlimited; equals Mitsuba's max_depth [default: each scene's]
    #[arg(long, value_name = "EDGES", value_parser = args::max_length)]
    max_length: Option<MaxLength>,

    /// How one of several emitters is chosen: in proportion to its flux, or all alike as Mitsuba does
    #[arg(long, value_name = "HOW", default_value = "power",
          value_parser = args::light_selection())]
    light_selection: LightSelection,

    /// Image size in pixels [default: each scene's]
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = args::film_size)]
    film: Option<FilmSize>,

    /// What errors are measured against: an EXR file, or none [default: what each scene names]
    #[arg(long, value_name = "FILE.exr|none")]
    reference: Option<PathBuf>,

    /// Folder to write into; made where it is missing
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,

    /// Write over an experiment that is in the folder
    #[arg(long)]
    force: bool,

    /// Write no images
    #[arg(long)]
    no_images: bool,
}

pub(super) fn run(registry: &Registry, args: &CompareArgs) -> anyhow::Result<Outcome> {
    interrupt::listen()?;
    let references = references(args)?;
    let (methods, mitsuba) = methods(args)?;
    let request = Request {
        methods,
        budget: args.spp.map_or(Budget::Seconds(args.seconds.unwrap_or(DEFAULT_SECONDS)), Budget::Spp),
        seed: args.seed,
        seeds: args.seeds,
        threads: threads(args.threads),
        max_length: args.max_length.map(|length| length.0),
        light_selection: args.light_selection,
        command: std::env::args().collect::<Vec<_>>().join(" "),
    };
    let subjects = args.scenes.iter().map(|word| load(word, args)).collect::<anyhow::Result<Vec<_>>>()?;
    let plan = Plan::resolve(&request, &subjects, registry, mitsuba.as_ref()).map_err(usage)?;
    for (subject, scene) in subjects.iter().zip(&plan.scenes) {
        experiment::check_reference(subject, scene, &references).map_err(usage)?;
        for (method, why) in &scene.skipped {
            complain("note", &format!("{}: {method} is skipped: {why}", scene.name));
        }
    }
    let folder = Folder::create(&args.output, args.force, !args.no_images).map_err(usage)?;
    let mut watch = Watch::new(plan.budget);
    let report = experiment::run(plan, &subjects, registry, mitsuba.as_ref(), &references, Some(&folder), &mut watch)
        .map_err(usage)?;
    watch.bar.finish_and_clear();
    show(&report, &args.output)?;
    Ok(outcome(&report))
}

fn outcome(report: &Report) -> Outcome {
    for row in report.agreement.iter().filter(|row| row.differs()) {
        complain("DIFFER", &format!("{}: {} against {}: {}", row.scene, row.method, row.against, row.details));
    }
    for (run, why) in &report.failed {
        complain("error", &format!("{}: {}, seed {}: {why}", run.scene, run.method, run.seed));
    }
    if report.stopped {
        Outcome::Interrupted
    } else if report.differs() {
        Outcome::Differ
    } else if report.failed.is_empty() {
        Outcome::Done
    } else {
        Outcome::Failed
    }
}

/// An error that the user's words have caused is told apart by the exit code.
fn usage(error: experiment::ExperimentError) -> anyhow::Error {
    if error.is_usage() { UsageError(error.to_string()).into() } else { error.into() }
}

fn references(args: &CompareArgs) -> anyhow::Result<ReferenceChoice> {
    match &args.reference {
        None => Ok(ReferenceChoice::Scene),
        Some(word) if word.as_os_str() == "none" => Ok(ReferenceChoice::None),
        Some(_) if args.scenes.len() > 1 => {
            Err(UsageError("--reference FILE serves one scene; compare the others apart".into()).into())
        }
        Some(file) => Ok(ReferenceChoice::File(file.clone())),
    }
}

/// The methods to compare. Mitsuba is looked for where it is wanted; where it is only the default, its absence is told.
fn methods(args: &CompareArgs) -> anyhow::Result<(Vec<String>, Option<Mitsuba>)> {
    let asked: Vec<String> = args.methods.iter().map(|method| method.trim().to_owned()).collect();
    let own = || OWN_METHODS.map(str::to_owned).to_vec();
    if !asked.is_empty() && !asked.iter().any(|method| method.starts_with("mitsuba:")) {
        return Ok((asked, None));
    }
    match Mitsuba::find(interrupt::requested) {
        Ok(mitsuba) => {
            if let Some(advice) = mitsuba.advice() {
                complain("note", advice);
            }
            let default = || own().into_iter().chain(MITSUBA_METHODS.map(str::to_owned)).collect();
            Ok((if asked.is_empty() { default() } else { asked }, Some(mitsuba)))
        }
        Err(why) => {
            complain("note", &format!("without Mitsuba: {why}"));
            Ok((if asked.is_empty() { own() } else { asked }, None))
        }
    }
}

fn threads(asked: u16) -> usize {
    match asked {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        asked => asked.into(),
    }
}

fn load(word: &std::path::Path, args: &CompareArgs) -> anyhow::Result<Subject> {
    let start = Instant::now();
    let options = LoadOptions { film: args.film, light_selection: args.light_selection, ..LoadOptions::default() };
    let loaded = scene::load(word, &options)?;
    let all = start.elapsed().as_secs_f64();
    scene::show(&loaded.notes);
    // Built once more, to tell its time from that of reading.
    let start = Instant::now();
    let again = SceneOptions { film: args.film, light_selection: args.light_selection };
    Scene::build(&loaded.description, again)?;
    let build_seconds = start.elapsed().as_secs_f64();
    let load_seconds = (all - build_seconds).max(0.0);
    let fingerprint = scene::fingerprint(&loaded.description);
    Ok(Subject { scene: loaded.scene, description: loaded.description, fingerprint, load_seconds, build_seconds })
}

/// Shows a bar in a terminal, and in a pipe a line for each finished run.
struct Watch {
    bar: ProgressBar,
    budget: Budget,
    run: Option<(RunId, Instant)>,
    rmse: Option<f64>,
    /// Wall-clock time of all finished runs \[s\].
    spent: f64,
    finished: u32,
}

impl Watch {
    fn new(budget: Budget) -> Self {
        let bar = if io::stderr().is_terminal() { ProgressBar::new(1000) } else { ProgressBar::hidden() };
        let style = ProgressStyle::with_template("[{bar:16}] {msg}").unwrap_or_else(|_| ProgressStyle::default_bar());
        bar.set_style(style.progress_chars("=> "));
        Self { bar, budget, run: None, rmse: None, spent: 0.0, finished: 0 }
    }

    fn end(&mut self) {
        if let Some((_, start)) = self.run.take() {
            self.spent += start.elapsed().as_secs_f64();
            self.finished += 1;
        }
    }

    fn tell(&self, line: &str) {
        if self.bar.is_hidden() {
            let _ = writeln!(io::stderr(), "{line}");
        }
    }

    /// For this run and all that follow \[s\].
    fn seconds_left(&self, run: &RunId, standing: &Standing) -> f64 {
        let of_a_run = match self.budget {
            Budget::Seconds(seconds) => seconds,
            Budget::Spp(_) if self.finished > 0 => self.spent / f64::from(self.finished),
            Budget::Spp(_) => standing.seconds / standing.share,
        };
        of_a_run * ((1.0 - standing.share).max(0.0) + (run.of - run.number) as f64)
    }
}

fn title(run: &RunId) -> String {
    format!("{}/{} {} {} seed {}", run.number, run.of, run.scene, run.method, run.seed)
}

impl Observer for Watch {
    fn begin(&mut self, run: &RunId) {
        self.run = Some((run.clone(), Instant::now()));
        self.rmse = None;
        self.bar.set_position(1000 * (run.number as u64 - 1) / run.of as u64);
        self.bar.set_message(title(run));
    }

    fn progress(&mut self, standing: &Standing) {
        let Some((run, _)) = &self.run else { return };
        if self.bar.is_hidden() {
            return;
        }
        let done = (run.number as f64 - 1.0 + standing.share.clamp(0.0, 1.0)) / run.of as f64;
        self.bar.set_position((1000.0 * done) as u64);
        let rmse = standing.rmse.map_or_else(String::new, |rmse| format!(", RMSE {rmse:.2e}"));
        let left = time(self.seconds_left(run, standing));
        self.bar.set_message(format!("{}: {} spp{rmse}, {left} left", title(run), standing.spp));
    }

    fn finished(&mut self, run: &RunId, row: &Row) {
        self.end();
        let rmse = row.rmse.map_or_else(String::new, |rmse| format!(", RMSE {rmse:.3e}"));
        self.tell(&format!("{}: {} spp in {:.2} s{rmse}", title(run), row.spp, row.render_seconds));
    }

    fn unfinished(&mut self, run: &RunId, why: &Unfinished) {
        self.end();
        let (what, why) = match why {
            Unfinished::Unsupported(why) => ("is skipped", why),
            Unfinished::Failed(why) => ("failed", why),
        };
        self.bar.suspend(|| complain("note", &format!("{}: {} {what}: {why}", run.scene, run.method)));
    }

    fn stopped(&self) -> bool {
        interrupt::requested()
    }
}

fn show(report: &Report, folder: &std::path::Path) -> io::Result<()> {
    let mut out = io::stdout().lock();
    for scene in &report.plan.scenes {
        for (method, why) in &scene.skipped {
            writeln!(out, "skipped: {}, {method}: {why}", scene.name)?;
        }
    }
    for rows in report.agreement.chunk_by(|a, b| a.scene == b.scene) {
        for rows in rows.chunk_by(|a, b| a.against == b.against) {
            write!(out, "{}", agreement_table(rows))?;
        }
        write!(out, "{}", agreement_note(rows))?;
    }
    writeln!(out, "\n{}", tables(&report.summary))?;
    writeln!(out, "wrote {}", folder.display())?;
    out.flush()
}

/// One line for each method, in 80 columns.
fn agreement_table(rows: &[AgreementRow]) -> String {
    let Some(first) = rows.first() else { return String::new() };
    let against = if first.against == "exact" { "the exact answer" } else { first.against.as_str() };
    let mut text = format!("{}: same image as {against}?\n", first.scene);
    let width = rows.iter().map(|row| row.method.chars().count()).max().unwrap_or(0).min(24);
    for row in rows {
        let verdict = match row.verdict.as_str() {
            "differ" => "DIFFER",
            verdict => verdict,
        };
        let method: String = row.method.chars().take(24).collect();
        let difference = format!("{:+.3} ± {:.3} %", 100.0 * row.image_difference, 100.0 * row.image_error);
        let reach = match (row.image_detectable, row.block_detectable) {
            (Some(image), Some(block)) => {
                format!("finds {:.2} %, in a block {:.1} %", 100.0 * image, 100.0 * block)
            }
            _ => format!("at most {:.1} standard errors", row.worst_t.unwrap_or(f64::NAN).abs()),
        };
        text += &format!("  {method:width$}  {verdict}: {difference}; {reach}\n");
    }
    text
}

/// What the tables of a scene mean.
fn agreement_note(rows: &[AgreementRow]) -> String {
    let Some(row) = rows.iter().find(|row| row.image_detectable.is_some()) else { return String::new() };
    let masked = rows.iter().map(|row| row.blocks_masked).max().unwrap_or(0);
    let mut text = format!("  (finds: differences that show with probability {}", row.power);
    if masked > 0 {
        text += &format!("; light tracing: without {masked} blocks that see Dirac surfaces");
    }
    text + ")\n"
}
