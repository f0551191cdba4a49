#![allow(clippy::unwrap_used)]

use std::collections::HashMap;
use std::f64::consts::{FRAC_1_SQRT_2, PI};
use std::fs;
use std::sync::Arc;

use glam::DVec3;
use proptest::prelude::*;
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::*;
use crate::scene::description::*;
use crate::scene::texture::{Parameter, Texture};
use crate::spectrum::Rgb;

/// An element as it is read back: tag, attributes, children.
#[derive(Debug, Default)]
struct Node {
    tag: String,
    attributes: HashMap<String, String>,
    children: Vec<Node>,
}

impl Node {
    fn from_tag(tag: &BytesStart) -> Self {
        let attributes = tag.attributes().map(|a| {
            let a = a.unwrap();
            (a.key.as_ref().to_owned(), a.value.into_owned())
        });
        Self { tag: tag.name().as_ref().to_owned(), attributes: attributes.collect(), children: Vec::new() }
    }

    fn parse(xml: &str) -> Self {
        let mut reader = Reader::from_str(xml);
        let mut open = vec![Self::default()];
        loop {
            match reader.read_event().unwrap() {
                Event::Start(tag) => open.push(Self::from_tag(&tag)),
                Event::Empty(tag) => open.last_mut().unwrap().children.push(Self::from_tag(&tag)),
                Event::End(_) => {
                    let done = open.pop().unwrap();
                    open.last_mut().unwrap().children.push(done);
                }
                Event::Eof => return open.pop().unwrap().children.pop().unwrap(),
                _ => {}
            }
        }
    }

    fn all(&self, tag: &str) -> Vec<&Self> {
        self.children.iter().filter(|child| child.tag == tag).collect()
    }

    fn plugin(&self) -> &str {
        &self.attributes["type"]
    }

    fn value(&self, name: &str) -> &str {
        let named = |child: &&Self| child.attributes.get("name").is_some_and(|n| n == name);
        &self.children.iter().find(named).unwrap_or_else(|| panic!("no '{name}' in {self:?}")).attributes["value"]
    }

    fn numbers(&self, name: &str) -> Vec<f64> {
        self.value(name).split(", ").map(|v| v.parse().unwrap()).collect()
    }

    /// The sixteen numbers of `to_world`, row by row.
    fn matrix(&self) -> Vec<f64> {
        let matrix = &self.all("transform")[0].all("matrix")[0].attributes["value"];
        matrix.split(' ').map(|v| v.parse().unwrap()).collect()
    }
}

fn exported(scene: &SceneDescription, options: &ExportOptions) -> Result<Node, ExportError> {
    let folder = tempfile::tempdir().unwrap();
    export(scene, options, folder.path()).map(|path| Node::parse(&fs::read_to_string(path).unwrap()))
}

fn camera(projection: Projection) -> SensorDescription {
    SensorDescription {
        window: SensorDescription::WHOLE,
        name: "view".into(),
        position: DVec3::new(0.1, 1.0 / 3.0, -1e-7),
        forward: DVec3::new(FRAC_1_SQRT_2, 0.0, -FRAC_1_SQRT_2),
        up: DVec3::Y,
        projection,
    }
}

fn perspective(aspect: Option<f64>) -> Projection {
    Projection::Perspective { vertical_fov: 0.7, aspect, lens: None }
}

fn material(bsdf: BsdfDescription, two_sided: bool) -> Material {
    Material { name: "m".into(), bsdf, two_sided, emission: Rgb::BLACK.into() }
}

fn grey() -> Material {
    material(BsdfDescription::Diffuse { reflectance: Rgb::grey(0.5).into() }, false)
}

fn triangle() -> Mesh {
    Mesh {
        name: "a<b>&\"../c".into(),
        positions: vec![DVec3::ZERO, DVec3::new(0.1, 0.0, 0.0), DVec3::new(0.0, 0.3, 1e-3)],
        triangles: vec![[0, 1, 2]],
        material: 0,
        ..Mesh::default()
    }
}

