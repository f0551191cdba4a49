//! References that are rendered once, kept, and extended: `$PATHSPACE_CACHE/references/SCENE_KEY/METHOD.film`.
//!
//! The key changes with whatever the expected image depends on: content of the scene, size of the film, longest path. Below it
//! lies the state of a film for each method that has rendered it, so that methods can be compared before one is believed.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use cpu_time::ProcessTime;
use xxhash_rust::xxh3::xxh3_64;

use crate::estimator::{Control, Registry};
use crate::film::{Film, Image, RenderInfo, state};
use crate::report::{Agreement, AgreementSettings, Reference, Verdict};

use super::Subject;
use super::budget::Budget;
use super::error::ExperimentError;
use super::files::file_name;
use super::method::{self, MethodKind};
use super::plan::ScenePlan;
use super::run::{Observer, RunId, Standing};

/// Seeds of runs are smaller, so that no run shares its random numbers with its reference.
const SEED: u64 = 1 << 62;

/// Rendering time between two looks at the clock \[s\].
const LOOK_EVERY: f64 = 0.2;

/// Rendering time after which what is done is written \[s\].
const SAVE_EVERY: f64 = 60.0;

/// Where references are kept, and what renders them.
pub struct Cache<'a> {
    /// The folder.
    pub folder: PathBuf,
    /// The methods.
    pub registry: &'a Registry,
    /// Where rendering runs.
    pub pool: &'a rayon::ThreadPool,
    /// Is told how it goes on.
    pub observer: &'a mut (dyn Observer + Send),
}

/// A reference that is asked for.
#[derive(Clone, Copy)]
pub struct Wanted<'a> {
    /// The scene.
    pub subject: &'a Subject,
    /// How it is rendered.
    pub plan: &'a ScenePlan,
    /// `name:key=value:…` of the registry.
    pub method: &'a str,
    /// Rendering time or samples at least spent on it, in all.
    pub until: Budget,
}

impl Wanted<'_> {
    fn spent(&self, film: &Film, info: &RenderInfo) -> f64 {
        match self.until {
            Budget::Seconds(_) | Budget::Error(_) => info.render_seconds,
            Budget::Spp(_) => film.passes() as f64,
        }
    }
}

/// A reference that is kept.
#[derive(Debug)]
pub struct Kept {
    /// Its method, as the user wrote it.
    pub method: String,
    /// Its film.
    pub film: Film,
    /// What made it.
    pub info: RenderInfo,
}

/// `$PATHSPACE_CACHE`, else `pathspace` in the user's folder for caches, else `.pathspace-cache`.
#[must_use]
pub fn default_folder() -> PathBuf {
    let variable = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let users = || variable("XDG_CACHE_HOME").or_else(|| Some(variable("HOME")?.join(".cache")));
    variable("PATHSPACE_CACHE")
        .or_else(|| Some(users()?.join("pathspace")))
        .unwrap_or_else(|| PathBuf::from(".pathspace-cache"))
}

impl Kept {
    /// With the variance of its pixels.
    #[must_use]
    pub fn reference(&self) -> Reference {
        let square = |error: Image| Image { pixels: error.pixels.iter().map(|&e| e * e).collect(), ..error };
        Reference { mean: self.film.mean_image(), variance: self.film.standard_error_image().map(square) }
    }

    /// What it is, in words.
    #[must_use]
    pub fn words(&self) -> String {
        format!("{}, {} spp in {:.0} s", self.method, self.film.passes(), self.info.render_seconds)
    }

    /// Root mean square of its pixels' standard errors over the mean of the image; `None` below two passes.
    #[must_use]
    pub fn noise(&self) -> Option<f64> {
        let error = self.film.standard_error_image()?;
        let values = |image: &Image| image.pixels.iter().flat_map(|pixel| pixel.to_array()).collect::<Vec<_>>();
        let (errors, means) = (values(&error), values(&self.film.mean_image()));
        let count = errors.len() as f64;
        let square = errors.iter().map(|error| error * error).sum::<f64>() / count;
        Some(square.sqrt() / (means.iter().sum::<f64>() / count))
    }
}

