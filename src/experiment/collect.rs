//! The tables of an experiment, made from nothing but its folder.

use std::collections::BTreeMap;

use crate::report::replicas::Bias;
use crate::report::{CurveRow, Reference, Row, SummaryRow, VerdictRow, curves, summarise, verdicts};
use crate::spectrum::Rgb;

use super::agreement::{self, AgreementRow, Pool};
use super::error::ExperimentError;
use super::files::Folder;
use super::manifest::Manifest;
use super::mask;
use super::method::{MITSUBA, name_of};
use super::plan::{Record, ScenePlan};
use super::seeds::seed_of;
use super::{job, reference, score};

/// What an experiment has found.
#[derive(Clone, Debug)]
pub struct Report {
    /// What was done, with what was skipped.
    pub manifest: Manifest,
    /// All checkpoints of finished runs, by scene, method and seed.
    pub rows: Vec<Row>,
    /// Errors over time.
    pub curves: Vec<CurveRow>,
    /// What they say of each method.
    pub summary: Vec<SummaryRow>,
    /// What they say of each pair of methods.
    pub verdicts: Vec<VerdictRow>,
    /// Whether the methods agree.
    pub agreement: Vec<AgreementRow>,
    /// Runs of the manifest that are not finished.
    pub missing: usize,
}

impl Report {
    /// A method of this program misses the reference, or what Mitsuba renders. That Mitsuba's own methods miss the reference, as
    /// some do in long runs (`scenes/hidden_lamps/README.md`), is told and no more.
    #[must_use]
    pub fn differs(&self) -> bool {
        let is_mitsubas = |row: &AgreementRow| {
            let method = self.manifest.methods.iter().find(|method| method.label() == row.method);
            method.is_some_and(|method| method.text().starts_with(MITSUBA))
        };
        self.agreement.iter().any(|row| row.differs() && !is_mitsubas(row))
    }

    /// The scenes, with what was skipped.
    pub fn scenes(&self) -> impl Iterator<Item = &ScenePlan> {
        self.manifest.record.iter().flat_map(|record| &record.scenes)
    }
}

/// A method and all its finished runs on a scene.
struct Member<'a> {
    label: &'a str,
    /// See [`name_of`].
    name: &'a str,
    pool: Pool,
}

impl Member<'_> {
    fn is_light(&self) -> bool {
        mask::LIGHT_METHODS.contains(&self.name)
    }

    fn is_mitsubas(&self) -> bool {
        self.name.starts_with(MITSUBA)
    }
}

/// Reads all finished runs of the folder and writes its tables and mean images.
///
/// # Errors
/// When the folder holds no experiment, a run is damaged, or a file cannot be written.
pub fn collect(folder: &Folder) -> Result<Report, ExperimentError> {
    let manifest = folder.manifest()?;
    let resolved = manifest.and_then(|manifest| Some((manifest.record.clone()?, manifest)));
    let Some((record, manifest)) = resolved else {
        return Err(ExperimentError::Scene(format!("{}: holds no experiment", folder.path().display())));
    };
    let mut report = Report {
        manifest,
        rows: Vec::new(),
        curves: Vec::new(),
        summary: Vec::new(),
        verdicts: Vec::new(),
        agreement: Vec::new(),
        missing: 0,
    };
    let mut spreads = Vec::new();
    for scene in &record.scenes {
        spreads.extend(collect_scene(folder, &record, scene, &mut report)?);
    }
    let metrics = report.manifest.metrics.clone();
    report.curves = curves(&report.rows, &metrics);
    report.summary = summarise(&report.rows);
    report.verdicts = verdicts(&report.rows, &metrics);
    for row in &mut report.summary {
        let of_row = |spread: &&Spread| (&spread.scene, &spread.method) == (&row.scene, &row.method);
        if let Some(spread) = spreads.iter().find(of_row) {
            row.variance = spread.variance;
            (row.bias2, row.bias2_error) = spread.bias.map(|bias| (bias.squared, bias.error)).unzip();
        }
    }
    folder.write_table("rows.csv", &report.rows)?;
    folder.write_table("curves.csv", &report.curves)?;
    folder.write_table("verdicts.csv", &report.verdicts)?;
    folder.write_table("summary.csv", &report.summary)?;
    folder.write_table("agreement.csv", &report.agreement)?;
    Ok(report)
}

