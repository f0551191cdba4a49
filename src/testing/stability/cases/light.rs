//! Lights that are small, strong, many, narrow or enclosed.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3};

use super::super::case::{Case, Stage, Subject};
use super::super::truth::square_mean;
use super::case;
use super::scale::emission_of_ball;
use super::scenery::{ASPECT, FILM, FLOOR, SEEN, floor, floor_mean, isotropic, point_light};
use crate::scene::description::{BsdfDescription, EnvironmentDescription, Light, LightKind, Sphere};
use crate::scene::texture::{Bitmap, Texels};
use crate::spectrum::Rgb;
use crate::testing::scenes::{cabinet, diffuse, material, patches, rectangle};

pub(super) fn cases() -> Vec<Case> {
    let new = |name, sweep: (&'static str, &[f64]), stage| case("light", name, sweep, Subject::Scene(stage));
    vec![
        new("small square", ("side", &[1.0, 1e-2, 1e-4, 1e-6, 1e-9]), small_square)
            .about("a square lamp of one watt above the floor: E by quadrature over the lamp"),
        new("small ball", ("radius", &[0.3, 1e-2, 1e-4, 1e-6, 1e-9]), |radius| {
            ball_lamp(radius, None, DVec3::new(0.2, 0.1, 1.5))
        })
        .about("a ball lamp of one watt above the floor: E = Φ cos θ / (4π r²)"),
        new("dim", ("power", &[1.0, 1e-10, 1e-20, 1e-30]), powered)
            .about("all lights so many times as strong: the image, too"),
        new("strong", ("power", &[1.0, 1e10, 1e20, 1e30]), powered).about("the same"),
        new("many", ("lights", &[1.0, 10.0, 1e2, 1e3, 1e4]), many)
            .about("points of intensities over twelve decades above the floor: E = Σ I cos θ / r²"),
        new("narrow spot", ("angle in degrees", &[10.0, 1.0, 0.1, 0.01]), narrow_spot)
            .about("a spot of one watt onto the floor: the mean of E is Φ over the area seen"),
        new("bright texel", ("columns of the map", &[16.0, 256.0, 1024.0, 4096.0]), bright_texel)
            .about("a black environment but for one texel: E by quadrature over the texel's footprint"),
        new("lamp in glass", ("index", &[1.0, 1.5, 3.0, 10.0]), |index| {
            ball_lamp(0.05, Some(index), DVec3::new(0.1, 0.05, 1.5))
        })
        .about(
            "a white ball lamp of one watt in the middle of a lossless glass ball: E = Φ cos θ / (4π r²), as without",
        ),
    ]
}

fn small_square(side: f64) -> Stage {
    let centre = DVec3::new(0.2, 0.1, 1.5);
    let mut scene = floor();
    scene.materials.push(diffuse("lamp", Rgb::BLACK, Rgb::grey(1.0 / (PI * side * side))));
    let corner = centre - DVec3::new(0.5, 0.5, 0.0) * side;
    scene.meshes.push(rectangle("lamp", corner, DVec3::Y * side, DVec3::X * side, 1));
    let irradiance = |at: DVec3| {
        let part = |p: DVec2| {
            let way = centre + p.extend(0.0) * (0.5 * side) - at;
            let d2 = way.length_squared();
            way.z * way.z / (d2 * d2)
        };
        square_mean(12, part) / PI
    };
    Stage::new(scene, floor_mean(12, irradiance))
}

/// A ball lamp of one watt, bare or within glass of an index.
fn ball_lamp(radius: f64, glass: Option<f64>, place: DVec3) -> Stage {
    let mut scene = floor();
    // Within glass it gets its own light back, and must not keep it.
    let albedo = if glass.is_some() { Rgb::WHITE } else { Rgb::BLACK };
    scene.materials.push(diffuse("lamp", albedo, emission_of_ball(1.0, radius)));
    scene.spheres.push(Sphere::new("lamp", place, radius, 1));
    if let Some(index) = glass {
        scene.materials.push(material("glass", BsdfDescription::dielectric(index, 1.0), Rgb::BLACK));
        scene.spheres.push(Sphere::new("glass", place, 4.0 * radius, 2));
    }
    Stage::new(scene, floor_mean(16, |at| isotropic(1.0, place, at)))
}

fn powered(power: f64) -> Stage {
    let mut scene = cabinet(FILM);
    for material in &mut scene.materials {
        if let Some(&emission) = material.emission.constant() {
            material.emission = (emission * power).into();
        }
    }
    for light in &mut scene.lights {
        if let LightKind::Point { intensity, .. } | LightKind::Spot { intensity, .. } = &mut light.kind {
            *intensity *= power;
        }
    }
    Stage::as_tame(scene, power)
}

fn many(count: f64) -> Stage {
    // The points of an additive sequence (Roberts 2018), which fill a box evenly.
    let unit = |i: f64, base: f64| ((i + 1.0) * base).fract();
    let light = |i: u32| {
        let i = f64::from(i);
        let [x, y, z] = [0.819_172_513, 0.671_043_606, 0.549_700_477].map(|base| unit(i, base));
        let place = DVec3::new(2.0 * x - 1.0, 2.0 * y - 1.0, 1.2 + z);
        (place, libm::pow(10.0, -12.0 * unit(i, 0.618_033_989)))
    };
    let lights: Vec<(DVec3, f64)> = (0..count as u32).map(light).collect();
    let mut scene = floor();
    scene.lights = lights.iter().map(|&(place, intensity)| point_light(place, intensity)).collect();
    let irradiance = |at| lights.iter().map(|&(place, intensity)| isotropic(4.0 * PI * intensity, place, at)).sum();
    Stage::new(scene, floor_mean(12, irradiance))
}

/// `Φ = 2π I (∫₀^a sin + ∫_a^b (b − θ)/(b − a) sin θ dθ) = 2π I (1 − (sin b − sin a)/(b − a))`.
fn narrow_spot(degrees: f64) -> Stage {
    let (inner, outer) = (0.5 * degrees.to_radians(), degrees.to_radians());
    // (b − a) − (sin b − sin a) without cancellation: 2 h (1 − sinc h cos m), h half the difference, m the middle.
    let (half, middle) = (0.5 * (outer - inner), 0.5 * (outer + inner));
    let deficit = |x: f64| if x < 1e-2 { x * x / 6.0 * (1.0 - x * x / 20.0) } else { 1.0 - libm::sin(x) / x };
    let versine = 2.0 * libm::sin(0.5 * middle).powi(2);
    let share = deficit(half) + versine - deficit(half) * versine;
    let intensity = 1.0 / (2.0 * PI * share);
    let mut scene = floor();
    let kind = LightKind::Spot {
        position: DVec3::new(0.1, 0.05, 1.5),
        direction: -DVec3::Z,
        intensity: Rgb::grey(intensity),
        inner_angle: inner,
        outer_angle: outer,
    };
    scene.lights.push(Light { name: "spot".into(), kind });
    Stage::new(scene, FLOOR / PI / (4.0 * SEEN * SEEN * ASPECT))
}

/// The map's equator lies in the floor's normal plane: `to_world` is the identity, +y the pole.
fn bright_texel(columns: f64) -> Stage {
    let (width, height) = (columns as usize, columns as usize / 2);
    // Where +z is in the map: longitude π from −z by way of +x.
    let (column, row) = (width / 2, height / 2 - height / 8);
    let at = |x: f64, y: f64| {
        let longitude = 2.0 * PI * (x + 0.5) / columns;
        let polar = PI * y / (height as f64 - 1.0);
        let sine = libm::sin(polar);
        (DVec3::new(sine * libm::sin(longitude), libm::cos(polar), -sine * libm::cos(longitude)), sine)
    };
    let cell = 2.0 * PI / columns * PI / (height as f64 - 1.0);
    // ∫ hat · cos θ dω of the texel, over the two cells on either side along both axes.
    let quarter = |sx: f64, sy: f64| {
        0.25 * square_mean(16, |p| {
            let (x, y) = (0.5 * (1.0 + p.x), 0.5 * (1.0 + p.y));
            let (direction, sine) = at(column as f64 + sx * x, row as f64 + sy * y);
            4.0 * (1.0 - x) * (1.0 - y) * direction.z.max(0.0) * sine * cell
        })
    };
    let share = quarter(1.0, 1.0) + quarter(1.0, -1.0) + quarter(-1.0, 1.0) + quarter(-1.0, -1.0);
    // Stored in single precision.
    let bright = share.recip() as f32;
    let mut texels = vec![[0.0, 0.0, 0.0, 1.0]; width * height];
    texels[row * width + column] = [bright, bright, bright, 1.0];
    let (width, height) = (width as u32, height as u32);
    let bitmap = Bitmap { width, height, texels: Texels::Float(texels), ..patches(2, 2, 1.0) };
    let mut scene = floor();
    scene.environment =
        Some(EnvironmentDescription::Map { bitmap: Arc::new(bitmap), scale: 1.0, to_world: DMat3::IDENTITY });
    Stage::new(scene, FLOOR / PI * f64::from(bright) * share)
}
