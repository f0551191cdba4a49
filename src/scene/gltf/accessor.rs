//! Accessors: typed arrays in the buffers, plain or interleaved, sparse, normalised.
//!
//! Every bound is checked before anything is allocated, so that no count in a file can ask for more memory than its
//! buffers justify.

use gltf::json;
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::Checked;

use super::buffers::Buffers;
use super::fault::Fault;

/// Longest array that a file may ask for without storing it (a sparse accessor without a buffer view is all zeros).
const MAX_IMPLICIT: u64 = 1 << 24;

/// Reads accessors of one file.
pub(super) struct Accessors<'a> {
    pub root: &'a json::Root,
    pub buffers: &'a Buffers<'a>,
}

/// Elements at equal distances in a buffer.
#[derive(Clone, Copy)]
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
}

impl<'a> Strided<'a> {
    fn get(&self, index: usize) -> &'a [u8] {
        &self.bytes[index * self.stride..][..self.size]
    }
}

/// Shape of an accessor's elements.
#[derive(Clone, Copy)]
struct Shape {
    component: ComponentType,
    normalized: bool,
    width: usize,
}

impl Accessors<'_> {
    /// The elements as vectors of `N` components; normalised integers become fractions.
    pub(super) fn vectors<const N: usize>(&self, index: usize, user: &str) -> Result<Vec<[f64; N]>, Fault> {
        let shape = self.shape(index, user)?;
        if shape.width != N {
            let problem = format!("has {} components where {N} are needed", shape.width);
            return Err(Fault::invalid(place(index, user), problem, EXPORT_AGAIN));
        }
        let size = shape.component.size();
        self.elements(index, user, size * N, [0.0; N], |bytes| {
            std::array::from_fn(|i| component(shape.component, shape.normalized, &bytes[i * size..]))
        })
    }

    /// The elements as unsigned integers, as indices are stored.
    pub(super) fn indices(&self, index: usize, user: &str) -> Result<Vec<u32>, Fault> {
        let shape = self.shape(index, user)?;
        let unsigned = matches!(shape.component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32);
        if shape.width != 1 || !unsigned {
            return Err(Fault::invalid(place(index, user), "indices must be unsigned integers", EXPORT_AGAIN));
        }
        self.elements(index, user, shape.component.size(), 0, |bytes| unsigned_integer(shape.component, bytes))
    }

    /// How many components an element has.
    pub(super) fn width(&self, index: usize, user: &str) -> Result<usize, Fault> {
        Ok(self.shape(index, user)?.width)
    }

    /// The bytes of a buffer view.
    pub(super) fn bytes(&self, view: usize, place: &str) -> Result<&[u8], Fault> {
        let length = self.root.buffer_views.get(view).map_or(0, |view| view.byte_length.0);
        let (stored, _) = self.strided(view, 0, 1, usize::try_from(length).unwrap_or(usize::MAX), place)?;
        Ok(stored.get(0))
    }

    fn get(&self, index: usize, user: &str) -> Result<&json::Accessor, Fault> {
        let missing = || Fault::invalid(place(index, user), "does not exist", EXPORT_AGAIN);
        self.root.accessors.get(index).ok_or_else(missing)
    }

    fn shape(&self, index: usize, user: &str) -> Result<Shape, Fault> {
        let accessor = self.get(index, user)?;
        let (Checked::Valid(component), Checked::Valid(kind)) = (&accessor.component_type, &accessor.type_) else {
            return Err(Fault::invalid(place(index, user), "has an unknown type", EXPORT_AGAIN));
        };
        // Matrices are never asked for, and are the only ones whose components may have gaps.
        let width = if matches!(kind, Type::Mat2 | Type::Mat3 | Type::Mat4) { 0 } else { kind.multiplicity() };
        Ok(Shape { component: component.0, normalized: accessor.normalized, width })
    }

    fn elements<T: Clone>(
        &self,
        index: usize,
        user: &str,
        size: usize,
        zero: T,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, Fault> {
        let accessor = self.get(index, user)?;
        let place = place(index, user);
        let count = accessor.count.0;
        let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
        let mut values = match &accessor.buffer_view {
            Some(view) => {
                let (stored, count) = self.strided(view.value(), offset, count, size, &place)?;
                (0..count).map(|i| decode(stored.get(i))).collect()
            }
            None if count <= MAX_IMPLICIT => vec![zero; count as usize],
            None => {
                let problem = format!("asks for {count} elements that no buffer holds");
                return Err(Fault::invalid(place, problem, EXPORT_AGAIN));
            }
        };
        if let Some(sparse) = &accessor.sparse {
            self.replace(&mut values, sparse, size, &place, decode)?;
        }
        Ok(values)
    }

    /// Puts the values of a sparse accessor in the places that it lists.
    fn replace<T>(
        &self,
        values: &mut [T],
        sparse: &json::accessor::sparse::Sparse,
        size: usize,
        place: &str,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<(), Fault> {
        let place = format!("{place}.sparse");
        let Checked::Valid(kind) = &sparse.indices.component_type else {
            return Err(Fault::invalid(place, "has an unknown type", EXPORT_AGAIN));
        };
        let (kind, count) = (kind.0, sparse.count.0);
        let view = sparse.indices.buffer_view.value();
        let (targets, _) = self.strided(view, sparse.indices.byte_offset.0, count, kind.size(), &place)?;
        let view = sparse.values.buffer_view.value();
        let (stored, count) = self.strided(view, sparse.values.byte_offset.0, count, size, &place)?;
        for i in 0..count {
            let target = unsigned_integer(kind, targets.get(i)) as usize;
            let length = values.len();
            let Some(value) = values.get_mut(target) else {
                let problem = format!("replaces element {target} of {length}");
                return Err(Fault::invalid(place, problem, EXPORT_AGAIN));
            };
            *value = decode(stored.get(i));
        }
        Ok(())
    }

    /// `count` elements of `size` bytes in a buffer view, known to lie inside it and inside the buffer.
    fn strided(
        &self,
        view: usize,
        offset: u64,
        count: u64,
        size: usize,
        place: &str,
    ) -> Result<(Strided<'_>, usize), Fault> {
        let invalid = |problem: String| Fault::invalid(place, problem, EXPORT_AGAIN);
        let Some(found) = self.root.buffer_views.get(view) else {
            return Err(invalid(format!("bufferViews[{view}] does not exist")));
        };
        let Some(Some(buffer)) = self.buffers.get(found.buffer.value()) else {
            return Err(invalid(format!("buffers[{}] has no data", found.buffer.value())));
        };
        let start = found.byte_offset.map_or(0, |start| start.0);
        let length = found.byte_length.0;
        let end = u128::from(start) + u128::from(length);
        if end > buffer.len() as u128 {
            let problem = format!("bufferViews[{view}] ends at byte {end} of a buffer of {}", buffer.len());
            return Err(invalid(problem));
        }
        let stride = found.byte_stride.map_or(size, |stride| stride.0);
        if stride < size {
            return Err(invalid(format!("elements of {size} bytes cannot be {stride} bytes apart")));
        }
        if count == 0 {
            return Err(invalid("has no elements".into()));
        }
        let end = u128::from(offset) + u128::from(count - 1) * stride as u128 + size as u128;
        if end > u128::from(length) {
            return Err(invalid(format!("{count} elements end at byte {end} of a buffer view of {length}")));
        }
        // All of these are now known to be at most the length of a buffer in memory.
        let bytes = &buffer[(start + offset) as usize..(start + length) as usize];
        Ok((Strided { bytes, stride, size }, count as usize))
    }
}

const EXPORT_AGAIN: &str = "correct the file or export it again";

fn place(index: usize, user: &str) -> String {
    format!("{user}: accessors[{index}]")
}

/// Normalised integers stand for `c / max`, signed ones for `max(c / max, −1)` (glTF 2.0, section 3.6.2.2).
fn component(kind: ComponentType, normalized: bool, bytes: &[u8]) -> f64 {
    let value = match kind {
        ComponentType::I8 => f64::from(i8::from_le_bytes([bytes[0]])),
        ComponentType::I16 => f64::from(i16::from_le_bytes([bytes[0], bytes[1]])),
        ComponentType::F32 => f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
        ComponentType::U8 | ComponentType::U16 | ComponentType::U32 => f64::from(unsigned_integer(kind, bytes)),
    };
    if !normalized {
        return value;
    }
    match kind {
        ComponentType::I8 => (value / f64::from(i8::MAX)).max(-1.0),
        ComponentType::I16 => (value / f64::from(i16::MAX)).max(-1.0),
        ComponentType::U8 => value / f64::from(u8::MAX),
        ComponentType::U16 => value / f64::from(u16::MAX),
        ComponentType::U32 => value / f64::from(u32::MAX),
        ComponentType::F32 => value,
    }
}

fn unsigned_integer(kind: ComponentType, bytes: &[u8]) -> u32 {
    match kind {
        ComponentType::I8 | ComponentType::U8 => u32::from(bytes[0]),
        ComponentType::I16 | ComponentType::U16 => u32::from(u16::from_le_bytes([bytes[0], bytes[1]])),
        ComponentType::U32 | ComponentType::F32 => u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
    }
}
