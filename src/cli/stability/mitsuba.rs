//! Mitsuba's columns: `pathspace.stability.run` renders what can be exported, in both variants.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use anyhow::bail;
use serde::{Deserialize, Serialize};

use crate::cli::{complain, interrupt};
use crate::experiment::Mitsuba;
use crate::experiment::process::{Ended, Line, run_limited};
use crate::film::output::write_atomically;
use crate::scene::mitsuba::{ExportOptions, export};
use crate::testing::stability::{Case, Cell, Effort, External, Stage, Subject, Verdict, beyond};

use super::table::value;

/// Each with what its method is called.
const VARIANTS: [(&str, &str); 2] =
    [("scalar_rgb", "mitsuba:path:scalar_rgb"), ("llvm_ad_rgb", "mitsuba:path:llvm_ad_rgb")];

/// For a cell \[s\]; with all values and samples.
const SECONDS: [f64; 2] = [0.3, 1.0];

/// For all cells.
const LIMIT: Duration = Duration::from_secs(6 * 3600);

#[derive(Serialize)]
struct CellsFile {
    schema: u32,
    cells: Vec<Exported>,
}

#[derive(Serialize)]
struct Exported {
    id: String,
    scene: String,
    integrator: &'static str,
    max_depth: i64,
    width: u32,
    height: u32,
}

/// A line of the process.
#[derive(Deserialize)]
struct Told {
    id: String,
    #[serde(default)]
    passes: Vec<Option<f64>>,
    #[serde(default)]
    spp: u64,
    #[serde(default)]
    nonfinite: u64,
    #[serde(default)]
    negative: u64,
    largest: Option<f64>,
    seconds_per_sample: Option<f64>,
    slow: Option<f64>,
    failed: Option<String>,
}

/// A cell to be rendered.
struct Asked<'a> {
    case: &'a Case,
    value: f64,
    stage: Stage,
    /// Why it cannot be.
    refused: Option<String>,
}

/// The cells of all cases in their order by both variants. `told` gets a sentence now and then.
pub(super) fn cells(
    mitsuba: &Mitsuba,
    cases: &[Case],
    effort: Effort,
    tests: usize,
    folder: &Path,
    told: &dyn Fn(String),
) -> anyhow::Result<Vec<Cell>> {
    let folder = folder.join("mitsuba");
    let mut asked = ask(cases, effort);
    write_scenes(&mut asked, &folder)?;
    let mut cells = Vec::new();
    for (variant, method) in VARIANTS {
        let seconds = SECONDS[usize::from(effort.all_values)];
        let answers = serve(mitsuba, &folder, variant, seconds, effort.seed, told)?;
        if interrupt::requested() {
            break;
        }
        cells.extend(judged(&asked, &answers, method, tests));
    }
    Ok(cells)
}

fn ask<'a>(cases: &'a [Case], effort: Effort) -> Vec<Asked<'a>> {
    let of_case = |case: &'a Case| {
        let Subject::Scene(stage) = case.subject else { return Vec::new() };
        let values = effort.values(case).into_iter();
        let asked = |value: f64| {
            let stage = stage(value);
            Asked { case, value, refused: stage.ours_alone.map(str::to_owned), stage }
        };
        values.map(asked).collect()
    };
    cases.iter().flat_map(of_case).collect()
}

impl Asked<'_> {
    fn id(&self) -> String {
        format!("{}/{}", self.case.full_name(), value(self.value))
    }
}

