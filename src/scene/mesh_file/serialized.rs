//! Mitsuba's own `.serialized` files, versions 3 and 4.
//!
//! Little endian throughout. A mesh is a header (0x041C, the version) and a zlib stream: flags, in version 4 the name, the
//! numbers of vertices and triangles, then one array after the other. Several meshes stand one after the other, with a
//! dictionary of where they begin at the end of the file. Colours and the flag for face normals are passed over, as in
//! Mitsuba 3.

use std::io::Read;

use flate2::bufread::ZlibDecoder;
use glam::{Vec2, Vec3};

use super::error::Fault;
use super::{MeshData, finite_or_zero};

const MAGIC: u16 = 0x041C;

/// Of the flags.
const NORMALS: u32 = 0x0001;
const TEXCOORDS: u32 = 0x0002;
const COLOURS: u32 = 0x0008;
const DOUBLE_PRECISION: u32 = 0x2000;

/// A mesh may unpack to so many bytes, and to [`MOST_RATIO`] times its packed size on top: real ones stay far below, and a
/// small file cannot fill the memory.
const MOST_BYTES: u64 = 256 << 20;
const MOST_RATIO: u64 = 100;

/// A name is no longer than this.
const MOST_NAME: usize = 65536;

const REMEDY: &str = "copy or export the file again";

pub(super) fn read(bytes: &[u8], shape_index: usize) -> Result<MeshData, Fault> {
    let version = version(bytes, 0)?;
    let start = if shape_index == 0 { 0 } else { start(bytes, version, shape_index)? };
    if start != 0 {
        self::version(bytes, start)?;
    }
    let packed = &bytes[start + 4..];
    let limit = MOST_BYTES.saturating_add(MOST_RATIO * packed.len() as u64);
    let place = format!("mesh {shape_index}");
    Stream { zlib: ZlibDecoder::new(packed).take(limit), place, limit }.mesh(version)
}

fn version(bytes: &[u8], start: usize) -> Result<u16, Fault> {
    let word = |at: usize| array(bytes, start + at).map(u16::from_le_bytes);
    let fault = |problem, remedy| Err(Fault::new(format!("byte {start}"), problem, remedy));
    match (word(0), word(2)) {
        (Some(MAGIC), Some(version @ (3 | 4))) => Ok(version),
        (Some(MAGIC), Some(version)) => {
            fault(format!("version {version} is unknown"), "save the mesh as version 4, as PLY or as OBJ")
        }
        _ => fault("no serialized mesh begins here".into(), "check that it is a file of Mitsuba"),
    }
}

/// Where a mesh begins, by the dictionary at the file's end.
fn start(bytes: &[u8], version: u16, shape_index: usize) -> Result<usize, Fault> {
    let fault = |problem| Fault::new("the dictionary at the end", problem, "check the shape index and the file");
    let end = bytes.len() - 4;
    let count = array(bytes, end).map_or(0, u32::from_le_bytes) as usize;
    if shape_index >= count {
        return Err(fault(format!("there is no mesh {shape_index} among {count}")));
    }
    let width = if version == 3 { 4 } else { 8 };
    let entry = (count - shape_index).checked_mul(width).and_then(|back| end.checked_sub(back));
    let start = entry.and_then(|entry| match width {
        4 => array(bytes, entry).map(|b| u64::from(u32::from_le_bytes(b))),
        _ => array(bytes, entry).map(u64::from_le_bytes),
    });
    let start = start.and_then(|start| usize::try_from(start).ok()).filter(|&start| start < bytes.len());
    start.ok_or_else(|| fault(format!("mesh {shape_index} begins outside of the file")))
}

fn array<const N: usize>(bytes: &[u8], at: usize) -> Option<[u8; N]> {
    bytes.get(at..)?.first_chunk().copied()
}

struct Stream<'a> {
    zlib: std::io::Take<ZlibDecoder<&'a [u8]>>,
    place: String,
    limit: u64,
}

