//! Where an integrator puts what it finds.

use std::fmt::{self, Display, Formatter};

use glam::DVec3;

use crate::path::{Path, Technique};
use crate::scene::Scene;
use crate::scene::sensor::Pixel;
use crate::spectrum::Rgb;

/// One term of the estimator: `w_i(x̄) f_j(x̄) / (n_i p_i(x̄))` for a path x̄ drawn by technique i.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// The pixel j that sees the path.
    pub pixel: Pixel,
    /// The term's value.
    pub value: Rgb,
    /// The technique i.
    pub technique: Technique,
    /// `w_i(x̄)`.
    pub weight: f64,
    /// The number of the sampler in the integrator's definition, where the technique alone does not tell.
    pub sampler: Option<u32>,
}

/// Takes the terms of the estimator one by one.
pub trait Sink {
    /// It looks at the paths themselves. Where it does not, the code that would remember them is not compiled.
    const RECORDS: bool;

    /// Takes a term; `path` makes the path it belongs to, and is called only by sinks that record.
    fn add(&mut self, term: Term, path: impl FnOnce() -> Option<Path>);
}

/// A term with its path, for tests and for looking.
#[derive(Clone, Debug)]
pub struct RecordedTerm {
    /// The term.
    pub term: Term,
    /// Its path.
    pub path: Path,
}

impl RecordedTerm {
    /// For people, with the path's notation and with positions in world coordinates.
    #[must_use]
    pub fn in_world(&self, scene: &Scene) -> impl Display {
        Shown { recorded: self.clone(), path: scene.notation(&self.path), centre: scene.centre() }
    }
}

impl Display for RecordedTerm {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let path = format!("path of {} edges", self.path.edges());
        Shown { recorded: self.clone(), path, centre: DVec3::ZERO }.fmt(f)
    }
}

struct Shown {
    recorded: RecordedTerm,
    /// What to call the path.
    path: String,
    centre: DVec3,
}

impl Display for Shown {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let RecordedTerm { term: Term { pixel, value, technique, weight, .. }, path } = &self.recorded;
        let [r, g, b] = value.to_array();
        writeln!(f, "{} by {technique}: pixel {},{}, weight {weight}, value {r} {g} {b}", self.path, pixel.x, pixel.y)?;
        for (i, vertex) in path.vertices().iter().enumerate() {
            let [x, y, z] = (vertex.position + self.centre).to_array();
            writeln!(f, "  x_{i} {:<9} {x} {y} {z}", vertex.kind.name())?;
        }
        Ok(())
    }
}

/// Remembers everything.
#[derive(Clone, Debug, Default)]
pub struct Recorder {
    /// The terms in the order of their arrival.
    pub terms: Vec<RecordedTerm>,
}

impl Sink for Recorder {
    const RECORDS: bool = true;

    fn add(&mut self, term: Term, path: impl FnOnce() -> Option<Path>) {
        let path = path().expect("an integrator remembers its paths for a sink that records");
        self.terms.push(RecordedTerm { term, path });
    }
}
