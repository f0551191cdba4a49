//! What the cells of a case say together.

use super::cell::{Cell, Verdict};

/// Of a case and a method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome<'a> {
    /// The last value up to which all hold.
    pub last: Option<f64>,
    /// The first cell that does not hold.
    pub first: Option<&'a Cell>,
}

/// Of cells from tame to extreme. A cell that fails beyond one that says nothing is not overlooked.
#[must_use]
pub fn outcome<'a>(cells: &[&'a Cell]) -> Outcome<'a> {
    let holds = |cell: &&&Cell| cell.verdict == Verdict::Holds;
    let held = cells.iter().take_while(holds).count();
    let bad = cells.iter().find(|cell| cell.is_bad());
    Outcome { last: held.checked_sub(1).map(|i| cells[i].value), first: bad.or(cells.get(held)).copied() }
}