impl Stream<'_> {
    fn mesh(mut self, version: u16) -> Result<MeshData, Fault> {
        let flags = u32::from_le_bytes(self.array()?);
        if version == 4 {
            self.skip_name()?;
        }
        let vertices = u64::from_le_bytes(self.array()?);
        let triangles = u64::from_le_bytes(self.array()?);
        let has = |flag: u32| flags & flag != 0;
        let double = has(DOUBLE_PRECISION);
        let [normal, texcoord, colour] =
            [(NORMALS, 3), (TEXCOORDS, 2), (COLOURS, 3)].map(|(flag, numbers)| if has(flag) { numbers } else { 0 });
        let width = if double { 8 } else { 4 };
        let promised = u128::from(vertices) * (3 + normal + texcoord + colour) * width + u128::from(triangles) * 12;
        if promised > u128::from(self.limit) {
            return Err(self.fault(format!("{vertices} vertices and {triangles} triangles cannot be in this file")));
        }
        let positions = self.vectors(vertices, double, Vec3::from_array)?;
        if let Some(bad) = positions.iter().position(|p| !p.is_finite()) {
            return Err(self.fault(format!("the position of vertex {bad} is not finite")));
        }
        let normals =
            if has(NORMALS) { Some(self.vectors(vertices, double, |n| Vec3::from(finite_or_zero(n)))?) } else { None };
        let texcoords = if has(TEXCOORDS) {
            Some(self.vectors(vertices, double, |uv| Vec2::from(finite_or_zero(uv)))?)
        } else {
            None
        };
        if has(COLOURS) {
            self.vectors(vertices, double, |_: [f32; 3]| ())?;
        }
        let triangles = self.triangles(triangles, positions.len())?;
        Ok(MeshData { positions, normals, texcoords, triangles, ..MeshData::default() })
    }

    fn fault(&self, problem: impl Into<String>) -> Fault {
        Fault::new(&self.place, problem, REMEDY)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        let mut bytes = [0; N];
        match self.zlib.read_exact(&mut bytes) {
            Ok(()) => Ok(bytes),
            Err(error) => Err(self.fault(format!("it cannot be unpacked ({error})"))),
        }
    }

    fn skip_name(&mut self) -> Result<(), Fault> {
        for _ in 0..MOST_NAME {
            if self.array::<1>()? == [0] {
                return Ok(());
            }
        }
        Err(self.fault("its name has no end"))
    }

    fn vectors<const N: usize, T>(
        &mut self,
        count: u64,
        double: bool,
        value: impl Fn([f32; N]) -> T,
    ) -> Result<Vec<T>, Fault> {
        let mut all = Vec::new();
        if double {
            self.records(count, |numbers: [[u8; 8]; N]| {
                all.push(value(numbers.map(|number| f64::from_le_bytes(number) as f32)));
            })?;
        } else {
            self.records(count, |numbers: [[u8; 4]; N]| all.push(value(numbers.map(f32::from_le_bytes))))?;
        }
        Ok(all)
    }

    fn triangles(&mut self, count: u64, vertices: usize) -> Result<Vec<[u32; 3]>, Fault> {
        let mut triangles = Vec::new();
        self.records(count, |corners: [[u8; 4]; 3]| triangles.push(corners.map(u32::from_le_bytes)))?;
        let bad = |triangle: &[u32; 3]| triangle.iter().any(|&i| i as usize >= vertices);
        match triangles.iter().position(bad) {
            Some(bad) => Err(self.fault(format!("triangle {bad} names a vertex that is not one of the {vertices}"))),
            None => Ok(triangles),
        }
    }

    /// Each of `count` records of N numbers; memory grows with what is there, not with what is promised.
    fn records<const N: usize, const WIDTH: usize>(
        &mut self,
        count: u64,
        mut record: impl FnMut([[u8; WIDTH]; N]),
    ) -> Result<(), Fault> {
        const AT_ONCE: u64 = 4096;
        let mut buffer = vec![[[0; WIDTH]; N]; count.min(AT_ONCE) as usize];
        let mut left = count;
        while left > 0 {
            let records = &mut buffer[..left.min(AT_ONCE) as usize];
            if let Err(error) = self.zlib.read_exact(records.as_flattened_mut().as_flattened_mut()) {
                return Err(self.fault(format!("it cannot be unpacked ({error})")));
            }
            records.iter().copied().for_each(&mut record);
            left -= records.len() as u64;
        }
        Ok(())
    }
}
