//! A run on disk: `runs/SCENE/METHOD/SEED/` holds all that the tables are made of, and is there whole or not at all.
//!
//! Whoever makes a run holds the lock beside its folder, works in a folder of another name, and renames that at the end. A lock
//! ends with its process, so a crash leaves nothing that stands in the way.

use std::collections::BTreeMap;
use std::fs::{self, File, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::film::exr::{read_exr, write_exr};
use crate::film::output::write_atomically;
use crate::film::{BlockStatistics, RenderInfo};
use crate::report::Row;
use crate::scene::LightSelection;

use super::budget::Budget;
use super::error::ExperimentError;
use super::machine::Machine;
use super::run::Finished;

/// Rises with every change that runs of before do not survive.
const SCHEMA: u32 = 1;

/// All that the result of a run depends on beside machine and version.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Identity {
    pub scene: String,
    pub fingerprint: String,
    pub film: (u32, u32),
    pub max_length: String,
    pub light_selection: LightSelection,
    pub reference: String,
    pub method: String,
    pub integrator: String,
    pub settings: BTreeMap<String, String>,
    pub seed: u64,
    pub budget: Budget,
}

/// `run.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct RunFile {
    pub schema: u32,
    pub version: String,
    pub identity: Identity,
    pub machine: Machine,
    /// Samples per pixel of a pass of the statistics.
    pub pass_spp: u64,
    pub rows: Vec<Row>,
}

/// `statistics.postcard`.
#[derive(Serialize, Deserialize)]
struct Statistics {
    all: BlockStatistics,
    restricted: Option<BlockStatistics>,
}

impl Identity {
    /// What is different first, in words.
    pub fn difference(&self, other: &Self) -> Option<String> {
        let (Ok(mine), Ok(theirs)) = (toml::Table::try_from(self), toml::Table::try_from(other)) else {
            return (self != other).then(|| "other settings".to_owned());
        };
        let differs = |(key, value): (&String, &toml::Value)| {
            let other = theirs.get(key)?;
            (value != other).then(|| format!("{key} {value}, not {other}"))
        };
        mine.iter().find_map(differs)
    }
}

fn failed(path: &Path, what: &str) -> impl FnOnce(io::Error) -> ExperimentError {
    let place = format!("{}: cannot be {what}", path.display());
    move |error| ExperimentError::Scene(format!("{place}: {error}"))
}

fn damaged(path: &Path, what: &str) -> ExperimentError {
    let folder = path.parent().unwrap_or(path);
    ExperimentError::Scene(format!("{}: {what}; remove {} to run it again", path.display(), folder.display()))
}

/// What identifies a finished run, or `None` where there is none.
pub(super) fn read_run(folder: &Path) -> Result<Option<RunFile>, ExperimentError> {
    let path = folder.join("run.json");
    let text = match fs::read(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(failed(&path, "read")(error)),
    };
    let run: RunFile = serde_json::from_slice(&text).map_err(|error| damaged(&path, &error.to_string()))?;
    if run.schema != SCHEMA {
        return Err(damaged(&path, &format!("has schema {} and this program reads {SCHEMA}", run.schema)));
    }
    Ok(Some(run))
}

/// A finished run with its image and statistics.
pub(super) fn load(folder: &Path) -> Result<Option<(RunFile, Finished)>, ExperimentError> {
    let Some(run) = read_run(folder)? else { return Ok(None) };
    let file = folder.join("image.exr");
    let image = file.exists().then(|| read_exr(&file)).transpose()?;
    let path = folder.join("statistics.postcard");
    let bytes = fs::read(&path).map_err(failed(&path, "read"))?;
    let Statistics { all, restricted } =
        postcard::from_bytes(&bytes).map_err(|error| damaged(&path, &error.to_string()))?;
    let (rows, pass_spp) = (run.rows.clone(), run.pass_spp);
    Ok(Some((run, Finished { rows, image, statistics: all, restricted, pass_spp })))
}

/// The right to make a run.
pub(super) struct Claim {
    folder: PathBuf,
    temporary: PathBuf,
    lock: PathBuf,
    // Closing it ends the lock.
    _file: File,
}

impl Claim {
    /// `None` where somebody else is making the run.
    pub fn take(folder: &Path) -> Result<Option<Self>, ExperimentError> {
        let parent = folder.parent().unwrap_or(Path::new("."));
        fs::create_dir_all(parent).map_err(failed(parent, "made"))?;
        let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let lock = parent.join(format!(".{name}.lock"));
        let file = File::options().create(true).truncate(false).write(true).open(&lock);
        let file = file.map_err(failed(&lock, "made"))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Ok(None),
            // Where the file system has no locks, two may make the same run, and one of them wins.
            Err(TryLockError::Error(error)) if error.kind() == io::ErrorKind::Unsupported => {}
            Err(TryLockError::Error(error)) => return Err(failed(&lock, "locked")(error)),
        }
        let temporary = parent.join(format!(".{name}.part"));
        match fs::remove_dir_all(&temporary) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(failed(&temporary, "removed")(error)),
            _ => {}
        }
        fs::create_dir(&temporary).map_err(failed(&temporary, "made"))?;
        Ok(Some(Self { folder: folder.to_owned(), temporary, lock, _file: file }))
    }

    /// Where files may lie that vanish or become part of the run.
    pub fn scratch(&self) -> &Path {
        &self.temporary
    }

    /// Makes the run a finished one.
    pub fn finish(
        self,
        identity: Identity,
        machine: Machine,
        run: &Finished,
        info: &RenderInfo,
    ) -> Result<(), ExperimentError> {
        if let (Some(image), Some(row)) = (&run.image, run.rows.last()) {
            write_exr(&self.temporary.join("image.exr"), image, [], info, row.spp, &[])?;
        }
        let statistics = Statistics { all: run.statistics.clone(), restricted: run.restricted.clone() };
        let bytes = postcard::to_allocvec(&statistics).map_err(|error| ExperimentError::Scene(error.to_string()))?;
        write_atomically(&self.temporary.join("statistics.postcard"), |file| file.write_all(&bytes))?;
        let file = RunFile {
            schema: SCHEMA,
            version: env!("CARGO_PKG_VERSION").into(),
            identity,
            machine,
            pass_spp: run.pass_spp,
            rows: run.rows.clone(),
        };
        write_atomically(&self.temporary.join("run.json"), |writer| {
            serde_json::to_writer_pretty(&mut *writer, &file)?;
            writer.write_all(b"\n")
        })?;
        match fs::rename(&self.temporary, &self.folder) {
            // Somebody else was faster.
            Err(_) if self.folder.join("run.json").exists() => Ok(()),
            result => result.map_err(failed(&self.folder, "made")),
        }
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.temporary);
        let _ = fs::remove_file(&self.lock);
    }
}
