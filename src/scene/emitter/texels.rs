//! Texels of an image drawn by their luminance, and places within what each contributes to its surroundings.

use crate::scene::discrete::Discrete;
use crate::spectrum::Rgb;

/// Chooses a texel in proportion to its luminance and to a factor of its row.
#[derive(Clone, Debug)]
pub(super) struct TexelChoice {
    rows: Discrete,
    columns: Vec<Discrete>,
}

/// A texel, and two numbers uniform in `(0, 1)` that its choice has left over.
pub(super) struct ChosenTexel {
    pub column: usize,
    pub row: usize,
    pub rest: [f64; 2],
}

impl TexelChoice {
    /// Of an image whose colours are finite and not negative.
    pub(super) fn new(
        [width, height]: [usize; 2],
        colour: impl Fn(usize, usize) -> Rgb,
        row_factor: impl Fn(usize) -> f64,
    ) -> Option<Self> {
        let luminances = |row: usize| (0..width).map(|column| colour(column, row).luminance()).collect::<Vec<_>>();
        let mut totals = Vec::with_capacity(height);
        let columns = (0..height).map(|row| {
            let luminances = luminances(row);
            totals.push(luminances.iter().sum::<f64>() * row_factor(row));
            Discrete::new(luminances)
        });
        let columns: Option<Vec<_>> = columns.collect();
        Some(Self { columns: columns?, rows: Discrete::new(totals)? })
    }

    pub(super) fn sample(&self, u: [f64; 2]) -> ChosenTexel {
        // Ends of the interval, where nothing is contributed, are as likely as few digits are left over.
        let inside = |u: f64| u.clamp(1e-15, 1.0 - 1e-15);
        let (row, for_row) = self.rows.split(u[0]);
        let (column, for_column) = self.columns[row].split(u[1]);
        ChosenTexel { column, row, rest: [inside(for_column), inside(for_row)] }
    }
}

/// Inverts the distribution with the density `1 − |x|` on `(−1, 1)`, by which bilinear interpolation spreads a texel.
pub(super) fn tent(u: f64) -> f64 {
    if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 - 2.0 * u).sqrt() }
}
