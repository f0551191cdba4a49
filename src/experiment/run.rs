//! All runs of an experiment, one after the other.

use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::estimator::Registry;
use crate::film::{BlockStatistics, Image, RenderInfo};
use crate::report::{Row, SummaryRow, summarise};
use crate::scene::mitsuba::{ExportError, ExportOptions, export};

use super::agreement::{self, AgreementRow, Pool};
use super::error::ExperimentError;
use super::files::{Folder, file_name};
use super::mask;
use super::method::{self, Method, MethodKind, MitsubaMethod};
use super::mitsuba::{self, Mitsuba};
use super::plan::{Plan, ScenePlan};
use super::reference::{self, ReferenceChoice, Truth};
use super::{Subject, own};

/// Which run of an experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct RunId {
    /// Its number, from 1.
    pub number: usize,
    /// The number of runs.
    pub of: usize,
    /// The scene.
    pub scene: String,
    /// The method.
    pub method: String,
    /// The seed.
    pub seed: u64,
}

/// Where a run stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standing {
    /// Share of its budget that is spent.
    pub share: f64,
    /// Rendering time so far \[s\].
    pub seconds: f64,
    /// Samples per pixel so far.
    pub spp: u64,
    /// Error at the latest checkpoint, where it is known.
    pub rmse: Option<f64>,
}

/// Is told how an experiment goes on, while no clock runs.
pub trait Observer {
    /// A run begins.
    fn begin(&mut self, _run: &RunId) {}
    /// It goes on.
    fn progress(&mut self, _standing: &Standing) {}
    /// It is finished, with the row of its last checkpoint.
    fn finished(&mut self, _run: &RunId, _row: &Row) {}
    /// It was not finished.
    fn unfinished(&mut self, _run: &RunId, _why: &Unfinished) {}
    /// The user wants to end the experiment.
    fn stopped(&self) -> bool {
        false
    }
}

/// Watches nothing.
impl Observer for () {}

/// Why a run is missing.
#[derive(Clone, Debug, PartialEq)]
pub enum Unfinished {
    /// The method cannot render the scene; its other seeds are not tried.
    Unsupported(String),
    /// It went wrong.
    Failed(String),
}

/// What an experiment has found.
#[derive(Clone, Debug)]
pub struct Report {
    /// What was done, with what was skipped.
    pub plan: Plan,
    /// All checkpoints of finished runs, by scene, method and seed.
    pub rows: Vec<Row>,
    /// What they say.
    pub summary: Vec<SummaryRow>,
    /// Whether the methods agree.
    pub agreement: Vec<AgreementRow>,
    /// Runs that went wrong, and why.
    pub failed: Vec<(RunId, String)>,
    /// The user ended it early.
    pub stopped: bool,
}

impl Report {
    /// Two methods estimate different images, or one misses an exact answer.
    #[must_use]
    pub fn differs(&self) -> bool {
        self.agreement.iter().any(AgreementRow::differs)
    }
}

/// A run that is about to be made.
pub(super) struct Job<'a> {
    pub plan: &'a Plan,
    pub scene: &'a ScenePlan,
    pub label: &'a str,
    pub seed: u64,
    pub truth: &'a Truth,
    /// Blocks that light methods see, where those are not all.
    pub keep: Option<&'a [bool]>,
}

/// A run that was made.
pub(super) struct Finished {
    pub rows: Vec<Row>,
    pub image: Image,
    pub statistics: BlockStatistics,
    pub restricted: Option<BlockStatistics>,
    /// Samples per pixel of a pass of the statistics.
    pub pass_spp: u64,
}

/// How a run has ended.
pub(super) enum RunEnd {
    Finished(Box<Finished>),
    Unsupported(String),
    Failed(String),
    Stopped,
}

