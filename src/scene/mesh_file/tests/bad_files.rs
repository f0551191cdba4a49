//! Each thing that can be wrong is told with its place and a remedy.

use super::{library, packed, ply, read_with, serialized};
use crate::scene::mesh_file::MeshFormat::{self, Obj, Ply, Serialized};
use crate::scene::mesh_file::{MeshError, MeshOptions, read};

fn refused(bytes: impl AsRef<[u8]>, format: MeshFormat, parts: &[&str]) {
    let error = read_with(bytes.as_ref(), format, false).unwrap_err();
    assert!(parts.iter().all(|part| error.contains(part)), "{error}\n{parts:?}");
}

#[test]
fn obj() {
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (line, parts) in [
        ("f 1 2 4", ["line 4", "no vertex 4"]),
        ("f 1 2 -4", ["line 4", "no vertex -4"]),
        ("f 0 1 2", ["line 4", "no vertex 0"]),
        ("f 1/1 2 3", ["line 4", "no texture coordinate 1"]),
        ("f 1//1 2 3", ["line 4", "no normal 1"]),
        ("f 1/ 2/a 3", ["line 4", "\"2/a\" is no corner"]),
        ("f 1/1/1/1 2 3", ["line 4", "no texture coordinate"]),
        ("f 1//// 2 3", ["line 4", "\"1////\" is no corner"]),
        ("f 99999999999999999999 2 3", ["line 4", "is no corner"]),
        ("f -9223372036854775808 2 3", ["line 4", "no vertex"]),
        ("v 1 2", ["line 4", "v needs 3 numbers"]),
        ("v 1 2 x", ["line 4", "\"x\" is no number"]),
        ("v 1 2 inf", ["line 4", "not finite"]),
        ("vt 1", ["line 4", "vt needs 2"]),
        ("vn \\\n1 1", ["line 4", "vn needs 3"]),
        ("l 1 \\\n2\nvn 1 1", ["line 6", "vn needs 3"]),
    ] {
        refused(format!("{vertices}{line}\n"), Obj, &parts);
    }
}

#[test]
fn ply_headers() {
    for (header, parts) in [
        ("", ["line 1", "end_header"]),
        ("plywood\n", ["line 1", "not the word ply"]),
        ("ply\nformat ascii 2.0\n", ["line 2", "format ascii 2.0"]),
        ("ply\nformat utf8 1.0\n", ["line 2", "utf8"]),
        ("ply\nproperty int x\n", ["line 2", "of no element"]),
        ("ply\nformat ascii 1.0\nelement vertex -1\n", ["line 3", "-1"]),
        ("ply\nelement vertex 1\nproperty quad x\n", ["line 3", "quad"]),
        ("ply\nelement vertex 1\nproperty list float int x\n", ["line 3", "whole number"]),
        ("ply\nelement vertex 1\nproperty x\n", ["line 3", "a type and a name"]),
        ("ply\nend_header\n", ["line 2", "format"]),
        ("ply\nformat ascii 1.0\nelement vertex 0\nelement vertex 0\nend_header\n", ["header", "x"]),
        ("ply\nformat ascii 1.0\nelement a 0\nelement a 0\nend_header\n", ["header", "two elements a"]),
        (
            "ply\nformat ascii 1.0\nelement face 0\nproperty int vertex_index\nend_header\n",
            ["header", "list vertex_index"],
        ),
    ] {
        refused(header, Ply, &parts);
    }
}

#[test]
fn ply_contents() {
    let square = ["0 0 0", "1 0 0", "1 1 0"];
    for (vertices, faces, parts) in [
        (["0 0 0", "1 0 0", "1 1 nan"], "3 0 1 2", ["vertex 2", "finite"]),
        (["0 0 0", "1 0 0", "1 a 0"], "3 0 1 2", ["vertex 2", "\"a\" is no number"]),
        (square, "3 0 1 3", ["triangle 0", "one of the 3"]),
        (square, "3 0 1 -1", ["face 0", "-1"]),
        (square, "300 0 1 2", ["face 0", "\"300\""]),
        (square, "200 0 1 2", ["face 0", "ends here"]),
        (square, "3 0 1 2 3", ["the end", "more than"]),
        (square, "", ["face 0", "ends here"]),
    ] {
        refused(ply("", &vertices, "", &[faces]), Ply, &parts);
    }
}

