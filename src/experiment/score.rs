//! Images of other programs, measured as if they were runs of an experiment: `scored/SCENE/METHOD.csv` in its folder.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::film::Image;
use crate::film::exr::read_exr;
use crate::report::flip::flip;
use crate::report::replicas::Replicas;
use crate::report::rows::{read_rows, write_rows};
use crate::report::{Errors, Metric, Reference, ReportError, Row};

use super::error::ExperimentError;
use super::files::{Folder, file_name};
use super::reference::read_reference;

/// A line of a list of images: where an image lies, and what `rows.csv` says of its render. Only `file` is needed to measure an
/// image; `scene`, `method` and `render_seconds` are, too, where it takes part in an experiment.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct Listed {
    /// An EXR file; a relative path is meant from the list's folder.
    pub file: PathBuf,
    /// See [`Row::scene`].
    #[serde(default)]
    pub scene: String,
    /// See [`Row::method`].
    #[serde(default)]
    pub method: String,
    /// See [`Row::renderer`].
    #[serde(default)]
    pub renderer: String,
    /// See [`Row::hardware`].
    #[serde(default)]
    pub hardware: String,
    /// See [`Row::host`].
    #[serde(default)]
    pub host: String,
    /// See [`Row::seed`].
    #[serde(default)]
    pub seed: u64,
    /// See [`Row::threads`].
    #[serde(default)]
    pub threads: u32,
    /// See [`Row::spp`].
    #[serde(default)]
    pub spp: u64,
    /// See [`Row::render_seconds`].
    #[serde(default)]
    pub render_seconds: f64,
    /// See [`Row::cpu_seconds`].
    #[serde(default)]
    pub cpu_seconds: Option<f64>,
    /// See [`Row::setup_seconds`].
    #[serde(default)]
    pub setup_seconds: Option<f64>,
    /// See [`Row::load_seconds`].
    #[serde(default)]
    pub load_seconds: Option<f64>,
    /// See [`Row::rays`].
    #[serde(default)]
    pub rays: Option<u64>,
}

/// Reads a list of images, `.csv`; unknown columns are passed over.
///
/// # Errors
/// Where it cannot be read, has no column `file`, or holds a cell that is not what its column says.
pub fn read_list(list: &Path) -> Result<Vec<Listed>, ExperimentError> {
    let source = |source| ReportError::Read { path: list.to_owned(), source };
    let file = fs::File::open(list).map_err(source)?;
    let lines = csv::Reader::from_reader(file).deserialize().collect::<Result<Vec<Listed>, csv::Error>>();
    let mut lines = lines.map_err(|error| ReportError::Table { path: list.to_owned(), what: error.to_string() })?;
    for line in &mut lines {
        line.file = list.parent().unwrap_or(Path::new("")).join(&line.file);
    }
    Ok(lines)
}

/// Measures an image against a reference.
///
/// # Errors
/// Where the image cannot be read, or is of another size.
pub fn score(listed: &Listed, reference: &Reference, with_flip: bool) -> Result<(Row, Image), ExperimentError> {
    let image = read_exr(&listed.file)?;
    let errors = Errors::between(&image, reference)
        .map_err(|error| ExperimentError::Scene(format!("{}: {error}", listed.file.display())))?;
    let Listed { scene, method, renderer, hardware, host, .. } = listed.clone();
    let row = Row {
        scene,
        method,
        renderer,
        hardware,
        host,
        seed: listed.seed,
        threads: listed.threads,
        spp: listed.spp,
        render_seconds: listed.render_seconds,
        cpu_seconds: listed.cpu_seconds,
        setup_seconds: listed.setup_seconds,
        load_seconds: listed.load_seconds,
        rays: listed.rays,
        flip: with_flip.then(|| flip(&image, &reference.mean)).flatten(),
        ..Row::default()
    };
    Ok((row.with_errors(&errors), image))
}

/// Measures all images against the references of an experiment's scenes, and keeps what they say in its folder, in place of
/// what there was of the same methods. Checkpoints of a seed are numbered by time.
///
/// # Errors
/// Where a scene has no reference, a line lacks what a row needs, a method is one of the experiment's own, or a file cannot be read
/// or written.
pub fn score_into(folder: &Folder, list: &[Listed]) -> Result<usize, ExperimentError> {
    let manifest = folder.manifest()?.ok_or_else(|| {
        ExperimentError::Scene(format!("{}: holds no experiment; make one with compare", folder.path().display()))
    })?;
    let mut methods: BTreeMap<(&str, &str), Vec<&Listed>> = BTreeMap::new();
    for line in list {
        let refuse = |what: String| Err(ExperimentError::Scene(format!("{}: {what}", line.file.display())));
        if line.scene.is_empty()
            || line.method.is_empty()
            || line.render_seconds.partial_cmp(&0.0) != Some(Ordering::Greater)
        {
            return refuse(
                "an experiment needs its scene, method and render_seconds above 0; add them to the list".into(),
            );
        }
        if manifest.methods.iter().any(|method| method.label() == line.method) {
            return refuse(format!("the experiment has a method {} of its own; give it another name", line.method));
        }
        methods.entry((&line.scene, &line.method)).or_default().push(line);
    }
    for ((scene, method), mut lines) in methods {
        let file = folder.reference(scene);
        if !file.exists() {
            let what =
                format!("{}: no such file: the experiment has no scene {scene} with a reference", file.display());
            return Err(ExperimentError::Scene(what));
        }
        let reference = read_reference(&file)?;
        lines.sort_by(|a, b| a.seed.cmp(&b.seed).then(a.render_seconds.total_cmp(&b.render_seconds)));
        let (mut rows, mut last) = (Vec::<Row>::new(), BTreeMap::new());
        for line in lines {
            let (row, image) = score(line, &reference, manifest.metrics.contains(&Metric::Flip))?;
            let checkpoint =
                rows.last().filter(|before| before.seed == row.seed).map_or(0, |before| before.checkpoint + 1);
            rows.push(Row { checkpoint, ..row });
            last.insert(line.seed, image);
        }
        let mut replicas = Replicas::default();
        last.values().for_each(|image| replicas.add(image));
        folder.write_scored(scene, method, replicas.mean())?;
        write_rows(&table(folder, scene, method), &rows)?;
    }
    Ok(list.len())
}

fn table(folder: &Folder, scene: &str, method: &str) -> PathBuf {
    folder.path().join("scored").join(file_name(scene)).join(format!("{}.csv", file_name(method)))
}

/// All rows of a scene that are kept.
pub(super) fn rows_of(folder: &Folder, scene: &str) -> Result<Vec<Row>, ExperimentError> {
    let place = folder.path().join("scored").join(file_name(scene));
    let mut files: Vec<PathBuf> =
        fs::read_dir(place).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    files.retain(|file| file.extension().is_some_and(|ending| ending == "csv"));
    files.sort();
    let mut rows = Vec::new();
    for file in files {
        rows.extend(read_rows(&file)?);
    }
    Ok(rows)
}
