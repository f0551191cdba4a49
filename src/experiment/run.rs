//! All runs of an experiment that are not there yet, one after the other.

use std::fs;
use std::path::{Path, PathBuf};

use crate::estimator::Registry;
use crate::film::{BlockStatistics, Image, RenderInfo};
use crate::names::did_you_mean;
use crate::report::flip::flip;
use crate::report::{Errors, Metric, Row};
use crate::scene::mitsuba::ExportError;
use crate::spectrum::Rgb;

use super::budget::Budget;
use super::cache::{self, Cache};
use super::error::ExperimentError;
use super::files::Folder;
use super::job::{Claim, Identity, RunFile, read_run};
use super::mask;
use super::method::{self, Method, MethodKind, MitsubaMethod};
use super::mitsuba::{self, Mitsuba};
use super::plan::{MethodPlan, Plan, ScenePlan};
use super::reference::{self, Truth};
use super::{Subject, own};

/// Which run of an experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct RunId {
    /// Its number, from 1.
    pub number: usize,
    /// The number of runs to make.
    pub of: usize,
    /// The scene.
    pub scene: String,
    /// The method.
    pub method: String,
    /// The seed.
    pub seed: u64,
}

/// Where a run stands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Standing {
    /// Share of its budget that is spent.
    pub share: f64,
    /// Rendering time so far \[s\].
    pub seconds: f64,
    /// Samples per pixel so far.
    pub spp: u64,
    /// Error at the latest checkpoint, where it is known.
    pub rmse: Option<f64>,
    /// Of a reference: its noise, see [`super::cache::Kept::noise`].
    pub noise: Option<f64>,
    /// Rendering time left, where that is known better than from the budget \[s\].
    pub seconds_left: Option<f64>,
}

/// Is told how an experiment goes on, while no clock runs.
pub trait Observer {
    /// So many runs were there already.
    fn kept(&mut self, _finished: usize) {}
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

/// A run that is about to be made.
pub(super) struct Job<'a> {
    pub plan: &'a Plan,
    pub scene: &'a ScenePlan,
    pub method: &'a MethodPlan,
    pub seed: u64,
    pub truth: &'a Truth,
    /// Blocks that light methods see, where those are not all.
    pub keep: Option<&'a [bool]>,
}

impl Job<'_> {
    pub fn budget(&self) -> Budget {
        self.plan.manifest.budget
    }

    /// The row with the errors of its image.
    pub fn measured(&self, row: Row, image: &Image) -> Result<Row, ExperimentError> {
        Ok(match &self.truth.reference {
            Some(reference) => {
                let wants_flip = self.plan.manifest.metrics.contains(&Metric::Flip);
                let flip = wants_flip.then(|| flip(image, &reference.mean)).flatten();
                Row { flip, ..row.with_errors(&Errors::between(image, reference)?) }
            }
            None => row,
        })
    }

    fn identity(&self, method: &Method) -> Identity {
        Identity {
            scene: self.scene.name.clone(),
            fingerprint: self.scene.fingerprint.clone(),
            film: (self.scene.film.width, self.scene.film.height),
            max_length: self.scene.max_length.clone(),
            light_selection: self.plan.manifest.light_selection,
            reference: self.truth.fingerprint(),
            method: self.method.label.clone(),
            integrator: method.name.clone(),
            settings: method.settings.clone(),
            seed: self.seed,
            budget: self.budget(),
        }
    }
}

/// A run that was made.
#[derive(Clone)]
pub(super) struct Finished {
    pub rows: Vec<Row>,
    /// The mean of all samples, where images are kept.
    pub image: Option<Image>,
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

/// What can render.
#[derive(Clone, Copy)]
pub struct Renderers<'a> {
    /// The integrators of this program.
    pub registry: &'a Registry,
    /// Mitsuba, where there is one.
    pub mitsuba: Option<&'a Mitsuba>,
}

