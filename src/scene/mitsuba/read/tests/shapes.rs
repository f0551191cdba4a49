//! Shapes and where they are.

use glam::{DMat3, DVec3};

use super::{refusal, scene};

const QUAD: &str = "<shape type=\"rectangle\">";

/// The normal of the first triangle, by the order of its corners.
fn facing(mesh: &crate::scene::description::Mesh) -> DVec3 {
    let [a, b, c] = mesh.triangles[0].map(|i| mesh.positions[i as usize]);
    (b - a).cross(c - a).normalize()
}

#[test]
fn a_rectangle_faces_z_however_it_is_mirrored() {
    let front = |inner: &str| facing(&scene(&format!("{QUAD}{inner}</shape>")).meshes[0]);
    assert_eq!(front(""), DVec3::Z);
    assert_eq!(front("<transform name=\"to_world\"><scale x=\"-2\"/></transform>"), DVec3::Z);
    assert_eq!(front("<transform name=\"to_world\"><scale z=\"-1\"/></transform>"), -DVec3::Z);
    assert_eq!(front("<boolean name=\"flip_normals\" value=\"true\"/>"), -DVec3::Z);
}

#[test]
fn a_cube_faces_outwards_on_all_sides() {
    for inner in ["", "<transform name=\"to_world\"><scale y=\"-1\"/></transform>"] {
        let scene = scene(&format!("<shape type=\"cube\">{inner}</shape>"));
        let mesh = &scene.meshes[0];
        assert_eq!((mesh.positions.len(), mesh.triangles.len()), (24, 12));
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
            assert!((b - a).cross(c - a).dot(a + b + c) > 0.0);
        }
    }
}

#[test]
fn spheres_are_placed_by_all_three_and_inside_out_where_mirrored() {
    let sphere = |inner: &str| scene(&format!("<shape type=\"sphere\">{inner}</shape>")).spheres[0].clone();
    let placed = sphere(
        "<point name=\"center\" x=\"1\" y=\"0\" z=\"0\"/><float name=\"radius\" value=\"2\"/>\
         <transform name=\"to_world\"><scale value=\"3\"/><translate z=\"1\"/></transform>",
    );
    assert_eq!((placed.centre, placed.radius, placed.inward), (DVec3::new(3.0, 0.0, 1.0), 6.0, false));
    assert_eq!(placed.axes, DMat3::IDENTITY);
    assert!(sphere("<float name=\"radius\" value=\"-2\"/>").inward);
    assert!(sphere("<boolean name=\"flip_normals\" value=\"true\"/>").inward);
    let mirrored = "<transform name=\"to_world\"><scale x=\"-1\"/></transform>";
    assert!(sphere(mirrored).inward);
    let error = refusal("<shape type=\"sphere\"><transform name=\"to_world\"><scale x=\"2\"/></transform></shape>");
    assert!(error.contains("ellipsoid"), "{error}");
}

#[test]
fn disks_and_cylinders_keep_their_axes() {
    let scene = scene(
        "<shape type=\"disk\"><transform name=\"to_world\"><scale x=\"2\" y=\"3\"/><translate z=\"1\"/></transform></shape>\
         <shape type=\"cylinder\"><point name=\"p0\" value=\"1 0 0\"/><point name=\"p1\" value=\"1 0 5\"/>\
         <float name=\"radius\" value=\"0.5\"/></shape>",
    );
    let disk = &scene.disks[0];
    assert_eq!((disk.centre, disk.axes), (DVec3::Z, [DVec3::X * 2.0, DVec3::Y * 3.0]));
    let cylinder = &scene.cylinders[0];
    assert_eq!((cylinder.base, cylinder.axis, cylinder.radius), (DVec3::X, DVec3::Z * 5.0, 0.5));
    assert!(cylinder.meridian.dot(DVec3::Z).abs() < 1e-15);
}

#[test]
fn instances_are_copies_of_their_group() {
    let group = "<shape type=\"shapegroup\" id=\"g\"><shape type=\"rectangle\"/><shape type=\"sphere\"/></shape>";
    let instance = |x: i32| {
        format!(
            "<shape type=\"instance\"><ref id=\"g\"/><transform name=\"to_world\"><translate x=\"{x}\"/></transform></shape>"
        )
    };
    let scene = scene(&format!("{group}{}{}", instance(3), instance(5)));
    assert_eq!((scene.meshes.len(), scene.spheres.len(), scene.materials.len()), (2, 2, 1));
    assert_eq!([scene.spheres[0].centre.x, scene.spheres[1].centre.x], [3.0, 5.0]);
    assert_eq!(scene.meshes[1].positions[0], DVec3::new(4.0, -1.0, 0.0));
}
