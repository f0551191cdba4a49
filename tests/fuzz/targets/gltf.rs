//! glTF and GLB: a file, with buffers and images in it or beside it.
#![no_main]

use libfuzzer_sys::fuzz_target;
use pathspace::scene::gltf::{ReadOptions, from_bytes};

fuzz_target!(|bytes: &[u8]| {
    if let Ok(scene) = from_bytes(bytes, &pathspace_fuzz::path("scene.gltf"), &ReadOptions::default()) {
        pathspace_fuzz::scene(&scene);
    }
});