/// What became of the runs that were missing.
#[derive(Clone, Debug, Default)]
pub struct Made {
    /// Runs that were made.
    pub finished: usize,
    /// Runs that went wrong, and why.
    pub failed: Vec<(RunId, String)>,
    /// Runs that other processes are making.
    pub elsewhere: usize,
    /// The user ended it early.
    pub stopped: bool,
}

/// Makes the runs of a plan that `folder` does not hold yet; of these only `jobs`, written `SCENE/METHOD/SEED`, if there are any.
/// `plan` was resolved with the manifest that the folder holds. What the runs say is for [`super::collect`] to tell.
///
/// # Errors
/// When a reference cannot be used or a run of the folder was made otherwise (before anything runs), or a file cannot be written.
pub fn run(
    plan: &Plan,
    subjects: &[Subject],
    renderers: Renderers<'_>,
    folder: &Folder,
    jobs: &[String],
    observer: &mut (dyn Observer + Send),
) -> Result<Made, ExperimentError> {
    if subjects.len() != plan.scenes.len() {
        return Err(ExperimentError::Usage("the plan has other scenes than are given".into()));
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(plan.machine.threads).build();
    let pool = pool.map_err(|error| ExperimentError::Usage(format!("threads: {error}; ask for fewer")))?;
    let mut plan = plan.clone();
    let mut truths = Vec::new();
    for ((scene, subject), entry) in plan.scenes.iter_mut().zip(subjects).zip(&plan.manifest.scenes) {
        let policy = entry.reference.as_ref().unwrap_or(&plan.manifest.reference);
        let Renderers { registry, mitsuba } = renderers;
        let mut cache = Cache { folder: cache::default_folder(), registry, mitsuba, pool: &pool, observer };
        let truth = reference::resolve(subject, scene, policy, &mut cache)?;
        scene.reference.clone_from(&truth.words);
        scene.exact = truth.exact.map(Rgb::to_array);
        truths.push(truth);
    }
    let mut session = Session { pool, renderers, folder, observer, plan, truths, subjects };
    let pending = session.pending(jobs)?;
    session.write_plan()?;
    for (scene, truth) in session.plan.scenes.iter().zip(&session.truths) {
        folder.write_reference(&scene.name, truth)?;
    }
    let made = session.all(pending)?;
    session.write_plan()?;
    Ok(made)
}

/// The runs of a plan that its folder does not hold, `SCENE/METHOD/SEED`.
///
/// # Errors
/// When a run of the folder is damaged.
pub fn missing(plan: &Plan, folder: &Folder) -> Result<Vec<String>, ExperimentError> {
    let mut missing = Vec::new();
    for run in all(plan, folder) {
        if read_run(&run.place)?.is_none() {
            missing.push(run.name);
        }
    }
    Ok(missing)
}

/// A run of a plan.
struct Pending {
    /// Place of its scene in the plan.
    scene: usize,
    /// Place of its method.
    method: usize,
    seed: u64,
    /// `SCENE/METHOD/SEED`.
    name: String,
    /// Its folder.
    place: PathBuf,
}

/// Seed by seed, the methods taking turns, so that a machine whose speed drifts is as fast for all of them.
fn all(plan: &Plan, folder: &Folder) -> Vec<Pending> {
    let mut runs = Vec::new();
    for repetition in 0..plan.manifest.seeds {
        for (scene, scene_plan) in plan.scenes.iter().enumerate() {
            let able = |method: &&MethodPlan| !scene_plan.skipped.contains_key(&method.label);
            for method in plan.methods.iter().filter(able) {
                let seed = plan.seed_of(method, repetition);
                let place = folder.run(&scene_plan.name, &method.label, seed);
                let name = place.strip_prefix(folder.runs()).unwrap_or(&place).to_string_lossy().into_owned();
                let method = plan.methods.iter().position(|other| other == method).unwrap_or_default();
                runs.push(Pending { scene, method, seed, name, place });
            }
        }
    }
    runs
}

struct Session<'a> {
    pool: rayon::ThreadPool,
    renderers: Renderers<'a>,
    folder: &'a Folder,
    observer: &'a mut (dyn Observer + Send),
    plan: Plan,
    truths: Vec<Truth>,
    subjects: &'a [Subject],
}

