//! Images as functions of the plane.

use std::fmt;
use std::sync::LazyLock;

use glam::DVec2;
use xxhash_rust::xxh3::xxh3_64;

use crate::spectrum::Rgb;

/// An image of up to four channels; its first row lies at v = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Bitmap {
    /// Where it is from, for messages and export.
    pub name: String,
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Its pixels, row by row.
    pub texels: Texels,
    /// What lies between the pixels.
    pub filter: Filter,
    /// What lies outside, along u and along v.
    pub wrap: [Wrap; 2],
}

/// Pixels as they are stored. Printed for debugging they are their number and a hash.
#[derive(Clone, PartialEq)]
pub enum Texels {
    /// Red, green and blue by the curve of sRGB, opacity linear, each 0 … 255.
    Srgb8(Vec<[u8; 4]>),
    /// All linear, each 0 … 255 standing for 0 … 1.
    Linear8(Vec<[u8; 4]>),
    /// All linear.
    Float(Vec<[f32; 4]>),
}

/// What lies between the centres of pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// The nearest pixel.
    Nearest,
    /// Interpolated along both axes.
    #[default]
    Bilinear,
}

/// What lies outside of the unit square.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The image again.
    #[default]
    Repeat,
    /// The image again, every other one mirrored.
    Mirror,
    /// The nearest pixel at the edge.
    Clamp,
}

impl Wrap {
    /// The pixel, 0 … n − 1, that stands at a place.
    fn index(self, i: i64, n: u32) -> usize {
        let n = i64::from(n);
        let inside = match self {
            Self::Repeat => i.rem_euclid(n),
            Self::Mirror => {
                let place = i.rem_euclid(2 * n);
                if place < n { place } else { 2 * n - 1 - place }
            }
            Self::Clamp => i.clamp(0, n - 1),
        };
        inside as usize
    }
}

/// The curve of sRGB (IEC 61966-2-1) at the 256 values.
static SRGB: LazyLock<[f64; 256]> = LazyLock::new(|| std::array::from_fn(|i| srgb_to_linear(i as f64 / 255.0)));

/// From a value of sRGB, 0 … 1, to a linear one.
#[must_use]
pub fn srgb_to_linear(x: f64) -> f64 {
    if x <= 0.04045 { x / 12.92 } else { libm::pow((x + 0.055) / 1.055, 2.4) }
}

impl fmt::Debug for Texels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (kind, bytes): (_, &[u8]) = match self {
            Self::Srgb8(texels) => ("Srgb8", texels.as_flattened()),
            Self::Linear8(texels) => ("Linear8", texels.as_flattened()),
            Self::Float(texels) => ("Float", bytemuck::cast_slice(texels)),
        };
        write!(f, "{kind}({} bytes, {:016x})", bytes.len(), xxh3_64(bytes))
    }
}

impl Texels {
    fn get(&self, index: usize) -> [f64; 4] {
        match self {
            Self::Srgb8(texels) => {
                let [r, g, b, a] = texels[index];
                [SRGB[usize::from(r)], SRGB[usize::from(g)], SRGB[usize::from(b)], f64::from(a) / 255.0]
            }
            Self::Linear8(texels) => texels[index].map(|x| f64::from(x) / 255.0),
            Self::Float(texels) => texels[index].map(f64::from),
        }
    }
}

impl Bitmap {
    /// The pixel at a column and row, wrapped.
    #[must_use]
    pub fn texel(&self, x: i64, y: i64) -> [f64; 4] {
        let (column, row) = (self.wrap[0].index(x, self.width), self.wrap[1].index(y, self.height));
        self.texels.get(row * self.width as usize + column)
    }