fn scene() -> SceneDescription {
    SceneDescription {
        name: "scene".into(),
        sensor: Some(camera(perspective(None))),
        materials: vec![grey()],
        ..Default::default()
    }
}

proptest! {
    #[test]
    fn numbers_keep_every_digit(v in prop::array::uniform7(prop::num::f64::NORMAL)) {
        let mut scene = scene();
        let centre = DVec3::new(v[0], v[1], v[2]);
        scene.spheres.push(Sphere::new("s", centre, v[3], 0));
        scene.environment = Some(Rgb::new(v[4], v[5], v[6]).map(f64::abs).into());
        let root = exported(&scene, &ExportOptions::default()).unwrap();
        let sphere = root.all("shape")[0];
        prop_assert_eq!(sphere.numbers("center"), &v[..3]);
        prop_assert_eq!(sphere.numbers("radius"), &v[3..4]);
        let emitted: Vec<_> = v[4..].iter().map(|x| x.abs()).collect();
        prop_assert_eq!(root.all("emitter")[0].numbers("radiance"), emitted);
    }
}

#[test]
fn the_camera_matrix_holds_left_up_forward_and_position() {
    let sensor = camera(perspective(None));
    let root = exported(&scene(), &ExportOptions::default()).unwrap();
    let m = root.all("sensor")[0].matrix();
    let column = |c: usize| DVec3::new(m[c], m[4 + c], m[8 + c]);
    let right = sensor.forward.cross(sensor.up);
    assert_eq!([column(0), column(1), column(2), column(3)], [-right, sensor.up, sensor.forward, sensor.position]);
    assert_eq!(root.all("sensor")[0].numbers("fov"), [0.7_f64.to_degrees()]);
    assert_eq!(root.all("sensor")[0].value("fov_axis"), "y");
}

#[test]
fn an_orthographic_film_shows_its_half_width_and_half_height() {
    let mut scene = scene();
    scene.sensor = Some(camera(Projection::Orthographic { half_width: 3.0, half_height: 5.0 }));
    let options = ExportOptions { film: FilmSize { width: 200, height: 100 }, ..Default::default() };
    let m = exported(&scene, &options).unwrap().all("sensor")[0].matrix();
    let length = |c: usize| DVec3::new(m[c], m[4 + c], m[8 + c]).length();
    // Mitsuba's film reaches to y = height / width.
    assert!((length(0) - 3.0).abs() < 1e-15 && (length(1) * 0.5 - 5.0).abs() < 1e-15);
}

#[test]
fn meshes_are_flat_exactly_where_they_have_no_normals() {
    let mut scene = scene();
    let smooth = Mesh { normals: Some(vec![DVec3::Z, DVec3::X, DVec3::Y]), ..triangle() };
    scene.meshes = vec![triangle(), smooth];
    let folder = tempfile::tempdir().unwrap();
    let xml = export(&scene, &ExportOptions::default(), folder.path()).unwrap();
    let root = Node::parse(&fs::read_to_string(xml).unwrap());
    let shapes = root.all("shape");
    assert_eq!([shapes[0].value("face_normals"), shapes[1].value("face_normals")], ["true", "false"]);

    for (shape, floats) in shapes.iter().zip([3, 6]) {
        let bytes = fs::read(folder.path().join(shape.value("filename"))).unwrap();
        let end = b"end_header\n";
        let body = bytes.windows(end.len()).position(|w| w == end).unwrap() + end.len();
        let value = |i: usize| f32::from_le_bytes(bytes[body + 4 * i..][..4].try_into().unwrap());
        let last_vertex = 2 * floats;
        assert_eq!([value(last_vertex), value(last_vertex + 1), value(last_vertex + 2)], [0.0, 0.3, 1e-3]);
        let faces = &bytes[body + 3 * floats * 4..];
        assert_eq!(faces, [&[3][..], &0u32.to_le_bytes(), &1u32.to_le_bytes(), &2u32.to_le_bytes()].concat());
    }
}