/// Numbers that a header makes up cost nothing: the file must have room for them.
#[test]
fn ply_promises() {
    for count in ["9999999999", "18446744073709551615"] {
        for format in ["ascii", "binary_little_endian"] {
            let vertices = "property float x\nproperty float y\nproperty float z\n";
            let header = format!("ply\nformat {format} 1.0\nelement vertex {count}\n{vertices}end_header\n1 2 3");
            refused(header, Ply, &["element vertex", "promised"]);
            let faces = "property list uchar int vertex_index\n";
            let header = format!("ply\nformat {format} 1.0\nelement face {count}\n{faces}end_header\n\0\0\0");
            refused(header, Ply, &["element face", "promised"]);
        }
    }
    let lengths =
        "ply\nformat binary_little_endian 1.0\nelement face 1\nproperty list uint uchar vertex_index\nend_header\n";
    refused([lengths.as_bytes(), &[255; 4]].concat(), Ply, &["face 0", "ends here"]);
}

/// Many attributes of one face, shared by many triangles.
#[test]
fn ply_attributes_do_not_multiply() {
    let attributes: String = (0..2000).map(|i| format!("property uchar a{i}_0\n")).collect();
    let header = format!(
        "ply\nformat binary_little_endian 1.0\nelement face 1\nproperty list ushort uchar vertex_index\n{attributes}\
         end_header\n"
    );
    let mut file = header.into_bytes();
    file.extend(u16::MAX.to_le_bytes());
    file.resize(file.len() + usize::from(u16::MAX) + 2000, 0);
    refused(file, Ply, &["face 0", "too many attributes"]);
}

#[test]
fn serialized_files() {
    let at = |shape_index| Serialized { shape_index };
    refused([], at(0), &["byte 0", "no serialized mesh"]);
    refused([0x1C, 4, 4], at(0), &["byte 0", "no serialized mesh"]);
    refused([0x1C, 4, 5, 0], at(0), &["byte 0", "version 5"]);
    refused([0x1C, 4, 4, 0], at(0), &["mesh 0", "unpacked"]);
    let whole = serialized(4, false, 1.0);
    refused(&whole[..whole.len() / 2], at(0), &["mesh 0", "unpacked"]);
    refused(serialized(4, true, f64::INFINITY), at(0), &["mesh 0", "vertex 2", "finite"]);
    let two = library(4, &[whole.clone(), whole.clone()]);
    refused(&two, at(2), &["dictionary", "no mesh 2 among 2"]);
    refused(&two, at(usize::MAX), &["dictionary", "among 2"]);
    let offset = two.len() - 12;
    for wrong in [u64::MAX, two.len() as u64, 3] {
        let mut file = two.clone();
        file[offset..offset + 8].copy_from_slice(&wrong.to_le_bytes());
        assert!(read_with(&file, at(1), false).is_err());
    }
    let mut file = two.clone();
    let count = file.len() - 4;
    file[count..].fill(255);
    refused(&file, at(1), &["dictionary", "outside of the file"]);
}

/// A promise of 10¹⁸ vertices, a name without an end, and three hundred megabytes of zeros in three hundred kilobytes.
#[test]
fn serialized_bombs() {
    let file = |data: &[u8]| [&[0x1C, 4, 4, 0][..], &packed(data)].concat();
    let head = |vertices: u64, triangles: u64| {
        let mut data = [&0x1000_u32.to_le_bytes()[..], b"\0"].concat();
        data.extend(vertices.to_le_bytes());
        data.extend(triangles.to_le_bytes());
        data
    };
    let only = Serialized { shape_index: 0 };
    refused(file(&head(1 << 60, 0)), only, &["mesh 0", "cannot be in this file"]);
    refused(file(&head(u64::MAX, u64::MAX)), only, &["mesh 0", "cannot be in this file"]);
    refused(file(&head(1 << 20, 0)), only, &["mesh 0", "unpacked"]);
    refused(file(&[1; 1 << 20]), only, &["mesh 0", "no end"]);
    let mut bomb = head(25 << 20, 0);
    bomb.resize(bomb.len() + (300 << 20), 0);
    refused(file(&bomb), only, &["mesh 0", "cannot be in this file"]);
}

#[test]
fn files_that_are_not_there_or_no_files() {
    let folder = tempfile::tempdir().unwrap();
    let options = MeshOptions::default();
    let error = read(&folder.path().join("none.obj"), Obj, &options).unwrap_err();
    assert!(matches!(error, MeshError::NotFound { .. }), "{error}");
    let error = read(folder.path(), Ply, &options).unwrap_err();
    assert!(matches!(error, MeshError::Unreadable { .. }), "{error}");
    #[cfg(unix)]
    assert!(matches!(read("/dev/zero".as_ref(), Ply, &options), Err(MeshError::Unreadable { .. })));
}
