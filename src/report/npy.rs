//! Arrays in NumPy's format, as the script that drives another renderer writes them.
//!
//! The format: the bytes `\x93NUMPY`, version, length of the header, a header that is a Python dictionary with the keys
//! `descr`, `fortran_order` and `shape`, and the numbers (NumPy documentation, *numpy.lib.format*). Read are versions 1
//! and 2 with little-endian floats of 4 or 8 bytes in C order; everything else is refused.

use std::fs;
use std::path::Path;

use super::error::ReportError;

/// An array of numbers in C order: the last index runs fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Length of each dimension.
    pub shape: Vec<usize>,
    /// All numbers, as many as the product of the lengths.
    pub data: Vec<f64>,
}

/// Reads a `.npy` file.
///
/// # Errors
/// When it cannot be read, is damaged, or is of a kind that is not read.
pub fn read_npy(path: &Path) -> Result<Array, ReportError> {
    let bytes = fs::read(path).map_err(|source| ReportError::Read { path: path.to_owned(), source })?;
    parse(&bytes).map_err(|what| ReportError::Array { path: path.to_owned(), what })
}

fn parse(bytes: &[u8]) -> Result<Array, String> {
    let short = || "it ends within its header".to_owned();
    let rest = bytes.strip_prefix(b"\x93NUMPY").ok_or("it does not begin like a .npy file")?;
    let (header_length, rest) = match rest {
        [1, _, a, b, rest @ ..] => (usize::from(u16::from_le_bytes([*a, *b])), rest),
        [2, _, a, b, c, d, rest @ ..] => (u32::from_le_bytes([*a, *b, *c, *d]) as usize, rest),
        [1 | 2, ..] | [] => return Err(short()),
        [version, ..] => return Err(format!("format version {version} is not read, only 1 and 2")),
    };
    let (header, data) = rest.split_at_checked(header_length).ok_or_else(short)?;
    let header = std::str::from_utf8(header).map_err(|_| "its header is no text")?;
    if value_of(header, "fortran_order")?.split(',').next().map(str::trim) != Some("False") {
        return Err("it is in Fortran order; save it in C order".to_owned());
    }
    let shape = shape_of(value_of(header, "shape")?)?;
    let size = match value_of(header, "descr")?.trim_start().get(..5) {
        Some("'<f4'" | "\"<f4\"") => 4,
        Some("'<f8'" | "\"<f8\"") => 8,
        _ => return Err("its numbers are not little-endian float32 or float64".to_owned()),
    };
    let count = shape.iter().try_fold(1_usize, |product, &length| product.checked_mul(length));
    let expected = count.and_then(|count| count.checked_mul(size)).ok_or("its shape is too large")?;
    if data.len() != expected {
        return Err(format!("its shape {shape:?} needs {expected} bytes of numbers, and it holds {}", data.len()));
    }
    let data = if size == 4 {
        data.as_chunks::<4>().0.iter().map(|&number| f64::from(f32::from_le_bytes(number))).collect()
    } else {
        data.as_chunks::<8>().0.iter().map(|&number| f64::from_le_bytes(number)).collect()
    };
    Ok(Array { shape, data })
}

/// What follows `'key':` in the header.
fn value_of<'text>(header: &'text str, key: &str) -> Result<&'text str, String> {
    [format!("'{key}':"), format!("\"{key}\":")]
        .iter()
        .find_map(|quoted| header.split_once(quoted.as_str()))
        .map(|(_, value)| value.trim_start())
        .ok_or_else(|| format!("its header has no '{key}'"))
}

fn shape_of(value: &str) -> Result<Vec<usize>, String> {
    let bad = || "its header has no valid shape".to_owned();
    let (list, _) = value.strip_prefix('(').and_then(|rest| rest.split_once(')')).ok_or_else(bad)?;
    let lengths = list.split(',').map(str::trim).filter(|length| !length.is_empty());
    lengths.map(|length| length.parse().map_err(|_| bad())).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn file(version: u8, header: &str, data: &[u8]) -> Vec<u8> {
        let mut bytes = b"\x93NUMPY".to_vec();
        bytes.extend([version, 0]);
        match version {
            1 => bytes.extend((header.len() as u16).to_le_bytes()),
            _ => bytes.extend((header.len() as u32).to_le_bytes()),
        }
        bytes.extend(header.as_bytes());
        bytes.extend(data);
        bytes
    }

    const DOUBLES: &str = "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 1), }          \n";

    fn doubles() -> Vec<u8> {
        [1.5_f64, -0.1].iter().flat_map(|x| x.to_le_bytes()).collect()
    }

    #[test]
    fn both_versions_and_both_precisions_are_read() {
        let expected = Array { shape: vec![2, 1], data: vec![1.5, -0.1] };
        assert_eq!(parse(&file(1, DOUBLES, &doubles())), Ok(expected.clone()));
        assert_eq!(parse(&file(2, DOUBLES, &doubles())), Ok(expected));
        let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (3,), }\n";
        let data: Vec<u8> = [1.5_f32, 2.0, 3.0].iter().flat_map(|x| x.to_le_bytes()).collect();
        assert_eq!(parse(&file(1, header, &data)), Ok(Array { shape: vec![3], data: vec![1.5, 2.0, 3.0] }));
    }

    #[test]
    fn what_is_not_read_is_refused() {
        for (from, to) in [
            ("<f8", ">f8"),
            ("<f8", "<i8"),
            ("False", "True"),
            ("(2, 1)", "(2, 2)"),
            ("(2, 1)", "(-2, 1)"),
            ("(2, 1)", "(4294967296, 4294967296, 4294967296)"),
            ("(2, 1)", "2, 1"),
            ("shape", "form"),
        ] {
            assert!(parse(&file(1, &DOUBLES.replace(from, to), &doubles())).is_err(), "{from} → {to}");
        }
        assert!(parse(&file(3, DOUBLES, &doubles())).is_err());
        let whole = file(1, DOUBLES, &doubles());
        assert!((0..whole.len()).all(|length| parse(&whole[..length]).is_err()));
        assert!(parse(&[whole, vec![0]].concat()).is_err());
    }

    proptest! {
        #[test]
        fn garbage_never_panics(tail in prop::collection::vec(any::<u8>(), 0..200), cut in 0_usize..80) {
            let mut bytes = file(1, DOUBLES, &doubles());
            bytes.truncate(cut);
            bytes.extend(tail);
            let _ = parse(&bytes);
        }
    }
}
