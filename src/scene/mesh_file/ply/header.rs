//! The header of a PLY file: which elements there are, and what each is made of.

use half::f16;

use crate::scene::mesh_file::error::Fault;

const REMEDY: &str = "correct the header or export the mesh again";

/// How the numbers after the header are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F16,
    F32,
    F64,
}

#[derive(Clone, Debug)]
pub(super) struct Property {
    pub name: String,
    /// The type of the length, of a list.
    pub list: Option<Scalar>,
    pub scalar: Scalar,
}

#[derive(Clone, Debug)]
pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

#[derive(Clone, Debug)]
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
}

impl Scalar {
    /// By the names of the format, and those that Mitsuba knows besides.
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "long" => Self::I64,
            "ulong" => Self::U64,
            "half" | "float16" => Self::F16,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Its size in binary files \[bytes\].
    pub fn width(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 | Self::F16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The smallest and the largest of the whole numbers; `None` of the others.
    pub fn range(self) -> Option<[i128; 2]> {
        Some(match self {
            Self::I8 => [i8::MIN.into(), i8::MAX.into()],
            Self::U8 => [0, u8::MAX.into()],
            Self::I16 => [i16::MIN.into(), i16::MAX.into()],
            Self::U16 => [0, u16::MAX.into()],
            Self::I32 => [i32::MIN.into(), i32::MAX.into()],
            Self::U32 => [0, u32::MAX.into()],
            Self::I64 => [i64::MIN.into(), i64::MAX.into()],
            Self::U64 => [0, u64::MAX.into()],
            Self::F16 | Self::F32 | Self::F64 => return None,
        })
    }

    /// From [`width`](Self::width) bytes, the least significant first.
    #[inline]
    pub fn decode(self, b: [u8; 8]) -> f64 {
        match self {
            Self::I8 => f64::from(b[0] as i8),
            Self::U8 => f64::from(b[0]),
            Self::I16 => f64::from(i16::from_le_bytes([b[0], b[1]])),
            Self::U16 => f64::from(u16::from_le_bytes([b[0], b[1]])),
            Self::I32 => f64::from(i32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            Self::U32 => f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            Self::I64 => i64::from_le_bytes(b) as f64,
            Self::U64 => u64::from_le_bytes(b) as f64,
            Self::F16 => f64::from(f16::from_le_bytes([b[0], b[1]])),
            Self::F32 => f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            Self::F64 => f64::from_le_bytes(b),
        }
    }
}

/// The header and what follows it.
pub(super) fn parse(bytes: &[u8]) -> Result<(Header, &[u8]), Fault> {
    let mut rest = bytes;
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut number = 0;
    loop {
        number += 1;
        let fault = |problem: String| Fault::new(format!("line {number}"), problem, REMEDY);
        let Some(end) = rest.iter().position(|&b| b == b'\n') else {
            return Err(fault("the header does not end with a line end_header".into()));
        };
        let line = String::from_utf8_lossy(&rest[..end]);
        rest = &rest[end + 1..];
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        if number == 1 && words != ["ply"] {
            return Err(Fault::new("line 1", "is not the word ply", "check that it is a PLY file"));
        }
        match words[..] {
            [] | ["comment" | "obj_info", ..] => {}
            ["ply"] if number == 1 => {}
            ["format", name, "1.0"] if encoding.is_none() => {
                encoding = Some(match name {
                    "ascii" => Encoding::Text,
                    "binary_little_endian" => Encoding::LittleEndian,
                    "binary_big_endian" => Encoding::BigEndian,
                    _ => return Err(fault(format!("{name:.40} is no format of numbers"))),
                });
            }
            ["element", name, count] => {
                let count = count.parse().map_err(|_| fault(format!("{count:.40} is no number of elements")))?;
                elements.push(Element { name: name.into(), count, properties: Vec::new() });
            }
            ["property", ref description @ ..] => {
                let element = elements.last_mut().ok_or_else(|| fault("is a property of no element".into()))?;
                element.properties.push(property(description).map_err(fault)?);
            }
            ["end_header"] => {
                let encoding = encoding.ok_or_else(|| fault("no format was named before".into()))?;
                return Ok((Header { encoding, elements }, rest));
            }
            _ => return Err(fault(format!("{:.60} is no line of a header", line.trim()))),
        }
    }
}

fn property(description: &[&str]) -> Result<Property, String> {
    let scalar = |name: &str| Scalar::named(name).ok_or_else(|| format!("{name:.40} is no type of numbers"));
    match *description {
        ["list", length, item, name] => {
            let length = scalar(length)?;
            if length.range().is_none() {
                return Err("the length of a list must be a whole number".into());
            }
            Ok(Property { name: name.into(), list: Some(length), scalar: scalar(item)? })
        }
        [item, name] => Ok(Property { name: name.into(), list: None, scalar: scalar(item)? }),
        _ => Err("a property is a type and a name, or list, two types and a name".into()),
    }
}
