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

#[cfg(test)]
mod tests {
    use super::super::all;
    use super::*;

    #[test]
    fn the_last_value_that_holds_and_what_comes_after() {
        let case = &all()[0];
        let cells: Vec<Cell> = [Verdict::Holds, Verdict::Holds, Verdict::Noise, Verdict::Fails]
            .into_iter()
            .zip(&case.values)
            .map(|(verdict, &value)| Cell { verdict, ..Cell::of(case, value, "m") })
            .collect();
        let of = |n: usize| outcome(&cells[..n].iter().collect::<Vec<_>>()).first.map(|cell| cell.verdict);
        assert_eq!([2, 3, 4].map(of), [None, Some(Verdict::Noise), Some(Verdict::Fails)]);
        assert_eq!(outcome(&cells.iter().collect::<Vec<_>>()).last, Some(case.values[1]));
    }

    #[test]
    fn cases_have_names_of_their_own_values_and_a_truth_that_is_told() {
        let cases = all();
        for (i, case) in cases.iter().enumerate() {
            let name = case.full_name();
            assert!(cases[..i].iter().all(|other| other.full_name() != name), "{name} twice");
            assert!(case.values.len() >= 3 && !case.about.is_empty(), "{name}");
            assert!(case.limit.is_none_or(|limit| case.values.contains(&limit.last)), "{name}");
        }
    }
}
