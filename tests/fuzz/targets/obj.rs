//! OBJ files.
#![no_main]

use libfuzzer_sys::fuzz_target;
use pathspace::scene::mesh_file::MeshFormat;

fuzz_target!(|bytes: &[u8]| pathspace_fuzz::mesh(bytes, MeshFormat::Obj, bytes.len() % 2 == 0));
