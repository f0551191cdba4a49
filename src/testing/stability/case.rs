//! What is swept, and what is true of it.

use crate::scene::SceneDescription;

use super::journal::Journal;

/// Something difficult, from tame to extreme.
#[derive(Clone)]
pub struct Case {
    /// What is difficult about it: `stiff`, `scale`, `geometry`, `material`, `light`, `sensor`, `algebra` or `random`.
    pub group: &'static str,
    /// Name within the group.
    pub name: &'static str,
    /// What is swept, with its unit.
    pub parameter: &'static str,
    /// From tame to extreme.
    pub values: Vec<f64>,
    /// What is seen, and how the truth is known.
    pub about: &'static str,
    /// Where it ends by nature.
    pub limit: Option<Limit>,
    /// What to measure for a value of the parameter.
    pub subject: Subject,
}

/// What a case measures.
#[derive(Clone, Copy)]
pub enum Subject {
    /// The mean luminance of an image, by each method.
    Scene(fn(f64) -> Stage),
    /// A number that the library itself computes, without a method.
    Number(fn(f64) -> Exact),
    /// Paths with all their numbers, which are evaluated a second time elsewhere.
    Journal(fn(f64) -> Journal),
}

/// Beyond some value no implementation in double precision can hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// The last value that has to hold; those after it in the sweep need not.
    pub last: f64,
    /// Why.
    pub why: &'static str,
}

/// A scene and its truth.
#[derive(Clone, Debug)]
pub struct Stage {
    /// The scene.
    pub scene: SceneDescription,
    /// Of the mean luminance of the image.
    pub truth: Truth,
    /// Relative error of the truth, or of rounding on the way to it.
    pub tolerance: f64,
    /// Paths are drawn as they are at the tame value, but for a map of space: light is no rarer.
    pub alike: bool,
    /// Why the truth is not that of other programs, which mean another image by the same scene.
    pub ours_alone: Option<&'static str>,
}

/// What the mean luminance of an image is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Truth {
    /// This, from a closed form or a quadrature \[W/m²/sr\].
    Value(f64),
    /// That of the case's tame value times this factor, with the same random numbers.
    Tame(f64),
}

/// A number without noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exact {
    /// What is computed.
    pub estimate: f64,
    /// What is right.
    pub truth: f64,
    /// The relative error that rounding explains.
    pub tolerance: f64,
}

impl Case {
    /// GROUP/NAME.
    #[must_use]
    pub fn full_name(&self) -> String {
        format!("{}/{}", self.group, self.name)
    }

    /// What files of a value are called.
    #[must_use]
    pub fn file_name(&self, value: f64) -> String {
        format!("{}-{}-{value:e}", self.group, self.name.replace(' ', "-"))
    }

    /// It ends before this value by nature.
    #[must_use]
    pub fn is_beyond(&self, value: f64) -> bool {
        let place = |value: f64| self.values.iter().position(|&v| v == value);
        self.limit.is_some_and(|limit| place(value) > place(limit.last))
    }
}

impl Stage {
    /// Relative error of sums of some thousand steps, none of which is known better than 1e-16 of its terms.
    pub const ROUNDING: f64 = 1e-9;

    /// A scene with a truth of its own.
    #[must_use]
    pub fn new(scene: SceneDescription, truth: f64) -> Self {
        Self { scene, truth: Truth::Value(truth), tolerance: Self::ROUNDING, alike: false, ours_alone: None }
    }

    /// With a truth that is not known better than this.
    #[must_use]
    pub fn within(self, tolerance: f64) -> Self {
        Self { tolerance, ..self }
    }

    /// A scene that has to look as the tame one does, but for a factor.
    #[must_use]
    pub fn as_tame(scene: SceneDescription, factor: f64) -> Self {
        Self { scene, truth: Truth::Tame(factor), tolerance: Self::ROUNDING, alike: true, ours_alone: None }
    }
}