    /// At a point of the plane in which the image fills the unit square.
    #[must_use]
    pub fn eval(&self, uv: DVec2) -> [f64; 4] {
        let at = uv * self.size();
        if self.filter == Filter::Nearest {
            return self.texel(at.x.floor() as i64, at.y.floor() as i64);
        }
        let (corners, f) = self.corners(at);
        let weights = [(1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y];
        std::array::from_fn(|c| corners.iter().zip(weights).map(|(texel, weight)| weight * texel[c]).sum())
    }

    /// How its luminance changes with u and v; zero without interpolation.
    #[must_use]
    pub fn gradient(&self, uv: DVec2) -> DVec2 {
        if self.filter == Filter::Nearest {
            return DVec2::ZERO;
        }
        let (corners, f) = self.corners(uv * self.size());
        let [a, b, c, d] = corners.map(|[r, g, b, _]| Rgb::new(r, g, b).luminance());
        let along_u = (b - a) * (1.0 - f.y) + (d - c) * f.y;
        let along_v = (c - a) * (1.0 - f.x) + (d - b) * f.x;
        DVec2::new(along_u, along_v) * self.size()
    }

    /// The four pixels around a point in pixels, and where between their centres it is.
    fn corners(&self, at: DVec2) -> ([[f64; 4]; 4], DVec2) {
        let at = at - 0.5;
        let low = at.floor();
        let (x, y) = (low.x as i64, low.y as i64);
        let corners =
            [(x, y), (x.saturating_add(1), y), (x, y.saturating_add(1)), (x.saturating_add(1), y.saturating_add(1))];
        (corners.map(|(x, y)| self.texel(x, y)), at - low)
    }

    fn size(&self) -> DVec2 {
        DVec2::new(f64::from(self.width), f64::from(self.height))
    }

    /// The mean of its pixels.
    #[must_use]
    pub fn mean(&self) -> Rgb {
        let count = self.width as usize * self.height as usize;
        let sum: Rgb = (0..count).map(|i| self.texels.get(i)).map(|[r, g, b, _]| Rgb::new(r, g, b)).sum();
        sum / count as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two_by_two(filter: Filter, wrap: Wrap) -> Bitmap {
        let texels = [0.0, 1.0, 2.0, 4.0].map(|x| [x, 0.0, 0.0, 1.0_f32]).to_vec();
        Bitmap { name: String::new(), width: 2, height: 2, texels: Texels::Float(texels), filter, wrap: [wrap; 2] }
    }

    fn red(bitmap: &Bitmap, u: f64, v: f64) -> f64 {
        bitmap.eval(DVec2::new(u, v))[0]
    }

    #[test]
    fn rows_begin_at_v_zero_and_pixels_have_their_centres_at_halves() {
        for filter in [Filter::Nearest, Filter::Bilinear] {
            let bitmap = two_by_two(filter, Wrap::Repeat);
            let corners = [
                red(&bitmap, 0.25, 0.25),
                red(&bitmap, 0.75, 0.25),
                red(&bitmap, 0.25, 0.75),
                red(&bitmap, 0.75, 0.75),
            ];
            assert_eq!(corners, [0.0, 1.0, 2.0, 4.0]);
        }
        assert_eq!(red(&two_by_two(Filter::Bilinear, Wrap::Repeat), 0.5, 0.5), 1.75);
    }

    #[test]
    fn the_plane_beyond_is_as_the_wrap_says() {
        let far = |wrap, u| red(&two_by_two(Filter::Nearest, wrap), u, 0.25);
        assert_eq!([far(Wrap::Repeat, 1.25), far(Wrap::Repeat, -0.25), far(Wrap::Repeat, 1e300)], [0.0, 1.0, 1.0]);
        assert_eq!([far(Wrap::Mirror, 1.25), far(Wrap::Mirror, 1.75), far(Wrap::Mirror, -0.25)], [1.0, 0.0, 0.0]);
        assert_eq!([far(Wrap::Clamp, 1.25), far(Wrap::Clamp, -7.0)], [1.0, 0.0]);
    }

    #[test]
    fn the_gradient_is_the_slope_between_pixels() {
        let bitmap = two_by_two(Filter::Bilinear, Wrap::Clamp);
        let luminance = |uv: DVec2| Rgb::new(bitmap.eval(uv)[0], 0.0, 0.0).luminance();
        let uv = DVec2::new(0.4, 0.6);
        let h = 1e-6;
        let slope = |d: DVec2| (luminance(uv + d * h) - luminance(uv - d * h)) / (2.0 * h);
        let found = bitmap.gradient(uv);
        assert!((found - DVec2::new(slope(DVec2::X), slope(DVec2::Y))).length() < 1e-6, "{found}");
    }

    #[test]
    fn sixteen_values_of_srgb_are_linear_at_the_foot_and_a_power_above() {
        assert_eq!(srgb_to_linear(1.0), 1.0);
        assert_eq!(srgb_to_linear(0.0), 0.0);
        assert!((srgb_to_linear(0.5) - 0.214_041_140).abs() < 1e-9);
    }
}