/// Makes all runs of a plan, and writes what it finds into `folder` as it goes. `plan` may come from
/// [`Plan::resolve`] or from the `experiment.toml` of an earlier experiment on the same scenes.
///
/// # Errors
/// When a reference cannot be used (before anything runs), or a file cannot be written.
pub fn run(
    mut plan: Plan,
    subjects: &[Subject],
    registry: &Registry,
    mitsuba: Option<&Mitsuba>,
    references: &ReferenceChoice,
    folder: Option<&Folder>,
    observer: &mut (dyn Observer + Send),
) -> Result<Report, ExperimentError> {
    if subjects.len() != plan.scenes.len() {
        return Err(ExperimentError::Usage("the plan has other scenes than are given".into()));
    }
    let mut truths = Vec::new();
    for (scene, subject) in plan.scenes.iter_mut().zip(subjects) {
        if scene.fingerprint != subject.fingerprint || scene.film != subject.scene.sensor().film() {
            let what = format!("{}: is not the scene that was planned; plan anew", subject.scene.source().display());
            return Err(ExperimentError::Scene(what));
        }
        let truth = reference::resolve(subject, scene.longest(), references)?;
        scene.reference.clone_from(&truth.words);
        truths.push(truth);
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(plan.threads).build();
    let pool = pool.map_err(|error| ExperimentError::Usage(format!("threads: {error}; ask for fewer")))?;
    let mut session =
        Session { pool, registry, mitsuba, folder, observer, rows: BTreeMap::new(), pools: BTreeMap::new() };
    let mut report = Report {
        rows: Vec::new(),
        summary: Vec::new(),
        agreement: Vec::new(),
        failed: Vec::new(),
        stopped: false,
        plan,
    };
    session.write_plan(&report.plan)?;
    for index in 0..subjects.len() {
        session.scene(index, &subjects[index], &truths[index], &mut report)?;
        if report.stopped {
            break;
        }
    }
    report.rows = session.all_rows();
    report.summary = summarise(&report.rows);
    if let Some(folder) = folder {
        folder.write_rows(&report.rows)?;
        folder.write_summary(&report.summary)?;
        folder.write_agreement(&report.agreement)?;
    }
    session.write_plan(&report.plan)?;
    Ok(report)
}

struct Session<'a> {
    pool: rayon::ThreadPool,
    registry: &'a Registry,
    mitsuba: Option<&'a Mitsuba>,
    folder: Option<&'a Folder>,
    observer: &'a mut (dyn Observer + Send),
    /// Rows of each finished run, by scene, method and repetition.
    rows: BTreeMap<(usize, usize, u32), Vec<Row>>,
    /// By scene and method.
    pools: BTreeMap<(usize, usize), Pool>,
}

