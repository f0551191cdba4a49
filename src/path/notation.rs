//! Heckbert's notation of light paths.

use crate::scene::Scene;

use super::Path;

impl Scene {
    /// How a path scatters, from the light to the eye (Heckbert 1990, §2): `L`, then a letter for each inner vertex, then
    /// `E`. `S` is a Dirac lobe, `D` a diffuse surface, and `G` a glossy one, that is, any other finite lobe.
    #[must_use]
    pub fn notation(&self, path: &Path) -> String {
        (0..=path.edges()).map(|i| self.letter(path, i)).collect()
    }

    /// The letter of x_i in [`notation`](Self::notation).
    #[must_use]
    pub fn letter(&self, path: &Path, i: usize) -> char {
        match i {
            0 => 'L',
            _ if i == path.edges() => 'E',
            _ if path.is_dirac(i) => 'S',
            _ if self.is_glossy(path.vertex(i)) => 'G',
            _ => 'D',
        }
    }
}
