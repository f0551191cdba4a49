//! Files that are wrong in ways that nobody thought of: whatever they hold, the answer is a mesh or one line.

use proptest::prelude::*;

use super::{OBJ, library, packed, ply, read_with, serialized};
use crate::scene::mesh_file::MeshFormat::{self, Obj, Ply, Serialized};

fn seeds() -> Vec<(Vec<u8>, MeshFormat)> {
    let vertices = ["0 0 0 1 0.5 200", "1 0 0 1 0.5 0", "0 1 0 1 0.5 1"];
    let text = ply("float u, float v, uchar foo_0", &vertices, "int id_0", &["3 0 1 2 5"]);
    let mut binary =
        text.replace("ascii", "binary_big_endian").split("end_header\n").next().unwrap().as_bytes().to_vec();
    binary.extend(b"end_header\n");
    binary.extend([0; 3 * 21]);
    binary.extend([3, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 5]);
    vec![
        (OBJ.into(), Obj),
        (text.into(), Ply),
        (binary, Ply),
        (serialized(3, false, 1.0), Serialized { shape_index: 0 }),
        (library(4, &[serialized(4, true, 1.0), serialized(4, false, 2.0)]), Serialized { shape_index: 1 }),
    ]
}

/// A change at a place, as a share of the length.
#[derive(Clone, Debug)]
enum Change {
    Set(f64, u8),
    Cut(f64, f64),
    Repeat(f64, f64),
    Insert(f64, &'static str),
}

fn change() -> impl Strategy<Value = Change> {
    let words = ["999999999999", "-1", "nan", "/", "\\\n", "list", "property uchar a_0\n", "\n", " ", "element q 9\n"];
    prop_oneof![
        4 => (0.0..1.0, any::<u8>()).prop_map(|(at, byte)| Change::Set(at, byte)),
        1 => (0.0..1.0, 0.0..1.0).prop_map(|(from, to)| Change::Cut(from, to)),
        1 => (0.0..1.0, 0.0..1.0).prop_map(|(from, to)| Change::Repeat(from, to)),
        2 => (0.0..1.0, prop::sample::select(words.to_vec())).prop_map(|(at, word)| Change::Insert(at, word)),
    ]
}

fn changed(mut bytes: Vec<u8>, changes: &[Change]) -> Vec<u8> {
    for change in changes {
        let at = |share: f64| (share * bytes.len() as f64) as usize;
        match *change {
            Change::Set(share, byte) => {
                let at = at(share);
                bytes.get_mut(at).into_iter().for_each(|b| *b = byte);
            }
            Change::Cut(a, b) => drop(bytes.drain(at(a.min(b))..at(a.max(b)))),
            Change::Repeat(a, b) => bytes.extend_from_within(at(a.min(b))..at(a.max(b))),
            Change::Insert(share, word) => drop(bytes.splice(at(share)..at(share), word.bytes())),
        }
    }
    bytes
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn never_panics(seed in 0..5_usize, changes in prop::collection::vec(change(), 1..6), flip in any::<bool>()) {
        let (bytes, format) = seeds().swap_remove(seed);
        let _ = read_with(&changed(bytes, &changes), format, flip);
    }

    /// The stream inside, where a changed file would only fail its checksum.
    #[test]
    fn never_panics_inside_the_stream(changes in prop::collection::vec(change(), 1..6)) {
        let file = serialized(4, false, 1.0);
        let mut data = Vec::new();
        std::io::Read::read_to_end(&mut flate2::read::ZlibDecoder::new(&file[4..]), &mut data).unwrap();
        let file = [&file[..4], &packed(&changed(data, &changes))].concat();
        let _ = read_with(&file, Serialized { shape_index: 0 }, false);
    }
}
