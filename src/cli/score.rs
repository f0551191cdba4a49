//! `score`: errors of images that other programs have made.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use comfy_table::presets::NOTHING;
use comfy_table::{CellAlignment, Table};

use crate::experiment::{Folder, Listed, collect, read_list, read_reference, score, score_into};
use crate::report::rows::write_rows;
use crate::report::{Metric, Row, cut, number};

use super::compare::{tables, usage};
use super::{Outcome, UsageError, complain};

const AFTER_HELP: &str = "\
A list is a CSV file with a column `file` and any columns of rows.csv: scene, method, seed, spp, render_seconds, cpu_seconds,
hardware, renderer, … (src/docs/tables.md). With --into, its images enter the tables and the report of an experiment: each line needs
scene, method and render_seconds, and times are compared with those of runs whose `hardware` is the same text.

Examples:
  pathspace score a.exr b.exr --reference scenes/cornell_box/reference.exr
  pathspace score pbrt.csv --reference ref.exr -o rows.csv
  pathspace score pbrt.csv --into results/cornell_box

pbrt.csv:
  file,scene,method,seed,spp,render_seconds,hardware
  out/bdpt_1.exr,cornell_box,pbrt:bdpt,1,64,10.2,AMD EPYC × 2";

/// Measure images of any program against a reference, or let them take part in an experiment
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct ScoreArgs {
    /// EXR files, or lists of them
    #[arg(required = true, value_name = "FILE.exr|LIST.csv")]
    images: Vec<PathBuf>,

    /// What they are measured against: an EXR file; where it has a layer standard_error, its noise is taken off squared errors
    #[arg(long, value_name = "FILE.exr", required_unless_present = "into", conflicts_with = "into")]
    reference: Option<PathBuf>,

    /// Folder of an experiment whose references they are measured against, and whose tables they enter
    #[arg(long, value_name = "DIR", conflicts_with = "output")]
    into: Option<PathBuf>,

    /// Write the rows, too, with every digit
    #[arg(short, long, value_name = "FILE.csv")]
    output: Option<PathBuf>,
}

pub(super) fn run(args: &ScoreArgs) -> anyhow::Result<Outcome> {
    let mut list = Vec::new();
    for image in &args.images {
        if image.extension().is_some_and(|ending| ending == "csv") {
            list.extend(read_list(image).map_err(usage)?);
        } else {
            list.push(Listed { file: image.clone(), ..Listed::default() });
        }
    }
    match (&args.reference, &args.into) {
        (Some(reference), _) => {
            let reference = read_reference(reference).map_err(usage)?;
            let rows = list.iter().map(|listed| score(listed, &reference, true).map(|(row, _)| row));
            let rows = rows.collect::<Result<Vec<Row>, _>>().map_err(usage)?;
            let mut out = io::stdout().lock();
            write!(out, "{}", table(&list, &rows))?;
            out.flush()?;
            if let Some(file) = &args.output {
                write_rows(file, &rows)?;
                complain("note", &format!("wrote {}", file.display()));
            }
            Ok(Outcome::Done)
        }
        (None, Some(into)) => {
            if !into.join("experiment.toml").exists() {
                let what = format!("{}: holds no experiment.toml; name the folder of an experiment", into.display());
                return Err(UsageError(what).into());
            }
            let folder = Folder::open(into, false).map_err(usage)?;
            let images = score_into(&folder, &list).map_err(usage)?;
            tables::show(&collect(&folder).map_err(usage)?, into)?;
            complain("note", &format!("{images} images entered"));
            Ok(Outcome::Done)
        }
        (None, None) => Err(UsageError("name a reference with --reference FILE.exr".into()).into()),
    }
}

/// In 80 columns.
fn table(list: &[Listed], rows: &[Row]) -> String {
    const METRICS: [Metric; 5] = [Metric::Rmse, Metric::Relmse, Metric::Mape, Metric::Smape, Metric::Flip];
    let mut table = Table::new();
    let header = ["image", "RMSE", "relMSE", "MAPE", "SMAPE", "FLIP", "mean ratio", "not finite"];
    table.load_style(NOTHING).set_header(header);
    for (listed, row) in list.iter().zip(rows) {
        let file = listed.file.file_name().unwrap_or(listed.file.as_os_str()).to_string_lossy().into_owned();
        let errors = METRICS.map(|metric| metric.of(row).map_or("-".into(), |value| number(metric.shown(value))));
        let ratio = row.mean_ratio.map_or("-".into(), number);
        table.add_row([cut(&file, 20)].into_iter().chain(errors).chain([ratio, row.invalid.to_string()]));
    }
    for (index, column) in table.column_iter_mut().enumerate() {
        column.set_padding((0, 1));
        column.set_cell_alignment(if index == 0 { CellAlignment::Left } else { CellAlignment::Right });
    }
    table.lines().map(|line| format!("{}\n", line.trim_end())).collect()
}
