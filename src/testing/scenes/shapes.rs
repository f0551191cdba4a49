//! Scenes of analytic shapes and of light by images.

use std::sync::Arc;

use glam::{DAffine2, DMat3, DVec3};

use crate::scene::SceneDescription;
use crate::scene::description::{
    BsdfDescription, ConductorFresnel, Cylinder, Disk, EnvironmentDescription, FilmSize, Light, LightKind, Material,
    Sphere,
};
use crate::scene::texture::{Bitmap, Filter, Parameter, Texels, Texture, Wrap};
use crate::spectrum::Rgb;

use super::{diffuse, material, rectangle, room, terrace};

/// A small image of colours between 0 and `most`, black in places, that repeats.
#[must_use]
pub fn patches(width: u32, height: u32, most: f32) -> Bitmap {
    let texel = |i: u32| {
        let value = |step: f64| {
            let x = (f64::from(i + 1) * step).fract();
            if x < 0.3 { 0.0 } else { x as f32 * most }
        };
        [value(0.819_172_513), value(0.671_043_606), value(0.549_700_477), 1.0]
    };
    let texels = Texels::Float((0..width * height).map(texel).collect());
    Bitmap { name: "patches".into(), width, height, texels, filter: Filter::Bilinear, wrap: [Wrap::Repeat; 2] }
}

fn glowing(name: &str, bitmap: &Arc<Bitmap>) -> Material {
    let texture = Texture::Bitmap { bitmap: bitmap.clone(), to_uv: DAffine2::IDENTITY };
    let emission = Parameter::Texture(Arc::new(texture));
    Material { emission, ..diffuse(name, Rgb::grey(0.4), Rgb::BLACK) }
}

/// The room lit by shapes of every kind, seen among others of glass and metal: an ellipse, a disk that faces up, a tube, a
/// shade that emits inwards, a ball, a ball that emits inwards through its perforated front, and a picture. All but two
/// emit by textures.
#[must_use]
pub fn lanterns(film: FilmSize) -> SceneDescription {
    let mut scene = room(film);
    scene.name = "lanterns".into();
    let first = scene.materials.len();
    let bitmap = Arc::new(patches(5, 4, 6.0));
    let metal = ConductorFresnel::Ior { eta: Rgb::new(0.2, 0.9, 1.1), k: Rgb::new(3.9, 2.4, 2.2) };
    let tint = ConductorFresnel::Tint { specular_tint: Rgb::new(0.9, 0.8, 0.7) };
    // Within a diffuse sphere that emits, all techniques are equally dense, and the maximum heuristic throws dice.
    let brushed = Box::new(BsdfDescription::rough_conductor(0.5, tint.clone()));
    scene.materials.extend([
        glowing("glow", &bitmap),
        diffuse("lamp", Rgb::grey(0.3), Rgb::new(2.0, 5.0, 8.0)),
        material("lace", BsdfDescription::Mask { opacity: 0.4.into(), nested: brushed }, Rgb::new(7.0, 4.0, 5.0)),
        material("rough metal", BsdfDescription::rough_conductor(0.25, metal), Rgb::BLACK),
        material("mirror", BsdfDescription::conductor(tint), Rgb::BLACK),
        material("glass", BsdfDescription::dielectric(1.5, 1.0), Rgb::BLACK),
    ]);
    let [glow, lamp, lace, rough, mirror, glass] = [0, 1, 2, 3, 4, 5].map(|i| first + i);
    let disk = |name: &str, centre: [f64; 3], axes: [[f64; 3]; 2], flipped: bool, material: usize| Disk {
        name: name.into(),
        centre: centre.into(),
        axes: axes.map(Into::into),
        flipped,
        material,
    };
    let cylinder = |name: &str, ends: [[f64; 3]; 2], radius: f64, inward: bool, material: usize| {
        let [base, top] = ends.map(DVec3::from_array);
        let (axis, clockwise) = (top - base, inward);
        let meridian = axis.normalize().any_orthonormal_vector();
        Cylinder { name: name.into(), base, axis, radius, meridian, clockwise, inward, material }
    };
    scene.disks = vec![
        disk("ellipse", [-0.5, 1.9, -0.4], [[0.3, 0.0, 0.1], [0.1, 0.0, 0.2]], true, glow),
        disk("upwards", [0.6, 0.7, -0.6], [[0.2, 0.0, 0.0], [0.0, 0.05, -0.2]], false, lamp),
        disk("mirror", [0.95, 1.0, 0.1], [[0.0, 0.4, 0.0], [0.0, 0.0, 0.5]], true, mirror),
    ];
    scene.cylinders = vec![
        cylinder("tube", [[-0.8, 1.5, -0.9], [0.3, 1.6, -0.85]], 0.04, false, glow),
        cylinder("shade", [[0.55, 1.2, 0.0], [0.55, 1.6, 0.05]], 0.2, true, glow),
        cylinder("pillar", [[-0.8, 0.0, 0.3], [-0.75, 1.1, 0.3]], 0.12, false, rough),
        cylinder("glass pipe", [[0.2, 0.65, 0.4], [0.5, 0.75, 0.35]], 0.13, false, glass),
    ];
    let axes =
        DMat3::from_rotation_x(0.7) * DMat3::from_rotation_z(0.4) * DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
    scene.spheres = vec![
        Sphere { axes, ..Sphere::new("ball", DVec3::new(0.2, 1.5, -0.2), 0.1, glow) },
        Sphere { inward: true, ..Sphere::new("lace", DVec3::new(-0.4, 1.4, 0.0), 0.15, lace) },
    ];
    scene.meshes[1].material = glow;
    scene.meshes.push(rectangle("picture", DVec3::new(-0.99, 0.9, 0.2), DVec3::Z * -0.6, DVec3::Y * 0.5, glow));
    scene
}

/// The terrace under an image of the sky, turned and mirrored, with a projector in place of the spot light.
#[must_use]
pub fn observatory(film: FilmSize) -> SceneDescription {
    let mut scene = terrace(film);
    scene.name = "observatory".into();
    let to_world = DMat3::from_rotation_x(0.4) * DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0));
    let bitmap = Arc::new(patches(6, 5, 1.5));
    scene.environment = Some(EnvironmentDescription::Map { bitmap, scale: 0.7, to_world });
    let forward = DVec3::new(-0.2, -1.0, -0.6).normalize();
    scene.lights.retain(|light| light.name != "spot");
    scene.lights.push(Light {
        name: "projector".into(),
        kind: LightKind::Projector {
            position: DVec3::new(0.0, 1.8, 0.8),
            forward,
            up: forward.any_orthonormal_vector(),
            horizontal_fov: 0.9,
            image: Arc::new(patches(4, 3, 2.0)),
            scale: Rgb::new(1.0, 0.8, 0.6),
        },
    });
    scene
}
