//! Non-negative numbers of any magnitude.

use std::cmp::Ordering;
use std::ops::{Add, Div, Mul};

/// A non-negative number `mantissa · 2^exponent` whose range no product of densities leaves.
///
/// The precision is that of `f64`; the mantissa is in `[1, 2)`, or zero, infinite or NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wide {
    mantissa: f64,
    exponent: i64,
}

impl Wide {
    /// Zero.
    pub const ZERO: Self = Self { mantissa: 0.0, exponent: 0 };
    /// One.
    pub const ONE: Self = Self { mantissa: 1.0, exponent: 0 };

    /// The number `value`.
    #[must_use]
    pub fn new(value: f64) -> Self {
        Self { mantissa: value, exponent: 0 }.normalised()
    }

    /// It is zero.
    #[must_use]
    pub fn is_zero(self) -> bool {
        self.mantissa == 0.0
    }

    /// As a plain number: infinite or zero where it is out of range.
    #[must_use]
    pub fn to_f64(self) -> f64 {
        libm::scalbn(self.mantissa, self.exponent.clamp(-3000, 3000) as i32)
    }

    /// As a plain number with all its digits; `None` where it is beyond the normal range of `f64`, or no number.
    #[must_use]
    pub fn to_normal(self) -> Option<f64> {
        let value = self.to_f64();
        (self.is_zero() || value.is_normal()).then_some(value)
    }

    /// Mantissa, in `[1, 2)` where the number is above zero and finite, and exponent.
    #[must_use]
    pub fn parts(self) -> (f64, i64) {
        (self.mantissa, self.exponent)
    }

    /// Natural logarithm; −∞ for zero.
    #[must_use]
    pub fn ln(self) -> f64 {
        libm::log(self.mantissa) + self.exponent as f64 * std::f64::consts::LN_2
    }

    /// Raised to a power.
    #[must_use]
    pub fn powf(self, power: f64) -> Self {
        if self.is_zero() {
            return if power == 0.0 { Self::ONE } else { Self::ZERO };
        }
        let exponent = self.exponent as f64 * power;
        let whole = exponent.floor();
        let mantissa = libm::pow(self.mantissa, power) * libm::exp2(exponent - whole);
        if mantissa.is_finite() && mantissa > 0.0 {
            return Self { mantissa, exponent: whole as i64 }.normalised();
        }
        let log2 = power * (libm::log2(self.mantissa) + self.exponent as f64);
        Self { mantissa: libm::exp2(log2 - log2.floor()), exponent: log2.floor() as i64 }.normalised()
    }

    fn normalised(self) -> Self {
        if self.mantissa == 0.0 || !self.mantissa.is_finite() {
            return Self { exponent: 0, ..self };
        }
        let (fraction, power) = libm::frexp(self.mantissa);
        Self { mantissa: 2.0 * fraction, exponent: self.exponent + i64::from(power) - 1 }
    }
}

impl Mul for Wide {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Self { mantissa: self.mantissa * o.mantissa, exponent: self.exponent + o.exponent }.normalised()
    }
}

impl Mul<f64> for Wide {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        self * Self::new(factor)
    }
}

impl Div for Wide {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        Self { mantissa: self.mantissa / o.mantissa, exponent: self.exponent - o.exponent }.normalised()
    }
}

impl Add for Wide {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        if self.is_zero() {
            return o;
        }
        if o.is_zero() {
            return self;
        }
        let (large, small) = if self.exponent >= o.exponent { (self, o) } else { (o, self) };
        let shift = (large.exponent - small.exponent).min(2000) as i32;
        Self { mantissa: large.mantissa + libm::scalbn(small.mantissa, -shift), exponent: large.exponent }.normalised()
    }
}

impl std::iter::Sum for Wide {
    fn sum<I: Iterator<Item = Self>>(terms: I) -> Self {
        terms.fold(Self::ZERO, Add::add)
    }
}

impl PartialOrd for Wide {
    fn partial_cmp(&self, o: &Self) -> Option<Ordering> {
        if self.is_zero() || o.is_zero() || !self.mantissa.is_finite() || !o.mantissa.is_finite() {
            return self.mantissa.partial_cmp(&o.mantissa);
        }
        match self.exponent.cmp(&o.exponent) {
            Ordering::Equal => self.mantissa.partial_cmp(&o.mantissa),
            unequal => Some(unequal),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_of_a_thousand_factors_come_back() {
        let tiny = (0..1000).fold(Wide::ONE, |p, i| p * (1e-9 + f64::from(i) * 1e-12));
        let back = (0..1000).rev().fold(tiny, |p, i| p / Wide::new(1e-9 + f64::from(i) * 1e-12));
        assert!((back.to_f64() - 1.0).abs() < 1e-12);
        assert!(tiny.to_normal().is_none() && Wide::ZERO.to_normal() == Some(0.0));
        assert!(tiny.ln() < -20000.0 && tiny < Wide::new(f64::MIN_POSITIVE) && tiny > Wide::ZERO);
    }

    #[test]
    fn sums_and_powers_agree_with_plain_numbers() {
        for (a, b) in [(1.5, 3e-5), (7e120, 2e120), (0.0, 2.0), (1e-300, 1e300)] {
            assert_eq!((Wide::new(a) + Wide::new(b)).to_f64(), a + b);
            assert!((Wide::new(b).powf(0.3).to_f64() / b.powf(0.3) - 1.0).abs() < 1e-12);
        }
        assert!((Wide::new(1e200).powf(100.0).ln() / (20000.0 * std::f64::consts::LN_10) - 1.0).abs() < 1e-12);
    }
}
