//! Linear RGB values: radiance, throughput, reflectance.

use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Sub};

use serde::{Deserialize, Serialize};

/// Three linear channels with sRGB (Rec. 709) primaries, in double precision. The unit is that of the quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "[f64; 3]", into = "[f64; 3]")]
pub struct Rgb {
    /// Red.
    pub r: f64,
    /// Green.
    pub g: f64,
    /// Blue.
    pub b: f64,
}

impl Rgb {
    /// All channels zero.
    pub const BLACK: Self = Self::grey(0.0);
    /// All channels one.
    pub const WHITE: Self = Self::grey(1.0);

    /// From its channels.
    #[must_use]
    pub const fn new(r: f64, g: f64, b: f64) -> Self {
        Self { r, g, b }
    }

    /// All channels equal.
    #[must_use]
    pub const fn grey(value: f64) -> Self {
        Self::new(value, value, value)
    }

    /// The channels in order.
    #[must_use]
    pub const fn to_array(self) -> [f64; 3] {
        [self.r, self.g, self.b]
    }

    /// Applies a function to each channel.
    #[must_use]
    pub fn map(self, mut f: impl FnMut(f64) -> f64) -> Self {
        Self::new(f(self.r), f(self.g), f(self.b))
    }

    /// Relative luminance of linear Rec. 709, `0.2126 r + 0.7152 g + 0.0722 b` (ITU-R BT.709).
    #[must_use]
    pub fn luminance(self) -> f64 {
        0.2126 * self.r + 0.7152 * self.g + 0.0722 * self.b
    }

    /// The largest channel.
    #[must_use]
    pub fn max_component(self) -> f64 {
        self.r.max(self.g).max(self.b)
    }

    /// The smallest channel.
    #[must_use]
    pub fn min_component(self) -> f64 {
        self.r.min(self.g).min(self.b)
    }

    /// The mean of the channels.
    #[must_use]
    pub fn mean(self) -> f64 {
        (self.r + self.g + self.b) / 3.0
    }

    /// All channels exactly zero.
    #[must_use]
    pub fn is_black(self) -> bool {
        self == Self::BLACK
    }

    /// No channel is NaN or infinite.
    #[must_use]
    pub fn is_finite(self) -> bool {
        self.r.is_finite() && self.g.is_finite() && self.b.is_finite()
    }
}

impl From<[f64; 3]> for Rgb {
    fn from([r, g, b]: [f64; 3]) -> Self {
        Self { r, g, b }
    }
}

impl From<Rgb> for [f64; 3] {
    fn from(value: Rgb) -> Self {
        value.to_array()
    }
}

impl Add for Rgb {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self::new(self.r + o.r, self.g + o.g, self.b + o.b)
    }
}

impl Sub for Rgb {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self::new(self.r - o.r, self.g - o.g, self.b - o.b)
    }
}

impl Mul for Rgb {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Self::new(self.r * o.r, self.g * o.g, self.b * o.b)
    }
}

impl Mul<f64> for Rgb {
    type Output = Self;
    fn mul(self, k: f64) -> Self {
        Self::new(self.r * k, self.g * k, self.b * k)
    }
}

impl Mul<Rgb> for f64 {
    type Output = Rgb;
    fn mul(self, value: Rgb) -> Rgb {
        value * self
    }
}

impl Div<f64> for Rgb {
    type Output = Self;
    fn div(self, k: f64) -> Self {
        Self::new(self.r / k, self.g / k, self.b / k)
    }
}

impl AddAssign for Rgb {
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl MulAssign for Rgb {
    fn mul_assign(&mut self, o: Self) {
        *self = *self * o;
    }
}

impl MulAssign<f64> for Rgb {
    fn mul_assign(&mut self, k: f64) {
        *self = *self * k;
    }
}

impl Sum for Rgb {
    fn sum<I: Iterator<Item = Self>>(values: I) -> Self {
        values.fold(Self::BLACK, Add::add)
    }
}
