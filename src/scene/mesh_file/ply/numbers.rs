//! The numbers after the header, one by one.

use half::f16;

use super::header::{Encoding, Property, Scalar};

/// Where numbers come from.
pub(super) trait Numbers {
    /// The next one.
    fn next(&mut self, scalar: Scalar) -> Result<f64, String>;

    /// Nothing is left but white space, where that does not count.
    fn at_end(&mut self) -> bool;

    /// At most so many rows of such properties are left.
    fn room(&self, properties: &[Property]) -> u64;
}

const ENDED: &str = "the file ends here";

/// Of files in text.
pub(super) struct Text<'a> {
    pub rest: &'a [u8],
}

/// Of binary files.
pub(super) struct Binary<'a> {
    pub rest: &'a [u8],
    pub encoding: Encoding,
}

impl Text<'_> {
    fn skip_space(&mut self) {
        let space = self.rest.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(self.rest.len());
        self.rest = &self.rest[space..];
    }
}

impl Numbers for Text<'_> {
    #[inline]
    fn next(&mut self, scalar: Scalar) -> Result<f64, String> {
        self.skip_space();
        let end = self.rest.iter().position(u8::is_ascii_whitespace).unwrap_or(self.rest.len());
        let (token, rest) = self.rest.split_at(end);
        self.rest = rest;
        if token.is_empty() {
            return Err(ENDED.into());
        }
        let text = std::str::from_utf8(token).unwrap_or("?");
        let number = match (scalar, scalar.range()) {
            (_, Some([least, most])) => {
                text.parse().ok().filter(|n| (least..=most).contains(n)).map(|n: i128| n as f64)
            }
            (Scalar::F64, _) => text.parse().ok(),
            (Scalar::F16, _) => text.parse().ok().map(|x| f64::from(f16::from_f32(x))),
            _ => text.parse::<f32>().ok().map(f64::from),
        };
        number.ok_or_else(|| format!("{text:.40?} is no number of type {scalar:?}"))
    }

    fn at_end(&mut self) -> bool {
        self.skip_space();
        self.rest.is_empty()
    }

    /// A digit and a space each; the last needs no space.
    fn room(&self, properties: &[Property]) -> u64 {
        (self.rest.len() as u64 + 1) / (2 * properties.len() as u64).max(1)
    }
}

impl Numbers for Binary<'_> {
    #[inline]
    fn next(&mut self, scalar: Scalar) -> Result<f64, String> {
        let width = scalar.width();
        let Some((number, rest)) = self.rest.split_at_checked(width) else { return Err(ENDED.into()) };
        self.rest = rest;
        let mut bytes = [0; 8];
        bytes[..width].copy_from_slice(number);
        if self.encoding == Encoding::BigEndian {
            bytes[..width].reverse();
        }
        Ok(scalar.decode(bytes))
    }

    fn at_end(&mut self) -> bool {
        self.rest.is_empty()
    }

    fn room(&self, properties: &[Property]) -> u64 {
        let row: usize = properties.iter().map(|p| p.list.unwrap_or(p.scalar).width()).sum();
        self.rest.len() as u64 / (row as u64).max(1)
    }
}
