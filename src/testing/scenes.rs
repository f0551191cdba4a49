//! Small scenes with known answers, and some that have a bit of everything.

mod shapes;

use std::sync::Arc;

use glam::{DAffine2, DVec2, DVec3, Vec2};

use crate::scene::description::{
    BsdfDescription, ConductorFresnel, FilmSize, Lens, Light, LightKind, Material, Mesh, MicrofacetKind, NormalSource,
    PixelFilter, PrincipledDescription, Projection, SensorDescription, ShapeIndex, Sphere, Target,
};
use crate::scene::texture::{Parameter, Texture};
use crate::scene::{LightSelection, Scene, SceneDescription, SceneOptions};
use crate::spectrum::Rgb;

pub use shapes::{lanterns, observatory, patches};

/// A rectangle with corners `origin`, `origin + u`, `origin + u + v`, `origin + v`; its front is where u × v points.
#[must_use]
pub fn rectangle(name: &str, origin: DVec3, u: DVec3, v: DVec3, material: usize) -> Mesh {
    Mesh {
        name: name.into(),
        positions: vec![origin, origin + u, origin + u + v, origin + v],
        texcoords: Some(vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material,
        ..Mesh::default()
    }
}

/// A box from corner to corner; its front is the inside, or the outside.
#[must_use]
pub fn cuboid(name: &str, min: DVec3, max: DVec3, inwards: bool, material: usize) -> Mesh {
    let corner = |i: usize| {
        let pick = |axis: usize| if i >> axis & 1 == 0 { min[axis] } else { max[axis] };
        DVec3::new(pick(0), pick(1), pick(2))
    };
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let turned = |[a, b, c]: [u32; 3]| if inwards { [a, c, b] } else { [a, b, c] };
    Mesh {
        name: name.into(),
        positions: (0..8).map(corner).collect(),
        triangles: triangles.map(turned).collect(),
        material,
        ..Mesh::default()
    }
}

/// A one-sided material.
#[must_use]
pub fn material(name: &str, bsdf: BsdfDescription, emission: Rgb) -> Material {
    Material { name: name.into(), bsdf, two_sided: false, emission: emission.into() }
}

/// A one-sided diffuse material.
#[must_use]
pub fn diffuse(name: &str, reflectance: Rgb, emission: Rgb) -> Material {
    material(name, BsdfDescription::Diffuse { reflectance: reflectance.into() }, emission)
}

/// A pinhole camera at `position` that looks at `target`.
#[must_use]
pub fn pinhole(position: DVec3, target: DVec3, vertical_fov_degrees: f64) -> SensorDescription {
    let forward = (target - position).normalize();
    let side = if forward.y.abs() < 0.99 { DVec3::Y } else { DVec3::X };
    let right = forward.cross(side).normalize();
    SensorDescription {
        window: SensorDescription::WHOLE,
        name: "camera".into(),
        position,
        forward,
        up: right.cross(forward),
        projection: Projection::Perspective {
            vertical_fov: vertical_fov_degrees.to_radians(),
            aspect: None,
            lens: None,
        },
    }
}

/// Puts a thin lens into a camera.
#[must_use]
pub fn with_lens(mut camera: SensorDescription, aperture_radius: f64, focus_distance: f64) -> SensorDescription {
    if let Projection::Perspective { lens, .. } = &mut camera.projection {
        *lens = Some(Lens { aperture_radius, focus_distance });
    }
    camera
}

/// The closed diffuse box: L = emission / (1 − reflectance) everywhere, or the partial sum for limited lengths.
#[must_use]
pub fn enclosure(emission: Rgb, reflectance: Rgb, film: FilmSize) -> SceneDescription {
    SceneDescription {
        name: "enclosure".into(),
        meshes: vec![cuboid("walls", DVec3::new(-1.0, -0.8, -1.2), DVec3::new(1.0, 0.8, 1.2), true, 0)],
        materials: vec![diffuse("wall", reflectance, emission)],
        sensor: Some(pinhole(DVec3::new(0.3, 0.1, 0.9), DVec3::new(-0.2, -0.1, -1.0), 60.0)),
        film: Some(film),
        ..SceneDescription::default()
    }
}

/// Two unit squares that face each other at distance one, seen from the side; the lower one emits.
#[must_use]
pub fn plates(film: FilmSize) -> SceneDescription {
    SceneDescription {
        name: "plates".into(),
        meshes: vec![
            rectangle("lower", DVec3::ZERO, DVec3::Z, DVec3::X, 0),
            rectangle("upper", DVec3::Y, DVec3::X, DVec3::Z, 1),
        ],
        materials: vec![
            diffuse("lamp", Rgb::new(0.6, 0.4, 0.2), Rgb::new(1.0, 2.0, 3.0)),
            diffuse("grey", Rgb::new(0.5, 0.7, 0.9), Rgb::BLACK),
        ],
        sensor: Some(pinhole(DVec3::new(0.5, 0.5, 2.2), DVec3::new(0.5, 0.5, 0.0), 50.0)),
        film: Some(film),
        ..SceneDescription::default()
    }
}

/// A room with two diffuse blocks and a lamp below the ceiling: 32 triangles.
#[must_use]
pub fn room(film: FilmSize) -> SceneDescription {
    let white = Rgb::new(0.73, 0.71, 0.68);
    let mut scene = SceneDescription {
        name: "room".into(),
        materials: vec![
            diffuse("white", white, Rgb::BLACK),
            diffuse("red", Rgb::new(0.6, 0.06, 0.05), Rgb::BLACK),
            diffuse("lamp", Rgb::grey(0.5), Rgb::new(17.0, 12.0, 4.0)),
        ],
        sensor: Some(pinhole(DVec3::new(0.0, 1.0, 0.95), DVec3::new(0.0, 1.0, -1.0), 65.0)),
        film: Some(film),
        ..SceneDescription::default()
    };
    scene.meshes = vec![
        cuboid("walls", DVec3::new(-1.0, 0.0, -1.0), DVec3::new(1.0, 2.0, 1.0), true, 0),
        rectangle("lamp", DVec3::new(-0.3, 1.95, -0.3), DVec3::X * 0.6, DVec3::Z * 0.6, 2),
        cuboid("tall", DVec3::new(-0.7, 0.001, -0.8), DVec3::new(-0.1, 1.2, -0.2), false, 1),
        cuboid("short", DVec3::new(0.1, 0.001, -0.4), DVec3::new(0.6, 0.6, 0.2), false, 0),
    ];
    scene
}

/// The room with a floor whose normals lean outwards, as those of a curved surface do.
#[must_use]
pub fn relief(film: FilmSize) -> SceneDescription {
    let mut scene = room(film);
    scene.name = "relief".into();
    let mut carpet = rectangle("carpet", DVec3::new(-0.9, 0.05, 0.9), DVec3::X * 1.8, DVec3::Z * -1.8, 1);
    carpet.normals = Some(carpet.positions.iter().map(|p| DVec3::new(0.5 * p.x, 1.0, 0.5 * p.z).normalize()).collect());
    scene.meshes.push(carpet);
    scene
}

/// The relief lit by many lights, of every local kind and of powers over six decades.
#[must_use]
pub fn bazaar(film: FilmSize) -> SceneDescription {
    let mut scene = relief(film);
    scene.name = "bazaar".into();
    // The points of an additive sequence (Roberts 2018), which fill a box evenly; the first number is only the power's.
    let unit = |i: u32, base: f64| (f64::from(i + 1) * base).fract();
    let place = |i: u32| {
        let [x, y, z] = [0.819_172_513, 0.671_043_606, 0.549_700_477].map(|base| unit(i, base));
        DVec3::new(1.8 * x - 0.9, 0.2 + 1.6 * y, 1.8 * z - 0.9)
    };
    let power = |i: u32| libm::pow(10.0, 6.0 * unit(i, 0.618_033_989) - 4.5);
    for i in 0..LIGHTS {
        let (position, colour) = (place(i), Rgb::new(1.0, 0.4 + 0.5 * unit(i, 0.7), 0.3) * power(i));
        let name = format!("light {i}");
        match i % 4 {
            0 => scene.lights.push(Light { name, kind: LightKind::Point { position, intensity: colour } }),
            1 => {
                let direction = (place(i + 1) - position).normalize();
                let (inner_angle, outer_angle) = (0.3, 0.6);
                let kind = LightKind::Spot { position, direction, intensity: colour, inner_angle, outer_angle };
                scene.lights.push(Light { name, kind });
            }
            kind => {
                let material = scene.materials.len();
                scene.materials.push(diffuse(&name, Rgb::grey(0.3), colour * 300.0));
                if kind == 2 {
                    scene.spheres.push(Sphere::new(name, position, 0.02, material));
                } else {
                    scene.meshes.push(rectangle(&name, position, DVec3::X * 0.04, DVec3::Z * 0.04, material));
                }
            }
        }
    }
    scene
}

/// Lights of [`bazaar`] beside the lamp.
const LIGHTS: u32 = 240;

/// The room with every kind of BSDF, emitter and Dirac event, under a thin lens.
#[must_use]
pub fn cabinet(film: FilmSize) -> SceneDescription {
    let mut scene = room(film);
    scene.name = "cabinet".into();
    let metal = ConductorFresnel::Ior { eta: Rgb::new(0.2, 0.9, 1.1), k: Rgb::new(3.9, 2.4, 2.2) };
    let tint = ConductorFresnel::Tint { specular_tint: Rgb::new(0.9, 0.8, 0.7) };
    let first = scene.materials.len();
    scene.materials.extend([
        material("rough metal", BsdfDescription::rough_conductor(0.2, metal), Rgb::BLACK),
        material("mirror", BsdfDescription::conductor(tint), Rgb::BLACK),
        material("glass", BsdfDescription::dielectric(1.5, 1.0), Rgb::BLACK),
        material("rough glass", BsdfDescription::rough_dielectric(0.3, 1.4, 1.0), Rgb::BLACK),
        diffuse("bulb", Rgb::grey(0.2), Rgb::new(3.0, 5.0, 9.0)),
    ]);
    let sphere = |name: &str, centre: [f64; 3], radius: f64, material: usize| {
        Sphere::new(name, DVec3::from_array(centre), radius, material)
    };
    scene.spheres = vec![
        sphere("metal ball", [0.35, 0.85, -0.1], 0.24, first),
        sphere("glass ball", [-0.3, 0.35, 0.3], 0.3, first + 2),
        sphere("frosted ball", [0.6, 0.25, 0.55], 0.24, first + 3),
        sphere("bulb", [0.7, 1.6, -0.7], 0.1, first + 4),
    ];
    scene.meshes.push(rectangle("mirror", DVec3::new(-0.95, 0.5, 0.6), DVec3::Z * -1.2, DVec3::Y * 0.9, first + 1));
    scene.lights = vec![
        Light {
            name: "point".into(),
            kind: LightKind::Point { position: DVec3::new(-0.5, 1.7, 0.5), intensity: Rgb::new(0.5, 0.8, 0.4) },
        },
        Light {
            name: "spot".into(),
            kind: LightKind::Spot {
                position: DVec3::new(0.0, 1.8, 0.8),
                direction: DVec3::new(-0.2, -1.0, -0.6).normalize(),
                intensity: Rgb::new(2.0, 1.5, 1.0),
                inner_angle: 0.2,
                outer_angle: 0.5,
            },
        },
    ];
    let camera = pinhole(DVec3::new(0.1, 1.0, 0.9), DVec3::new(0.0, 0.8, -1.0), 70.0);
    scene.sensor = Some(with_lens(camera, 0.08, 1.4));
    scene
}

/// The cabinet with materials that vary over their surfaces and are made of others, some with finite and Dirac lobes.
#[must_use]
pub fn veneer(film: FilmSize) -> SceneDescription {
    let mut scene = cabinet(film);
    scene.name = "veneer".into();
    let matt = |r: f64, g: f64, b: f64| Box::new(BsdfDescription::Diffuse { reflectance: Rgb::new(r, g, b).into() });
    let grey = |x: f64| Texture::Constant([x, x, x, 1.0]);
    let board = |first: Texture, second: Texture, scale: f64| {
        let to_uv = DAffine2::from_scale(DVec2::splat(scale));
        Arc::new(Texture::Checkerboard { colours: Box::new([first, second]), to_uv })
    };
    let tint = || ConductorFresnel::Tint { specular_tint: Rgb::new(0.9, 0.8, 0.7) };
    let mut replace = |name: &str, bsdf: BsdfDescription| {
        let found = scene.materials.iter_mut().find(|material| material.name == name);
        found.expect("the cabinet has it").bsdf = bsdf;
    };
    let alpha = Parameter::Texture(board(grey(0.15), grey(0.5), 8.0));
    replace("rough metal", BsdfDescription::rough_conductor(alpha, tint()));
    let mirror = Box::new(BsdfDescription::conductor(tint()));
    replace("mirror", BsdfDescription::Blend { weight: 0.5.into(), first: mirror, second: matt(0.1, 0.5, 0.3) });
    let leaf = Box::new(BsdfDescription::TwoSided { front: matt(0.7, 0.6, 0.1), back: matt(0.1, 0.2, 0.7) });
    let opacity = Parameter::Texture(board(grey(0.3), grey(0.9), 6.0));
    replace("rough glass", BsdfDescription::Mask { opacity, nested: leaf });
    let tilted = Texture::Constant([0.6, 0.42, 0.9, 1.0]);
    let upright = Texture::Constant([0.5, 0.5, 1.0, 1.0]);
    let normal = NormalSource::Map { texture: board(tilted, upright, 5.0), scale: [1.0; 2], against_v: false };
    let tiles = board(Texture::Constant([0.8, 0.7, 0.6, 1.0]), Texture::Constant([0.2, 0.3, 0.4, 1.0]), 4.0);
    let tiles = Box::new(BsdfDescription::Diffuse { reflectance: Parameter::Texture(tiles) });
    scene.materials[0].bsdf = BsdfDescription::Perturbed { normal, nested: tiles };
    scene
}

/// The cabinet with materials beyond the plain ones: tinted and brushed metal and glass of other microfacets, a pane,
/// smooth and rough plastic, and the principled model.
#[must_use]
pub fn showroom(film: FilmSize) -> SceneDescription {
    let mut scene = cabinet(film);
    scene.name = "showroom".into();
    let mut replace = |name: &str, bsdf: BsdfDescription| {
        let found = scene.materials.iter_mut().find(|material| material.name == name);
        found.expect("the cabinet has it").bsdf = bsdf;
    };
    replace(
        "rough metal",
        BsdfDescription::RoughConductor {
            distribution: MicrofacetKind::Beckmann,
            alpha: 0.5.into(),
            alpha_v: Some(0.15.into()),
            fresnel: ConductorFresnel::Ior { eta: Rgb::new(0.2, 0.9, 1.1), k: Rgb::new(3.9, 2.4, 2.2) },
            reflectance: Rgb::new(0.8, 0.9, 1.0).into(),
        },
    );
    replace(
        "mirror",
        BsdfDescription::ThinDielectric {
            interior_ior: 1.5,
            exterior_ior: 1.0,
            reflectance: Rgb::new(0.9, 0.8, 0.7).into(),
            transmittance: Rgb::new(0.5, 0.9, 0.8).into(),
        },
    );
    replace(
        "glass",
        BsdfDescription::Dielectric {
            interior_ior: 1.5,
            exterior_ior: 1.0,
            reflectance: Rgb::new(0.7, 0.8, 1.0).into(),
            transmittance: Rgb::new(1.0, 0.8, 0.6).into(),
        },
    );
    replace(
        "rough glass",
        BsdfDescription::RoughDielectric {
            distribution: MicrofacetKind::Ggx,
            alpha: 0.2.into(),
            alpha_v: Some(0.5.into()),
            interior_ior: 1.4,
            exterior_ior: 1.0,
            reflectance: Rgb::new(1.0, 0.5, 0.8).into(),
            transmittance: Rgb::new(0.6, 0.8, 1.0).into(),
        },
    );
    replace(
        "white",
        BsdfDescription::RoughPlastic {
            distribution: MicrofacetKind::Ggx,
            alpha: 0.3,
            interior_ior: 1.5,
            exterior_ior: 1.0,
            diffuse: Rgb::new(0.7, 0.65, 0.6).into(),
            specular: Rgb::new(0.9, 0.9, 1.0).into(),
            nonlinear: true,
        },
    );
    replace(
        "red",
        BsdfDescription::Plastic {
            interior_ior: 1.5,
            exterior_ior: 1.0,
            diffuse: Rgb::new(0.7, 0.2, 0.1).into(),
            specular: Rgb::new(0.9, 1.0, 0.8).into(),
            nonlinear: false,
        },
    );
    let principled = |spec_trans: f64| {
        BsdfDescription::Principled(Box::new(PrincipledDescription {
            base_color: Rgb::new(0.8, 0.5, 0.2).into(),
            roughness: 0.5.into(),
            anisotropic: 0.4.into(),
            metallic: 0.2.into(),
            spec_trans: spec_trans.into(),
            eta: 1.4,
            spec_tint: 0.4.into(),
            sheen: 0.5.into(),
            sheen_tint: 0.3.into(),
            flatness: 0.3.into(),
            clearcoat: 0.7.into(),
            clearcoat_gloss: 0.2.into(),
        }))
    };
    replace("bulb", principled(0.0));
    scene.spheres.push(Sphere::new("marble", DVec3::new(-0.4, 1.4, -0.3), 0.2, scene.materials.len()));
    scene.materials.push(material("marble", principled(0.6), Rgb::BLACK));
    scene
}

/// The cabinet without walls, under a constant environment and parallel light.
#[must_use]
pub fn terrace(film: FilmSize) -> SceneDescription {
    let mut scene = cabinet(film);
    scene.name = "terrace".into();
    scene.meshes[0] = rectangle("floor", DVec3::new(-1.0, 0.0, 1.0), DVec3::X * 2.0, DVec3::Z * -2.0, 0);
    scene.environment = Some(Rgb::new(0.3, 0.4, 0.6).into());
    scene.lights.push(Light {
        name: "sun".into(),
        kind: LightKind::Directional {
            direction: DVec3::new(0.4, -1.0, -0.3).normalize(),
            irradiance: Rgb::new(2.0, 1.8, 1.5),
        },
    });
    scene
}

/// The terrace seen by an orthographic camera.
#[must_use]
pub fn gallery(film: FilmSize) -> SceneDescription {
    let mut scene = terrace(film);
    scene.name = "gallery".into();
    if let Some(camera) = &mut scene.sensor {
        camera.projection = Projection::Orthographic { half_width: 0.8, half_height: 0.6 };
    }
    scene
}

/// A part of the cabinet, under the same lens, with pixels that share the film by a Gaussian filter.
#[must_use]
pub fn vignette(film: FilmSize) -> SceneDescription {
    let mut scene = cabinet(film);
    scene.name = "vignette".into();
    scene.filter = PixelFilter::Gaussian { stddev: 0.5 };
    if let Some(camera) = &mut scene.sensor {
        camera.window = [DVec2::new(0.15, 0.1), DVec2::new(0.9, 0.8)];
    }
    scene
}

/// The gallery, shifted, with pixels that share the film by a tent filter.
#[must_use]
pub fn frieze(film: FilmSize) -> SceneDescription {
    let mut scene = gallery(film);
    scene.name = "frieze".into();
    scene.filter = PixelFilter::Tent { radius: 1.25 };
    if let Some(camera) = &mut scene.sensor {
        camera.window = [DVec2::new(-0.1, 0.2), DVec2::new(0.8, 1.1)];
    }
    scene
}

/// The cabinet with an irradiance meter on one of its blocks.
///
/// # Panics
/// If the cabinet has lost its block.
#[must_use]
pub fn photometer(film: FilmSize) -> SceneDescription {
    let mut scene = cabinet(film);
    scene.name = "photometer".into();
    let block = scene.meshes.iter().position(|mesh| mesh.name == "short").expect("the cabinet has a short block");
    if let Some(sensor) = &mut scene.sensor {
        sensor.projection = Projection::Surface { shape: ShapeIndex::Mesh(block) };
    }
    scene
}

/// The terrace from infinitely far above.
#[must_use]
pub fn overlook(film: FilmSize) -> SceneDescription {
    let mut scene = terrace(film);
    scene.name = "overlook".into();
    let mut sensor = pinhole(DVec3::ZERO, DVec3::new(0.3, -1.0, -0.2), 50.0);
    sensor.projection = Projection::Distant { target: Target::Scene };
    scene.sensor = Some(sensor);
    scene
}

/// The scene, chosen emitters in proportion to their flux.
///
/// # Panics
/// If the description is none; those of this module are.
#[must_use]
pub fn build(description: &SceneDescription) -> Scene {
    let options = SceneOptions { film: None, light_selection: LightSelection::Power };
    Scene::build(description, options).expect("a test scene can be built").0
}
