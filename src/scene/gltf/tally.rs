//! What was read differently from what the file says, counted over the whole file.

/// Counts and names that become a few sentences at the end, however large the file is.
#[derive(Debug, Default)]
pub(super) struct Tally {
    pub points_and_lines: usize,
    pub without_positions: usize,
    pub zero_area: usize,
    pub bad_normals: usize,
    /// Materials that are more than the models here can say.
    pub simplified: Vec<String>,
    /// Double-sided materials that emit.
    pub one_sided_emission: Vec<String>,
    /// Lights with a range.
    pub ranges: usize,
    /// Sentences of their own.
    pub others: Vec<String>,
}

impl Tally {
    /// One sentence for each kind.
    pub(super) fn sentences(self) -> Vec<String> {
        let mut all = self.others;
        let mut count = |number: usize, one: &str, many: &str, what: &str| {
            if number > 0 {
                all.push(format!("{number} {} {what}", if number == 1 { one } else { many }));
            }
        };
        count(self.points_and_lines, "primitive", "primitives", "of points or lines left out: they have no surface");
        count(self.without_positions, "primitive", "primitives", "without positions left out");
        count(self.zero_area, "triangle", "triangles", "of zero area left out");
        count(self.bad_normals, "vertex", "vertices", "without a usable normal: the geometric one is taken");
        count(self.ranges, "light", "lights", "with a range: it is ignored, light reaches everywhere");
        let simplified = format!(
            "simplified to one diffuse, conductor or dielectric lobe: full glTF materials come later{}",
            names(&self.simplified)
        );
        count(self.simplified.len(), "material", "materials", &simplified);
        let emission = format!("emitting on the front only, though double-sided{}", names(&self.one_sided_emission));
        count(self.one_sided_emission.len(), "material", "materials", &emission);
        all
    }
}

/// The first few names, in brackets.
fn names(all: &[String]) -> String {
    const SHOWN: usize = 4;
    let shown = all.iter().take(SHOWN).map(String::as_str).collect::<Vec<_>>().join(", ");
    let more = if all.len() > SHOWN { ", …" } else { "" };
    format!(" ({shown}{more})")
}
