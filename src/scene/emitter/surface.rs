//! Surfaces that emit from their front, with the same radiance in all directions.

use glam::DVec3;

use crate::geometry::Frame;
use crate::measure::{Area, Density, Jacobian, SolidAngle};
use crate::path::{Edge, Vertex, VertexKind};
use crate::scene::accel::{Accel, AnalyticShape, PrimitiveId, ShapePoint, SphereShape};
use crate::scene::texture::Parameter;
use crate::scene::{MaterialId, discrete::Discrete};
use crate::spectrum::Rgb;
use crate::warp;

use super::{DirectSample, EdgeDensity, EmissionSample, EmitterId};

/// A triangle mesh that emits.
#[derive(Clone, Debug)]
pub struct MeshEmitter {
    /// Its own id.
    pub id: EmitterId,
    /// Radiance of the front \[W/m²/sr\].
    pub radiance: Parameter<Rgb>,
    /// π times the integral of the radiance over the surface \[W\].
    pub flux: Rgb,
    /// Total area \[m²\].
    pub area: f64,
    /// The triangles, by id.
    pub triangles: Vec<PrimitiveId>,
    /// Chooses one of them in proportion to its area.
    pub choice: Discrete,
    /// How it scatters.
    pub material: MaterialId,
}

/// An analytic shape that emits.
#[derive(Clone, Debug)]
pub struct ShapeEmitter {
    /// Its own id.
    pub id: EmitterId,
    /// Radiance of the front \[W/m²/sr\].
    pub radiance: Parameter<Rgb>,
    /// π times the integral of the radiance over the surface \[W\].
    pub flux: Rgb,
    /// Area \[m²\].
    pub area: f64,
    /// The shape.
    pub primitive: PrimitiveId,
    /// How it scatters.
    pub material: MaterialId,
}

/// `p(x_0) = 1/A`, `p_σ(ω) = cos θ_0 / π`.
#[inline]
pub(super) fn emission_density(area: f64, x0: &Vertex, direction: DVec3) -> EdgeDensity {
    EdgeDensity {
        position: Density::new(1.0 / area),
        direction: warp::cosine_hemisphere_density(x0.normal.dot(direction)),
    }
}

impl MeshEmitter {
    #[inline(always)]
    fn vertex(&self, accel: &Accel, [choice, u, v]: [f64; 3]) -> Vertex {
        let primitive = self.triangles[self.choice.sample(choice)];
        let triangle = accel.triangle(primitive);
        let normal = accel.normal(primitive);
        let [_, v, w] = warp::uniform_triangle([u, v]);
        Vertex {
            position: triangle.point([v, w]),
            normal,
            shading_normal: normal,
            kind: VertexKind::Surface { primitive, material: self.material, emitter: Some(self.id) },
        }
    }

    pub(super) fn sample_emission(&self, accel: &Accel, u: [f64; 5]) -> EmissionSample {
        let vertex = self.vertex(accel, [u[0], u[1], u[2]]);
        emit_from(vertex, [u[3], u[4]])
    }

    #[inline(always)]
    pub(super) fn sample_direct(&self, accel: &Accel, u: [f64; 3]) -> DirectSample {
        DirectSample { vertex: self.vertex(accel, u), density: self.direct_density() }
    }

    #[inline]
    pub(super) fn direct_density(&self) -> Density<Area> {
        Density::new(1.0 / self.area)
    }
}

impl ShapeEmitter {
    pub(super) fn sample_emission(&self, accel: &Accel, u: [f64; 5]) -> EmissionSample {
        emit_from(self.vertex(self.shape(accel).sample([u[1], u[2]])), [u[3], u[4]])
    }

    /// From a sphere seen from outside, uniform in the cone that it fills; from other shapes uniform by area.
    pub(super) fn sample_direct(&self, accel: &Accel, x1: DVec3, u: [f64; 2]) -> Option<DirectSample> {
        let shape = self.shape(accel);
        let AnalyticShape::Sphere(sphere @ SphereShape { inward: false, .. }) = shape else {
            return Some(DirectSample { vertex: self.vertex(shape.sample(u)), density: self.uniform_density() });
        };
        let cone = cone(sphere, x1)?;
        let frame = Frame::around(cone.axis);
        // At the very silhouette the density in area is zero, and rounding decides whether the point faces x_1.
        let local = warp::uniform_cone([u[0].min(1.0 - 1e-12), u[1]], cone.one_minus_cos_max);
        // The point of the sphere that this direction meets first, as an angle α at the centre (pbrt 4, §6.2.4).
        let sin2 = local.x * local.x + local.y * local.y;
        let cos_alpha = sin2 / cone.sin_max + local.z * (1.0 - sin2 / (cone.sin_max * cone.sin_max)).max(0.0).sqrt();
        let sin_alpha = (1.0 - cos_alpha * cos_alpha).max(0.0).sqrt();
        let scale = if sin2 > 0.0 { sin_alpha / sin2.sqrt() } else { 0.0 };
        let outward = frame.to_world(DVec3::new(local.x * scale, local.y * scale, -cos_alpha));
        let vertex = self.vertex(sphere.along(outward));
        let density = warp::uniform_cone_density(cone.one_minus_cos_max)
            * Edge::from_to(x1, vertex.position).solid_angle_to_area(&vertex);
        Some(DirectSample { vertex, density })
    }

    pub(super) fn direct_density(&self, accel: &Accel, x1: DVec3, x0: &Vertex, edge: &Edge) -> Density<Area> {
        let AnalyticShape::Sphere(sphere @ SphereShape { inward: false, .. }) = self.shape(accel) else {
            return self.uniform_density();
        };
        let to_area: Jacobian<SolidAngle, Area> = edge.solid_angle_to_area(x0);
        // Only what faces x_1 lies first along its direction.
        match cone(sphere, x1) {
            Some(cone) if x0.normal.dot(edge.direction) < 0.0 => {
                warp::uniform_cone_density(cone.one_minus_cos_max) * to_area
            }
            _ => Density::ZERO,
        }
    }

    fn uniform_density(&self) -> Density<Area> {
        Density::new(1.0 / self.area)
    }

    fn shape<'a>(&self, accel: &'a Accel) -> &'a AnalyticShape {
        accel.as_analytic(self.primitive).expect("the emitter names an analytic shape")
    }

    fn vertex(&self, ShapePoint { position, normal }: ShapePoint) -> Vertex {
        let kind = VertexKind::Surface { primitive: self.primitive, material: self.material, emitter: Some(self.id) };
        Vertex { position, normal, shading_normal: normal, kind }
    }
}

/// The cone of directions from `origin` to a sphere; `None` inside, from where nothing is seen to emit outwards.
fn cone(sphere: &SphereShape, origin: DVec3) -> Option<Cone> {
    let to_centre = sphere.centre - origin;
    let distance = to_centre.length();
    let sin_max = sphere.radius / distance;
    let cos_max = ((distance - sphere.radius) * (distance + sphere.radius)).max(0.0).sqrt() / distance;
    let one_minus_cos_max = sin_max * sin_max / (1.0 + cos_max);
    (distance > sphere.radius).then(|| Cone { axis: to_centre / distance, sin_max, one_minus_cos_max })
}

struct Cone {
    axis: DVec3,
    sin_max: f64,
    one_minus_cos_max: f64,
}

fn emit_from(vertex: Vertex, u: [f64; 2]) -> EmissionSample {
    let direction = Frame::around(vertex.normal).to_world(warp::cosine_hemisphere(u));
    EmissionSample { vertex, direction }
}
