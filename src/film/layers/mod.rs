//! Images of each path length and of each technique, beside the film's own.

mod store;
mod tally;
mod tile;

use std::fmt::{self, Display, Formatter};
use std::str::FromStr;

use crate::path::Technique;
use crate::spectrum::Rgb;

pub use store::{LayerPass, Layers};
pub use tally::{LayerListing, LayerPart, Tally, TechniqueRow};

/// Which layers to keep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LayerSelection {
    /// One for each path length.
    pub length: bool,
    /// Two for each technique.
    pub technique: bool,
}

/// One of the layers. Its name in files is that of [`Display`], which [`FromStr`] reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Layer {
    /// L_k, the paths with k + 1 edges.
    Length {
        /// k + 1.
        edges: u32,
    },
    /// What a technique adds to the image.
    Weighted(Technique),
    /// The image of a technique alone.
    Unweighted(Technique),
}

impl Display for Layer {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length { edges } => write!(f, "L_{}", edges.saturating_sub(1)),
            Self::Weighted(Technique { s, t }) => write!(f, "s{s}_t{t}.weighted"),
            Self::Unweighted(Technique { s, t }) => write!(f, "s{s}_t{t}.unweighted"),
        }
    }
}

impl FromStr for Layer {
    type Err = ();

    fn from_str(name: &str) -> Result<Self, ()> {
        let parse = || {
            if let Some(k) = name.strip_prefix("L_") {
                return Some(Self::Length { edges: k.parse::<u32>().ok()?.checked_add(1)? });
            }
            let (technique, kind) = name.strip_prefix('s')?.split_once('.')?;
            let (s, t) = technique.split_once("_t")?;
            let technique = Technique { s: s.parse().ok()?, t: t.parse().ok()? };
            let vertices = technique.s.checked_add(technique.t)?;
            match kind {
                _ if vertices < 2 => None,
                "weighted" => Some(Self::Weighted(technique)),
                "unweighted" => Some(Self::Unweighted(technique)),
                _ => None,
            }
        };
        parse().ok_or(())
    }
}

/// A term of the estimator, as layers take it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contribution {
    /// Index of its pixel, row by row from the top left.
    pub pixel: u32,
    /// Who has drawn its path.
    pub technique: Technique,
    /// `w f / (n p)`, in the unit of the image.
    pub value: Rgb,
    /// `w`.
    pub weight: f64,
}

impl Contribution {
    /// `f / (n p)`; `None` where the weight is zero or the quotient beyond the range of numbers.
    #[must_use]
    pub fn unweighted(&self) -> Option<Rgb> {
        let value = self.value / self.weight;
        (self.weight > 0.0 && value.is_finite()).then_some(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_read_what_they_write_and_nothing_else() {
        let technique = Technique { s: 12, t: 0 };
        for layer in [Layer::Length { edges: 11 }, Layer::Weighted(technique), Layer::Unweighted(technique)] {
            assert_eq!(layer.to_string().parse(), Ok(layer));
        }
        assert_eq!(Layer::Length { edges: 1 }.to_string(), "L_0");
        for name in ["", "L_", "L_x", "L_4294967295", "s1_t1", "s1_t0.weighted", "s1_t2.heavy", "standard_error"] {
            assert_eq!(name.parse::<Layer>(), Err(()), "{name}");
        }
        assert_eq!("s4294967295_t4294967295.weighted".parse::<Layer>(), Err(()));
    }

    #[test]
    fn what_has_no_weight_has_no_unweighted_value() {
        let of = |value: f64, weight: f64| {
            let technique = Technique { s: 1, t: 1 };
            Contribution { pixel: 0, technique, value: Rgb::grey(value), weight }.unweighted()
        };
        assert_eq!(of(1.0, 0.25), Some(Rgb::grey(4.0)));
        assert_eq!(of(0.0, 0.0), None);
        assert_eq!(of(1.0, 1e-310), None);
    }
}
