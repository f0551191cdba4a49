//! Scenes and materials of any kind, with parameters over many orders of magnitude.

use glam::{DMat3, DVec3};
use pathspace::scene::SceneDescription;
use pathspace::scene::description::{
    BsdfDescription, ConductorFresnel, Cylinder, Disk, FilmSize, GltfCoat, GltfDescription, GltfSheen, Lens, Light,
    LightKind, Material, MicrofacetKind, PrincipledDescription, Projection, SensorDescription, Slot, Sphere,
};
use pathspace::scene::texture::Parameter;
use pathspace::spectrum::Rgb;
use pathspace::testing::scenes;
use proptest::prelude::*;

pub const FILM: FilmSize = FilmSize { width: 4, height: 3 };

/// A power of ten.
pub fn decades(low: f64, high: f64) -> BoxedStrategy<f64> {
    (low..high).prop_map(|e| libm::pow(10.0, e)).boxed()
}

/// 0 … 1, its ends often.
fn share() -> BoxedStrategy<f64> {
    prop_oneof![Just(0.0), Just(1.0), 0.0..=1.0_f64, decades(-9.0, 0.0), decades(-9.0, 0.0).prop_map(|x| 1.0 - x)]
        .boxed()
}

fn tint() -> BoxedStrategy<Parameter<Rgb>> {
    [share(), share(), share()].prop_map(|c| Parameter::from(Rgb::from(c))).boxed()
}

fn alpha() -> BoxedStrategy<f64> {
    prop_oneof![decades(-8.0, 0.0), Just(1.0), 0.05..1.0_f64].boxed()
}

/// Along u and v, up to 1 : 10⁴.
fn alphas() -> BoxedStrategy<[f64; 2]> {
    let stretched = (alpha(), decades(-4.0, 0.0)).prop_map(|(u, ratio)| [u, (u * ratio).max(1e-8)]);
    prop_oneof![alpha().prop_map(|a| [a, a]), stretched].boxed()
}

fn index() -> BoxedStrategy<f64> {
    prop_oneof![
        1.05..2.5_f64,
        decades(-9.0, -1.0).prop_map(|x| 1.0 + x),
        decades(-9.0, -1.0).prop_map(|x| 1.0 - x),
        Just(1.0),
        decades(-0.5, 2.0),
    ]
    .boxed()
}

fn fresnel() -> BoxedStrategy<ConductorFresnel> {
    let part = || prop_oneof![0.05..8.0_f64, Just(1.0), decades(-3.0, 2.0)];
    let k = || prop_oneof![Just(0.0), 0.0..8.0_f64];
    prop_oneof![
        [share(), share(), share()].prop_map(|c| ConductorFresnel::Tint { specular_tint: Rgb::from(c) }),
        ([part(), part(), part()], [k(), k(), k()])
            .prop_map(|(eta, k)| ConductorFresnel::Ior { eta: Rgb::from(eta), k: Rgb::from(k) }),
    ]
    .boxed()
}

fn kind() -> BoxedStrategy<MicrofacetKind> {
    prop_oneof![Just(MicrofacetKind::Ggx), Just(MicrofacetKind::Beckmann)].boxed()
}

fn principled() -> BoxedStrategy<BsdfDescription> {
    (tint(), prop::array::uniform10(share()), index(), any::<bool>())
        .prop_map(|(base_color, shares, eta, opaque)| {
            let [
                roughness,
                anisotropic,
                metallic,
                spec_trans,
                spec_tint,
                sheen,
                sheen_tint,
                flatness,
                clearcoat,
                gloss,
            ] = shares;
            BsdfDescription::Principled(Box::new(PrincipledDescription {
                base_color,
                roughness: roughness.max(1e-4).into(),
                anisotropic: anisotropic.into(),
                metallic: metallic.into(),
                spec_trans: if opaque { 0.0 } else { spec_trans }.into(),
                eta: eta.max(1.0 + 1e-9),
                spec_tint: spec_tint.into(),
                sheen: sheen.into(),
                sheen_tint: sheen_tint.into(),
                flatness: flatness.into(),
                clearcoat: clearcoat.into(),
                clearcoat_gloss: gloss.into(),
            }))
        })
        .boxed()
}

