//! PLY, in text and binary of both byte orders.
//!
//! Names of texture coordinates, colours and attributes are Mitsuba's. What else there is in the file is passed over.
//! Beyond what Mitsuba reads, faces may have more than three corners and become fans; their attributes go to each of the
//! triangles. Positions and normals in integers are taken as they are.

mod fields;
mod header;
mod numbers;

use glam::{Vec2, Vec3};

use self::fields::{Field, Fields};
use self::header::{Element, Encoding};
use self::numbers::{Binary, Numbers, Text};
use super::error::Fault;
use super::{MeshData, finite_or_zero};

const REMEDY: &str = "copy the file or export the mesh again";

/// Names of texture coordinates, the first pair that there is.
const TEXCOORDS: [[&str; 2]; 3] = [["u", "v"], ["texture_u", "texture_v"], ["s", "t"]];

/// Values of attributes of faces: no more than so many for each byte of the file, however many triangles share one.
const VALUES_PER_BYTE: usize = 16;

pub(super) fn read(bytes: &[u8], flip_tex_coords: bool) -> Result<MeshData, Fault> {
    let (header, rest) = header::parse(bytes)?;
    let reader = Reader { flip_tex_coords, most_values: bytes.len() * VALUES_PER_BYTE, mesh: MeshData::default() };
    match header.encoding {
        Encoding::Text => reader.read(&header.elements, Text { rest }),
        encoding => reader.read(&header.elements, Binary { rest, encoding }),
    }
}

struct Reader {
    flip_tex_coords: bool,
    most_values: usize,
    mesh: MeshData,
}

impl Reader {
    fn read(mut self, elements: &[Element], mut numbers: impl Numbers) -> Result<MeshData, Fault> {
        for (i, element) in elements.iter().enumerate() {
            let name = &element.name;
            if elements[..i].iter().any(|other| other.name == *name) {
                return Err(Fault::new("the header", format!("has two elements {name:.40}"), REMEDY));
            }
            let room = numbers.room(&element.properties);
            if element.count > room && !element.properties.is_empty() {
                let problem = format!("{} are promised, there is room for {room} in the file", element.count);
                return Err(Fault::new(format!("element {name:.40}"), problem, REMEDY));
            }
            match name.as_str() {
                "vertex" => self.vertices(element, &mut numbers)?,
                "face" => self.faces(element, &mut numbers)?,
                _ => self.others(element, &mut numbers)?,
            }
        }
        if !numbers.at_end() {
            return Err(Fault::new("the end", "there is more than the header promises", REMEDY));
        }
        let vertices = self.mesh.positions.len();
        let bad = |triangle: &[u32; 3]| triangle.iter().any(|&i| i as usize >= vertices);
        match self.mesh.triangles.iter().position(bad) {
            Some(bad) => {
                let problem = format!("names a vertex that is not one of the {vertices}");
                Err(Fault::new(format!("triangle {bad}"), problem, REMEDY))
            }
            None => Ok(self.mesh),
        }
    }

    fn vertices(&mut self, element: &Element, numbers: &mut impl Numbers) -> Result<(), Fault> {
        let has = |name: &str| fields::position(element, name).is_some();
        if let Some(missing) = ["x", "y", "z"].into_iter().find(|name| !has(name)) {
            return Err(Fault::new("the header", format!("vertices have no property {missing}"), REMEDY));
        }
        let texcoords = TEXCOORDS.iter().find(|names| names.iter().all(|name| has(name)));
        let [u, v] = texcoords.unwrap_or(&TEXCOORDS[0]);
        let mut fields = Fields::new(element, "vertex_", &["x", "y", "z", "nx", "ny", "nz", u, v]);
        let has_normals = ["nx", "ny", "nz"].iter().all(|name| has(name));
        let has_texcoords = texcoords.is_some();
        let capacity = |has: bool| if has { element.count as usize } else { 0 };
        let mut positions = Vec::with_capacity(capacity(true));
        let mut normals = Vec::with_capacity(capacity(has_normals));
        let mut texcoords = Vec::with_capacity(capacity(has_texcoords));
        for vertex in 0..element.count {
            let place = |problem: String| Fault::new(format!("vertex {vertex}"), problem, REMEDY);
            let mut row = [0.0; 8];
            fields.grow();
            for (property, i) in element.properties.iter().zip(0..) {
                if let Some(length) = property.list {
                    skip(numbers.next(length).map_err(place)?, property.scalar, numbers).map_err(place)?;
                    continue;
                }
                let number = numbers.next(property.scalar).map_err(place)?;
                match fields.fields[i] {
                    Field::Known(i @ 0..6) => row[i] = number as f32,
                    Field::Known(i) => row[i] = fields::value(number, property.scalar),
                    Field::Attribute(attribute, channel) => {
                        fields.set(attribute, channel, fields::value(number, property.scalar));
                    }
                    Field::Unused => {}
                }
            }
            let [x, y, z, nx, ny, nz, u, v] = row;
            let position = Vec3::new(x, y, z);
            if !position.is_finite() {
                return Err(place("a coordinate is not finite".into()));
            }
            positions.push(position);
            if has_normals {
                normals.push(Vec3::from(finite_or_zero([nx, ny, nz])));
            }
            if has_texcoords {
                let v = if self.flip_tex_coords { 1.0 - v } else { v };
                texcoords.push(Vec2::from(finite_or_zero([u, v])));
            }
        }
        self.mesh.positions = positions;
        self.mesh.normals = has_normals.then_some(normals);
        self.mesh.texcoords = has_texcoords.then_some(texcoords);
        self.keep(fields);
        Ok(())
    }

