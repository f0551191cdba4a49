//! Runs cases by methods.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::estimator::{Registry, RegistryError};
use crate::scene::{LightSelection, Scene, SceneOptions};

use super::Effort;
use super::case::{Case, Stage, Subject};
use super::cell::{Cell, Verdict};
use super::judge::too_rare;
use super::sweep::Sweep;

/// What a method is called where there is none.
const CORE: &str = "core";

/// How far a run is.
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a> {
    /// Cases that are finished.
    pub done: usize,
    /// All cases.
    pub of: usize,
    /// The cells of the one that has just been finished.
    pub cells: &'a [Cell],
}

/// The settings of a run.
pub struct Run<'a> {
    /// Where integrators come from.
    pub registry: &'a Registry,
    /// Integrators with their settings.
    pub methods: &'a [String],
    /// What is looked at.
    pub cases: &'a [Case],
    /// How much is drawn.
    pub effort: Effort,
    /// Cases at a time; each is run by one thread.
    pub threads: usize,
}

impl Run<'_> {
    /// The cells of all cases in their order, or of those that were finished when `stop` was told.
    ///
    /// # Errors
    /// Where the registry does not know a method.
    pub fn cells(
        &self,
        stop: &(dyn Fn() -> bool + Sync),
        told: &(dyn Fn(Progress<'_>) + Sync),
    ) -> Result<Vec<Cell>, RegistryError> {
        self.methods.iter().try_for_each(|label| self.registry.build(label, &[]).map(|_| ()))?;
        let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let finished: Mutex<Vec<Option<Vec<Cell>>>> = Mutex::new(vec![None; self.cases.len()]);
        let work = || {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().ok();
            loop {
                let index = next.fetch_add(1, Ordering::Relaxed);
                let Some(case) = self.cases.get(index).filter(|_| !stop()) else { return };
                let cells = match &pool {
                    Some(pool) => pool.install(|| self.case(case, stop)),
                    None => self.case(case, stop),
                };
                if stop() {
                    return;
                }
                told(Progress { done: done.fetch_add(1, Ordering::Relaxed) + 1, of: self.cases.len(), cells: &cells });
                finished.lock().unwrap_or_else(PoisonError::into_inner)[index] = Some(cells);
            }
        };
        std::thread::scope(|scope| (0..self.threads.max(1)).for_each(|_| drop(scope.spawn(work))));
        let finished = finished.into_inner().unwrap_or_else(PoisonError::into_inner);
        Ok(finished.into_iter().flatten().flatten().collect())
    }

    /// All cells of these cases: what the significance is shared by.
    #[must_use]
    pub fn tests(&self) -> usize {
        self.cases.iter().map(|case| self.effort.values(case).len()).sum::<usize>() * self.methods.len().max(1)
    }

    fn case(&self, case: &Case, stop: &(dyn Fn() -> bool + Sync)) -> Vec<Cell> {
        let values = self.effort.values(case);
        match case.subject {
            Subject::Number(compute) => values.into_iter().map(|value| number(case, value, compute)).collect(),
            // Evaluated elsewhere.
            Subject::Journal(_) => Vec::new(),
            Subject::Scene(stage) => {
                let mut sweeps: Vec<Sweep> = self.methods.iter().map(|label| Sweep::new(label)).collect();
                for value in values {
                    if stop() {
                        break;
                    }
                    self.value(case, value, stage, &mut sweeps, stop);
                }
                sweeps.into_iter().flat_map(|sweep| sweep.cells).collect()
            }
        }
    }

    /// Adds a cell to each sweep.
    fn value(
        &self,
        case: &Case,
        value: f64,
        stage: fn(f64) -> Stage,
        sweeps: &mut [Sweep],
        stop: &(dyn Fn() -> bool + Sync),
    ) {
        let stage = stage(value);
        let options = SceneOptions { film: None, light_selection: LightSelection::Power };
        let scene = match Scene::build(&stage.scene, options) {
            Ok((scene, _)) => scene,
            Err(error) => {
                for sweep in sweeps {
                    let cell = Cell::of(case, value, &sweep.label);
                    let details = error.to_string();
                    sweep.cells.push(beyond(case, Cell { verdict: Verdict::Missing, details, ..cell }));
                }
                return;
            }
        };
        for sweep in sweeps.iter_mut() {
            let cell = match self.registry.build(&sweep.label, &[]) {
                Ok(method) => {
                    let cell = || sweep.cell(case, value, &stage, &scene, method.integrator.as_ref(), self, stop);
                    catch_unwind(AssertUnwindSafe(cell)).unwrap_or_else(|_| {
                        let details = "it panicked".to_owned();
                        Cell { verdict: Verdict::Fails, details, ..Cell::of(case, value, &sweep.label) }
                    })
                }
                Err(error) => {
                    let details = error.to_string();
                    Cell { verdict: Verdict::Missing, details, ..Cell::of(case, value, &sweep.label) }
                }
            };
            sweep.cells.push(beyond(case, cell));
        }
        let mut last: Vec<&mut Cell> = sweeps.iter_mut().filter_map(|sweep| sweep.cells.last_mut()).collect();
        let found = last.iter().any(|cell| cell.verdict == Verdict::Holds);
        if found && !stage.alike && value != case.values[0] {
            last.iter_mut().for_each(|cell| too_rare(cell));
        }
    }
}

/// A cell that does not hold where nothing can says so. Values that cannot be right are no excuse.
#[must_use]
pub fn beyond(case: &Case, cell: Cell) -> Cell {
    let impossible = cell.invalid.unwrap_or(0) + cell.negative.unwrap_or(0) > 0 || cell.details.contains("panic");
    match case.limit {
        Some(limit) if cell.is_bad() && case.is_beyond(cell.value) && !impossible => {
            Cell { verdict: Verdict::Beyond, details: format!("{}: {}", limit.why, cell.details), ..cell }
        }
        _ => cell,
    }
}

/// A number that needs no method.
fn number(case: &Case, value: f64, compute: fn(f64) -> super::Exact) -> Cell {
    let exact = compute(value);
    let scale = if exact.truth == 0.0 { 1.0 } else { exact.truth.abs() };
    let difference = (exact.estimate - exact.truth) / scale;
    let holds = difference.abs() <= exact.tolerance;
    let cell = Cell {
        verdict: if holds { Verdict::Holds } else { Verdict::Fails },
        estimate: Some(exact.estimate),
        truth: Some(exact.truth),
        difference: Some(difference),
        detectable: Some(exact.tolerance),
        details: if holds { String::new() } else { format!("off by {difference:.1e}") },
        ..Cell::of(case, value, CORE)
    };
    beyond(case, cell)
}
