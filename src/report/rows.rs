//! `rows.csv`: one line per scene, method, seed and checkpoint.

use std::fs::File;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::film::output::write_atomically;

use super::error::ReportError;
use super::metrics::Errors;

/// One line of `rows.csv`. Columns stand in the order of the fields; a missing value is an empty cell.
///
/// Times count rendering only, unless their name says otherwise. At a checkpoint, all of them and all counts include
/// everything since the render began.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Name of the scene.
    pub scene: String,
    /// Name of the method, such as `bdpt` or `mitsuba:path`.
    pub method: String,
    /// The program that ran it, with version and variant.
    pub renderer: String,
    /// Processor model and threads.
    #[serde(default)]
    pub hardware: String,
    /// Host.
    #[serde(default)]
    pub host: String,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Threads that rendered.
    pub threads: u32,
    /// Index of the checkpoint within its render, from 0.
    pub checkpoint: u32,
    /// Samples per pixel so far.
    pub spp: u64,
    /// Wall-clock time spent rendering so far \[s\].
    pub render_seconds: f64,
    /// Processor time of all threads spent rendering so far \[s\].
    pub cpu_seconds: Option<f64>,
    /// Wall-clock time before the first sample, apart from loading: acceleration structure, compilation, warm-up \[s\].
    pub setup_seconds: Option<f64>,
    /// Rays traced so far, where the renderer tells.
    pub rays: Option<u64>,
    /// Mean squared error, see [`super::metrics`]; this and the following four are missing without a reference.
    pub mse: Option<f64>,
    /// Root of the mean squared error.
    pub rmse: Option<f64>,
    /// Relative mean squared error.
    pub relmse: Option<f64>,
    /// Symmetric mean absolute relative error.
    pub smape: Option<f64>,
    /// Mean of the image over mean of the reference.
    pub mean_ratio: Option<f64>,
    /// Contributions or pixels that were not finite.
    pub invalid: u64,
    /// Wall-clock time spent reading the scene \[s\].
    #[serde(default)]
    pub load_seconds: Option<f64>,
    /// Contributions that were negative where the weighting promises none.
    #[serde(default)]
    pub negative: Option<u64>,
}

impl Row {
    /// With the metrics of this checkpoint's image. Its invalid pixels replace a smaller count.
    #[must_use]
    pub fn with_errors(self, errors: &Errors) -> Self {
        Self {
            mse: Some(errors.mse),
            rmse: Some(errors.rmse),
            relmse: Some(errors.relmse),
            smape: Some(errors.smape),
            mean_ratio: Some(errors.mean_ratio),
            invalid: self.invalid.max(errors.invalid),
            ..self
        }
    }
}

/// Writes a table with a header; atomically.
pub(super) fn write_table<T: Serialize>(path: &Path, rows: &[T]) -> Result<(), ReportError> {
    write_atomically(path, |file| {
        let mut writer = csv::Writer::from_writer(file);
        rows.iter().try_for_each(|row| writer.serialize(row)).map_err(std::io::Error::other)?;
        writer.flush()
    })?;
    Ok(())
}

/// Writes `rows.csv`; atomically, so that a reader never sees half of it.
///
/// # Errors
/// When the file cannot be written.
pub fn write_rows(path: &Path, rows: &[Row]) -> Result<(), ReportError> {
    write_table(path, rows)
}

/// Reads `rows.csv`; columns may stand in any order, and unknown ones are passed over.
///
/// # Errors
/// When the file cannot be read, lacks a column, or holds a cell that is not what its column says.
pub fn read_rows(path: &Path) -> Result<Vec<Row>, ReportError> {
    let file = File::open(path).map_err(|source| ReportError::Read { path: path.to_owned(), source })?;
    let rows = csv::Reader::from_reader(file).deserialize().collect::<Result<_, _>>();
    rows.map_err(|error: csv::Error| ReportError::Table { path: path.to_owned(), what: error.to_string() })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    const COLUMNS: &str = "scene,method,renderer,hardware,host,seed,threads,checkpoint,spp,render_seconds,cpu_seconds,setup_seconds,\
                           rays,mse,rmse,relmse,smape,mean_ratio,invalid,load_seconds,negative";

    fn row() -> Row {
        Row {
            scene: "a, \"quoted\" scene".into(),
            method: "mitsuba:path".into(),
            seed: u64::MAX,
            render_seconds: 0.1 + 0.2,
            mse: Some(1e-300),
            relmse: Some(0.0),
            rays: None,
            ..Row::default()
        }
    }

    #[test]
    fn columns_are_the_documented_ones_and_values_survive() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows.csv");
        let rows = [row(), Row { seed: 1, rays: Some(7), negative: Some(3), ..row() }];
        write_rows(&path, &rows).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap().lines().next(), Some(COLUMNS));
        assert_eq!(read_rows(&path).unwrap(), rows);
    }

    #[test]
    fn a_bad_cell_or_a_missing_column_is_named_with_its_file_and_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows.csv");
        let cells = "s,path,r,m,h,1,2,0,sixteen,1,1,0,,,,,,,0,,";
        fs::write(&path, format!("{COLUMNS}\n{cells}\n")).unwrap();
        let message = read_rows(&path).unwrap_err().to_string();
        assert!(message.contains("rows.csv") && message.contains("line: 2"), "{message}");
        fs::write(&path, format!("{COLUMNS}\n{}\n", cells.replace("sixteen", "16")).replace("spp", "samples")).unwrap();
        assert!(read_rows(&path).unwrap_err().to_string().contains("spp"));
        fs::write(&path, [0xff, 0xfe, b'\n', 0xff]).unwrap();
        assert!(read_rows(&path).is_err());
        assert!(matches!(read_rows(&folder.path().join("none.csv")), Err(ReportError::Read { .. })));
    }
}
