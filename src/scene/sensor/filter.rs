//! Pixel filters wider than a pixel: who sees a point of the film that several pixels share.
//!
//! Pixel j responds to the point r of the film by its filter `h_j(r) = h(r − c_j) / ∫h(r − c_j) dr`, cut at the film's edge
//! and normalised over what is left, with c_j its centre. Several pixels respond to one point, yet a path is to have one
//! pixel that sees it, and walks from the sensor are drawn for one pixel. So the sensor's vertex gets one more coordinate,
//! ζ in `[0, 1)`, which says *which of the pixels that overlap here*:
//!
//! - `H(r) = Σ_j h_j(r)`, and at r pixel j owns an interval of ζ of the length `h_j(r) / H(r)`. The intervals fill `[0, 1)`.
//! - On the path space extended by ζ, with the measure `dμ dζ`, the importance is `W(r, ζ) = H(r) |∂r|`, whatever the pixel
//!   that owns (r, ζ), with |∂r| the Jacobian from points of the film to the measure of the last edge. Integrated over the
//!   part that pixel j owns, it gives `∫ H (h_j / H) … = ∫ h_j …`, which is I_j.
//! - A walk for pixel j draws r by h_j, then ζ uniformly in j's interval. Its density on the extended space is
//!   `h_j(r) / (h_j(r) / H(r)) = H(r)`: the same for all pixels, and `W / p` is one, as for a box.
//! - Walks from the emitters draw ζ uniformly, with density one.
//!
//! Hence densities of paths and weights are functions of the path alone, and all else stays as it is for a box, for which H
//! is one everywhere and ζ decides nothing.
//!
//! Filters are products of two profiles, so `H(r) = H_x H_y`, and ζ first chooses the row, then what is left of it chooses
//! the column.

use std::f64::consts::{FRAC_1_SQRT_2, PI};
use std::ops::Range;
use std::sync::Arc;

use glam::DVec2;

use crate::scene::description::{FilmSize, PixelFilter};

use super::Pixel;

/// A filter on the pixels of a film.
#[derive(Clone, Debug)]
pub(super) struct Filter {
    columns: Axis,
    rows: Axis,
}

/// One of its two factors.
#[derive(Clone, Debug)]
struct Axis {
    profile: Profile,
    /// Of the pixels along the axis.
    cuts: Vec<Cut>,
}

/// What the film's edges leave of a pixel's profile.
#[derive(Clone, Copy, Debug)]
struct Cut {
    /// `∫g` from the centre to the lower end, not positive.
    lower: f64,
    /// `∫g` from end to end.
    mass: f64,
}

/// g, which is even and zero beyond its radius, in pixels.
#[derive(Clone, Debug)]
enum Profile {
    /// `g(x) = 1 − |x|/r`.
    Tent { radius: f64 },
    /// `g(x) = exp(−x²/2σ²) − exp(−8)`, which ends at 4σ.
    Gaussian { stddev: f64, quantiles: Arc<[f64]> },
}

impl Filter {
    /// `None` for a box, which no pixels share.
    pub fn new(description: PixelFilter, film: FilmSize) -> Option<Self> {
        let profile = match description {
            PixelFilter::Box => return None,
            PixelFilter::Tent { radius } => Profile::Tent { radius },
            PixelFilter::Gaussian { stddev } => Profile::Gaussian { stddev, quantiles: quantiles() },
        };
        Some(Self { columns: Axis::new(profile.clone(), film.width), rows: Axis::new(profile, film.height) })
    }

    /// Draws a point of the film for a pixel by h_j, and ζ in its interval there.
    #[inline(never)]
    pub fn sample(&self, pixel: Pixel, u: [f64; 2], among: f64) -> (DVec2, f64) {
        let raster = DVec2::new(self.columns.sample(pixel.x, u[0]), self.rows.sample(pixel.y, u[1]));
        let zeta = self.rows.share(raster.y, pixel.y, self.columns.share(raster.x, pixel.x, among));
        (raster, zeta)
    }

    /// `H(r)` \[1/pixel²\], zero outside of the film.
    #[inline(never)]
    pub fn total(&self, raster: DVec2) -> f64 {
        self.columns.total(raster.x) * self.rows.total(raster.y)
    }

    /// The pixel that owns ζ at r.
    #[inline(never)]
    pub fn owner(&self, raster: DVec2, zeta: f64) -> Option<Pixel> {
        let (y, rest) = self.rows.owner(raster.y, zeta)?;
        let (x, _) = self.columns.owner(raster.x, rest)?;
        Some(Pixel { x, y })
    }
}

impl Axis {
    fn new(profile: Profile, pixels: u32) -> Self {
        let cut = |pixel: u32| {
            let (centre, radius) = (centre(pixel), profile.radius());
            let lower = profile.integral((-centre).max(-radius));
            Cut { lower, mass: profile.integral((f64::from(pixels) - centre).min(radius)) - lower }
        };
        Self { cuts: (0..pixels).map(cut).collect(), profile }
    }

    fn end(&self) -> f64 {
        self.cuts.len() as f64
    }

    fn sample(&self, pixel: u32, u: f64) -> f64 {
        let Cut { lower, mass } = self.cuts[pixel as usize];
        let x = centre(pixel) + self.profile.quantile(lower + u * mass);
        // Rounding must not leave the film.
        x.clamp(0.0, self.end().next_down())
    }

    /// The pixels whose profiles reach r.
    fn reaching(&self, r: f64) -> Range<u32> {
        let radius = self.profile.radius();
        let first = (r - radius - 0.5).ceil().max(0.0) as u32;
        let end = (r + radius + 0.5).floor().min(self.end());
        first..end as u32
    }

