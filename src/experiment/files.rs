//! The folder of an experiment.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::film::exr::write_exr;
use crate::film::output::write_atomically;
use crate::film::png::write_png;
use crate::film::{Image, RenderInfo};
use crate::report::rows::write_rows;
use crate::report::summary::write_summary;
use crate::report::{Row, SummaryRow};

use super::agreement::AgreementRow;
use super::error::ExperimentError;
use super::plan::Plan;

/// What a folder of an experiment holds, of which nothing is left when another takes its place.
const CONTENTS: [&str; 6] = ["experiment.toml", "rows.csv", "summary.csv", "agreement.csv", "images", "mitsuba"];

/// Where an experiment is written; every file is whole or not there.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
    images: bool,
}

impl Folder {
    /// Makes the folder. `force` clears away an experiment that is there already, and nothing else; `images` says whether
    /// images are written too.
    ///
    /// # Errors
    /// When it cannot be made or written to, or holds an experiment.
    pub fn create(path: &Path, force: bool, images: bool) -> Result<Self, ExperimentError> {
        let failed =
            |source: io::Error| ExperimentError::Scene(format!("{}: cannot be made: {source}", path.display()));
        if CONTENTS.iter().any(|name| path.join(name).exists()) {
            if !force {
                let what = format!("{}: holds an experiment; choose another folder, or --force", path.display());
                return Err(ExperimentError::Scene(what));
            }
            for name in CONTENTS {
                let old = path.join(name);
                let removed = if old.is_dir() { fs::remove_dir_all(&old) } else { fs::remove_file(&old) };
                match removed {
                    Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(failed(error)),
                    _ => {}
                }
            }
        }
        fs::create_dir_all(path).map_err(failed)?;
        crate::film::check_writable(&path.join("rows.csv"))?;
        Ok(Self { path: path.to_owned(), images })
    }

    /// Its path.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Where a scene is exported to.
    pub(super) fn mitsuba(&self, scene: &str) -> PathBuf {
        self.path.join("mitsuba").join(file_name(scene))
    }

    pub(super) fn write_plan(&self, plan: &Plan) -> Result<(), ExperimentError> {
        let text = plan.to_toml()?;
        Ok(write_atomically(&self.path.join("experiment.toml"), |file| file.write_all(text.as_bytes()))?)
    }

    pub(super) fn write_rows(&self, rows: &[Row]) -> Result<(), ExperimentError> {
        Ok(write_rows(&self.path.join("rows.csv"), rows)?)
    }

    pub(super) fn write_summary(&self, summary: &[SummaryRow]) -> Result<(), ExperimentError> {
        Ok(write_summary(&self.path.join("summary.csv"), summary)?)
    }

    pub(super) fn write_agreement(&self, rows: &[AgreementRow]) -> Result<(), ExperimentError> {
        Ok(write_atomically(&self.path.join("agreement.csv"), |file| {
            let mut writer = csv::Writer::from_writer(file);
            rows.iter().try_for_each(|row| writer.serialize(row)).map_err(io::Error::other)?;
            writer.flush()
        })?)
    }

    /// `images/SCENE/METHOD/seed_N.exr`.
    pub(super) fn write_image(
        &self,
        image: &Image,
        method: &str,
        info: &RenderInfo,
        spp: u64,
    ) -> Result<(), ExperimentError> {
        if !self.images {
            return Ok(());
        }
        let folder = self.image_folder(&info.scene, method)?;
        Ok(write_exr(&folder.join(format!("seed_{}.exr", info.seed)), image, [], info, spp, &[])?)
    }

    /// `images/SCENE/METHOD/mean.png`, over all seeds, for looking.
    pub(super) fn write_mean(&self, image: &Image, scene: &str, method: &str) -> Result<(), ExperimentError> {
        if !self.images {
            return Ok(());
        }
        Ok(write_png(&self.image_folder(scene, method)?.join("mean.png"), image, 0.0)?)
    }

    fn image_folder(&self, scene: &str, method: &str) -> Result<PathBuf, ExperimentError> {
        let folder = self.path.join("images").join(file_name(scene)).join(file_name(method));
        fs::create_dir_all(&folder)
            .map_err(|error| ExperimentError::Scene(format!("{}: cannot be made: {error}", folder.display())))?;
        Ok(folder)
    }
}

/// A name as the name of a file on any system: letters, digits, `.`, `-` and `_` stay, all else becomes `_`.
pub(super) fn file_name(name: &str) -> String {
    let keep = |c: char| if c.is_alphanumeric() || ".-_".contains(c) { c } else { '_' };
    let name: String = name.chars().map(keep).collect();
    if name.is_empty() || name.starts_with('.') { format!("_{name}") } else { name }
}