impl Session<'_> {
    fn write_plan(&self) -> Result<(), ExperimentError> {
        let recorded = self.plan.recorded(self.folder.manifest()?.as_ref());
        self.folder.write_manifest(&recorded)
    }

    fn method(&self, scene: usize, method: usize) -> Result<Method, ExperimentError> {
        method::build(&self.plan.methods[method].text, self.renderers.registry, &self.plan.scenes[scene].max_length)
    }

    fn job<'a>(&'a self, pending: &Pending, keep: Option<&'a [bool]>) -> Job<'a> {
        Job {
            plan: &self.plan,
            scene: &self.plan.scenes[pending.scene],
            method: &self.plan.methods[pending.method],
            seed: pending.seed,
            truth: &self.truths[pending.scene],
            keep,
        }
    }

    /// What is to be made, after a look at what is there.
    fn pending(&mut self, jobs: &[String]) -> Result<Vec<Pending>, ExperimentError> {
        let all = all(&self.plan, self.folder);
        if let Some(unknown) = jobs.iter().find(|job| !all.iter().any(|run| run.name == **job)) {
            let suggestion = did_you_mean(unknown, all.iter().map(|run| run.name.as_str()));
            return Err(ExperimentError::Usage(format!("there is no job '{unknown}'{suggestion}")));
        }
        let (mut pending, mut kept) = (Vec::new(), 0);
        for run in all.into_iter().filter(|run| jobs.is_empty() || jobs.contains(&run.name)) {
            match read_run(&run.place)? {
                Some(found) => self.check(&run, &found.identity)?,
                None => {
                    pending.push(run);
                    continue;
                }
            }
            kept += 1;
        }
        self.observer.kept(kept);
        Ok(pending)
    }

    /// A run of the folder is what this plan would make.
    fn check(&self, run: &Pending, found: &Identity) -> Result<(), ExperimentError> {
        let wanted = self.job(run, None).identity(&self.method(run.scene, run.method)?);
        let Some(difference) = found.difference(&wanted) else { return Ok(()) };
        Err(ExperimentError::Scene(format!(
            "{}: was made with {difference}; choose another folder, or --force to start anew",
            run.place.display()
        )))
    }

    fn all(&mut self, mut pending: Vec<Pending>) -> Result<Made, ExperimentError> {
        let mut made = Made::default();
        let of = pending.len();
        let mut masks: Vec<Option<Option<Vec<bool>>>> = vec![None; self.plan.scenes.len()];
        let mut number = 0;
        // What others are making is looked at once more: they may have crashed.
        for round in 0..2 {
            let mut elsewhere = Vec::new();
            for run in pending {
                if self.plan.scenes[run.scene].skipped.contains_key(&self.plan.methods[run.method].label) {
                    continue;
                }
                let Some(claim) = Claim::take(&run.place)? else {
                    elsewhere.push(run);
                    continue;
                };
                if read_run(&run.place)?.is_some() {
                    continue;
                }
                number += 1;
                let keep = masks[run.scene].get_or_insert_with(|| self.mask(run.scene)).clone();
                let id = RunId {
                    number,
                    of,
                    scene: self.plan.scenes[run.scene].name.clone(),
                    method: self.plan.methods[run.method].label.clone(),
                    seed: run.seed,
                };
                self.one(&run, &id, claim, keep.as_deref(), &mut made)?;
                if made.stopped {
                    return Ok(made);
                }
            }
            if round == 1 {
                made.elsewhere = elsewhere.len();
            }
            pending = elsewhere;
        }
        Ok(made)
    }

    /// Where light methods do not see, if one takes part.
    fn mask(&self, scene: usize) -> Option<Vec<bool>> {
        let is_light = |method: &MethodPlan| mask::LIGHT_METHODS.contains(&method::name_of(&method.text));
        let masked = self.plan.methods.iter().any(is_light);
        masked.then(|| self.pool.install(|| mask::blocks_without_dirac(&self.subjects[scene].scene))).flatten()
    }

    fn one(
        &mut self,
        run: &Pending,
        id: &RunId,
        claim: Claim,
        keep: Option<&[bool]>,
        made: &mut Made,
    ) -> Result<(), ExperimentError> {
        self.observer.begin(id);
        let method = self.method(run.scene, run.method)?;
        let subject = &self.subjects[run.scene];
        let job = Job {
            plan: &self.plan,
            scene: &self.plan.scenes[run.scene],
            method: &self.plan.methods[run.method],
            seed: run.seed,
            truth: &self.truths[run.scene],
            keep,
        };
        let end = match &method.kind {
            MethodKind::Own(integrator) => own::render(integrator.as_ref(), subject, &job, &self.pool, self.observer)?,
            MethodKind::Mitsuba(wanted) => {
                mitsuba_run(self.renderers.mitsuba, wanted, self.folder, subject, &job, claim.scratch(), self.observer)?
            }
        };
        match end {
            RunEnd::Finished(mut finished) => {
                if !self.plan.manifest.images {
                    finished.image = None;
                }
                let info = info(&job, &method, &finished);
                claim.finish(job.identity(&method), self.plan.machine.clone(), &finished, &info)?;
                made.finished += 1;
                if let Some(row) = finished.rows.last() {
                    self.observer.finished(id, row);
                }
            }
            RunEnd::Stopped => made.stopped = true,
            RunEnd::Unsupported(why) => {
                self.observer.unfinished(id, &Unfinished::Unsupported(why.clone()));
                self.plan.scenes[run.scene].skipped.insert(id.method.clone(), why);
                self.write_plan()?;
            }
            RunEnd::Failed(why) => {
                self.observer.unfinished(id, &Unfinished::Failed(why.clone()));
                made.failed.push((id.clone(), why));
            }
        }
        Ok(())
    }
}