#[test]
fn opaque_two_sided_materials_are_wrapped_and_glass_is_not() {
    let fresnel = ConductorFresnel::Tint { specular_tint: Rgb::grey(0.9) };
    let glass = BsdfDescription::rough_dielectric(0.1, 1.5, 1.0);
    let mut scene = scene();
    scene.materials = vec![
        material(BsdfDescription::rough_conductor(0.2, fresnel.clone()), true),
        material(BsdfDescription::conductor(fresnel), false),
        material(glass, true),
    ];
    let root = exported(&scene, &ExportOptions::default()).unwrap();
    let bsdfs = root.all("bsdf");
    assert_eq!(bsdfs.iter().map(|b| b.plugin()).collect::<Vec<_>>(), ["twosided", "conductor", "roughdielectric"]);
    let inner = bsdfs[0].all("bsdf")[0];
    assert_eq!([inner.plugin(), inner.value("distribution"), inner.value("alpha")], ["roughconductor", "ggx", "0.2"]);
    assert_eq!(bsdfs[1].value("material"), "none");
}

fn written(bsdf: BsdfDescription) -> Result<Node, ExportError> {
    let scene = SceneDescription { materials: vec![material(bsdf, false)], ..scene() };
    let mut root = exported(&scene, &ExportOptions::default())?;
    let index = root.children.iter().position(|child| child.tag == "bsdf").unwrap();
    Ok(root.children.swap_remove(index))
}

#[test]
fn tints_and_roughness_along_v_are_written_where_there_are_any() {
    let metal = |fresnel, reflectance: Rgb, alpha_v: Option<f64>| BsdfDescription::RoughConductor {
        distribution: MicrofacetKind::Beckmann,
        alpha: 0.2.into(),
        alpha_v: alpha_v.map(Into::into),
        fresnel,
        reflectance: reflectance.into(),
    };
    let ior = ConductorFresnel::Ior { eta: Rgb::new(0.2, 0.9, 1.1), k: Rgb::new(3.9, 2.4, 2.2) };
    let brushed = written(metal(ior.clone(), Rgb::new(1.0, 0.5, 0.25), Some(0.6))).unwrap();
    assert_eq!([brushed.plugin(), brushed.value("distribution")], ["roughconductor", "beckmann"]);
    assert_eq!([brushed.value("alpha_u"), brushed.value("alpha_v")], ["0.2", "0.6"]);
    assert_eq!(brushed.numbers("specular_reflectance"), [1.0, 0.5, 0.25]);
    let plain = written(metal(ior, Rgb::WHITE, None)).unwrap();
    assert_eq!(plain.value("alpha"), "0.2");
    assert_eq!(plain.all("rgb").len(), 2, "eta and k only");
    // Mitsuba has one factor for both.
    let tint = ConductorFresnel::Tint { specular_tint: Rgb::new(0.5, 0.5, 1.0) };
    let tinted = written(metal(tint, Rgb::new(1.0, 0.5, 0.25), None)).unwrap();
    assert_eq!(tinted.numbers("specular_reflectance"), [0.5, 0.25, 0.25]);
}

#[test]
fn panes_and_coats_keep_their_indices_and_colours() {
    let (reflectance, transmittance) = (Rgb::new(0.9, 0.8, 0.7).into(), Rgb::new(0.5, 0.9, 0.8).into());
    let pane =
        written(BsdfDescription::ThinDielectric { interior_ior: 1.5, exterior_ior: 1.1, reflectance, transmittance });
    let pane = pane.unwrap();
    assert_eq!([pane.plugin(), pane.value("int_ior"), pane.value("ext_ior")], ["thindielectric", "1.5", "1.1"]);
    assert_eq!(pane.numbers("specular_reflectance"), [0.9, 0.8, 0.7]);
    assert_eq!(pane.numbers("specular_transmittance"), [0.5, 0.9, 0.8]);
    let coat = |interior_ior| BsdfDescription::RoughPlastic {
        distribution: MicrofacetKind::Ggx,
        alpha: 0.3,
        interior_ior,
        exterior_ior: 1.0,
        diffuse: Rgb::new(0.1, 0.2, 0.3).into(),
        specular: Rgb::WHITE.into(),
        nonlinear: true,
    };
    let plastic = written(coat(1.5)).unwrap();
    assert_eq!([plastic.plugin(), plastic.value("distribution")], ["roughplastic", "ggx"]);
    assert_eq!([plastic.value("alpha"), plastic.value("nonlinear")], ["0.3", "true"]);
    assert_eq!(plastic.numbers("diffuse_reflectance"), [0.1, 0.2, 0.3]);
    assert!(written(coat(1.0)).unwrap_err().to_string().contains("leave the coat out"));
    // What bends nothing is written as the smooth interface that Mitsuba takes.
    assert_eq!(written(BsdfDescription::rough_dielectric(0.3, 1.2, 1.2)).unwrap().plugin(), "dielectric");
}

