//! Spectra as linear RGB, as Mitsuba's RGB variants turn them into it.

use super::fault::{Fault, Place, Result};
use super::number;
use super::tables::{D65, OBSERVER};
use crate::spectrum::Rgb;

/// The wavelengths of the tables \[nm\].
const FIRST: f64 = 360.0;
const LAST: f64 = 830.0;

/// Most pairs in a spectrum.
const MOST_PAIRS: usize = 100_000;

/// What a colour is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Role {
    /// A share of light, 0 … 1: under D65.
    Share,
    /// Any other number of a material: under D65.
    Unbounded,
    /// Light itself.
    Emission,
}

/// A spectrum.
#[derive(Clone, Debug)]
pub(super) enum Spectrum {
    /// The same at all wavelengths.
    Uniform(f64),
    /// Wavelengths \[nm\], increasing, with their values; linear between and zero outside.
    Pairs(Vec<[f64; 2]>),
}

impl Spectrum {
    /// From one value, or `wavelength:value` pairs.
    pub(super) fn from_pairs(text: &str, place: &Place) -> Result<Self> {
        if !text.contains(':') && number::tokens(text).count() == 1 {
            return Ok(Self::Uniform(number::float(text, place)?));
        }
        let pair = |token: &str| match token.split_once(':') {
            Some((wavelength, value)) => Ok([number::float(wavelength, place)?, number::float(value, place)?]),
            None => Err(Fault::new(place, format!("{token:?} is no pair"), "write wavelength:value, in nanometres")),
        };
        Self::new(number::tokens(text).map(pair).collect::<Result<_>>()?, place)
    }

    /// From the lines of a file, a wavelength and a value each; `#` begins a comment.
    pub(super) fn from_lines(text: &str, place: &Place) -> Result<Self> {
        let lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
        let pair = |line: &str| match line.split_ascii_whitespace().collect::<Vec<_>>().as_slice() {
            [wavelength, value, ..] => Ok([number::float(wavelength, place)?, number::float(value, place)?]),
            _ => Err(Fault::new(place, format!("its file has the line {line:?}"), "write a wavelength and a value")),
        };
        Self::new(lines.map(pair).collect::<Result<_>>()?, place)
    }

    fn new(pairs: Vec<[f64; 2]>, place: &Place) -> Result<Self> {
        let problem = if pairs.len() < 2 {
            "has less than two pairs"
        } else if pairs.len() > MOST_PAIRS {
            "has more than 100000 pairs"
        } else if pairs.windows(2).any(|two| two[0][0] >= two[1][0]) {
            "has wavelengths that do not increase"
        } else {
            return Ok(Self::Pairs(pairs));
        };
        Err(Fault::new(place, problem, "correct the list"))
    }

    /// Planck's law \[W/m²/sr/nm\] every nanometre, for a temperature \[K\].
    pub(super) fn black_body(temperature: f64, scale: f64, place: &Place) -> Result<Self> {
        if temperature <= 0.0 {
            return Err(Fault::new(place, "has a temperature that is not above zero", "give it in kelvin"));
        }
        // The constants of CODATA 2014, which Mitsuba has.
        const C: f64 = 2.997_924_58e8;
        const H: f64 = 6.626_070_04e-34;
        const K: f64 = 1.380_648_52e-23;
        let radiance = |nanometres: f64| {
            let lambda = nanometres * 1e-9;
            let lambda5 = lambda * lambda * lambda * lambda * lambda;
            1e-9 * 2.0 * H * C * C / (lambda5 * libm::expm1(H * C / (lambda * K * temperature)))
        };
        let wavelengths = (0..=(LAST - FIRST) as u32).map(|i| FIRST + f64::from(i));
        Ok(Self::Pairs(wavelengths.map(|w| [w, scale * radiance(w)]).collect()))
    }

    /// As linear RGB.
    pub(super) fn rgb(&self, role: Role) -> Rgb {
        match self {
            // White in the sense of sRGB is D65; equal energy is not.
            Self::Uniform(value) if role == Role::Emission => from_xyz([1.0; 3]) * *value,
            Self::Uniform(value) => Rgb::grey(*value),
            Self::Pairs(pairs) => {
                let rgb = integrated(pairs, role != Role::Emission);
                if role == Role::Share { rgb.map(|x| x.clamp(0.0, 1.0)) } else { rgb.map(|x| x.max(0.0)) }
            }
        }
    }
}

/// The sum over a thousand wavelengths that Mitsuba takes.
fn integrated(pairs: &[[f64; 2]], daylight: bool) -> Rgb {
    const STEPS: u32 = 1000;
    /// ∫ȳ dλ \[nm\].
    const WHITE: f64 = 106.750_259_399_414_06;
    let mut xyz = [0.0; 3];
    for i in 0..STEPS {
        let wavelength = FIRST + f64::from(i) / f64::from(STEPS - 1) * (LAST - FIRST);
        let Some(value) = interpolated(pairs, wavelength) else { continue };
        let at = (wavelength - FIRST) / (LAST - FIRST) * (OBSERVER.len() - 1) as f64;
        let low = (at as usize).min(OBSERVER.len() - 2);
        let between = |a: f64, b: f64| a + (at - low as f64) * (b - a);
        let weight = if daylight { value * between(D65[low], D65[low + 1]) } else { value };
        for (sum, (a, b)) in xyz.iter_mut().zip(OBSERVER[low].into_iter().zip(OBSERVER[low + 1])) {
            *sum += weight * between(a, b);
        }
    }
    from_xyz(xyz.map(|sum| sum * (LAST - FIRST) / WHITE / f64::from(STEPS)))
}

fn interpolated(pairs: &[[f64; 2]], wavelength: f64) -> Option<f64> {
    let above = pairs.partition_point(|pair| pair[0] <= wavelength);
    if above == 0 {
        return None;
    }
    let low = (above - 1).min(pairs.len() - 2);
    let ([w0, v0], [w1, v1]) = (pairs[low], pairs[low + 1]);
    (wavelength <= w1).then(|| ((wavelength - w1) * v0 + (w0 - wavelength) * v1) / (w0 - w1))
}

/// From CIE XYZ to linear Rec. 709, with the matrix of Mitsuba.
fn from_xyz([x, y, z]: [f64; 3]) -> Rgb {
    Rgb::new(
        3.240_479 * x - 1.537_150 * y - 0.498_535 * z,
        -0.969_256 * x + 1.875_991 * y + 0.041_556 * z,
        0.055_648 * x - 0.204_043 * y + 1.057_311 * z,
    )
}