fn info(job: &Job<'_>, method: &Method, run: &Finished) -> RenderInfo {
    let last = run.rows.last();
    RenderInfo {
        scene: job.scene.name.clone(),
        integrator: method.name.clone(),
        settings: serde_json::json!(method.settings),
        seed: job.seed,
        render_seconds: last.map_or(0.0, |row| row.render_seconds),
        cpu_seconds: last.and_then(|row| row.cpu_seconds).unwrap_or(0.0),
        version: env!("CARGO_PKG_VERSION").into(),
    }
}

fn mitsuba_run(
    mitsuba: Option<&Mitsuba>,
    wanted: &MitsubaMethod,
    folder: &Folder,
    subject: &Subject,
    job: &Job<'_>,
    scratch: &Path,
    observer: &mut (dyn Observer + Send),
) -> Result<RunEnd, ExperimentError> {
    let Some(mitsuba) = mitsuba else {
        return Ok(RunEnd::Unsupported("there is no Python with Mitsuba".into()));
    };
    let file = match folder.mitsuba(job.scene, &subject.description) {
        Ok(file) => file,
        Err(error @ ExportError::Unsupported { .. }) => return Ok(RunEnd::Unsupported(error.to_string())),
        Err(error) => return Err(error.into()),
    };
    // Passes of all seeds are replicates of each other, so what the first has calibrated is kept.
    let runs = scratch.parent().and_then(|runs| fs::read_dir(runs).ok()).into_iter().flatten().flatten();
    let alike = |run: &RunFile| run.machine.hardware == job.plan.machine.hardware;
    let pass_spp = runs.filter_map(|run| read_run(&run.path()).ok()?).find(alike).map(|run| run.pass_spp);
    mitsuba::render(mitsuba, wanted, job, &file, &scratch.join("mitsuba"), pass_spp, observer)
}
