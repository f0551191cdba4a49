//! The path log as a PLY file: points and lines that any viewer of meshes shows.

use std::io::{self, Write};

use crate::film::png::srgb_from_linear;

use super::PathRecord;

/// Gathers paths for a PLY file (Turk 1994): its header needs their number.
///
/// Vertices have their place \[m\], the geometric normal (zero where there is none), a colour by letter, the number of
/// their path in the file and the luminance that the path adds to its pixel; edges have their path's colour, by what it adds,
/// brightest white.
#[derive(Clone, Debug, Default)]
pub struct PlyWriter {
    vertices: Vec<PlyVertex>,
    paths: Vec<PlyPath>,
}

#[derive(Clone, Copy, Debug)]
struct PlyVertex {
    position: [f64; 3],
    normal: [f64; 3],
    letter: char,
}

#[derive(Clone, Copy, Debug)]
struct PlyPath {
    vertices: usize,
    adds: [f64; 3],
}

impl PlyWriter {
    /// Adds a path; what has no edge is left out.
    pub fn push(&mut self, record: &PathRecord) {
        if record.vertices.len() < 2 {
            return;
        }
        self.vertices.extend(record.vertices.iter().map(|vertex| PlyVertex {
            position: vertex.position,
            normal: vertex.normal.unwrap_or_default(),
            letter: vertex.letter,
        }));
        let adds = record.contribution.map(Option::unwrap_or_default);
        self.paths.push(PlyPath { vertices: record.vertices.len(), adds });
    }

    /// Writes the whole file.
    ///
    /// # Errors
    /// Where writing fails.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let edges = self.vertices.len() - self.paths.len();
        writeln!(out, "ply\nformat ascii 1.0")?;
        writeln!(
            out,
            "comment light paths by pathspace; colours of vertices: L yellow, D grey, G green, S blue, E red"
        )?;
        writeln!(out, "comment colours of edges: what the path adds to its pixel, the brightest as white")?;
        writeln!(out, "element vertex {}", self.vertices.len())?;
        for name in ["x", "y", "z", "nx", "ny", "nz"] {
            writeln!(out, "property double {name}")?;
        }
        write_colour_properties(out)?;
        writeln!(out, "property int path\nproperty double adds")?;
        writeln!(out, "element edge {edges}\nproperty int vertex1\nproperty int vertex2")?;
        write_colour_properties(out)?;
        writeln!(out, "property int path\nend_header")?;
        let mut first = 0;
        for (number, path) in self.paths.iter().enumerate() {
            let adds = crate::spectrum::Rgb::from(path.adds).luminance();
            for vertex in &self.vertices[first..first + path.vertices] {
                let ([x, y, z], [nx, ny, nz]) = (vertex.position, vertex.normal);
                let [r, g, b] = colour_of(vertex.letter);
                writeln!(out, "{x} {y} {z} {nx} {ny} {nz} {r} {g} {b} {number} {adds}")?;
            }
            first += path.vertices;
        }
        self.write_edges(out)
    }

    fn write_edges(&self, out: &mut impl Write) -> io::Result<()> {
        let brightest = self.paths.iter().flat_map(|path| path.adds).fold(f64::MIN_POSITIVE, f64::max);
        let mut first = 0;
        for (number, path) in self.paths.iter().enumerate() {
            let [r, g, b] = path.adds.map(|channel| (255.0 * srgb_from_linear(channel / brightest)).round() as u8);
            for i in first..first + path.vertices - 1 {
                writeln!(out, "{i} {} {r} {g} {b} {number}", i + 1)?;
            }
            first += path.vertices;
        }
        Ok(())
    }
}

fn write_colour_properties(out: &mut impl Write) -> io::Result<()> {
    ["red", "green", "blue"].iter().try_for_each(|name| writeln!(out, "property uchar {name}"))
}

fn colour_of(letter: char) -> [u8; 3] {
    match letter {
        'L' => [255, 210, 0],
        'G' => [60, 180, 75],
        'S' => [60, 120, 255],
        'E' => [230, 40, 40],
        _ => [160, 160, 160],
    }
}