fn gltf() -> BoxedStrategy<BsdfDescription> {
    (prop::array::uniform10(share()), index())
        .prop_map(|(s, ior)| {
            let some = |factor: f64| (factor > 0.3).then_some(factor);
            BsdfDescription::Gltf(Box::new(GltfDescription {
                base_color: Slot::constant([s[0], s[1], s[2], 1.0]),
                metallic_roughness: Slot::constant([1.0, s[3], s[4], 1.0]),
                ior: ior.max(1.0),
                specular: Slot::constant([1.0, 1.0, 1.0, s[5]]),
                transmission: Slot::constant([s[6], 1.0, 1.0, 1.0]),
                clearcoat: some(s[7]).map(|factor| GltfCoat {
                    factor: Slot::constant([factor; 4]),
                    roughness: Slot::constant([s[8]; 4]),
                    normal: None,
                }),
                sheen: some(s[9])
                    .map(|color| GltfSheen { color: Slot::constant([color; 4]), roughness: Slot::constant([s[8]; 4]) }),
                ..GltfDescription::default()
            }))
        })
        .boxed()
}

/// Coats of glass, whose rough ones take too long to prepare for parameters of every case.
fn coated() -> BoxedStrategy<BsdfDescription> {
    let smooth = (index(), tint(), tint(), any::<bool>()).prop_map(|(interior_ior, diffuse, specular, nonlinear)| {
        BsdfDescription::Plastic { interior_ior, exterior_ior: 1.0, diffuse, specular, nonlinear }
    });
    let rough = (kind(), 0..4_usize, tint()).prop_map(|(distribution, i, diffuse)| BsdfDescription::RoughPlastic {
        distribution,
        alpha: [1e-8, 1e-3, 0.2, 1.0][i],
        interior_ior: 1.5,
        exterior_ior: 1.0,
        diffuse,
        specular: Rgb::WHITE.into(),
        nonlinear: false,
    });
    prop_oneof![4 => smooth, 1 => rough].boxed()
}

/// Models that are reciprocal and, but for those with a turned base, lose energy rather than make it.
pub fn plain_bsdf() -> BoxedStrategy<BsdfDescription> {
    prop_oneof![
        tint().prop_map(|reflectance| BsdfDescription::Diffuse { reflectance }),
        (fresnel(), tint()).prop_map(|(fresnel, reflectance)| BsdfDescription::Conductor { fresnel, reflectance }),
        (kind(), alphas(), fresnel(), tint()).prop_map(|(distribution, [u, v], fresnel, reflectance)| {
            let (alpha, alpha_v) = (u.into(), (u != v).then(|| v.into()));
            BsdfDescription::RoughConductor { distribution, alpha, alpha_v, fresnel, reflectance }
        }),
        (index(), tint(), tint()).prop_map(|(interior_ior, reflectance, transmittance)| {
            BsdfDescription::Dielectric { interior_ior, exterior_ior: 1.0, reflectance, transmittance }
        }),
        (index(), tint(), tint()).prop_map(|(interior_ior, reflectance, transmittance)| {
            BsdfDescription::ThinDielectric { interior_ior, exterior_ior: 1.0, reflectance, transmittance }
        }),
        (kind(), alphas(), index(), tint(), tint()).prop_map(
            |(distribution, [u, v], interior_ior, reflectance, transmittance)| BsdfDescription::RoughDielectric {
                distribution,
                alpha: u.into(),
                alpha_v: (u != v).then(|| v.into()),
                interior_ior,
                exterior_ior: 1.0,
                reflectance,
                transmittance,
            }
        ),
        coated(),
    ]
    .boxed()
}

/// Any model, made of others or not.
pub fn bsdf() -> BoxedStrategy<BsdfDescription> {
    let boxed = |bsdf: BsdfDescription| Box::new(bsdf);
    prop_oneof![
        8 => plain_bsdf(),
        2 => principled(),
        2 => gltf(),
        1 => Just(BsdfDescription::Null),
        1 => (share(), plain_bsdf()).prop_map(move |(opacity, nested)| BsdfDescription::Mask {
            opacity: opacity.into(),
            nested: boxed(nested),
        }),
        1 => (share(), plain_bsdf(), plain_bsdf()).prop_map(move |(weight, first, second)| BsdfDescription::Blend {
            weight: weight.into(),
            first: boxed(first),
            second: boxed(second),
        }),
    ]
    .boxed()
}

