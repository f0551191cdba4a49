//! The folder of an experiment; `src/docs/tables.md` describes its tables.
//!
//! ```text
//! experiment.toml   the resolved manifest
//! *.csv             tables over all finished runs
//! references/       SCENE.exr: what errors are measured against, with its standard error
//! runs/             SCENE/METHOD/SEED/: one run
//! scored/           SCENE/METHOD.csv: rows of images that other programs have made
//! images/           SCENE/METHOD.exr and .png: means over seeds; in the .exr, their variance and efficiency too
//! mitsuba/          SCENE/: the scene as Mitsuba reads it
//! ```

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::film::exr::{NamedLayer, write_exr};
use crate::film::output::write_atomically;
use crate::film::png::write_png;
use crate::film::{Image, RenderInfo};
use crate::report::Reference;
use crate::scene::SceneDescription;
use crate::scene::gltf::MaterialModel;
use crate::scene::mitsuba::{ExportError, ExportOptions, export};

use super::agreement::Pool;
use super::error::ExperimentError;
use super::manifest::Manifest;
use super::plan::ScenePlan;
use super::reference::Truth;

const MANIFEST: &str = "experiment.toml";

/// What a folder of an experiment holds, of which nothing is left when another takes its place.
const CONTENTS: [&str; 13] = [
    MANIFEST,
    "rows.csv",
    "curves.csv",
    "summary.csv",
    "verdicts.csv",
    "agreement.csv",
    "references",
    "runs",
    "scored",
    "images",
    "mitsuba",
    "report.html",
    "convergence.png",
];

/// Where an experiment is written; every file is whole or not there.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
}

impl Folder {
    /// Opens the folder, or makes it. `force` clears away an experiment that is there already, and nothing else.
    ///
    /// # Errors
    /// When it cannot be made or written to.
    pub fn open(path: &Path, force: bool) -> Result<Self, ExperimentError> {
        let failed =
            |source: io::Error| ExperimentError::Scene(format!("{}: cannot be made: {source}", path.display()));
        for name in CONTENTS.into_iter().filter(|_| force) {
            let old = path.join(name);
            let removed = if old.is_dir() { fs::remove_dir_all(&old) } else { fs::remove_file(&old) };
            match removed {
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(failed(error)),
                _ => {}
            }
        }
        fs::create_dir_all(path).map_err(failed)?;
        crate::film::check_writable(&path.join("rows.csv"))?;
        Ok(Self { path: path.to_owned() })
    }

    /// Its path.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The experiment that it holds.
    ///
    /// # Errors
    /// When `experiment.toml` is none.
    pub fn manifest(&self) -> Result<Option<Manifest>, ExperimentError> {
        let file = self.path.join(MANIFEST);
        if file.exists() { Manifest::read(&file).map(Some) } else { Ok(None) }
    }

    /// What the experiment in a folder, if there is one, has made of glTF's materials.
    #[must_use]
    pub fn materials_in(path: &Path) -> Option<MaterialModel> {
        Manifest::read(&path.join(MANIFEST)).ok()?.materials
    }

    pub(super) fn write_manifest(&self, manifest: &Manifest) -> Result<(), ExperimentError> {
        let text = toml::to_string(manifest).map_err(|error| ExperimentError::Usage(format!("{MANIFEST}: {error}")))?;
        let file = self.path.join(MANIFEST);
        if fs::read_to_string(&file).is_ok_and(|old| old == text) {
            return Ok(());
        }
        Ok(write_atomically(&file, |file| file.write_all(text.as_bytes()))?)
    }

    pub(super) fn runs(&self) -> PathBuf {
        self.path.join("runs")
    }

    /// Where a run lies.
    pub(super) fn run(&self, scene: &str, method: &str, seed: u64) -> PathBuf {
        self.runs().join(file_name(scene)).join(file_name(method)).join(seed.to_string())
    }

    /// The scene as Mitsuba reads it; written once.
    pub(super) fn mitsuba(&self, plan: &ScenePlan, description: &SceneDescription) -> Result<PathBuf, ExportError> {
        let folder = self.path.join("mitsuba").join(file_name(&plan.name));
        let file = folder.join("scene.xml");
        if file.exists() {
            return Ok(file);
        }
        // In a folder of another name first, since others may be doing the same.
        let parts = folder.with_extension(format!("{}.part", std::process::id()));
        let options = ExportOptions { film: plan.film, max_length: plan.longest(), ..ExportOptions::default() };
        let exported = export(description, &options, &parts);
        if exported.is_ok() {
            let _ = fs::rename(&parts, &folder);
        }
        let _ = fs::remove_dir_all(&parts);
        exported.map(|_| file)
    }