/// Of the images of a method on a scene over all its seeds, on whatever machine they were made.
struct Spread {
    scene: String,
    method: String,
    variance: Option<f64>,
    bias: Option<Bias>,
}

fn collect_scene(
    folder: &Folder,
    record: &Record,
    scene: &ScenePlan,
    report: &mut Report,
) -> Result<Vec<Spread>, ExperimentError> {
    let texts: BTreeMap<String, String> =
        report.manifest.methods.iter().map(|method| (method.label(), method.text())).collect();
    let mut members = Vec::new();
    for label in report.manifest.methods.iter().map(|method| method.label()) {
        let (Some((label, text)), Some(&stream)) = (texts.get_key_value(&label), record.streams.get(&label)) else {
            continue;
        };
        if scene.skipped.contains_key(label) {
            continue;
        }
        let mut member = Member { label, name: name_of(text), pool: Pool::default() };
        for repetition in 0..report.manifest.seeds {
            let seed = seed_of(report.manifest.seed, stream, repetition);
            let Some((_, run)) = job::load(&folder.run(&scene.name, label, seed))? else {
                report.missing += 1;
                continue;
            };
            member.pool.add(&run);
            report.rows.extend(run.rows);
        }
        if report.manifest.images {
            folder.write_mean(&scene.name, label, &member.pool)?;
        }
        members.push(member);
    }
    report.rows.extend(score::rows_of(folder, &scene.name)?);
    members.retain(|member| !member.pool.is_empty());
    let file = folder.reference(&scene.name);
    let reference = if file.exists() { Some(reference::read_reference(&file)?) } else { None };
    with_truth(scene, reference.as_ref(), &members, report)?;
    among(&scene.name, &members, report)?;
    let spread = |member: &Member<'_>| Spread {
        scene: scene.name.clone(),
        method: member.label.to_owned(),
        variance: member.pool.replicas.variance(),
        bias: reference.as_ref().and_then(|reference| member.pool.replicas.bias(reference)),
    };
    Ok(members.iter().map(spread).collect())
}

/// Each method against what its errors are measured against.
fn with_truth(
    scene: &ScenePlan,
    reference: Option<&Reference>,
    members: &[Member<'_>],
    report: &mut Report,
) -> Result<(), ExperimentError> {
    if let Some(exact) = scene.exact {
        for member in members {
            let row =
                agreement::with_exact(&scene.name, member.label, &member.pool, Rgb::from(exact), member.is_light())?;
            report.agreement.extend(row);
        }
        return Ok(());
    }
    for (member, reference) in members.iter().flat_map(|member| Some((member, reference?))) {
        let row = agreement::with_reference(&scene.name, member.label, &member.pool, reference, member.is_light())?;
        report.agreement.extend(row);
    }
    Ok(())
}

/// The first method of Mitsuba, or else the first, is what the others are tested against.
fn among(scene: &str, members: &[Member<'_>], report: &mut Report) -> Result<(), ExperimentError> {
    let (mut bases, mut others): (Vec<_>, Vec<_>) = members.iter().partition(|member| member.is_mitsubas());
    if bases.is_empty() && !others.is_empty() {
        bases.push(others.remove(0));
    }
    // Where the first one decides nothing, because its passes are heavy-tailed, the next may.
    for (i, base) in bases.iter().enumerate() {
        let mut open = Vec::new();
        let later = if i == 0 { &bases[1..] } else { &[] };
        for member in others.iter().chain(later) {
            let light = member.is_light() || base.is_light();
            let row = agreement::between((scene, member.label, base.label), &member.pool, &base.pool, light)?;
            if row.as_ref().is_some_and(AgreementRow::is_undecided) && !member.is_mitsubas() {
                open.push(*member);
            }
            report.agreement.extend(row);
        }
        others = open;
        if others.is_empty() {
            break;
        }
    }
    Ok(())
}
