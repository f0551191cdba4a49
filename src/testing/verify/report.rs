//! What the checks of an integrator found, for people and for tests.

use std::fmt::{self, Display, Formatter};

use crate::report::statistics::holm;

/// Probability that a report on an integrator without error has a failed check.
pub const SIGNIFICANCE: f64 = 1e-3;

/// The power that detectable deviations refer to.
pub const POWER: f64 = 0.9;

/// What a check says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing wrong was found.
    Holds,
    /// Something is wrong.
    Fails,
    /// Nothing can be said, and why.
    Open(String),
}

/// One check in one scene.
#[derive(Clone, Debug)]
pub struct Check {
    /// Which.
    pub name: &'static str,
    /// Where.
    pub scene: String,
    /// What it says. That of a statistical check follows from all p-values together.
    pub verdict: Verdict,
    /// Of a statistical check.
    pub p_value: Option<f64>,
    /// What was measured.
    pub found: String,
    /// What it would have seen.
    pub power: String,
    /// A path on which it failed.
    pub example: Option<String>,
}

impl Check {
    /// A check without chance: it fails where `wrong`.
    pub(super) fn exact(name: &'static str, scene: &str, wrong: bool, found: String, power: String) -> Self {
        let verdict = if wrong { Verdict::Fails } else { Verdict::Holds };
        Self { name, scene: scene.into(), verdict, p_value: None, found, power, example: None }
    }

    /// A check that could not be made.
    pub(super) fn open(name: &'static str, scene: &str, why: impl Into<String>) -> Self {
        let verdict = Verdict::Open(why.into());
        Self {
            name,
            scene: scene.into(),
            verdict,
            p_value: None,
            found: String::new(),
            power: String::new(),
            example: None,
        }
    }
}

/// All checks of an integrator.
#[derive(Clone, Debug)]
pub struct Report {
    /// The integrator, as the user wrote it.
    pub label: String,
    /// The checks.
    pub checks: Vec<Check>,
}

impl Report {
    /// Decides the statistical checks: a p-value, corrected for their number after Holm (1979), below [`SIGNIFICANCE`] is a
    /// failure.
    pub(super) fn new(label: String, mut checks: Vec<Check>) -> Self {
        let p_values: Vec<f64> = checks.iter().filter_map(|check| check.p_value).collect();
        let adjusted = holm(&p_values);
        for (check, adjusted) in checks.iter_mut().filter(|check| check.p_value.is_some()).zip(adjusted) {
            check.verdict = if adjusted <= SIGNIFICANCE { Verdict::Fails } else { Verdict::Holds };
        }
        Self { label, checks }
    }

    /// The checks that failed.
    pub fn failures(&self) -> impl Iterator<Item = &Check> {
        self.checks.iter().filter(|check| check.verdict == Verdict::Fails)
    }

    /// No check failed.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.failures().next().is_none()
    }
}

impl Report {
    /// Every check in a line of its own.
    #[must_use]
    pub fn list(&self) -> String {
        let line = |check: &Check| {
            let Check { name, scene, found, power, .. } = check;
            match &check.verdict {
                Verdict::Holds => format!("holds  {name}, {scene}: {found}; would have seen {power}\n"),
                Verdict::Fails => format!("FAILS  {name}, {scene}: {found}\n"),
                Verdict::Open(why) => format!("open   {name}, {scene}: {why}\n"),
            }
        };
        self.checks.iter().map(line).collect()
    }

    /// Each value once, in the order of the checks.
    fn distinct<'a>(&'a self, of: impl Fn(&'a Check) -> &'a str) -> Vec<&'a str> {
        let mut values = Vec::new();
        for value in self.checks.iter().map(of) {
            if !values.contains(&value) {
                values.push(value);
            }
        }
        values
    }

    /// One word for all checks of a kind in a scene.
    fn cell(&self, name: &str, scene: &str) -> String {
        let checks: Vec<&Check> = self.checks.iter().filter(|c| c.name == name && c.scene == scene).collect();
        let failed = checks.iter().filter(|check| check.verdict == Verdict::Fails).count();
        let open = checks.iter().filter(|check| matches!(check.verdict, Verdict::Open(_))).count();
        match checks.len() {
            0 => "-".into(),
            1 if failed == 1 => "FAILS".into(),
            count if failed > 0 => format!("FAILS {failed}/{count}"),
            count if open == count => "open".into(),
            1 => "holds".into(),
            count => format!("holds {}", count - open),
        }
    }
}

/// As many as fit into 80 columns beside the names of checks.
const SCENES_IN_A_TABLE: usize = 5;

/// Tables of checks and scenes in 80 columns, and what failed on which path.
impl Display for Report {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let (names, scenes) = (self.distinct(|check| check.name), self.distinct(|check| &check.scene));
        let width = names.iter().map(|name| name.chars().count()).max().unwrap_or(0);
        for (i, scenes) in scenes.chunks(SCENES_IN_A_TABLE).enumerate() {
            let label = if i == 0 { self.label.as_str() } else { "" };
            write!(f, "{:width$}", label.chars().take(width).collect::<String>())?;
            scenes.iter().try_for_each(|scene| write!(f, " {scene:>11}"))?;
            writeln!(f)?;
            for name in &names {
                write!(f, "{name:width$}")?;
                scenes.iter().try_for_each(|scene| write!(f, " {:>11}", self.cell(name, scene)))?;
                writeln!(f)?;
            }
        }
        for check in self.failures() {
            writeln!(f, "\n{}: {} fails in {}: {}", self.label, check.name, check.scene, check.found)?;
            if let Some(p_value) = check.p_value {
                writeln!(f, "p-value {p_value:.1e} before correction for {} tests", self.tests())?;
            }
            if let Some(example) = &check.example {
                write!(f, "for example\n{example}")?;
            }
        }
        Ok(())
    }
}

impl Report {
    /// Number of statistical tests.
    fn tests(&self) -> usize {
        self.checks.iter().filter(|check| check.p_value.is_some()).count()
    }
}