    fn faces(&mut self, element: &Element, numbers: &mut impl Numbers) -> Result<(), Fault> {
        let corners = element
            .properties
            .iter()
            .position(|p| matches!(&*p.name, "vertex_index" | "vertex_indices") && p.list.is_some());
        let Some(corners) = corners else {
            return Err(Fault::new("the header", "faces have no list vertex_index or vertex_indices", REMEDY));
        };
        let mut fields = Fields::new(element, "face_", &[]);
        let channels: usize = fields.attributes.iter().map(|a| a.channels).sum();
        let mut values = vec![0.0; element.properties.len()];
        let mut triangles: Vec<[u32; 3]> = Vec::with_capacity(element.count as usize);
        for face in 0..element.count {
            let place = |problem: String| Fault::new(format!("face {face}"), problem, REMEDY);
            let first = triangles.len();
            for (i, property) in element.properties.iter().enumerate() {
                match property.list {
                    Some(length) => {
                        let length = numbers.next(length).map_err(place)?;
                        if i == corners {
                            fan(length, property.scalar, numbers, &mut triangles).map_err(place)?;
                        } else {
                            skip(length, property.scalar, numbers).map_err(place)?;
                        }
                    }
                    None => values[i] = fields::value(numbers.next(property.scalar).map_err(place)?, property.scalar),
                }
            }
            if channels * triangles.len() > self.most_values {
                return Err(place("too many attributes for so many corners".into()));
            }
            for _ in first..triangles.len() {
                fields.grow();
                for (i, &value) in values.iter().enumerate() {
                    if let Field::Attribute(attribute, channel) = fields.fields[i] {
                        fields.set(attribute, channel, value);
                    }
                }
            }
        }
        self.mesh.triangles = triangles;
        self.keep(fields);
        Ok(())
    }

    fn others(&mut self, element: &Element, numbers: &mut impl Numbers) -> Result<(), Fault> {
        self.mesh.warnings.push(format!("the element {:.40} is ignored", element.name));
        if element.properties.is_empty() {
            return Ok(());
        }
        for i in 0..element.count {
            let place = |problem: String| Fault::new(format!("{:.40} {i}", element.name), problem, REMEDY);
            for property in &element.properties {
                let length = property.list.map_or(Ok(1.0), |length| numbers.next(length)).map_err(place)?;
                skip(length, property.scalar, numbers).map_err(place)?;
            }
        }
        Ok(())
    }

    fn keep(&mut self, fields: Fields) {
        self.mesh.attributes.extend(fields.attributes);
        self.mesh.warnings.extend(fields.warnings);
    }
}

/// So many numbers.
fn skip(length: f64, scalar: header::Scalar, numbers: &mut impl Numbers) -> Result<(), String> {
    for _ in 0..whole(length)? {
        numbers.next(scalar)?;
    }
    Ok(())
}

/// The triangles of a polygon.
fn fan(
    length: f64,
    scalar: header::Scalar,
    numbers: &mut impl Numbers,
    triangles: &mut Vec<[u32; 3]>,
) -> Result<(), String> {
    let (mut first, mut last) = (0, 0);
    for i in 0..whole(length)? {
        let corner = whole(numbers.next(scalar)?)?;
        match i {
            0 => first = corner,
            1 => {}
            _ => triangles.push([first, last, corner]),
        }
        last = corner;
    }
    Ok(())
}

fn whole(number: f64) -> Result<u32, String> {
    let whole = number as u32;
    if f64::from(whole) == number { Ok(whole) } else { Err(format!("{number} is no length or number of a vertex")) }
}