#[test]
fn all_parameters_of_the_principled_model_are_written() {
    let description = PrincipledDescription {
        base_color: Rgb::new(0.1, 0.2, 0.3).into(),
        clearcoat: 0.25.into(),
        eta: 1.25,
        ..Default::default()
    };
    let principled = written(BsdfDescription::Principled(Box::new(description.clone()))).unwrap();
    assert_eq!([principled.plugin(), principled.value("eta")], ["principled", "1.25"]);
    assert_eq!(principled.numbers("base_color"), [0.1, 0.2, 0.3]);
    for (name, number) in description.numbers() {
        assert_eq!(principled.numbers(name), [*number.constant().unwrap()], "{name}");
    }
}

#[test]
fn unlimited_length_is_minus_one() {
    let limited = ExportOptions { max_length: Some(8), rr_depth: 3, ..Default::default() };
    for (options, expected) in [(ExportOptions::default(), ["-1", "5"]), (limited, ["8", "3"])] {
        let root = exported(&scene(), &options).unwrap();
        let integrator = root.all("integrator")[0];
        assert_eq!([integrator.value("max_depth"), integrator.value("rr_depth")], expected);
    }
}

#[test]
fn spot_angles_are_degrees_along_the_direction() {
    let mut scene = scene();
    let direction = DVec3::new(2.0, -1.0, 2.0) / 3.0;
    let spot = |inner_angle, outer_angle| Light {
        name: "spot".into(),
        kind: LightKind::Spot { position: DVec3::ONE, direction, intensity: Rgb::WHITE, inner_angle, outer_angle },
    };
    scene.lights = vec![spot(PI / 6.0, PI / 4.0)];
    let root = exported(&scene, &ExportOptions::default()).unwrap();
    let emitter = root.all("emitter")[0];
    assert!((emitter.numbers("cutoff_angle")[0] - 45.0).abs() < 1e-12);
    assert!((emitter.numbers("beam_width")[0] - 30.0).abs() < 1e-12);
    let m = emitter.matrix();
    assert_eq!(DVec3::new(m[2], m[6], m[10]), direction);

    scene.lights = vec![spot(PI / 4.0, PI / 4.0)];
    let error = exported(&scene, &ExportOptions::default()).unwrap_err();
    assert!(matches!(error, ExportError::Unsupported { .. }), "{error}");
}

#[test]
fn pixels_that_are_not_square_are_refused_with_the_film_that_would_do() {
    let options = ExportOptions { film: FilmSize { width: 200, height: 100 }, ..Default::default() };
    let mut scene = scene();
    scene.sensor = Some(camera(perspective(Some(2.0 * (1.0 + 1e-4)))));
    assert!(exported(&scene, &options).is_ok());
    scene.sensor = Some(camera(perspective(Some(0.5))));
    let error = exported(&scene, &options).unwrap_err().to_string();
    assert!(error.contains("camera 'view'") && error.contains("100 × 200"), "{error}");
}

