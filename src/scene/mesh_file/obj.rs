//! Wavefront OBJ.
//!
//! What is read are `v`, `vt`, `vn` and `f`; all else (groups, materials, lines, curves) is passed over, as in Mitsuba.
//! Vertices are the different triples of position, texture coordinate and normal, in the order in which faces first name
//! them. Polygons become fans. Beyond what Mitsuba reads, an index may be negative, which counts back from the last value
//! so far, and a line goes on where it ends in a backslash.

use std::collections::HashMap;

use glam::{Vec2, Vec3};

use super::error::Fault;
use super::{MeshData, finite_or_zero};

/// The indices of a face's corner into the lists of positions, texture coordinates and normals.
type Corner = [u32; 3];

/// Of a corner without texture coordinate or normal; of a position that no corner has named.
const NONE: u32 = u32::MAX;

/// The last of a [`Corner`] and of messages.
const LISTS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

pub(super) fn read(bytes: &[u8], flip_tex_coords: bool) -> Result<MeshData, Fault> {
    let mut reader = Reader { flip_tex_coords, ..Reader::default() };
    let mut line = 1;
    let mut rest = bytes;
    while !rest.is_empty() {
        let (text, lines) = next_line(&mut rest);
        reader.line(text).map_err(|problem| {
            let remedy = "correct the line or export the mesh again";
            Fault::new(format!("line {line}"), problem, remedy)
        })?;
        line += lines;
    }
    Ok(reader.finish())
}

/// Takes a line off the text, with all that it goes on with after backslashes, and says how many lines that is.
fn next_line<'a>(rest: &mut &'a [u8]) -> (&'a [u8], usize) {
    let (mut end, mut lines) = (0, 1);
    loop {
        end += rest[end..].iter().position(|&b| b == b'\n').unwrap_or(rest.len() - end);
        let line = &rest[..end];
        if end == rest.len() || !line.strip_suffix(b"\r").unwrap_or(line).ends_with(b"\\") {
            *rest = &rest[(end + 1).min(rest.len())..];
            return (line, lines);
        }
        end += 1;
        lines += 1;
    }
}

#[derive(Default)]
struct Reader {
    flip_tex_coords: bool,
    positions: Vec<Vec3>,
    texcoords: Vec<Vec2>,
    normals: Vec<Vec3>,
    /// The corner that each vertex of the mesh is.
    vertices: Vec<Corner>,
    /// The first vertex of each position.
    first: Vec<u32>,
    /// The vertices that are not the first of their position.
    others: HashMap<Corner, u32>,
    triangles: Vec<[u32; 3]>,
}

impl Reader {
    fn line(&mut self, line: &[u8]) -> Result<(), String> {
        let mut tokens = line.split(|&b| matches!(b, b' ' | b'\t' | b'\r' | b'\n' | b'\\')).filter(|t| !t.is_empty());
        match tokens.next() {
            Some(b"v") => {
                let position = Vec3::from(numbers(tokens, "v")?);
                if !position.is_finite() {
                    return Err("a coordinate is not finite".into());
                }
                self.positions.push(position);
                self.first.push(NONE);
            }
            Some(b"vt") => {
                let [u, v] = numbers(tokens, "vt")?;
                let v = if self.flip_tex_coords { 1.0 - v } else { v };
                self.texcoords.push(Vec2::from(finite_or_zero([u, v])));
            }
            Some(b"vn") => self.normals.push(Vec3::from(finite_or_zero(numbers(tokens, "vn")?))),
            Some(b"f") => self.face(tokens)?,
            _ => {}
        }
        Ok(())
    }

    fn face<'a>(&mut self, tokens: impl Iterator<Item = &'a [u8]>) -> Result<(), String> {
        let (mut first, mut last) = (None, None);
        for token in tokens {
            if token.starts_with(b"#") {
                break;
            }
            let corner = self.corner(token)?;
            let vertex = self.vertex(corner);
            match (first, last) {
                (Some(first), Some(last)) => self.triangles.push([first, last, vertex]),
                (Some(_), None) => {}
                (None, _) => {
                    first = Some(vertex);
                    continue;
                }
            }
            last = Some(vertex);
        }
        Ok(())
    }

    /// `7`, `7/1`, `7//3`, `7/1/3`.
    fn corner(&self, token: &[u8]) -> Result<Corner, String> {
        let mut corner = [NONE; 3];
        let mut parts = token.split(|&b| b == b'/');
        let lengths = [self.positions.len(), self.texcoords.len(), self.normals.len()];
        for (list, part) in parts.by_ref().take(3).enumerate() {
            if part.is_empty() && list > 0 {
                continue;
            }
            let number = parse::<i64>(part).ok_or_else(|| format!("{} is no corner of a face", shown(token)))?;
            let length = lengths[list] as i64;
            let index = if number < 0 { length.saturating_add(number) } else { number - 1 };
            if !(0..length).contains(&index) {
                return Err(format!("there is no {} {number} up to here, only {length}", LISTS[list]));
            }
            corner[list] = index as u32;
        }
        if parts.next().is_some() { Err(format!("{} is no corner of a face", shown(token))) } else { Ok(corner) }
    }

    fn vertex(&mut self, corner: Corner) -> u32 {
        let new = self.vertices.len() as u32;
        let first = &mut self.first[corner[0] as usize];
        if *first == NONE {
            *first = new;
        } else if self.vertices[*first as usize] == corner {
            return *first;
        } else {
            let known = *self.others.entry(corner).or_insert(new);
            if known != new {
                return known;
            }
        }
        self.vertices.push(corner);
        new
    }

    fn finish(self) -> MeshData {
        let Self { positions, texcoords, normals, vertices, triangles, .. } = self;
        MeshData {
            positions: vertices.iter().map(|corner| positions[corner[0] as usize]).collect(),
            texcoords: gather(&vertices, 1, &texcoords),
            normals: gather(&vertices, 2, &normals),
            triangles,
            ..MeshData::default()
        }
    }
}

/// The values that the vertices name in a list; `None` where no vertex names any.
fn gather<T: Copy + Default>(vertices: &[Corner], list: usize, values: &[T]) -> Option<Vec<T>> {
    let named = vertices.iter().any(|corner| corner[list] != NONE);
    let value = |corner: &Corner| values.get(corner[list] as usize).copied().unwrap_or_default();
    named.then(|| vertices.iter().map(value).collect())
}

/// The first N numbers; more are passed over.
fn numbers<'a, const N: usize>(mut tokens: impl Iterator<Item = &'a [u8]>, name: &str) -> Result<[f32; N], String> {
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        let token = tokens.next().ok_or_else(|| format!("{name} needs {N} numbers"))?;
        *number = parse(token).ok_or_else(|| format!("{} is no number", shown(token)))?;
    }
    Ok(numbers)
}

fn parse<T: std::str::FromStr>(token: &[u8]) -> Option<T> {
    std::str::from_utf8(token).ok()?.parse().ok()
}

/// The beginning of a token, for messages.
fn shown(token: &[u8]) -> String {
    format!("{:?}", String::from_utf8_lossy(&token[..token.len().min(40)]))
}
