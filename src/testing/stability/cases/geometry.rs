//! Surfaces that meet, touch, graze and degenerate.

use std::path::Path;

use glam::DVec3;

use super::super::case::{Case, Stage, Subject};
use super::case;
use super::meshes::{latitude_longitude, sliced, subdivided};
use super::scale::emission_of_ball;
use super::scenery::{ASPECT, FILM, FLOOR, SEEN, floor, floor_mean, isotropic, sample_in_furnace, unit_enclosure};
use crate::scene::SceneDescription;
use crate::scene::description::{BsdfDescription, Light, LightKind, Projection, Sphere};
use crate::spectrum::Rgb;
use crate::testing::radiosity::point_form_factor;
use crate::testing::scenes::{diffuse, pinhole, rectangle};

pub(super) fn cases() -> Vec<Case> {
    let new = |name, sweep: (&'static str, &[f64]), stage| case("geometry", name, sweep, Subject::Scene(stage));
    vec![
        new("corner", ("size of the view", &[1e-1, 1e-3, 1e-6, 1e-9]), corner)
            .about("into a corner of the closed box, where vertices come close: L = 1"),
        new("edge of a lamp", ("size of the view", &[0.3, 1e-2, 1e-4, 1e-6, 1e-9]), edge_of_a_lamp)
            .about("a floor beside the lower edge of a wall that shines: Lambert's formula"),
        new("grazing light", ("cosine", &[0.5, 1e-2, 1e-4, 1e-7]), grazing_light)
            .about("a floor in parallel light: L = albedo/π · E cos θ"),
        new("grazing view", ("cosine", &[0.5, 1e-2, 1e-4, 1e-7]), grazing_view)
            .about("a diffuse plane in a constant environment: L = albedo"),
        new("near surfaces", ("gap", &[0.1, 1e-3, 1e-6, 1e-9, 1e-12, 0.0]), near_surfaces)
            .about("a lamp of radiance one above one of radiance ten, seen from above: L = 1")
            .ends_at(1e-12, "of coincident surfaces one is as good as the other"),
        new("touching lamp", ("gap over radius", &[1.0, 1e-3, 1e-6, 1e-9, 0.0]), touching_lamp)
            .about("a ball lamp that rests on the floor: E = Φ cos θ / (4π r²)"),
        new("slivers", ("aspect", &[1.0, 1e3, 1e6, 1e9, 1e12]), |aspect| {
            let mut scene = unit_enclosure(0.5);
            scene.meshes[0] = sliced(&scene.meshes[0], aspect);
            Stage::new(scene, 1.0)
        })
        .about("the closed box of slivers and of triangles without area: L = 1"),
        new("closed mesh", ("triangles", &[80.0, 1280.0, 20480.0, 327_680.0]), closed_mesh)
            .about("inside of a closed mesh of emission 1 - albedo, a million times as bright outside: L = 1"),
        new("fine sphere", ("triangles", &[1e2, 1e3, 1e4, 1e5, 1e6]), |triangles| {
            let mut scene = sample_in_furnace(grey(), pinhole(DVec3::new(0.3, 0.4, 3.0), DVec3::ZERO, 20.0));
            scene.meshes = vec![latitude_longitude(triangles)];
            Stage::new(scene, FLOOR)
        })
        .about("a convex diffuse mesh in a constant environment: L = albedo where it does not shade itself"),
        new("stretched box", ("height", &[1.0, 1e-2, 1e-4, 1e-6, 1e-9]), stretched_box)
            .about("a closed box, mirrored and pressed flat by its transform in a Mitsuba file: L = 1"),
        new("shading normals", ("tilt in degrees", &[0.0, 30.0, 60.0, 80.0, 89.0]), shading_normals)
            .about("a plane whose normals lean, in a constant environment: L = albedo (1 + cos tilt)/2"),
    ]
}

fn stretched_box(height: f64) -> Stage {
    let text = format!(
        r#"<scene version="3.0.0">
  <shape type="cube">
    <transform name="to_world"><scale x="-1" y="{height}" z="1.2"/></transform>
    <boolean name="flip_normals" value="true"/>
    <bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf>
    <emitter type="area"><rgb name="radiance" value="0.5"/></emitter>
  </shape>
  <sensor type="perspective">
    <float name="fov" value="60"/> <string name="fov_axis" value="y"/>
    <transform name="to_world">
      <lookat origin="0.3, {y}, 0.9" target="-0.2, -{y}, -1" up="0, 1, 0"/>
    </transform>
    <film type="hdrfilm">
      <integer name="width" value="8"/> <integer name="height" value="6"/> <rfilter type="box"/>
    </film>
  </sensor>
</scene>"#,
        y = 0.1 * height
    );
    let scene = crate::scene::mitsuba::read::from_bytes(text.as_bytes(), Path::new("box.xml"), &Default::default());
    Stage::new(scene.expect("the text is a scene"), 1.0)
}

fn grey() -> BsdfDescription {
    BsdfDescription::Diffuse { reflectance: Rgb::grey(FLOOR).into() }
}

fn corner(size: f64) -> Stage {
    let mut scene = unit_enclosure(0.5);
    let corner = DVec3::new(-1.0, -0.8, -1.2);
    let fov = 2.0 * libm::atan(size / 3.0).to_degrees();
    scene.sensor = Some(pinhole(DVec3::new(0.3, 0.1, 0.9), corner, fov));
    Stage::new(scene, 1.0)
}

fn edge_of_a_lamp(width: f64) -> Stage {
    let wall = rectangle("wall", DVec3::new(0.0, -0.5, 0.0), DVec3::Y, DVec3::Z, 1);
    let corners = wall.positions.clone();
    let mut scene = floor();
    scene.materials.push(diffuse("wall", Rgb::BLACK, Rgb::WHITE));
    scene.meshes.push(wall);
    let half_width = 0.5 * width;
    if let Some(camera) = &mut scene.sensor {
        camera.position = DVec3::new(half_width, 0.1, 0.5);
        camera.projection = Projection::Orthographic { half_width, half_height: half_width / ASPECT };
    }
    let irradiance = |at: DVec3| {
        let x = DVec3::new(half_width * (1.0 + at.x / (SEEN * ASPECT)), 0.1 + half_width / ASPECT * at.y / SEEN, 0.0);
        std::f64::consts::PI * point_form_factor(x, DVec3::Z, &corners)
    };
    Stage::new(scene, floor_mean(24, irradiance))
}

fn grazing_light(cosine: f64) -> Stage {
    let mut scene = floor();
    let sine = (1.0 - cosine * cosine).sqrt();
    let kind = LightKind::Directional { direction: DVec3::new(sine, 0.0, -cosine), irradiance: Rgb::WHITE };
    scene.lights.push(Light { name: "sun".into(), kind });
    Stage::new(scene, FLOOR / std::f64::consts::PI * cosine)
}

fn grazing_view(cosine: f64) -> Stage {
    let sine = (1.0 - cosine * cosine).sqrt();
    let camera = pinhole(DVec3::new(sine, 0.0, cosine), DVec3::ZERO, (0.2 * cosine).to_degrees());
    Stage::new(sample_in_furnace(grey(), camera), FLOOR)
}

fn near_surfaces(gap: f64) -> Stage {
    let plate = |name: &str, z: f64, material: usize| {
        rectangle(name, DVec3::new(-2.0, -2.0, z), DVec3::X * 4.0, DVec3::Y * 4.0, material)
    };
    let mut scene = floor();
    // The one that must not be seen comes first.
    scene.meshes = vec![plate("below", -gap, 1), plate("above", 0.0, 0)];
    let lamp = |name: &str, radiance: f64| diffuse(name, Rgb::grey(FLOOR), Rgb::grey(radiance));
    scene.materials = vec![lamp("above", 1.0), lamp("below", 10.0)];
    Stage::new(scene, 1.0)
}

fn touching_lamp(gap: f64) -> Stage {
    const FLUX: f64 = 1.0;
    let radius = 0.05;
    let place = DVec3::new(0.1, 0.05, radius * (1.0 + gap));
    let mut scene = floor();
    scene.materials.push(diffuse("lamp", Rgb::BLACK, emission_of_ball(FLUX, radius)));
    scene.spheres.push(Sphere::new("lamp", place, radius, 1));
    // From below, through a floor that lets it: the lamp hides nothing from there.
    let mut camera = pinhole(DVec3::new(0.0, 0.0, 1.0), DVec3::ZERO, 10.0);
    camera.projection = Projection::Surface { shape: crate::scene::description::ShapeIndex::Mesh(1) };
    scene.meshes.push(rectangle("meter", DVec3::new(-0.5, -0.375, 0.0), DVec3::X, DVec3::Y * 0.75, 0));
    scene.meshes[0] = rectangle("floor", DVec3::new(-2.0, -2.0, -1.0), DVec3::X * 4.0, DVec3::Y * 4.0, 0);
    scene.sensor = Some(camera);
    // The peak below the lamp is as wide as the lamp's radius: rings around it would need a clipped rectangle, nodes do not.
    let mean = floor_mean(160, |at| isotropic(FLUX, place, at)) * std::f64::consts::PI / FLOOR;
    Stage::new(scene, mean)
}

fn closed_mesh(triangles: f64) -> Stage {
    let levels = (libm::log(triangles / 20.0) / libm::log(4.0)).round() as u32;
    let scene = SceneDescription {
        name: "closed mesh".into(),
        meshes: vec![subdivided(levels)],
        materials: vec![diffuse("inside", Rgb::grey(0.5), Rgb::grey(0.5))],
        environment: Some(Rgb::grey(1e6).into()),
        sensor: Some(pinhole(DVec3::ZERO, DVec3::new(1.0, 0.3, 0.2), 90.0)),
        film: Some(FILM),
        ..SceneDescription::default()
    };
    Stage::new(scene, 1.0)
}

fn shading_normals(tilt: f64) -> Stage {
    let mut scene = sample_in_furnace(grey(), pinhole(DVec3::Z, DVec3::ZERO, 1.0));
    let (sine, cosine) = (libm::sin(tilt.to_radians()), libm::cos(tilt.to_radians()));
    scene.meshes[0].normals = Some(vec![DVec3::new(sine, 0.0, cosine); 4]);
    let why = "directions that the two normals have on different sides are black here, and not there";
    Stage { ours_alone: Some(why), ..Stage::new(scene, FLOOR * 0.5 * (1.0 + cosine)) }
}
