//! What makes no sense is told in one line, by name.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use crate::scene::description::{Cylinder, Disk, EnvironmentDescription, FilmSize, Light, LightKind, Mesh, Sphere};
use crate::scene::texture::Texels;
use crate::scene::{Scene, SceneDescription, SceneOptions};
use crate::spectrum::Rgb;
use crate::testing::scenes;

fn message(change: impl Fn(&mut SceneDescription)) -> String {
    let mut scene = scenes::lanterns(FilmSize { width: 2, height: 2 });
    assert!(Scene::build(&scene, SceneOptions::default()).is_ok());
    change(&mut scene);
    let message = Scene::build(&scene, SceneOptions::default()).expect_err("it makes no sense").to_string();
    assert!(!message.contains('\n'), "{message}");
    message
}

#[test]
fn shapes_that_cannot_be_are_named() {
    let sphere = |change: &dyn Fn(&mut Sphere)| message(|scene| change(&mut scene.spheres[0]));
    let disk = |change: &dyn Fn(&mut Disk)| message(|scene| change(&mut scene.disks[0]));
    let cylinder = |change: &dyn Fn(&mut Cylinder)| message(|scene| change(&mut scene.cylinders[0]));
    for (message, expected) in [
        (sphere(&|s| s.radius = 0.0), "sphere 'ball': its radius is 0"),
        (sphere(&|s| s.radius = f64::NAN), "sphere 'ball': its radius is NaN"),
        (sphere(&|s| s.radius = 1e-300), "sphere 'ball': its radius is 1e-300; give a number of at least 1e-70"),
        (sphere(&|s| s.centre.x = f64::INFINITY), "sphere 'ball': its centre is"),
        (sphere(&|s| s.axes.x_axis *= 1.1), "sphere 'ball': its axes are not three unit vectors"),
        (sphere(&|s| s.material = 99), "'ball': refers to material 99, but there are"),
        (disk(&|d| d.axes[1] = d.axes[0]), "disk 'ellipse': its axes"),
        (cylinder(&|c| c.axis = DVec3::ZERO), "cylinder 'tube': it goes from"),
        (cylinder(&|c| c.radius = -1.0), "cylinder 'tube': its radius is -1"),
        (cylinder(&|c| c.meridian = c.axis.normalize()), "cylinder 'tube': its meridian"),
    ] {
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn meshes_that_cannot_be_are_named() {
    let mesh = |change: &dyn Fn(&mut Mesh)| message(|scene| change(&mut scene.meshes[0]));
    for (message, expected) in [
        (mesh(&|m| m.positions[1].y = f64::NAN), "its vertex 1 is at [1, NaN, -1]; give three numbers"),
        (mesh(&|m| m.triangles[0][2] = 99), "a triangle names vertex 99, but there are"),
        (mesh(&|m| m.normals = Some(vec![DVec3::Z])), "it has 1 normals for"),
        (mesh(&|m| m.texcoords = Some(vec![])), "it has 0 texture coordinates for"),
    ] {
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn sizes_beyond_the_numbers_are_refused() {
    let scaled = |by: f64| {
        let mut scene = scenes::enclosure(Rgb::WHITE, Rgb::grey(0.5), FilmSize { width: 2, height: 2 });
        scene.meshes.iter_mut().flat_map(|m| &mut m.positions).for_each(|p| *p *= by);
        scene.sensor.iter_mut().for_each(|s| s.position *= by);
        Scene::build(&scene, SceneOptions::default()).map(|_| ())
    };
    for by in [1e-30, 1e-9, 1e9, 1e29] {
        scaled(by).expect("numbers reach that far");
    }
    for by in [1e-300, 1e-40, 1e40, 1e160] {
        let message = scaled(by).expect_err("no numbers for it").to_string();
        assert!(message.contains("the scene: it is ") && !message.contains('\n'), "{message}");
    }
}

#[test]
fn lights_that_cannot_be_are_named() {
    let image = |value: f32| {
        let mut bitmap = scenes::patches(2, 2, 1.0);
        bitmap.texels = Texels::Float(vec![[value, value, value, 1.0]; 4]);
        Arc::new(bitmap)
    };
    let projector = |value: f32, fov: f64| {
        message(|scene| {
            let (forward, up, scale) = (DVec3::X, DVec3::Y, Rgb::WHITE);
            let (position, image) = (DVec3::ZERO, image(value));
            let kind = LightKind::Projector { position, forward, up, horizontal_fov: fov, image, scale };
            scene.lights.push(Light { name: "beamer".into(), kind });
        })
    };
    let sky = |value: f32, scale: f64, stretch: f64| {
        message(|scene| {
            let to_world = DMat3::from_diagonal(DVec3::new(1.0, stretch, 1.0));
            scene.environment = Some(EnvironmentDescription::Map { bitmap: image(value), scale, to_world });
        })
    };
    let dim = |intensity: Rgb| {
        message(|scene| {
            let kind = LightKind::Point { position: DVec3::ZERO, intensity };
            scene.lights.push(Light { name: "bulb".into(), kind });
        })
    };
    for (message, expected) in [
        (projector(0.0, 1.0), "light 'beamer': its image is black"),
        (projector(f32::NAN, 1.0), "light 'beamer': pixel 0,0 of its image 'patches' is not finite"),
        (projector(1.0, 4.0), "light 'beamer': its field of view is 4 rad"),
        (sky(f32::INFINITY, 1.0, 1.0), "environment: pixel 0,0 of its image 'patches' is not finite"),
        (sky(1.0, -1.0, 1.0), "environment: its scale is -1"),
        (sky(1.0, 1.0, 2.0), "environment: its transform is no rotation"),
        (dim(Rgb::new(1.0, -1.0, 0.0)), "light 'bulb': it emits [1.0, -1.0, 0.0]"),
    ] {
        assert!(message.contains(expected), "{message}");
    }
}
