//! Points of the scene's surfaces, uniform by area.

use glam::DVec3;

use crate::geometry::Ray;
use crate::measure::{Area, Density};
use crate::path::Vertex;
use crate::warp;

use super::Scene;
use super::accel::{Hit, PrimitiveId};
use super::discrete::Discrete;

/// All surfaces of a scene as one, to draw points of.
#[derive(Clone, Debug)]
pub struct Surfaces {
    primitives: Vec<PrimitiveId>,
    choice: Discrete,
    area: f64,
}

impl Surfaces {
    pub(super) fn new(scene: &Scene) -> Option<Self> {
        let accel = scene.accel();
        let triangles = accel.triangles().map(|(id, triangle)| (id, triangle.area()));
        let analytic = accel.analytic().iter().enumerate().map(|(i, shape)| (accel.analytic_id(i), shape.area()));
        let (primitives, areas): (Vec<_>, Vec<_>) = triangles.chain(analytic).unzip();
        let area = areas.iter().sum();
        let choice = Discrete::new(areas).filter(|choice| !choice.is_empty() && area > 0.0)?;
        Some(Self { primitives, choice, area })
    }

    /// One shape alone, by its number in the scene; `None` where it has no area.
    pub(super) fn of_shape(scene: &Scene, shape: u32) -> Option<Self> {
        let accel = scene.accel();
        let triangles = accel.triangles().filter(|(_, triangle)| triangle.shape == shape);
        let triangles = triangles.map(|(id, triangle)| (id, triangle.area()));
        let analytic = accel.analytic().iter().enumerate().filter(|(_, other)| other.shape() == shape);
        let analytic = analytic.map(|(i, shape)| (accel.analytic_id(i), shape.area()));
        let mut primitives: Vec<(PrimitiveId, f64)> = triangles.chain(analytic).collect();
        primitives.sort_by_key(|(id, _)| id.0);
        let (primitives, areas): (Vec<_>, Vec<_>) = primitives.into_iter().unzip();
        let area = areas.iter().sum();
        let choice = Discrete::new(areas).filter(|choice| !choice.is_empty() && area > 0.0)?;
        Some(Self { primitives, choice, area })
    }

    /// A primitive of a [shape](Self::of_shape) that is one of it.
    pub(super) fn contains(&self, primitive: PrimitiveId) -> bool {
        self.primitives.binary_search_by_key(&primitive.0, |id| id.0).is_ok()
    }

    /// Those primitives alone whose points satisfy `keep`; `None` where there are none.
    #[must_use]
    pub fn restricted(&self, scene: &Scene, keep: impl Fn(&Vertex) -> bool) -> Option<Self> {
        let of = |primitive: &PrimitiveId| keep(&point(scene, *primitive, [0.5; 2]));
        let primitives: Vec<PrimitiveId> = self.primitives.iter().copied().filter(|primitive| of(primitive)).collect();
        let area_of = |&primitive: &PrimitiveId| match scene.accel().as_analytic(primitive) {
            Some(shape) => shape.area(),
            None => scene.accel().triangles().find(|(id, _)| *id == primitive).map_or(0.0, |(_, t)| t.area()),
        };
        let areas: Vec<f64> = primitives.iter().map(area_of).collect();
        let area = areas.iter().sum();
        let choice = Discrete::new(areas).filter(|choice| !choice.is_empty() && area > 0.0)?;
        Some(Self { primitives, choice, area })
    }

    /// Their area; both sides of a surface count once \[m²\].
    #[must_use]
    pub fn area(&self) -> f64 {
        self.area
    }

    /// `1 / area` \[1/m²\].
    #[must_use]
    pub fn density(&self) -> Density<Area> {
        Density::new(1.0 / self.area)
    }

    /// Draws a point; `u` is uniform in `[0, 1)³`.
    #[must_use]
    pub fn sample(&self, scene: &Scene, u: [f64; 3]) -> Vertex {
        point(scene, self.primitives[self.choice.sample(u[0])], [u[1], u[2]])
    }
}

/// A point of a primitive, uniform by area.
fn point(scene: &Scene, primitive: PrimitiveId, u: [f64; 2]) -> Vertex {
    let [_, v, w] = warp::uniform_triangle(u);
    // A ray that has arrived.
    let start = scene.accel().as_analytic(primitive).map_or(DVec3::ZERO, |shape| shape.sample(u).position);
    scene.surface_vertex(&Ray::new(start, DVec3::Z), &Hit { t: 0.0, primitive, barycentric: [v, w] })
}
