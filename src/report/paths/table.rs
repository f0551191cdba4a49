//! The path log for a terminal of 80 columns.

use std::fmt::Write;

use crate::estimator::Combination;
use crate::report::table::number;
use crate::report::{TABLE_WIDTH, cut};
use crate::spectrum::Rgb;

use super::{DensityRecord, PathRecord, VertexRecord};

/// Lines for people: one for each path, and below it one for each vertex if asked for.
#[derive(Clone, Copy, Debug)]
pub struct PathTable {
    /// Show the vertices too.
    pub vertices: bool,
    /// Show the number of the sampler: several have the same (s, t).
    pub samplers: bool,
    /// Show the probability of the length: it is drawn in advance.
    pub lengths: bool,
}

impl PathTable {
    /// What there is to tell of the paths of an integrator.
    #[must_use]
    pub fn new(vertices: bool, definition: Option<&Combination>) -> Self {
        // Longer than all that a sampler may have of its own: shorter paths can look like another technique.
        const LONG: u32 = 1 << 20;
        let technique = |i: usize| definition.map(|definition| definition.samplers[i].technique(LONG));
        let count = definition.map_or(0, |definition| definition.samplers.len());
        let samplers = (0..count).any(|i| (0..i).any(|j| technique(i) == technique(j)));
        Self { vertices, samplers, lengths: definition.is_some_and(|definition| definition.lengths.ends()) }
    }

    /// The names of the columns.
    #[must_use]
    pub fn header(&self) -> String {
        let mut text = format!(
            "{:>9} {:>6} {:>5} {:>8} {:>9} {:>9} {:>8}  path\n",
            "pixel", "sample", "s,t", "weight", "adds", "f", "ln p"
        );
        if self.vertices {
            let _ = writeln!(
                text,
                "  {:<5} {:<1} {:<8} {:<12} {:>8} {:>8} {:>8} {:>9} {:>9}",
                "", "", "kind", "of", "x [m]", "y", "z", "p_emitter", "p_sensor"
            );
        }
        text
    }

    /// What the columns mean, in sentences.
    #[must_use]
    pub fn legend(&self) -> String {
        let mut text = "adds, f: luminance of w f/(n p) [W/m²/sr] and of f(x̄); p: in area; →: seen by\n".to_owned();
        if self.samplers {
            text += "#: number of the sampler, from 0\n";
        }
        if self.lengths {
            text += "P: probability of the length, drawn in advance; adds is over P, too\n";
        }
        if self.vertices {
            text += "p_emitter, p_sensor: density in walks from either end [1/m²]; δ: Dirac\n";
        }
        text
    }

    /// A path.
    #[must_use]
    pub fn lines(&self, record: &PathRecord) -> String {
        let [x, y] = record.pixel;
        let adds =
            record.contribution.iter().all(Option::is_some).then(|| record.contribution.map(Option::unwrap_or_default));
        let start = format!(
            "{:>9} {:>6} {:>5} {:>8} {:>9} {:>9} {:>8}  ",
            format!("{x},{y}"),
            record.sample,
            format!("{},{}", record.s, record.t),
            number(record.weight),
            luminance(adds),
            luminance(record.f),
            record.ln_p.map_or("-".to_owned(), |ln_p| format!("{ln_p:.2}")),
        );
        let mut more = String::new();
        if let Some(sampler) = record.sampler.filter(|_| self.samplers) {
            let _ = write!(more, " #{sampler}");
        }
        if let Some(probability) = record.own().map(|own| own.length_probability).filter(|_| self.lengths) {
            let _ = write!(more, " P={}", number(probability));
        }
        let more = if record.seen_by == record.pixel {
            more
        } else {
            format!("{more} →{},{}", record.seen_by[0], record.seen_by[1])
        };
        let left = TABLE_WIDTH.saturating_sub(start.chars().count() + more.chars().count()).max(4);
        let mut text = format!("{start}{}{more}\n", cut(&record.notation, left));
        if self.vertices {
            for (i, vertex) in record.vertices.iter().enumerate() {
                text += &vertex_line(i, vertex);
            }
        }
        text
    }
}

fn vertex_line(i: usize, vertex: &VertexRecord) -> String {
    let [x, y, z] = vertex.position.map(number);
    let of = vertex.emitter.as_ref().or(vertex.material.as_ref()).map_or("", |named| &named.name);
    let (emitter, sensor) = (density(vertex.from_emitter), density(vertex.from_sensor));
    let (name, kind, of, letter) = (format!("x_{i}"), &vertex.kind, cut(of, 12), vertex.letter);
    format!("  {name:<5} {letter} {kind:<8} {of:<12} {x:>8} {y:>8} {z:>8} {emitter:>9} {sensor:>9}\n")
}

fn luminance(value: Option<[f64; 3]>) -> String {
    value.map_or("-".to_owned(), |value| number(Rgb::from(value).luminance()))
}

fn density(record: Option<DensityRecord>) -> String {
    match record {
        Some(DensityRecord { area: Some(area), .. }) => number(area),
        Some(DensityRecord { dirac: Some(_), .. }) => "δ".to_owned(),
        _ => "-".to_owned(),
    }
}
