//! Paths as sequences of vertices, and the techniques that can draw them.

use super::Vertex;

/// x̄ = x_0 … x_k, with x_0 on an emitter and x_k on the sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    vertices: Vec<Vertex>,
    dirac: Vec<bool>,
}

/// How a path is drawn: s vertices by a walk from the emitter, t by one from the sensor, s + t = k + 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Technique {
    /// Vertices of the walk from the emitter.
    pub s: u32,
    /// Vertices of the walk from the sensor.
    pub t: u32,
}

impl Technique {
    /// All techniques of paths with `edges` edges, in order of s.
    pub fn all(edges: u32) -> impl Iterator<Item = Self> {
        (0..=edges + 1).map(move |s| Self { s, t: edges + 1 - s })
    }

    /// Length of its paths in edges, k = s + t − 1.
    #[must_use]
    pub fn edges(self) -> u32 {
        self.s.saturating_add(self.t).saturating_sub(1)
    }
}

impl std::fmt::Display for Technique {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "s={},t={}", self.s, self.t)
    }
}

impl Path {
    /// From its vertices, each with whether the path takes a Dirac lobe there. `None` for fewer than two vertices.
    #[must_use]
    pub fn new(vertices: impl IntoIterator<Item = (Vertex, bool)>) -> Option<Self> {
        let (vertices, mut dirac): (Vec<_>, Vec<_>) = vertices.into_iter().unzip();
        if let (Some(first), true) = (dirac.first_mut(), vertices.len() >= 2) {
            *first = false;
            *dirac.last_mut()? = false;
            return Some(Self { vertices, dirac });
        }
        None
    }

    /// Number of edges k.
    #[must_use]
    pub fn edges(&self) -> usize {
        self.vertices.len() - 1
    }

    /// x_i.
    #[must_use]
    pub fn vertex(&self, i: usize) -> &Vertex {
        &self.vertices[i]
    }

    /// x_0 … x_k.
    #[must_use]
    pub fn vertices(&self) -> &[Vertex] {
        &self.vertices
    }

    /// The path takes a Dirac lobe at x_i; at its ends it takes none.
    #[must_use]
    pub fn is_dirac(&self, i: usize) -> bool {
        self.dirac[i]
    }
}
