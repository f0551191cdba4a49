//! The density of every vertex of a path, as walks from either end draw it, in all measures that it has.

use glam::DVec3;

use crate::measure::{Area, Density, Jacobian, ProjectedSolidAngle, SolidAngle};
use crate::scene::Scene;
use crate::scene::bsdf::{LobeDensity, Side};
use crate::scene::emitter::{EdgeDensity, Emitter};

use super::{Edge, Path, Roulette, Vertex};

/// The density with which a walk draws a vertex, given the vertices before. Solid angles are those at the vertex before.
///
/// A measure is `None` where the density has no value in it: a Dirac distribution, the first vertex of a walk (which has no
/// direction), a projected solid angle at a point light or a pinhole, or an area there (neither has a surface).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VertexDensity {
    /// `p_σ` \[1/sr\].
    pub solid_angle: Option<Density<SolidAngle>>,
    /// `p_σ⊥ = p_σ / |cos θ|` \[1/sr\], with θ at the vertex before.
    pub projected_solid_angle: Option<Density<ProjectedSolidAngle>>,
    /// `p_A = p_σ |cos θ| / ‖x−y‖²` \[1/m²\], with θ at the vertex itself.
    pub area: Option<Density<Area>>,
    /// What stands in for a density where there is none.
    pub dirac: Option<DiracDensity>,
    /// The probability with which roulette lets the walk draw the vertex: a factor of the other fields already.
    pub survival: f64,
}

/// The coefficient of a Dirac distribution: how likely what it stands for is, with respect to the measure of its δ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DiracDensity {
    /// A point: of a point or spot light, or a pinhole.
    Area(Density<Area>),
    /// A direction: of a directional light, or an orthographic film.
    SolidAngle(Density<SolidAngle>),
    /// A direction that a mirror or a smooth glass gives, as [`LobeDensity::Dirac`] has it.
    ProjectedSolidAngle(Density<ProjectedSolidAngle>),
}

impl VertexDensity {
    const ABSENT: Self =
        Self { solid_angle: None, projected_solid_angle: None, area: None, dirac: None, survival: 1.0 };

    /// Of the first vertex of a walk.
    fn of_position(at: &Vertex, density: Density<Area>) -> Self {
        if is_surface(at) {
            Self { area: Some(density), ..Self::ABSENT }
        } else {
            Self { dirac: Some(DiracDensity::Area(density)), ..Self::ABSENT }
        }
    }

    /// Of `next`, whose direction from `at` is drawn.
    fn of_direction(at: &Vertex, next: &Vertex, density: Density<SolidAngle>, survival: f64) -> Self {
        let edge = Edge::between(at, next);
        let density = density * survival;
        let projected = || density * Jacobian::solid_angle_to_projected(at.abs_cos(edge.direction));
        Self {
            solid_angle: Some(density),
            projected_solid_angle: is_surface(at).then(projected),
            area: is_surface(next).then(|| density * edge.solid_angle_to_area(next)),
            dirac: None,
            survival,
        }
    }

    fn of_dirac(density: DiracDensity, survival: f64) -> Self {
        Self { dirac: Some(density), survival, ..Self::ABSENT }
    }
}

fn is_surface(vertex: &Vertex) -> bool {
    vertex.normal != DVec3::ZERO
}

impl Scene {
    /// How a walk from one `side` draws x̄: element i is the density of x_i given the vertices that the walk visits before it.
    /// `None` for all vertices from the first on that no such walk draws. The product over its vertices, Dirac coefficients
    /// turned to area, is its share of [`path_density`](Self::path_density) for a walk of two or more vertices.
    ///
    /// Walks from the sensor are those for the pixel that sees the path. With an emitter at infinity, the direction is drawn
    /// first and x_0 for it.
    #[must_use]
    pub fn vertex_densities(&self, path: &Path, side: Side, roulette: Roulette) -> Vec<Option<VertexDensity>> {
        let k = path.edges();
        let index = |i: usize| if side == Side::Emitter { i } else { k - i };
        let walk: Vec<(&Vertex, bool)> = (0..=k).map(|i| (path.vertex(index(i)), path.is_dirac(index(i)))).collect();
        let mut densities = self.first_two(side, walk[0].0, walk[1].0).map_or_else(Vec::new, Vec::from);
        if !densities.is_empty() {
            self.each_step(&walk, side, roulette, |step, survival| {
                let i = densities.len();
                densities.push(match step.direction {
                    LobeDensity::Finite(d) => VertexDensity::of_direction(walk[i - 1].0, walk[i].0, d, survival),
                    LobeDensity::Dirac(d) => {
                        VertexDensity::of_dirac(DiracDensity::ProjectedSolidAngle(d * survival), survival)
                    }
                });
            });
        }
        let mut densities: Vec<_> = densities.into_iter().map(Some).collect();
        densities.resize(k + 1, None);
        if side == Side::Sensor {
            densities.reverse();
        }
        densities
    }

    /// The densities with which s = 1 draws x_0 for x_1 and t = 1 draws x_k for x_{k−1}; solid angles are those at the given
    /// vertex. A path of one edge has [`density_of_two`](Self::density_of_two) instead, of which these are a part.
    #[must_use]
    pub fn direct_densities(&self, path: &Path) -> (Option<VertexDensity>, Option<VertexDensity>) {
        let k = path.edges();
        let (x0, x1, before, xk) = (path.vertex(0), path.vertex(1), path.vertex(k - 1), path.vertex(k));
        let emitter = x0.emitter().map(|id| {
            let edge = Edge::between(x1, x0);
            let density = self.emitter(id).direct_density(self.accel(), x1.position, x0, &edge);
            let one_direction = matches!(self.emitter(id), Emitter::Directional(_));
            direct(x1, x0, self.emitter_probability(id).value() * density, one_direction)
        });
        let density = self.sensor().direct_density(before, xk);
        (emitter, Some(direct(before, xk, density, self.sensor().has_one_direction())))
    }

    fn first_two(&self, side: Side, first: &Vertex, second: &Vertex) -> Option<[VertexDensity; 2]> {
        let direction = Edge::between(first, second).direction;
        let (EdgeDensity { position, direction }, one_direction) = match side {
            Side::Emitter => {
                let id = first.emitter()?;
                let edge = self.emitter(id).emission_density(first, direction);
                let position = self.emitter_probability(id).value() * edge.position;
                (EdgeDensity { position, ..edge }, matches!(self.emitter(id), Emitter::Directional(_)))
            }
            Side::Sensor => (self.sensor().density(first, direction), self.sensor().has_one_direction()),
        };
        let second = if one_direction {
            VertexDensity::of_dirac(DiracDensity::SolidAngle(direction), 1.0)
        } else {
            VertexDensity::of_direction(first, second, direction, 1.0)
        };
        Some([VertexDensity::of_position(first, position), second])
    }
}

/// Of `end`, which is drawn for `given`.
fn direct(given: &Vertex, end: &Vertex, density: Density<Area>, one_direction: bool) -> VertexDensity {
    if !is_surface(end) {
        return VertexDensity::of_dirac(DiracDensity::Area(density), 1.0);
    }
    let edge = Edge::between(given, end);
    let solid_angle = density * Jacobian::area_to_solid_angle(end.abs_cos(edge.direction), edge.length_squared);
    if one_direction {
        return VertexDensity::of_dirac(DiracDensity::SolidAngle(solid_angle), 1.0);
    }
    VertexDensity { area: Some(density), ..VertexDensity::of_direction(given, end, solid_angle, 1.0) }
}
