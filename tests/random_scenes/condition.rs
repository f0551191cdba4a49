//! How many digits rounding of directions costs.

use glam::DVec3;
use pathspace::estimator::RecordedTerm;
use pathspace::path::Vertex;
use pathspace::scene::Scene;
use pathspace::scene::description::{BsdfDescription, LightKind, Projection, SceneDescription};

/// What f/p of a path may be off by between two ways of computing it, to first order: a walk draws directions, the
/// definition takes them from positions, which are rounded by ε of their size. A direction is then off by ε · size / length,
/// and what depends on it by that much over the width of the narrowest lobe, or over the cosine.
pub fn relative_error(scene: &Scene, description: &SceneDescription, term: &RecordedTerm) -> f64 {
    let bsdfs = description.materials.iter().map(|material| of_bsdf(&material.bsdf));
    let x0 = term.path.vertex(0);
    let first = (term.path.vertex(1).position - x0.position).normalize();
    let lights = description.lights.iter().map(|light| match light.kind {
        LightKind::Spot { position, direction, outer_angle, .. }
            if (position - scene.centre()).distance(x0.position) <= 1e-9 * position.length() =>
        {
            let angle = libm::atan2(direction.cross(first).length(), direction.dot(first));
            1.0 / (outer_angle - angle).max(1e-300)
        }
        _ => 1.0,
    });
    let steepest = bsdfs.chain(lights).fold(1.0, f64::max);
    let vertices = term.path.vertices();
    let size = vertices.iter().map(|vertex| (vertex.position + scene.centre()).abs().max_element()).fold(0.0, f64::max);
    let size = vertices.iter().map(|vertex| vertex.position.abs().max_element()).fold(size, f64::max);
    let per_edge = |pair: &[Vertex]| {
        let offset = pair[1].position - pair[0].position;
        let direction = offset.normalize();
        let cosine = cosine(&pair[0], direction).min(cosine(&pair[1], direction));
        size / offset.length() * (steepest + 1.0 / cosine)
    };
    64.0 * f64::EPSILON * vertices.windows(2).map(per_edge).sum::<f64>()
}

/// Rounding of directions in pixels: samplers keep 1e-9 of a pixel away from its edges, and rounding of more than that may
/// give what is drawn there to a neighbour.
pub fn rounds_beyond_pixels(description: &SceneDescription) -> bool {
    let Some(sensor) = &description.sensor else { return false };
    let in_image = match sensor.projection {
        Projection::Perspective { vertical_fov, lens, .. } => {
            let tangent = libm::tan(0.5 * vertical_fov);
            // A direction's tangent; on a lens also where it is met, over the distance of the plane in focus.
            let offset =
                lens.map_or(0.0, |lens| (lens.aperture_radius + sensor.position.length()) / lens.focus_distance);
            (1.0 + tangent * tangent + offset) / tangent
        }
        Projection::Orthographic { half_height, .. } | Projection::Window { half_height, .. } => {
            1.0 + sensor.position.length() / half_height
        }
        _ => 1.0,
    };
    64.0 * f64::EPSILON * in_image > 1e-9
}

fn cosine(vertex: &Vertex, direction: DVec3) -> f64 {
    if vertex.normal == DVec3::ZERO { 1.0 } else { vertex.normal.dot(direction).abs() }
}

/// The relative slope of a model's lobes, per radian.
pub fn of_bsdf(bsdf: &BsdfDescription) -> f64 {
    // The half vector of refraction at an interface of nearly equal indices turns with the difference's reciprocal.
    let refraction = |ior: f64| 1.0 / (ior - 1.0).abs().max(1e-15);
    let narrow = |alpha: Option<&f64>| alpha.map_or(1.0, |alpha| 1.0 / alpha);
    match bsdf {
        BsdfDescription::RoughConductor { alpha, alpha_v, .. } => {
            narrow(alpha.constant()).max(alpha_v.as_ref().map_or(1.0, |alpha| narrow(alpha.constant())))
        }
        BsdfDescription::RoughDielectric { alpha, alpha_v, interior_ior, .. } => {
            let narrowest = narrow(alpha.constant()).max(alpha_v.as_ref().map_or(1.0, |a| narrow(a.constant())));
            narrowest * refraction(*interior_ior).max(1.0)
        }
        BsdfDescription::RoughPlastic { alpha, .. } => 1.0 / alpha,
        BsdfDescription::Principled(principled) => {
            let roughness = principled.roughness.constant().copied().unwrap_or(1.0);
            1e4_f64.max(1.0 / (roughness * roughness).max(1e-8)) * refraction(principled.eta).max(1.0)
        }
        BsdfDescription::Gltf(gltf) => {
            let of = |roughness: f64| 1.0 / (roughness * roughness).max(1e-8);
            let coat = gltf.clearcoat.as_ref().map_or(1.0, |coat| of(coat.roughness.factor[1]));
            of(gltf.metallic_roughness.factor[1]).max(coat) * refraction(gltf.ior).max(1.0)
        }
        BsdfDescription::Mask { nested, .. } => of_bsdf(nested),
        BsdfDescription::Blend { first, second, .. } => of_bsdf(first).max(of_bsdf(second)),
        _ => 1.0,
    }
}
