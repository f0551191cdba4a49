//! Mitsuba's serialized meshes: the bytes as a file, and as what stands in the packed stream of one.
#![no_main]

use std::io::Write;

use flate2::{Compression, write::ZlibEncoder};
use libfuzzer_sys::fuzz_target;
use pathspace::scene::mesh_file::MeshFormat;

fuzz_target!(|bytes: &[u8]| {
    for shape_index in 0..2 {
        pathspace_fuzz::mesh(bytes, MeshFormat::Serialized { shape_index }, false);
    }
    for version in [3, 4] {
        let mut encoder = ZlibEncoder::new(vec![0x1C, 0x04, version, 0], Compression::fast());
        encoder.write_all(bytes).and_then(|()| encoder.try_finish()).expect("memory takes it");
        let file = encoder.finish().expect("memory takes it");
        pathspace_fuzz::mesh(&file, MeshFormat::Serialized { shape_index: 0 }, false);
    }
});
