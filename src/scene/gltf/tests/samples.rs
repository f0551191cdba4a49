//! Files that other people made, read where they lie beside the repository.

use std::path::{Path, PathBuf};

use glam::DVec3;

use super::{corners, facing};
use crate::scene::description::{LightKind, Mesh, Projection, SceneDescription};
use crate::scene::gltf::read;

/// The folder of the files; a test without it says so and passes.
fn folder() -> Option<PathBuf> {
    let given = std::env::var_os("PATHSPACE_SHARED").map(PathBuf::from);
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let beside = ["../shared", "../../shared"].map(|relative| here.join(relative));
    let found = given.into_iter().chain(beside).map(|folder| folder.join("scenes/gltf")).find(|folder| folder.is_dir());
    if found.is_none() {
        eprintln!("skipped: there is no folder of shared scenes (PATHSPACE_SHARED can name it)");
    }
    found
}

fn all_files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut waiting = vec![folder.to_path_buf()];
    while let Some(folder) = waiting.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let ending = path.extension().and_then(|ending| ending.to_str());
            if path.is_dir() {
                waiting.push(path);
            } else if matches!(ending, Some("gltf" | "glb")) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

fn sample(name: &str) -> Option<SceneDescription> {
    Some(read(&folder()?.join(name)).unwrap())
}

#[test]
fn files_from_elsewhere_load() {
    let Some(folder) = folder() else { return };
    let all = all_files(&folder);
    for path in &all {
        let scene = read(path).unwrap_or_else(|error| panic!("{error}"));
        assert!(!scene.meshes.is_empty(), "{}", path.display());
        println!("{}: {} meshes, {:?}", path.display(), scene.meshes.len(), scene.warnings);
    }
    assert!(all.len() >= 20, "only {} files", all.len());
}

#[test]
fn simple_sparse_accessor_moves_three_vertices() {
    let Some(scene) = sample("khronos/SimpleSparseAccessor/SimpleSparseAccessor.gltf") else { return };
    let mut heights: Vec<[i32; 2]> = scene.meshes[0].positions.iter().map(|p| [p.x as i32, p.y as i32]).collect();
    heights.sort_unstable();
    let bottom = (0..7).map(|x| [x, 0]);
    // The upper row stands at y = 1, but for those at x = 1, 3 and 5, which are raised to 2, 3 and 4.
    let top = [[0, 1], [1, 2], [2, 1], [3, 3], [4, 1], [5, 4], [6, 1]];
    let mut expected: Vec<[i32; 2]> = bottom.chain(top).collect();
    expected.sort_unstable();
    assert_eq!(heights, expected);
}

#[test]
fn box_interleaved_is_a_unit_cube_that_faces_outwards() {
    let Some(scene) = sample("khronos/BoxInterleaved/BoxInterleaved.gltf") else { return };
    let mesh = &scene.meshes[0];
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (24, 12));
    assert!(mesh.positions.iter().all(|p| p.abs() == DVec3::splat(0.5)));
    for triangle in corners(mesh) {
        assert!(facing(triangle).dot(triangle[0]) == 0.5);
    }
    assert!(mesh.normals.is_none(), "flat faces need no normals of their own");
}

#[test]
fn mesh_primitive_modes_gives_one_hexagon_in_three_ways() {
    let Some(scene) = sample("khronos/MeshPrimitiveModes/MeshPrimitiveModes.gltf") else { return };
    assert_eq!(scene.meshes.len(), 3);
    assert!(scene.warnings[0].starts_with("4 primitives of points or lines"), "{:?}", scene.warnings);
    let area = |mesh: &Mesh| -> f64 { corners(mesh).iter().map(|[a, b, c]| 0.5 * (*b - *a).cross(*c - *a).z).sum() };
    // A hexagon of corners (±0.866, ±0.5) and (0, ±1) has the area 4 · 0.866 · 0.75. The strip needs four triangles only.
    let hexagon = 4.0 * f64::from(0.866_f32) * 0.75;
    for (mesh, triangles, centre) in
        scene.meshes.iter().zip([6, 4, 6]).zip([-2.0, 0.0, 2.0]).map(|((m, t), c)| (m, t, c))
    {
        assert_eq!(mesh.triangles.len(), triangles);
        assert!((area(mesh) - hexagon).abs() < 1e-12, "{}: {}", mesh.name, area(mesh));
        assert!(corners(mesh).into_iter().all(|triangle| facing(triangle) == DVec3::Z), "{}", mesh.name);
        assert!(mesh.positions.iter().all(|p| (p.x - centre).abs() < 1.0 && (p.y + 3.0).abs() <= 1.0));
    }
}