fn direction() -> BoxedStrategy<DVec3> {
    (-1.0..1.0_f64, 0.0..std::f64::consts::TAU)
        .prop_map(|(z, phi)| {
            let r = (1.0 - z * z).sqrt();
            DVec3::new(r * libm::cos(phi), r * libm::sin(phi), z)
        })
        .boxed()
}

/// Any direction, down to grazing ones.
pub fn any_direction() -> BoxedStrategy<DVec3> {
    let cos = prop_oneof![0.01..1.0_f64, decades(-8.0, 0.0)];
    (cos, any::<bool>(), 0.0..std::f64::consts::TAU)
        .prop_map(|(cos, up, phi)| {
            let r = ((1.0 - cos) * (1.0 + cos)).sqrt();
            DVec3::new(r * libm::cos(phi), r * libm::sin(phi), if up { cos } else { -cos })
        })
        .boxed()
}

fn point() -> BoxedStrategy<DVec3> {
    prop::array::uniform3(-0.9..0.9_f64).prop_map(DVec3::from_array).boxed()
}

/// A shape and what it is made of.
#[derive(Clone, Debug)]
pub struct Object {
    shape: u8,
    at: DVec3,
    axis: DVec3,
    size: f64,
    inward: bool,
    two_sided: bool,
    bsdf: BsdfDescription,
    emission: Option<Rgb>,
}

fn object() -> BoxedStrategy<Object> {
    let size = prop_oneof![4 => 0.1..0.6_f64, 1 => decades(-4.0, -1.0)];
    let emission = prop_oneof![2 => Just(None), 1 => colour().prop_map(Some)];
    (0..4_u8, point(), direction(), size, any::<bool>(), any::<bool>(), bsdf(), emission)
        .prop_map(|(shape, at, axis, size, inward, two_sided, bsdf, emission)| Object {
            shape,
            at,
            axis,
            size,
            inward,
            two_sided,
            bsdf,
            emission,
        })
        .boxed()
}

fn colour() -> BoxedStrategy<Rgb> {
    prop::array::uniform3(0.01..1.0_f64).prop_map(Rgb::from).boxed()
}

fn light() -> BoxedStrategy<LightKind> {
    prop_oneof![
        (point(), colour()).prop_map(|(position, intensity)| LightKind::Point { position, intensity }),
        (point(), direction(), colour(), decades(-2.0, 2.25), share()).prop_map(
            |(position, direction, intensity, degrees, inner)| {
                let outer_angle = degrees.min(180.0).to_radians();
                LightKind::Spot { position, direction, intensity, inner_angle: inner * outer_angle, outer_angle }
            }
        ),
        (direction(), colour()).prop_map(|(direction, irradiance)| LightKind::Directional { direction, irradiance }),
    ]
    .boxed()
}

fn sensor() -> BoxedStrategy<SensorDescription> {
    let fov = prop_oneof![20.0..100.0_f64, decades(-3.0, 1.0), decades(-1.0, 1.0).prop_map(|x| 180.0 - x)];
    let lens = prop_oneof![2 => Just(None), 1 => (decades(-6.0, 0.0), decades(-3.0, 9.0)).prop_map(Some)];
    let place = direction().prop_map(|direction| direction * 0.97);
    (place, point(), fov, lens, 0..8_u8)
        .prop_map(|(position, target, fov, lens, kind)| {
            let mut sensor = scenes::pinhole(position, target, fov);
            if let Some((aperture_radius, focus_distance)) = lens
                && let Projection::Perspective { lens, .. } = &mut sensor.projection
            {
                *lens = Some(Lens { aperture_radius, focus_distance });
            }
            match kind {
                0 => sensor.projection = Projection::Orthographic { half_width: 0.6, half_height: 0.45 },
                1 => sensor.projection = Projection::Hemisphere,
                2 => sensor.projection = Projection::Window { half_width: 0.3, half_height: 0.2 },
                _ => {}
            }
            sensor
        })
        .boxed()
}

