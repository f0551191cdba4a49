//! References that are rendered once, kept, and extended: `$PATHSPACE_CACHE/references/SCENE_KEY/METHOD.film`.
//!
//! The key changes with whatever the expected image depends on: content of the scene, size of the film, longest path. Below it
//! lies the state of a film for each method that has rendered it, Mitsuba's too, so that methods can be compared before one is
//! believed. `src/docs/references.md` tells users.

mod by_mitsuba;
mod by_us;
mod growth;
mod kept;

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use xxhash_rust::xxh3::xxh3_64;

use crate::estimator::Registry;
use crate::film::{Film, RenderInfo, state};
use crate::report::{Reference, Verdict};

use super::Subject;
use super::error::ExperimentError;
use super::files::file_name;
use super::method::{self, Method, MethodKind};
use super::mitsuba::Mitsuba;
use super::plan::ScenePlan;
use super::run::{Observer, RunId};
use growth::Growth;
pub use growth::Until;
pub use kept::{Kept, compare};

/// Seeds of runs are smaller, so that no run shares its random numbers with its reference.
const FIRST_SEED: u64 = 1 << 62;

/// Rendering time after which what is done is written \[s\].
const SAVE_EVERY: f64 = 60.0;

/// Where references are kept, and what renders them.
pub struct Cache<'a> {
    /// The folder.
    pub folder: PathBuf,
    /// The methods.
    pub registry: &'a Registry,
    /// Mitsuba, where there is one.
    pub mitsuba: Option<&'a Mitsuba>,
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
    /// `name:key=value:…` of the registry or of Mitsuba.
    pub method: &'a str,
    /// How far.
    pub until: Until,
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

impl Cache<'_> {
    /// Where the references of a scene lie.
    #[must_use]
    pub fn folder_of(&self, subject: &Subject, plan: &ScenePlan) -> PathBuf {
        let key = format!("{} {:?} {}", subject.fingerprint, plan.film, plan.max_length);
        // Not the name that an experiment gives it: another would not find what it has.
        let name = file_name(subject.scene.name());
        self.folder.join("references").join(format!("{name}_{:016x}", xxh3_64(key.as_bytes())))
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
        files.iter().map(|file| Kept::read(file)).collect()
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
        let reference = ours.reference();
        if !reference.mean.pixels.iter().all(|pixel| pixel.is_finite()) {
            let what = format!("{name}: the reference by {} holds pixels that are not finite", ours.method);
            return Err(ExperimentError::Scene(what));
        }
        Ok((reference, ours.words()))
    }

    /// Renders until the reference is as far as is wanted; goes on with what is there.
    ///
    /// # Errors
    /// Where the method cannot render it, the user stops, or a file cannot be written.
    pub fn extend(&mut self, wanted: &Wanted<'_>) -> Result<(), ExperimentError> {
        let Wanted { subject, plan, method: text, until } = *wanted;
        let method = method::build(text, self.registry, &plan.max_length)?;
        let folder = self.folder_of(subject, plan);
        let file = folder.join(format!("{}.film", file_name(text)));
        // One that is far enough needs neither Mitsuba nor a folder that can be written to.
        if file.exists() {
            let kept = Kept::read(&file)?.check(&file, &method)?;
            if Growth::new(until, &mut ()).look(&kept.film, &kept.info)? {
                return Ok(());
            }
        }
        let refuse = |why: String| ExperimentError::Scene(format!("{}: reference by {text}: {why}", plan.name));
        match &method.kind {
            MethodKind::Own(integrator) => integrator.supports(&subject.scene).map_err(refuse)?,
            MethodKind::Mitsuba(wanted) => match self.mitsuba {
                Some(mitsuba) => mitsuba.supports(wanted).map_err(refuse)?,
                None => return Err(refuse(Mitsuba::MISSING.into())),
            },
        }
        let failed = |path: &Path| {
            let path = path.display().to_string();
            move |error: std::io::Error| ExperimentError::Scene(format!("{path}: cannot be made: {error}"))
        };
        fs::create_dir_all(&folder).map_err(failed(&folder))?;
        let lock_file = file.with_extension("lock");
        let lock = File::create(&lock_file).map_err(failed(&lock_file))?;
        // Where there are no locks, two may render the same, and the later one is kept.
        let _ = lock.lock();
        let mut kept = if file.exists() {
            Kept::read(&file)?.check(&file, &method)?
        } else {
            Kept {
                method: text.to_owned(),
                film: Film::new(plan.film.width, plan.film.height, None)?,
                info: begin(plan, text, &method),
            }
        };
        kept.made_by(&self.renderer(&method));
        self.observer.begin(&RunId {
            number: 1,
            of: 1,
            scene: plan.name.clone(),
            method: format!("reference by {text}"),
            seed: kept.info.seed,
        });
        let done = match &method.kind {
            MethodKind::Own(integrator) => self.by_us(wanted, integrator.as_ref(), &mut kept, &file)?,
            MethodKind::Mitsuba(integrator) => self.by_mitsuba(wanted, integrator, &mut kept, &file)?,
        };
        if !done {
            let spent = kept.info.render_seconds;
            let what = format!("{}: reference stopped after {spent:.0} s; it goes on where it was", plan.name);
            return Err(ExperimentError::Stopped(what));
        }
        Ok(())
    }

    fn renderer(&self, method: &Method) -> String {
        let own = env!("CARGO_PKG_VERSION");
        match (&method.kind, self.mitsuba) {
            (MethodKind::Mitsuba(_), Some(mitsuba)) => format!("{own} with {}", mitsuba.versions()),
            _ => own.to_owned(),
        }
    }
}

/// What is known before the first pass.
fn begin(plan: &ScenePlan, text: &str, method: &Method) -> RenderInfo {
    RenderInfo {
        scene: plan.name.clone(),
        integrator: text.to_owned(),
        settings: kept::settings(method),
        // One for each method: references that are compared must be independent.
        seed: FIRST_SEED | xxh3_64(text.as_bytes()) >> 2,
        ..RenderInfo::default()
    }
}

fn save(file: &Path, film: &Film, info: &RenderInfo) -> Result<(), ExperimentError> {
    Ok(state::save(file, film, info)?)
}
