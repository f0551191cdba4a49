#![allow(clippy::unwrap_used)]

use std::f64::consts::FRAC_1_SQRT_2;

use glam::DVec3;

use super::surface::Rectangle;
use super::{Meter, Region};
use crate::scene::SceneDescription;
use crate::scene::description::{Light, LightKind, Mesh, Projection, Sphere};
use crate::spectrum::Rgb;

fn read(text: &str) -> Meter {
    text.parse().unwrap_or_else(|error| panic!("{text}: {error}"))
}

#[test]
fn every_form_is_read() {
    let (position, normal) = (DVec3::new(1.0, -2.5, 3e-3), DVec3::Y);
    assert_eq!(read("irradiance:1,-2.5,3e-3:0,2,0"), Meter::Irradiance { position, normal });
    let rectangle = Region::Rectangle { corner: DVec3::ZERO, u: DVec3::X * 2.0, v: DVec3::Z };
    assert_eq!(read("irradiance:0,0,0:2,0,0:0,0,1"), Meter::MeanIrradiance(rectangle.clone()));
    assert_eq!(read("flux:0, 0, 0:2,0,0:0,0,1"), Meter::Flux(rectangle));
    assert_eq!(read("irradiance:floor"), Meter::MeanIrradiance(Region::Surface("floor".into())));
    assert_eq!(read("flux:my floor:2"), Meter::Flux(Region::Surface("my floor:2".into())));
    assert_eq!(read("flux:lamp:leaving"), Meter::FluxLeaving("lamp".into()));
    assert_eq!(read("radiance:1,-2.5,3e-3:0,2,0"), Meter::Radiance { position, direction: normal });
    let direction = DVec3::new(FRAC_1_SQRT_2, 0.0, -FRAC_1_SQRT_2);
    let Meter::Intensity { direction: found } = read("intensity:3,0,-3") else { panic!("another meter") };
    assert!((found - direction).length() < 1e-15);
}

#[test]
fn what_makes_no_sense_is_refused_with_a_remedy() {
    for (text, words) in [
        (
            "irradiace:0,0,0:0,1,0",
            ["unknown meter 'irradiace', did you mean 'irradiance'?", "known meters are irradiance, flux"],
        ),
        ("", ["unknown meter ''", "known meters"]),
        ("flux", ["does not say where", "write flux:X,Y,Z"]),
        ("irradiance:0,0,0:0,0,0", ["direction must not be zero", "write irradiance:X,Y,Z:NX,NY,NZ"]),
        ("radiance:0,0,0:0,0,0", ["direction must not be zero", "write radiance:"]),
        ("intensity:0,0,0", ["direction must not be zero", "write intensity:"]),
        ("intensity:0,NaN,1", ["three finite numbers", "write intensity:"]),
        ("radiance:0,0,inf:0,1,0", ["three finite numbers", "write radiance:"]),
        ("irradiance:0,0:0,1,0", ["three finite numbers", "write irradiance:"]),
        ("irradiance:0,0,0", ["another number of vectors", "write irradiance:"]),
        ("radiance:0,0,0:0,1,0:0,1,0", ["another number of vectors", "write radiance:"]),
        ("radiance:lamp", ["measured at no surface", "write radiance:"]),
        ("flux:0,0,0:1,0,0:2,0,0", ["must span an area", "write flux:"]),
        ("flux:0,0,0:1,0,0:1,0,1", ["right angles", "write flux:"]),
        ("irradiance:0,0,0:1e300,0,0:0,1e300,0", ["must span an area", "write irradiance:"]),
    ] {
        let error = text.parse::<Meter>().unwrap_err().to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{text}: {error}");
    }
}