/// Some objects, in a room or not, with lights of all kinds of powers around 10^`power`, at any scale.
pub fn scene() -> BoxedStrategy<SceneDescription> {
    let room = prop_oneof![Just(None), (bsdf(), any::<bool>()).prop_map(Some)];
    let objects = prop::collection::vec(object(), 1..6);
    let lights = prop::collection::vec((light(), decades(-6.0, 6.0)), 0..4);
    let environment = prop_oneof![2 => Just(None), 1 => colour().prop_map(Some)];
    let power = prop_oneof![Just(1.0), decades(-30.0, 30.0)];
    let scale = prop_oneof![2 => Just(1.0), 1 => decades(-6.0, 6.0)];
    (room, objects, lights, environment, sensor(), power, scale).prop_map(assemble).boxed()
}

type Parts =
    (Option<(BsdfDescription, bool)>, Vec<Object>, Vec<(LightKind, f64)>, Option<Rgb>, SensorDescription, f64, f64);

fn assemble((room, objects, lights, environment, mut sensor, power, scale): Parts) -> SceneDescription {
    let mut scene = SceneDescription { name: "random".into(), film: Some(FILM), ..SceneDescription::default() };
    if let Some((bsdf, emits)) = room {
        let emission = if emits { Rgb::grey(0.1 * power) } else { Rgb::BLACK };
        scene.materials.push(scenes::material("room", bsdf, emission));
        scene.meshes.push(scenes::cuboid("room", DVec3::splat(-scale), DVec3::splat(scale), true, 0));
    }
    for object in objects {
        let material = scene.materials.len();
        let emission = object.emission.map_or(Rgb::BLACK, |emission| emission * power);
        let two_sided = object.two_sided;
        scene.materials.push(Material { two_sided, ..scenes::material("material", object.bsdf.clone(), emission) });
        let (at, size, name) = (object.at * scale, object.size * scale, String::from("object"));
        let across = object.axis.any_orthonormal_vector();
        let Object { axis, inward, .. } = object;
        match object.shape {
            0 => scene.spheres.push(Sphere { inward, ..Sphere::new(name, at, size, material) }),
            1 => {
                let axes = [across * size, axis.cross(across) * size];
                scene.disks.push(Disk { name, centre: at, axes, flipped: inward, material });
            }
            2 => scene.cylinders.push(Cylinder {
                name,
                base: at,
                axis: axis * size,
                radius: 0.5 * size,
                meridian: across,
                clockwise: inward,
                inward,
                material,
            }),
            _ => {
                let mut cube = scenes::cuboid("object", DVec3::splat(-size), DVec3::splat(size), inward, material);
                let turn = DMat3::from_cols(across, axis.cross(across), axis);
                cube.positions.iter_mut().for_each(|position| *position = turn * *position + at);
                scene.meshes.push(cube);
            }
        }
    }
    for (kind, strength) in lights {
        scene.lights.push(Light { name: "light".into(), kind: scaled(kind, power * strength, scale) });
    }
    scene.environment = environment.map(|radiance| (radiance * power).into());
    sensor.position *= scale;
    match &mut sensor.projection {
        Projection::Perspective { lens: Some(lens), .. } => {
            lens.aperture_radius *= scale;
            lens.focus_distance *= scale;
        }
        Projection::Orthographic { half_width, half_height } | Projection::Window { half_width, half_height } => {
            *half_width *= scale;
            *half_height *= scale;
        }
        _ => {}
    }
    scene.sensor = Some(sensor);
    scene
}

fn scaled(mut kind: LightKind, power: f64, scale: f64) -> LightKind {
    match &mut kind {
        LightKind::Point { position, intensity } | LightKind::Spot { position, intensity, .. } => {
            *position *= scale;
            *intensity *= power;
        }
        LightKind::Directional { irradiance, .. } => *irradiance *= power,
        LightKind::Projector { .. } => {}
    }
    kind
}