#[test]
fn what_cannot_be_right_is_refused_in_one_line() {
    type Change = (&'static str, fn(&mut SceneDescription));
    let changes: [Change; 7] = [
        ("camera", |s| s.sensor = None),
        ("material 7", |s| s.meshes[0].material = 7),
        ("vertex", |s| s.meshes[0].triangles[0][1] = 3),
        ("normals", |s| s.meshes[0].normals = Some(vec![DVec3::Z])),
        ("position", |s| s.meshes[0].positions[0].x = f64::NAN),
        ("emits", |s| s.materials[0].emission = Rgb::new(1.0, f64::INFINITY, 0.0).into()),
        ("reflectance", |s| s.materials[0].bsdf = BsdfDescription::Diffuse { reflectance: Rgb::grey(1.5).into() }),
    ];
    for (word, change) in changes {
        let mut scene = SceneDescription { meshes: vec![triangle()], ..scene() };
        assert!(exported(&scene, &ExportOptions::default()).is_ok());
        change(&mut scene);
        let error = exported(&scene, &ExportOptions::default()).unwrap_err().to_string();
        assert!(error.contains(word) && !error.contains('\n'), "{error}");
    }
}

#[test]
fn a_folder_that_cannot_be_written_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("occupied");
    fs::write(&file, "").unwrap();
    let error = export(&scene(), &ExportOptions::default(), &file).unwrap_err();
    assert!(error.to_string().contains("occupied"), "{error}");
}

#[test]
fn analytic_shapes_keep_their_sides_and_emission_may_be_a_texture() {
    let mut scene = scene();
    let image = Arc::new(crate::testing::scenes::patches(3, 2, 4.0));
    let texture = Texture::Bitmap { bitmap: image.clone(), to_uv: glam::DAffine2::IDENTITY };
    scene.materials.push(Material { emission: Parameter::Texture(texture.into()), ..grey() });
    let mirrored = glam::DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0));
    scene.spheres.push(Sphere { axes: mirrored, ..Sphere::new("mirrored", DVec3::X, 2.0, 0) });
    scene.spheres.push(Sphere { inward: true, ..Sphere::new("inward", DVec3::X, 2.0, 0) });
    let axes = [DVec3::X, DVec3::Y * 2.0];
    scene.disks.push(Disk { name: "d".into(), centre: DVec3::Z, axes, flipped: true, material: 1 });
    let (base, axis, meridian) = (DVec3::Y, DVec3::Z * 3.0, DVec3::X);
    let (name, inward, clockwise) = ("c".into(), false, true);
    scene.cylinders.push(Cylinder { name, base, axis, radius: 0.5, meridian, clockwise, inward, material: 0 });
    let to_world = glam::DMat3::from_rotation_y(0.5);
    scene.environment = Some(EnvironmentDescription::Map { bitmap: image.clone(), scale: 2.0, to_world });
    let (forward, up) = (DVec3::Z, DVec3::Y);
    let (position, horizontal_fov, scale) = (DVec3::ZERO, 0.5, Rgb::new(1.0, 2.0, 3.0));
    let kind = LightKind::Projector { position, forward, up, horizontal_fov, image, scale };
    scene.lights.push(Light { name: "projector".into(), kind });
    let root = exported(&scene, &ExportOptions::default()).unwrap();
    let shapes = root.all("shape");
    assert_eq!(shapes.iter().map(|s| s.plugin()).collect::<Vec<_>>(), ["sphere", "sphere", "disk", "cylinder"]);
    let flipped = |shape: &Node| shape.all("boolean").iter().any(|b| b.attributes["value"] == "true");
    assert_eq!(shapes.iter().map(|s| flipped(s)).collect::<Vec<_>>(), [true, true, true, false]);
    assert_eq!(shapes[3].matrix()[..12], [0.5, 0.0, 0.0, 0.0, 0.0, -0.5, 0.0, 1.0, 0.0, 0.0, 3.0, 0.0]);
    assert_eq!(shapes[2].all("emitter")[0].all("texture")[0].value("filename"), "textures/0000.exr");
    let emitters = root.all("emitter");
    assert_eq!(emitters.iter().map(|e| e.plugin()).collect::<Vec<_>>(), ["projector", "envmap"]);
    assert_eq!(
        emitters[0].all("texture")[0].value("filename"),
        "textures/0001.exr",
        "the image in the colour of the scale"
    );
    assert_eq!(emitters[1].value("filename"), "textures/0000.exr");
}