impl Cache<'_> {
    /// Where the references of a scene lie.
    #[must_use]
    pub fn folder_of(&self, subject: &Subject, plan: &ScenePlan) -> PathBuf {
        let key = format!("{} {:?} {}", subject.fingerprint, plan.film, plan.max_length);
        self.folder.join("references").join(format!("{}_{:016x}", file_name(&plan.name), xxh3_64(key.as_bytes())))
    }

    /// All references of a scene, by method.
    ///
    /// # Errors
    /// Where one is damaged.
    pub fn kept(&self, subject: &Subject, plan: &ScenePlan) -> Result<Vec<Kept>, ExperimentError> {
        let entries = fs::read_dir(self.folder_of(subject, plan)).into_iter().flatten().flatten();
        let mut files: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
        files.retain(|file| file.extension().is_some_and(|ending| ending == "film"));
        files.sort();
        files.iter().map(|file| read(file)).collect()
    }

    /// A reference with its description; what is missing is rendered.
    ///
    /// # Errors
    /// Where the method cannot render it, the user stops, a file cannot be written, or another method's reference differs.
    pub(super) fn reference(&mut self, wanted: &Wanted<'_>) -> Result<(Reference, String), ExperimentError> {
        self.extend(wanted)?;
        let kept = self.kept(wanted.subject, wanted.plan)?;
        let name = wanted.plan.name.as_str();
        let Some(ours) = kept.iter().find(|kept| kept.method == wanted.method) else {
            return Err(ExperimentError::Scene(format!("{name}: the reference by {} is gone", wanted.method)));
        };
        for other in kept.iter().filter(|other| other.method != wanted.method) {
            if let Some(test) = compare(ours, other)?.filter(|test| test.verdict == Verdict::Differ) {
                return Err(ExperimentError::Scene(format!(
                    "{name}: references by {} and {} differ ({test}): find out which is wrong, then remove it from {}",
                    ours.method,
                    other.method,
                    self.folder_of(wanted.subject, wanted.plan).display()
                )));
            }
        }
        Ok((ours.reference(), ours.words()))
    }

    /// Renders until all that is wanted is spent on the reference; goes on with what is there.
    ///
    /// # Errors
    /// Where the method cannot render it, the user stops, or a file cannot be written.
    pub fn extend(&mut self, wanted: &Wanted<'_>) -> Result<(), ExperimentError> {
        let Wanted { subject, plan, method: text, .. } = *wanted;
        let method = method::build(text, self.registry, &plan.max_length)?;
        let MethodKind::Own(integrator) = &method.kind else {
            let what = format!("reference by {text}: give its image with --reference FILE.exr");
            return Err(ExperimentError::Usage(what));
        };
        integrator
            .supports(&subject.scene)
            .map_err(|why| ExperimentError::Scene(format!("{}: reference by {text}: {why}", plan.name)))?;
        let folder = self.folder_of(subject, plan);
        let failed = |path: &Path| {
            let path = path.display().to_string();
            move |error: std::io::Error| ExperimentError::Scene(format!("{path}: cannot be made: {error}"))
        };
        fs::create_dir_all(&folder).map_err(failed(&folder))?;
        let file = folder.join(format!("{}.film", file_name(text)));
        let lock_file = file.with_extension("lock");
        let lock = File::create(&lock_file).map_err(failed(&lock_file))?;
        // Where there are no locks, two may render the same, and the later one is kept.
        let _ = lock.lock();
        let Kept { mut film, mut info, .. } = if file.exists() {
            read(&file)?
        } else {
            let info = RenderInfo {
                scene: plan.name.clone(),
                integrator: text.to_owned(),
                settings: serde_json::json!(method.settings),
                seed: SEED,
                version: env!("CARGO_PKG_VERSION").into(),
                ..RenderInfo::default()
            };
            Kept { method: text.to_owned(), film: Film::new(plan.film.width, plan.film.height, None)?, info }
        };
        if info.settings != serde_json::json!(method.settings) {
            let what = format!("{}: was rendered with other settings; remove it", file.display());
            return Err(ExperimentError::Scene(what));
        }
        let id =
            RunId { number: 1, of: 1, scene: plan.name.clone(), method: format!("reference by {text}"), seed: SEED };
        self.observer.begin(&id);
        let end = wanted.until.end();
        while wanted.spent(&film, &info) < end && !self.observer.stopped() {
            let save_at = info.render_seconds + SAVE_EVERY;
            let mut clock = Clock { wanted, save_at, info: &mut info, observer: self.observer, batch: None };
            self.pool.install(|| integrator.render(&subject.scene, SEED, &mut film, &mut clock));
            state::save(&file, &film, &info)?;
        }
        if wanted.spent(&film, &info) < end {
            let spent = info.render_seconds;
            let what = format!("{}: reference stopped after {spent:.0} s; it goes on where it was", plan.name);
            return Err(ExperimentError::Stopped(what));
        }
        Ok(())
    }
}

fn read(file: &Path) -> Result<Kept, ExperimentError> {
    let (film, info) = state::load(file)?;
    Ok(Kept { method: info.integrator.clone(), film, info })
}

/// Whether two references of a scene are of the same image; `None` where one has too few passes to say.
///
/// # Errors
/// Where they are of different sizes.
pub fn compare(a: &Kept, b: &Kept) -> Result<Option<Agreement>, ExperimentError> {
    let settings = AgreementSettings::default();
    if a.film.passes().min(b.film.passes()) < settings.smallest_passes {
        return Ok(None);
    }
    let both = (a.film.block_statistics(), b.film.block_statistics());
    Ok(Some(Agreement::test_with(both, both, &settings)?))
}

struct Clock<'a> {
    wanted: &'a Wanted<'a>,
    /// Rendering time at which what is done is written \[s\].
    save_at: f64,
    info: &'a mut RenderInfo,
    observer: &'a mut (dyn Observer + Send),
    batch: Option<(Instant, ProcessTime, u64)>,
}

impl Control for Clock<'_> {
    fn next_passes(&mut self, film: &Film) -> u64 {
        let mut per_pass = Duration::ZERO;
        if let Some((wall, processor, passes)) = self.batch.take() {
            let wall = wall.elapsed();
            self.info.render_seconds += wall.as_secs_f64();
            self.info.cpu_seconds += processor.elapsed().as_secs_f64();
            per_pass = wall / (film.passes() - passes).max(1) as u32;
        }
        let (seconds, spent, end) =
            (self.info.render_seconds, self.wanted.spent(film, self.info), self.wanted.until.end());
        self.observer.progress(&Standing { share: spent / end, seconds, spp: film.passes(), rmse: None });
        if spent >= end || seconds >= self.save_at || self.observer.stopped() {
            return 0;
        }
        self.batch = Some((Instant::now(), ProcessTime::now(), film.passes()));
        let fitting = LOOK_EVERY / per_pass.as_secs_f64();
        let passes = if fitting.is_finite() { (fitting as u64).max(1) } else { 1 };
        match self.wanted.until {
            Budget::Spp(spp) => passes.min(spp - film.passes()),
            Budget::Seconds(_) | Budget::Error(_) => passes,
        }
    }
}
