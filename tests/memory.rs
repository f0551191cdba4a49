//! Memory of a scene on its way from a file to what is traced. A process of its own, for its peak.

use std::fmt::Write as _;
use std::path::Path;

use pathspace::scene::mitsuba::read;
use pathspace::scene::{Scene, SceneOptions};

/// Sides of the grid on the sphere.
const SIDE: u32 = 316;

/// Peak of reading and building, over what the process had before, for each triangle \[B\].
const MOST: f64 = 400.0;

const SCENE: &str = r#"<scene version="3.0.0"><emitter type="constant"/>
  <shape type="ply"><string name="filename" value="sphere.ply"/>
    <bsdf type="diffuse"><texture type="checkerboard" name="reflectance"/></bsdf></shape></scene>"#;

/// A bumpy sphere with normals and texture coordinates.
fn write(folder: &Path) {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for row in 0..=SIDE {
        for column in 0..=SIDE {
            let [u, v] = [column, row].map(|i| f64::from(i) / f64::from(SIDE));
            let ((sin_theta, cos_theta), (sin_phi, cos_phi)) =
                ((std::f64::consts::PI * v).sin_cos(), (std::f64::consts::TAU * u).sin_cos());
            let normal = [sin_theta * cos_phi, sin_theta * sin_phi, cos_theta];
            let radius = 1.0 + 0.05 * (120.0 * u).sin() * (90.0 * v).cos();
            let numbers = normal.map(|x| x * radius).into_iter().chain(normal).chain([u, v]);
            vertices.extend(numbers.flat_map(|x| (x as f32).to_le_bytes()));
            if row < SIDE && column < SIDE {
                let corner = row * (SIDE + 1) + column;
                let (below, next) = (corner + SIDE + 1, corner + 1);
                for triangle in [[corner, below, below + 1], [corner, below + 1, next]] {
                    faces.push(3);
                    faces.extend(triangle.iter().flat_map(|i| i.to_le_bytes()));
                }
            }
        }
    }
    let mut header = format!("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", (SIDE + 1) * (SIDE + 1));
    for name in ["x", "y", "z", "nx", "ny", "nz", "u", "v"] {
        writeln!(header, "property float {name}").expect("memory takes it");
    }
    writeln!(header, "element face {}\nproperty list uchar int vertex_indices\nend_header", 2 * SIDE * SIDE)
        .expect("it can be written");
    std::fs::write(folder.join("sphere.ply"), [header.into_bytes(), vertices, faces].concat())
        .expect("it can be written");
    std::fs::write(folder.join("scene.xml"), SCENE).expect("it can be written");
}

/// What the system says of this process's memory \[B\].
fn memory(what: &str) -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(what)?.strip_prefix(':'))?;
    line.trim().trim_end_matches(" kB").parse::<f64>().ok().map(|kib| kib * 1024.0)
}

#[test]
fn a_triangle_costs_few_bytes() {
    let folder = tempfile::tempdir().expect("there is room");
    write(folder.path());
    let Some(before) = memory("VmHWM") else {
        eprintln!("skipped: the system does not tell how much memory a process has");
        return;
    };
    let description = read::read(&folder.path().join("scene.xml")).expect("it can be read");
    let triangles = description.meshes[0].triangles.len();
    assert_eq!(triangles as u32, 2 * SIDE * SIDE);
    let (scene, _) = Scene::build(&description, SceneOptions::default()).expect("it can be built");
    assert_eq!(scene.accel().triangles().count(), triangles);
    let each = (memory("VmHWM").expect("it told before") - before) / triangles as f64;
    println!("{each:.0} bytes for each triangle at the peak");
    assert!(each < MOST, "{each} bytes for each triangle at the peak");
}
