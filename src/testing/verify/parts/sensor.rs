//! Sensors: where and whereto walks start, over the whole film.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use crate::geometry::Frame;
use crate::path::{Vertex, VertexKind};
use crate::sampler::Random;
use crate::scene::sensor::Pixel;
use crate::scene::{PrimitiveId, Scene};
use crate::warp;

use super::super::report::Check;
use super::counting::Claim;

/// Beyond the widest direction that was drawn, so that the reference covers all.
const MARGIN: f64 = 1.02;

/// The first edge of walks from all pixels; each is counted in the pixel that sees it.
pub(super) fn check(scene: &Scene, place: &str, n: u32, random: &mut Random) -> Check {
    let sensor = scene.sensor();
    let film = sensor.film();
    let pixels = f64::from(film.width) * f64::from(film.height);
    let draw = |random: &mut Random| {
        let [u, v] = random.uniform2();
        let pixel = Pixel { x: (u * f64::from(film.width)) as u32, y: (v * f64::from(film.height)) as u32 };
        sensor.sample(scene, pixel, random)
    };
    // x_k is anywhere on a surface of the scene: what draws it alone is trusted with its place.
    let anywhere = |random: &mut Random| sensor.sample_position(scene, random);
    if let Some(on_surface) = anywhere(&mut random.clone()).filter(|xk| xk.primitive() != PrimitiveId::NONE) {
        let by_area = sensor.density(&on_surface, on_surface.normal).position.value();
        let claim = Claim {
            draw: &|random| Some(draw(random)),
            density: &|(xk, direction): &(Vertex, DVec3)| {
                let density = sensor.density(xk, *direction);
                density.position.value() * density.direction.value() / pixels
            },
            reference: &|random| (anywhere(random).unwrap_or(on_surface), warp::uniform_sphere(random.uniform2())),
            reference_density: &|_| by_area / (2.0 * TAU),
            cell: &|(xk, direction)| {
                let seen = sensor.importance(xk, *direction).map(|importance| importance.pixel);
                let side = 4 * usize::from(direction.dot(xk.normal) > 0.7) + 8 * usize::from(xk.normal.y > 0.5);
                seen.map_or(0, |pixel| 16 + 16 * (pixel.y / 2 * film.width + pixel.x / 2) as usize + side)
            },
        };
        return claim.check("sensor", place, "first edge", n, random);
    }
    let (centre, forward) = sensor.through(0.5 * DVec2::new(film.width.into(), film.height.into()), [0.5; 2]);
    let axis = if centre.normal == DVec3::ZERO { forward } else { centre.normal };
    let mut probe = random.clone();
    let (mut reach, mut height) = (0.0_f64, 0.0_f64);
    for _ in 0..4096 {
        let (vertex, direction) = draw(&mut probe);
        reach = reach.max((vertex.position - sensor.position()).length() * MARGIN);
        height = height.max(0.5 * (direction - axis).length_squared() * MARGIN);
    }
    let frame = Frame::around(axis);
    let spread = |x: f64, u: f64| (2.0 * u - 1.0) * x;
    let claim = Claim {
        draw: &|random| Some(draw(random)),
        density: &|(xk, direction): &(Vertex, DVec3)| {
            let outside = (xk.position - sensor.position()).length() > sensor.extent() * (1.0 + 1e-9);
            if outside || sensor.importance(xk, *direction).is_none() {
                return 0.0;
            }
            let density = sensor.density(xk, *direction);
            density.position.value() * density.direction.value() / pixels
        },
        reference: &|random| {
            let [u, v] = random.uniform2();
            let offset = frame.to_world(DVec3::new(spread(reach, u), spread(reach, v), 0.0));
            let [u, v] = random.uniform2();
            let h = (height * u).min(2.0);
            let (sine, (s, c)) = ((h * (2.0 - h)).max(0.0).sqrt(), libm::sincos(TAU * v));
            let direction = frame.to_world(DVec3::new(sine * c, sine * s, 1.0 - h));
            let kind = VertexKind::Sensor { zeta: random.uniform(), primitive: PrimitiveId::NONE };
            (Vertex { position: sensor.position() + offset, kind, ..centre }, direction)
        },
        reference_density: &|_| {
            let position = if reach > 0.0 { 1.0 / (4.0 * reach * reach) } else { 1.0 };
            let direction = if height > 0.0 { 1.0 / (TAU * height.min(2.0)) } else { 1.0 };
            position * direction
        },
        cell: &|(xk, direction)| {
            let seen = sensor.importance(xk, *direction).map(|importance| importance.pixel);
            let lens = 4 * usize::from((xk.position - sensor.position()).dot(frame.x) > 0.0);
            seen.map_or(0, |pixel| 8 + 8 * (pixel.y / 2 * film.width + pixel.x / 2) as usize + lens)
        },
    };
    claim.check("sensor", place, "first edge", n, random)
}