#[test]
fn cameras_has_a_perspective_and_an_orthographic_one() {
    let Some(folder) = folder() else { return };
    let path = folder.join("khronos/Cameras/Cameras.gltf");
    let scene = read(&path).unwrap();
    let sensor = scene.sensor.unwrap();
    assert_eq!((sensor.position, sensor.forward, sensor.up), (DVec3::new(0.5, 0.5, 3.0), -DVec3::Z, DVec3::Y));
    assert_eq!(sensor.projection, Projection::Perspective { vertical_fov: 0.7, aspect: Some(1.0), lens: None });
    let options = crate::scene::gltf::ReadOptions { camera: Some("1".into()), ..Default::default() };
    let other = crate::scene::gltf::read_with(&path, &options).unwrap().sensor.unwrap();
    assert_eq!(other.projection, Projection::Orthographic { half_width: 1.0, half_height: 1.0 });
    // The square leans by −2 atan(0.383 / 0.92375) around x: its upper edge goes to y = cos, z = −sin.
    let (sin, cos) = (2.0 * 0.383 * 0.92375, 0.92375 * 0.92375 - 0.383 * 0.383);
    let length = 0.92375_f64 * 0.92375 + 0.383 * 0.383;
    let top = DVec3::new(1.0, cos / length, -sin / length);
    assert!(scene.meshes[0].positions.iter().any(|p| (*p - top).length() < 1e-12));
}

#[test]
fn simple_instancing_draws_a_lattice_of_cubes() {
    let Some(scene) = sample("khronos/SimpleInstancing/SimpleInstancing.glb") else { return };
    assert_eq!(scene.meshes.len(), 125);
    // The first instance stands at the origin, unscaled and unturned.
    assert!(scene.meshes[0].positions.iter().all(|p| p.cmpge(DVec3::ZERO).all() && p.cmple(DVec3::ONE).all()));
    for mesh in &scene.meshes {
        let centre = mesh.positions.iter().sum::<DVec3>() / mesh.positions.len() as f64;
        for triangle in corners(mesh) {
            assert!(facing(triangle).dot(triangle[0] - centre) > 0.0, "{} faces outwards", mesh.name);
        }
    }
}

#[test]
fn negative_scale_test_keeps_every_front() {
    let Some(folder) = folder() else { return };
    let scene = read(&folder.join("khronos/NegativeScaleTest/NegativeScaleTest.glb")).unwrap();
    let named = |name: &str| scene.meshes.iter().find(|mesh| mesh.name == name).unwrap();
    let centre = |mesh: &Mesh| {
        let (low, high) = mesh
            .positions
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
        0.5 * (low + high)
    };
    // Shiny Parent: turned by π around z and scaled by −1, which is a mirror in z, then moved by (1, −3.5, 0). Its second
    // child does the same around (2, 0, 0), so that it stands at (3, −3.5, 0), mirrored twice.
    for (name, expected) in [
        ("NotShiny1", DVec3::new(1.0, -1.0, 0.0)),
        ("NotShinyMinus1", DVec3::new(3.0, -1.0, 0.0)),
        ("Shiny1", DVec3::new(1.0, -3.5, 0.0)),
        ("ShinyMinus1", DVec3::new(3.0, -3.5, 0.0)),
        ("DarkMinus1", DVec3::new(3.0, -2.25, 0.0)),
    ] {
        let ball = named(name);
        let middle = centre(ball);
        assert!((middle - expected).length() < 1e-2, "{name}: {middle}");
        for triangle in corners(ball) {
            assert!(facing(triangle).dot(triangle[0] - middle) > 0.0, "{name} faces outwards");
        }
        for (position, normal) in ball.positions.iter().zip(ball.normals.as_ref().unwrap()) {
            assert!(normal.dot((*position - middle).normalize()) > 0.9, "{name} is shaded from outside");
        }
    }
    // The card in front of the cross: its triangles face the viewer after the turn and the mirror.
    // Two quadrilaterals, one facing each way; turned and mirrored, this is a mirror in y and they face as before.
    let signs: Vec<f64> = corners(named("NegativeScaleFront")).into_iter().map(|t| facing(t).z.signum()).collect();
    assert_eq!(signs, [1.0, 1.0, -1.0, -1.0]);
}

#[test]
fn easy_gltf_cube_has_three_kinds_of_light_and_a_camera() {
    let Some(scene) = sample("easy-gltf/cube.glb") else { return };
    assert!(scene.sensor.is_some());
    let kinds: Vec<&str> = scene
        .lights
        .iter()
        .map(|light| match light.kind {
            LightKind::Point { .. } => "point",
            LightKind::Spot { .. } => "spot",
            LightKind::Directional { .. } => "directional",
            LightKind::Projector { .. } => "projector",
        })
        .collect();
    assert_eq!(kinds, ["point", "directional", "spot"]);
    // Blender's sun stands at (−13.0, 16.5, 5.2) and shines downwards.
    let LightKind::Directional { direction, .. } = scene.lights[1].kind else { panic!("the second is the sun") };
    assert!(direction.y < 0.0);
    let centre = scene.meshes[0].positions.iter().sum::<DVec3>() / scene.meshes[0].positions.len() as f64;
    assert!((centre - DVec3::splat(0.5)).length() < 1e-6, "{centre}");
}
