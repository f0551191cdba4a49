//! `rows.csv`: one line per scene, method, seed and checkpoint.

use std::fs::File;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::film::output::write_atomically;

use super::error::ReportError;
use super::metrics::Errors;

/// Version of the tables of an experiment; rises with every change of their columns.
pub const SCHEMA: u32 = 1;

fn schema() -> u32 {
    SCHEMA
}

/// One line of `rows.csv`. Columns stand in the order of the fields; a missing value is an empty cell.
///
/// Times count rendering only, unless their name says otherwise. At a checkpoint, all of them and all counts include
/// everything since the render began. Errors are those of [`super::metrics`], and missing without a reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Version of the table.
    #[serde(default = "schema")]
    pub schema: u32,
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
    /// Wall-clock time spent reading the scene \[s\].
    pub load_seconds: Option<f64>,
    /// Rays traced so far, where the renderer tells.
    pub rays: Option<u64>,
    /// Mean squared error.
    pub mse: Option<f64>,
    /// Its root.
    pub rmse: Option<f64>,
    /// Relative mean squared error.
    pub relmse: Option<f64>,
    /// Mean absolute relative error.
    pub mape: Option<f64>,
    /// Symmetric mean absolute relative error.
    pub smape: Option<f64>,
    /// MSE without outliers.
    pub trimmed_mse: Option<f64>,
    /// relMSE without outliers.
    pub trimmed_relmse: Option<f64>,
    /// ꟻLIP, where it is asked for.
    pub flip: Option<f64>,
    /// Mean of the image over mean of the reference.
    pub mean_ratio: Option<f64>,
    /// What the reference's noise alone would make of the MSE, where it is known; it is taken off.
    pub reference_mse: Option<f64>,
    /// The same of relMSE.
    pub reference_relmse: Option<f64>,
    /// The error is smaller than the reference's noise: no truth.
    pub below_reference_noise: Option<bool>,
    /// Contributions or pixels that were not finite.
    pub invalid: u64,
    /// Contributions that were negative where the weighting promises none.
    pub negative: Option<u64>,
}

impl Default for Row {
    fn default() -> Self {
        Self {
            schema: SCHEMA,
            scene: String::new(),
            method: String::new(),
            renderer: String::new(),
            hardware: String::new(),
            host: String::new(),
            seed: 0,
            threads: 0,
            checkpoint: 0,
            spp: 0,
            render_seconds: 0.0,
            cpu_seconds: None,
            setup_seconds: None,
            load_seconds: None,
            rays: None,
            mse: None,
            rmse: None,
            relmse: None,
            mape: None,
            smape: None,
            trimmed_mse: None,
            trimmed_relmse: None,
            flip: None,
            mean_ratio: None,
            reference_mse: None,
            reference_relmse: None,
            below_reference_noise: None,
            invalid: 0,
            negative: None,
        }
    }
}

impl Row {
    /// With the metrics of this checkpoint's image. Its invalid pixels replace a smaller count.
    #[must_use]
    pub fn with_errors(self, errors: &Errors) -> Self {
        Self {
            mse: Some(errors.mse),
            rmse: errors.rmse,
            relmse: Some(errors.relmse),
            mape: Some(errors.mape),
            smape: Some(errors.smape),
            trimmed_mse: Some(errors.trimmed_mse),
            trimmed_relmse: Some(errors.trimmed_relmse),
            mean_ratio: Some(errors.mean_ratio),
            reference_mse: errors.reference_mse,
            reference_relmse: errors.reference_relmse,
            below_reference_noise: errors.below_reference_noise(),
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

    const COLUMNS: &str = "schema,scene,method,renderer,hardware,host,seed,threads,checkpoint,spp,render_seconds,cpu_seconds,\
                           setup_seconds,load_seconds,rays,mse,rmse,relmse,mape,smape,trimmed_mse,trimmed_relmse,flip,\
                           mean_ratio,reference_mse,reference_relmse,below_reference_noise,invalid,negative";

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
        let cells = "1,s,path,r,m,h,1,2,0,sixteen,1,1,0,,,,,,,,,,,,,,,0,";
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
