//! Mitsuba's XML, with files beside it that it may name.
#![no_main]

use libfuzzer_sys::fuzz_target;
use pathspace::scene::mitsuba::read::{ReadOptions, from_bytes};

fuzz_target!(|bytes: &[u8]| {
    if let Ok(scene) = from_bytes(bytes, &pathspace_fuzz::path("scene.xml"), &ReadOptions::default()) {
        pathspace_fuzz::scene(&scene);
    }
});