/// A rectangle of n × m cells, each cut in two, whose corner is at (1, 2, 3) and whose front faces u × v; its last vertex is moved.
fn grid(name: &str, u: DVec3, v: DVec3, [n, m]: [u32; 2], moved: DVec3) -> Mesh {
    let at = |i: u32, j: u32| {
        DVec3::new(1.0, 2.0, 3.0) + u * (f64::from(i) / f64::from(n)) + v * (f64::from(j) / f64::from(m))
    };
    let mut positions: Vec<DVec3> = (0..=m).flat_map(|j| (0..=n).map(move |i| at(i, j))).collect();
    *positions.last_mut().unwrap() += moved;
    let mut triangles = Vec::new();
    for (i, j) in (0..m).flat_map(|j| (0..n).map(move |i| (i, j))) {
        let a = j * (n + 1) + i;
        let (b, c, d) = (a + 1, a + n + 2, a + n + 1);
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    Mesh { name: name.into(), positions, triangles, ..Mesh::default() }
}

fn scene(meshes: Vec<Mesh>) -> SceneDescription {
    SceneDescription { meshes, ..SceneDescription::default() }
}

#[test]
fn rectangles_are_found_however_they_are_cut() {
    let (u, v) = (DVec3::new(3.0, 0.0, 4.0), DVec3::new(0.0, 2.0, 0.0));
    for cells in [[1, 1], [4, 1], [3, 5]] {
        let scene = scene(vec![grid("wall", u, v, cells, DVec3::ZERO)]);
        let found = Rectangle::in_front_of(&scene, "wall").unwrap();
        assert!((found.area() - 10.0).abs() < 1e-12, "{found:?}");
        assert!((found.forward - u.cross(v).normalize()).length() < 1e-12, "{found:?}");
        let centre = DVec3::new(1.0, 2.0, 3.0) + 0.5 * (u + v);
        let gap = (found.centre - centre).dot(found.forward);
        assert!((found.centre - centre).length() < 1e-5 && gap > 1e-6, "in front of it: {found:?}");
        let along = found.right.dot(u.normalize()).abs();
        let half = if along > 0.5 { [2.5, 1.0] } else { [1.0, 2.5] };
        assert!(found.half.iter().zip(half).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
    }
}

#[test]
fn what_is_no_rectangle_is_refused() {
    let (u, v) = (DVec3::X, DVec3::Y);
    let mut triangle = grid("triangle", u, v, [1, 1], DVec3::ZERO);
    triangle.triangles.pop();
    let mut folded = grid("folded", u, v, [1, 1], DVec3::ZERO);
    folded.triangles[1].reverse();
    let ball = Sphere::new("ball", DVec3::ZERO, 1.0, 0);
    let meshes = vec![
        triangle,
        folded,
        grid("trapezoid", u, v, [1, 1], DVec3::X * 0.01),
        grid("bent", u, v, [2, 2], DVec3::Z * 0.01),
        grid("slanted", u, v + u * 0.1, [1, 1], DVec3::ZERO),
        grid("twice", u, v, [1, 1], DVec3::ZERO),
        grid("twice", u, v, [1, 1], DVec3::ZERO),
    ];
    let scene = SceneDescription { spheres: vec![ball], ..scene(meshes) };
    for (name, words) in [
        ("triangle", "not a flat rectangle"),
        ("folded", "not a flat rectangle"),
        ("trapezoid", "not a flat rectangle"),
        ("bent", "not a flat rectangle"),
        ("slanted", "not a flat rectangle"),
        ("twice", "several surfaces"),
        ("ball", "'ball' is a sphere"),
        ("trapezoi", "did you mean 'trapezoid'?; there are triangle, folded"),
    ] {
        let error = read(&format!("flux:{name}")).aim(&scene).unwrap_err().to_string();
        assert!(error.contains(words), "{name}: {error}");
    }
}

#[test]
fn flux_looks_away_from_a_surface_or_back_at_it() {
    let scene = scene(vec![grid("wall", DVec3::X * 2.0, DVec3::Y * 3.0, [1, 1], DVec3::ZERO)]);
    let [onto, leaving] = ["flux:wall", "flux:wall:leaving"].map(|text| read(text).aim(&scene).unwrap());
    assert_eq!((onto.sensor.forward, leaving.sensor.forward), (DVec3::Z, -DVec3::Z));
    assert_eq!(onto.sensor.position, leaving.sensor.position);
    for aim in [&onto, &leaving] {
        let right = aim.sensor.forward.cross(aim.sensor.up);
        let Projection::Window { half_width, half_height } = aim.sensor.projection else { panic!("{aim:?}") };
        let wide = right.dot(DVec3::X).abs() > 0.5;
        let sides = if wide { [half_width, half_height] } else { [half_height, half_width] };
        assert!((sides[0] - 1.0).abs() < 1e-12 && (sides[1] - 1.5).abs() < 1e-12, "{aim:?}");
        assert!((aim.scale - 6.0).abs() < 1e-12 && aim.unit == "W", "{aim:?}");
    }
}

#[test]
fn quantities_without_a_value_are_refused() {
    let kind = LightKind::Point { position: DVec3::Y * 2.0, intensity: Rgb::WHITE };
    let lights = vec![Light { name: "bulb".into(), kind }];
    let lit = SceneDescription { lights, ..SceneDescription::default() };
    let open = SceneDescription { environment: Some(Rgb::WHITE.into()), ..SceneDescription::default() };
    for (text, scene, words) in [
        ("radiance:0,0,0:0,1,0", &lit, "the point light 'bulb'"),
        ("intensity:0,1,0", &lit, "the light 'bulb' has no surface"),
        ("intensity:0,1,0", &open, "environment"),
        ("intensity:0,1,0", &SceneDescription::default(), "no surfaces"),
    ] {
        let error = read(text).aim(scene).unwrap_err().to_string();
        assert!(error.contains(words), "{text}: {error}");
    }
    assert!(read("radiance:0,0,0:0,-1,0").aim(&lit).is_ok() && read("radiance:1,0,0:0,1,0").aim(&lit).is_ok());
}