/// Exports all, and lists them in `cells.json`.
fn write_scenes(asked: &mut [Asked<'_>], folder: &Path) -> anyhow::Result<()> {
    let mut cells = Vec::new();
    for asked in asked.iter_mut().filter(|asked| asked.refused.is_none()) {
        let scene = &asked.stage.scene;
        let film = scene.film.unwrap_or(ExportOptions::default().film);
        let place = asked.case.file_name(asked.value);
        let options = ExportOptions { film, ..ExportOptions::default() };
        match export(scene, &options, &folder.join(&place)) {
            Ok(_) => cells.push(Exported {
                id: asked.id(),
                scene: format!("{place}/scene.xml"),
                integrator: "path",
                max_depth: -1,
                width: film.width,
                height: film.height,
            }),
            Err(error) => asked.refused = Some(error.to_string()),
        }
    }
    std::fs::create_dir_all(folder)?;
    let text = serde_json::to_vec_pretty(&CellsFile { schema: 1, cells })?;
    write_atomically(&folder.join("cells.json"), |file| std::io::Write::write_all(file, &text))?;
    Ok(())
}

/// Runs one variant to its end.
fn serve(
    mitsuba: &Mitsuba,
    folder: &Path,
    variant: &str,
    seconds: f64,
    seed: u64,
    told: &dyn Fn(String),
) -> anyhow::Result<BTreeMap<String, Told>> {
    let mut command = mitsuba.command("stability.run");
    command.arg("--cells").arg(folder.join("cells.json")).args(["--variant", variant]);
    command.args(["--seconds", &seconds.to_string(), "--seed", &seed.to_string()]);
    let mut answers = BTreeMap::new();
    let mut last = String::new();
    let ended = run_limited(&mut command, LIMIT, interrupt::requested, |line| match line {
        Line::Out(text) => match serde_json::from_str::<Told>(&text) {
            Ok(answer) => {
                told(format!("mitsuba {variant}: {} {}", answers.len() + 1, answer.id));
                answers.insert(answer.id.clone(), answer);
            }
            Err(error) => last = format!("{error}: {text}"),
        },
        Line::Error(text) => last = text,
    })?;
    match ended {
        Ended::Stopped => Ok(answers),
        Ended::Itself(status) if matches!(status.code(), Some(0 | 130)) => Ok(answers),
        Ended::Itself(status) if status.code() == Some(3) => {
            complain("note", &format!("no {variant}: {last}"));
            Ok(answers)
        }
        Ended::TimedOut => bail!("Mitsuba takes longer than {} s; name fewer cases", LIMIT.as_secs()),
        Ended::Itself(status) => bail!("Mitsuba's side ended with {:?}: {last}", status.code()),
    }
}

fn judged(asked: &[Asked<'_>], answers: &BTreeMap<String, Told>, method: &str, tests: usize) -> Vec<Cell> {
    let mut tame: BTreeMap<String, (External, Cell)> = BTreeMap::new();
    let mut cells = Vec::new();
    for asked in asked {
        let Asked { case, value, stage, refused } = asked;
        let without = |verdict, details| Cell::without_numbers(case, *value, method, verdict, details);
        let cell = match (refused, answers.get(&asked.id())) {
            (Some(why), _) => without(Verdict::Missing, why.clone()),
            (None, None) => without(Verdict::Missing, "no answer".into()),
            (None, Some(Told { failed: Some(why), .. })) => without(Verdict::Fails, why.clone()),
            (None, Some(Told { slow: Some(seconds), .. })) => {
                without(Verdict::Slow, format!("a sample of every pixel takes {seconds:.0} s"))
            }
            (None, Some(answer)) => {
                let film = stage.scene.film.unwrap_or(ExportOptions::default().film);
                let external = External {
                    passes: answer.passes.iter().map(|pass| pass.unwrap_or(f64::NAN)).collect(),
                    spp: answer.spp,
                    pixels: u64::from(film.width) * u64::from(film.height),
                    nonfinite: answer.nonfinite,
                    negative: answer.negative,
                    largest: answer.largest.unwrap_or(f64::NAN),
                    seconds_per_sample: answer.seconds_per_sample.unwrap_or(f64::NAN),
                };
                let first = tame.get(&case.full_name()).map(|(external, cell)| (external, cell));
                let cell = Cell::external(case, *value, method, stage, &external, first, tests);
                tame.entry(case.full_name()).or_insert_with(|| (external, cell.clone()));
                cell
            }
        };
        cells.push(beyond(case, cell));
    }
    cells
}