    /// `h_j(r)` along this axis.
    fn value(&self, r: f64, pixel: u32) -> f64 {
        self.profile.value(r - centre(pixel)) / self.cuts[pixel as usize].mass
    }

    fn total(&self, r: f64) -> f64 {
        if !(0.0..self.end()).contains(&r) {
            return 0.0;
        }
        self.reaching(r).map(|pixel| self.value(r, pixel)).sum()
    }

    /// The number in `[0, 1)` that lies at `among` of the way through the pixel's interval at r.
    fn share(&self, r: f64, pixel: u32, among: f64) -> f64 {
        let (mut before, mut own, mut total) = (0.0, 0.0, 0.0);
        for j in self.reaching(r) {
            let value = self.value(r, j);
            if j == pixel {
                (before, own) = (total, value);
            }
            total += value;
        }
        ((before + among * own) / total).min(1.0_f64.next_down())
    }

    /// The pixel whose interval at r holds ζ, and how far through it ζ lies.
    fn owner(&self, r: f64, zeta: f64) -> Option<(u32, f64)> {
        let total = self.total(r);
        let mut rest = zeta * total;
        let mut last = None;
        for pixel in self.reaching(r) {
            let value = self.value(r, pixel);
            if value > 0.0 {
                if rest < value && total > 0.0 {
                    return Some((pixel, rest / value));
                }
                last = Some((pixel, 1.0_f64.next_down()));
            }
            rest -= value;
        }
        // Rounding may leave a rest after the last one.
        last.filter(|_| total > 0.0)
    }
}

fn centre(pixel: u32) -> f64 {
    f64::from(pixel) + 0.5
}

impl Profile {
    fn radius(&self) -> f64 {
        match self {
            Self::Tent { radius } => *radius,
            Self::Gaussian { stddev, .. } => GAUSSIAN_END * stddev,
        }
    }

    fn value(&self, x: f64) -> f64 {
        match self {
            Self::Tent { radius } => (1.0 - x.abs() / radius).max(0.0),
            Self::Gaussian { stddev, .. } => gaussian(x / stddev).max(0.0),
        }
    }

    /// `∫_0^x g`, for x up to the radius.
    fn integral(&self, x: f64) -> f64 {
        match self {
            Self::Tent { radius } => x - 0.5 * x * x.abs() / radius,
            Self::Gaussian { stddev, .. } => stddev * gaussian_integral(x / stddev),
        }
    }

    /// The inverse of [`integral`](Self::integral).
    fn quantile(&self, integral: f64) -> f64 {
        let magnitude = integral.abs();
        let x = match self {
            // Of the two roots of x²/2r − x + v = 0 the smaller one, by the form that does not cancel.
            Self::Tent { radius } => 2.0 * magnitude / (1.0 + (1.0 - 2.0 * magnitude / radius).max(0.0).sqrt()),
            Self::Gaussian { stddev, quantiles } => stddev * gaussian_quantile(quantiles, magnitude / stddev),
        };
        x.copysign(integral)
    }
}

/// Where the profile of a Gaussian ends, in standard deviations.
const GAUSSIAN_END: f64 = 4.0;
/// `exp(−4²/2)`.
const GAUSSIAN_FLOOR: f64 = 3.354_626_279_025_118_5e-4;
/// Cells of the table that starts the search for a quantile.
const CELLS: usize = 256;

/// `exp(−t²/2) − exp(−8)`.
fn gaussian(t: f64) -> f64 {
    libm::exp(-0.5 * t * t) - GAUSSIAN_FLOOR
}

/// Its integral from 0 to t: `√(π/2) erf(t/√2) − t exp(−8)`.
fn gaussian_integral(t: f64) -> f64 {
    (0.5 * PI).sqrt() * libm::erf(t * FRAC_1_SQRT_2) - t * GAUSSIAN_FLOOR
}

/// t for evenly spaced values of the integral from 0 on.
fn quantiles() -> Arc<[f64]> {
    let whole = gaussian_integral(GAUSSIAN_END);
    let at = |i: usize| solve(whole * (i as f64 / CELLS as f64), 0.0, GAUSSIAN_END, 0.5 * GAUSSIAN_END);
    (0..=CELLS).map(|i| if i == CELLS { GAUSSIAN_END } else { at(i) }).collect()
}

fn gaussian_quantile(quantiles: &[f64], integral: f64) -> f64 {
    let place = integral / gaussian_integral(GAUSSIAN_END) * CELLS as f64;
    let cell = (place as usize).min(CELLS - 1);
    let (low, high) = (quantiles[cell], quantiles[cell + 1]);
    solve(integral, low, high, low + (high - low) * (place - cell as f64).min(1.0))
}

/// t with the given integral, between two bounds: Newton's method, and bisection where it leaves them.
fn solve(integral: f64, mut low: f64, mut high: f64, start: f64) -> f64 {
    /// Bisection alone needs fewer.
    const STEPS: usize = 64;
    let mut t = start;
    for _ in 0..STEPS {
        let excess = gaussian_integral(t) - integral;
        if excess > 0.0 {
            high = t;
        } else {
            low = t;
        }
        let newton = t - excess / gaussian(t);
        let next = if newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
        if (next - t).abs() <= 4.0 * f64::EPSILON * GAUSSIAN_END {
            return next;
        }
        t = next;
    }
    t
}

#[cfg(test)]
#[path = "filter_tests.rs"]
mod tests;
