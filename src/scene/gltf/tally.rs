//! What was read differently from what the file says, counted over the whole file.

/// Counts and names that become a few sentences at the end, however large the file is.
#[derive(Debug, Default)]
pub(super) struct Tally {
    pub points_and_lines: usize,
    pub without_positions: usize,
    pub zero_area: usize,
    pub bad_normals: usize,
    /// Materials whose colour is emitted.
    pub unlit: Vec<String>,
    /// Materials that transmit and absorb inside.
    pub absorbing: usize,
    /// Materials with an occlusion texture.
    pub occlusion: usize,
    /// Some texture asks for mipmaps.
    pub mipmaps: bool,
    /// Primitives without the texture coordinates that their material's textures ask for.
    pub without_coordinates: usize,
    /// What Mitsuba's principled model loses of materials, and of which.
    pub lost: Vec<(&'static str, Vec<String>)>,
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
        let coordinates = "without the texture coordinates that their material asks for: (0, 0) is taken";
        count(self.without_coordinates, "primitive", "primitives", coordinates);
        count(self.occlusion, "material", "materials", "with occlusion: it is ignored, light finds its way");
        let absorbing =
            "absorbing inside: by the thickness that the file gives, half of it at each crossing of the surface";
        count(self.absorbing, "material", "materials", absorbing);
        let unlit = format!("unlit: seen as bright as their colour, they emit it{}", names(&self.unlit));
        count(self.unlit.len(), "material", "materials", &unlit);
        let emission = format!("emitting on the front only, though double-sided{}", names(&self.one_sided_emission));
        count(self.one_sided_emission.len(), "material", "materials", &emission);
        for (what, materials) in &self.lost {
            all.push(format!("Mitsuba's principled loses {what}{}", names(materials)));
        }
        if self.mipmaps {
            all.push("mipmaps are ignored: every look at a texture is at full resolution".into());
        }
        all
    }

    /// A material of which something cannot be said.
    pub(super) fn lose(&mut self, what: &'static str, material: &str) {
        match self.lost.iter_mut().find(|(known, _)| *known == what) {
            Some((_, materials)) => materials.push(material.into()),
            None => self.lost.push((what, vec![material.into()])),
        }
    }
}

/// The first few names, in brackets.
fn names(all: &[String]) -> String {
    const SHOWN: usize = 4;
    let shown = all.iter().take(SHOWN).map(String::as_str).collect::<Vec<_>>().join(", ");
    let more = if all.len() > SHOWN { ", …" } else { "" };
    format!(" ({shown}{more})")
}