impl Session<'_> {
    fn all_rows(&self) -> Vec<Row> {
        self.rows.values().flatten().cloned().collect()
    }

    fn write_plan(&self, plan: &Plan) -> Result<(), ExperimentError> {
        self.folder.map_or(Ok(()), |folder| folder.write_plan(plan))
    }

    /// All runs on one scene: seed by seed, the methods taking turns, so that a machine whose speed drifts is as fast for
    /// all of them.
    fn scene(
        &mut self,
        index: usize,
        subject: &Subject,
        truth: &Truth,
        report: &mut Report,
    ) -> Result<(), ExperimentError> {
        let labels = report.plan.methods.clone();
        let methods = labels.iter().map(|label| {
            let settings = &report.plan.scenes[index].settings;
            let settings = settings
                .get(label)
                .ok_or_else(|| ExperimentError::Usage(format!("the plan lacks the settings of {label}; plan anew")))?;
            method::rebuild(label, settings, self.registry)
        });
        let methods = methods.collect::<Result<Vec<Method>, _>>()?;
        let masked = methods.iter().any(is_light);
        let keep = if masked { self.pool.install(|| mask::blocks_without_dirac(&subject.scene)) } else { None };
        let mut exported = None;
        for repetition in 0..report.plan.seeds {
            for (number, method) in methods.iter().enumerate() {
                let label = labels[number].as_str();
                if report.plan.scenes[index].skipped.contains_key(label) {
                    continue;
                }
                let runs = labels.len() * report.plan.seeds as usize;
                let id = RunId {
                    number: index * runs + repetition as usize * labels.len() + number + 1,
                    of: runs * report.plan.scenes.len(),
                    scene: report.plan.scenes[index].name.clone(),
                    method: label.to_owned(),
                    seed: report.plan.seed_of(number, repetition),
                };
                self.observer.begin(&id);
                let job = Job {
                    plan: &report.plan,
                    scene: &report.plan.scenes[index],
                    label,
                    seed: id.seed,
                    truth,
                    keep: keep.as_deref(),
                };
                let end = match &method.kind {
                    MethodKind::Own(integrator) => {
                        own::render(integrator.as_ref(), subject, &job, &self.pool, self.observer)?
                    }
                    MethodKind::Mitsuba(wanted) => {
                        let known = self.pools.get(&(index, number)).map(|pool| pool.pass_spp);
                        self.mitsuba(wanted, subject, &job, &mut exported, known)?
                    }
                };
                match end {
                    RunEnd::Finished(run) => {
                        self.keep((index, number, repetition), &run, &job, method)?;
                        if let Some(row) = run.rows.last() {
                            self.observer.finished(&id, row);
                        }
                    }
                    RunEnd::Stopped => {
                        report.stopped = true;
                        return self.conclude(index, &methods, truth, report);
                    }
                    RunEnd::Unsupported(why) => {
                        self.observer.unfinished(&id, &Unfinished::Unsupported(why.clone()));
                        report.plan.scenes[index].skipped.insert(label.to_owned(), why);
                        self.write_plan(&report.plan)?;
                    }
                    RunEnd::Failed(why) => {
                        self.observer.unfinished(&id, &Unfinished::Failed(why.clone()));
                        report.failed.push((id, why));
                    }
                }
            }
        }
        self.conclude(index, &methods, truth, report)
    }

    /// Remembers and writes a finished run.
    fn keep(
        &mut self,
        place: (usize, usize, u32),
        run: &Finished,
        job: &Job<'_>,
        method: &Method,
    ) -> Result<(), ExperimentError> {
        self.rows.insert(place, run.rows.clone());
        self.pools.entry((place.0, place.1)).or_insert_with(|| Pool::new(run)).add(run);
        let (Some(folder), Some(row)) = (self.folder, run.rows.last()) else { return Ok(()) };
        folder.write_rows(&self.all_rows())?;
        let info = RenderInfo {
            scene: job.scene.name.clone(),
            integrator: method.name.clone(),
            settings: serde_json::json!(method.settings),
            seed: job.seed,
            render_seconds: row.render_seconds,
            cpu_seconds: row.cpu_seconds.unwrap_or(0.0),
            version: env!("CARGO_PKG_VERSION").into(),
        };
        folder.write_image(&run.image, job.label, &info, row.spp)
    }

    /// Tests the finished runs of a scene against each other, and writes their mean images.
    fn conclude(
        &mut self,
        index: usize,
        methods: &[Method],
        truth: &Truth,
        report: &mut Report,
    ) -> Result<(), ExperimentError> {
        let scene = report.plan.scenes[index].name.clone();
        let labels = &report.plan.methods;
        let pools: Vec<(usize, &Pool)> =
            (0..methods.len()).filter_map(|number| Some((number, self.pools.get(&(index, number))?))).collect();
        for &(number, pool) in &pools {
            if let Some(folder) = self.folder {
                folder.write_mean(&pool.mean_image(), &scene, &labels[number])?;
            }
            if let Some(exact) = truth.exact {
                let light = is_light(&methods[number]);
                report.agreement.extend(agreement::with_exact(&scene, &labels[number], pool, exact, light)?);
            }
        }
        let is_base = |number: usize| matches!(methods[number].kind, MethodKind::Mitsuba(_));
        let (mut bases, mut others): (Vec<_>, Vec<_>) = pools.iter().partition(|(number, _)| is_base(*number));
        if bases.is_empty() && !others.is_empty() {
            bases.push(others.remove(0));
        }
        // Where the first one decides nothing, because its passes are heavy-tailed, the next may.
        for (i, &(base, base_pool)) in bases.iter().enumerate() {
            let mut open = Vec::new();
            let later = if i == 0 { &bases[1..] } else { &[] };
            for &(number, pool) in others.iter().chain(later) {
                let light = is_light(&methods[number]) || is_light(&methods[base]);
                let names = (scene.as_str(), labels[number].as_str(), labels[base].as_str());
                let row = agreement::between(names, pool, base_pool, light)?;
                if row.as_ref().is_some_and(AgreementRow::is_undecided) && !is_base(number) {
                    open.push((number, pool));
                }
                report.agreement.extend(row);
            }
            others = open;
            if others.is_empty() {
                break;
            }
        }
        if let Some(folder) = self.folder {
            folder.write_agreement(&report.agreement)?;
        }
        Ok(())
    }

    fn mitsuba(
        &mut self,
        wanted: &MitsubaMethod,
        subject: &Subject,
        job: &Job<'_>,
        exported: &mut Option<PathBuf>,
        pass_spp: Option<u64>,
    ) -> Result<RunEnd, ExperimentError> {
        let (Some(mitsuba), Some(folder)) = (self.mitsuba, self.folder) else {
            return Ok(RunEnd::Unsupported("Mitsuba needs a Python and a folder to write into".into()));
        };
        let folder = folder.mitsuba(&job.scene.name);
        let file = match exported {
            Some(file) => file.clone(),
            None => {
                let options =
                    ExportOptions { film: job.scene.film, max_length: job.scene.longest(), ..ExportOptions::default() };
                match export(&subject.description, &options, &folder) {
                    Ok(file) => exported.insert(file).clone(),
                    Err(error @ ExportError::Unsupported { .. }) => return Ok(RunEnd::Unsupported(error.to_string())),
                    Err(error) => return Err(error.into()),
                }
            }
        };
        let run = folder.join(file_name(job.label)).join(format!("seed_{}", job.seed));
        mitsuba::render(mitsuba, wanted, job, &file, &run, pass_spp, self.observer)
    }
}

fn is_light(method: &Method) -> bool {
    mask::LIGHT_METHODS.contains(&method.name.as_str())
}