    pub(super) fn write_table<T: Serialize>(&self, name: &str, rows: &[T]) -> Result<(), ExperimentError> {
        Ok(write_atomically(&self.path.join(name), |file| {
            let mut writer = csv::Writer::from_writer(file);
            rows.iter().try_for_each(|row| writer.serialize(row)).map_err(io::Error::other)?;
            writer.flush()
        })?)
    }

    /// `references/SCENE.exr`.
    pub(super) fn reference(&self, scene: &str) -> PathBuf {
        self.path.join("references").join(format!("{}.exr", file_name(scene)))
    }

    pub(super) fn write_reference(&self, scene: &str, truth: &Truth) -> Result<(), ExperimentError> {
        let Some(reference) = &truth.reference else { return Ok(()) };
        let file = self.reference(scene);
        self.folder("references")?;
        write_reference(&file, scene, &truth.words, reference)
    }

    /// `images/SCENE/METHOD.exr` and `.png`.
    pub(super) fn write_mean(&self, scene: &str, method: &str, pool: &Pool) -> Result<(), ExperimentError> {
        let Some(image) = &pool.mean_image() else { return Ok(()) };
        let folder = self.folder(&format!("images/{}", file_name(scene)))?;
        let info = RenderInfo {
            scene: scene.into(),
            integrator: method.into(),
            version: env!("CARGO_PKG_VERSION").into(),
            ..RenderInfo::default()
        };
        let name = file_name(method);
        let layers = [("variance", pool.replicas.variance_image()), ("efficiency", pool.efficiency_image())];
        let layers =
            layers.into_iter().filter_map(|(name, image)| Some(NamedLayer { name: name.into(), image: image? }));
        write_exr(&folder.join(format!("{name}.exr")), image, layers, &info, pool.spp, &[])?;
        Ok(write_png(&folder.join(format!("{name}.png")), image, 0.0)?)
    }

    /// Makes `scored/SCENE` and writes `images/SCENE/METHOD.exr` and `.png` of an image of another program.
    pub(super) fn write_scored(&self, scene: &str, method: &str, mean: Option<&Image>) -> Result<(), ExperimentError> {
        self.folder(&format!("scored/{}", file_name(scene)))?;
        let Some(image) = mean else { return Ok(()) };
        let folder = self.folder(&format!("images/{}", file_name(scene)))?;
        let info = RenderInfo { scene: scene.into(), integrator: method.into(), ..RenderInfo::default() };
        let name = file_name(method);
        write_exr(&folder.join(format!("{name}.exr")), image, [], &info, 0, &[])?;
        Ok(write_png(&folder.join(format!("{name}.png")), image, 0.0)?)
    }

    fn folder(&self, name: &str) -> Result<PathBuf, ExperimentError> {
        let folder = self.path.join(name);
        fs::create_dir_all(&folder)
            .map_err(|error| ExperimentError::Scene(format!("{}: cannot be made: {error}", folder.display())))?;
        Ok(folder)
    }
}

/// An image with its standard error, as [`super::reference`] reads it.
fn write_reference(file: &Path, scene: &str, words: &str, reference: &Reference) -> Result<(), ExperimentError> {
    let info = RenderInfo {
        scene: scene.into(),
        integrator: words.into(),
        version: env!("CARGO_PKG_VERSION").into(),
        ..RenderInfo::default()
    };
    let error = reference.variance.as_ref().map(|variance| {
        let pixels = variance.pixels.iter().map(|pixel| pixel.map(f64::sqrt)).collect();
        NamedLayer { name: "standard_error".into(), image: Image { pixels, ..*variance } }
    });
    Ok(write_exr(file, &reference.mean, error, &info, 0, &[])?)
}

/// A name as the name of a file on any system: letters, digits, `.`, `-` and `_` stay, all else becomes `_`.
pub(super) fn file_name(name: &str) -> String {
    let keep = |c: char| if c.is_alphanumeric() || ".-_".contains(c) { c } else { '_' };
    let name: String = name.chars().map(keep).collect();
    if name.is_empty() || name.starts_with('.') { format!("_{name}") } else { name }
}
