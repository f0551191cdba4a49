//! An image of the surroundings, infinitely far away.
//!
//! Radiance is interpolated between texels along longitude and colatitude, so it is a sum over texels of tent functions.
//! That makes importance sampling exact: a texel is chosen in proportion to the luminance that it contributes to the whole
//! sphere, a direction by its tent and the sine of the colatitude; the density of the direction is then its luminance by
//! the integral of the luminance, whichever texel it came by.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DMat3, DVec3};

use crate::measure::{Density, SolidAngle};
use crate::path::Vertex;
use crate::scene::texture::{Bitmap, clamped};
use crate::spectrum::Rgb;

use super::infinite::{disk_density, entry, infinite_vertex, leave_sphere};
use super::texels::{TexelChoice, tent};
use super::{DirectSample, EdgeDensity, EmissionSample, EmitterId};
use crate::path::Edge;

/// Radiance by direction, from an image.
#[derive(Clone, Debug)]
pub struct EnvironmentMap {
    /// Its own id.
    pub id: EmitterId,
    /// Radius of the sphere that stands for infinity, around the scene's centre \[m\].
    pub sphere_radius: f64,
    image: Image,
    to_world: DMat3,
    to_local: DMat3,
    choice: TexelChoice,
    /// `∫ L dσ` \[W/m²\].
    total: Rgb,
}

/// The image by its texels. Columns are cells of longitude and repeat; rows are circles of latitude, the first and the last
/// the poles.
#[derive(Clone, Debug)]
struct Image {
    bitmap: Arc<Bitmap>,
    scale: f64,
    /// As Mitsuba has it, at least two columns and three rows, the last ones repeated where the bitmap has fewer.
    size: [usize; 2],
}

impl Image {
    /// What is negative in the file is black.
    fn texel(&self, column: usize, row: usize) -> Rgb {
        let (x, y) = (column.min(self.bitmap.width as usize - 1), row.min(self.bitmap.height as usize - 1));
        let [r, g, b, _] = self.bitmap.texel(x as i64, y as i64);
        Rgb::from([r, g, b].map(|x| self.scale * clamped(x, 0.0, f64::MAX)))
    }

    /// Colatitude between neighbouring rows.
    fn step(&self) -> f64 {
        PI / (self.size[1] - 1) as f64
    }

    /// `∫ hat(θ) sin θ dθ` for a row's tent function, on the sides towards the first and the last row.
    fn row_weights(&self, row: usize) -> [f64; 2] {
        let step = self.step();
        let theta = row as f64 * step;
        let (along_sine, along_cosine) = ((1.0 - libm::cos(step)) / step, 1.0 - libm::sin(step) / step);
        let (sine, cosine) = (libm::sin(theta) * along_sine, libm::cos(theta) * along_cosine);
        [if row == 0 { 0.0 } else { sine - cosine }, if row + 1 == self.size[1] { 0.0 } else { sine + cosine }]
    }

    /// Along a unit vector in its own frame.
    fn eval(&self, direction: DVec3) -> Rgb {
        let [width, height] = self.size;
        let u = libm::atan2(direction.x, -direction.z) / TAU;
        let u = (u - u.floor()) * width as f64 - 0.5;
        let v = libm::atan2(libm::hypot(direction.x, direction.z), direction.y) / PI * (height - 1) as f64;
        let (left, top) = (u.floor(), v.floor().clamp(0.0, (height - 2) as f64));
        let (fx, fy) = (u - left, v - top);
        // The first half of column 0 neighbours the last column.
        let left = (left as i64).rem_euclid(width as i64) as usize;
        let (right, top) = ((left + 1) % width, top as usize);
        (self.texel(left, top) * (1.0 - fx) + self.texel(right, top) * fx) * (1.0 - fy)
            + (self.texel(left, top + 1) * (1.0 - fx) + self.texel(right, top + 1) * fx) * fy
    }
}

impl EnvironmentMap {
    /// From an image of finite colours, at a scale, under a rotation or reflection; `None` where all of it is black.
    #[must_use]
    pub fn new(id: EmitterId, bitmap: Arc<Bitmap>, scale: f64, to_world: DMat3, sphere_radius: f64) -> Option<Self> {
        let size = [(bitmap.width as usize).max(2), (bitmap.height as usize).max(3)];
        let image = Image { bitmap, scale, size };
        let row_factor = |row: usize| image.row_weights(row).iter().sum::<f64>();
        let choice = TexelChoice::new(size, |column, row| image.texel(column, row), row_factor)?;
        let row_total = |row: usize| (0..size[0]).map(|column| image.texel(column, row)).sum::<Rgb>() * row_factor(row);
        let total = (0..size[1]).map(row_total).sum::<Rgb>() * (TAU / size[0] as f64);
        let is_usable = total.is_finite() && total.luminance() > 0.0;
        let to_local = to_world.transpose();
        is_usable.then_some(Self { id, sphere_radius, image, to_world, to_local, choice, total })
    }

    /// Radiance of light that goes along a unit vector \[W/m²/sr\].
    #[must_use]
    pub fn radiance(&self, direction: DVec3) -> Rgb {
        self.image.eval(self.to_local * -direction)
    }

    /// The vertex where a ray that leaves the scene meets infinity.
    #[must_use]
    pub fn beyond(&self, origin: DVec3, direction: DVec3) -> Vertex {
        infinite_vertex(self.id, leave_sphere(origin, direction, self.sphere_radius), self.sphere_radius)
    }

    /// Where light comes from, in proportion to its luminance.
    fn sample(&self, u: [f64; 3]) -> DVec3 {
        let texel = self.choice.sample([u[0], u[1]]);
        let step = self.image.step();
        let [above, below] = self.image.row_weights(texel.row);
        let up = texel.rest[1] * (above + below) < above;
        let neighbour = if up { texel.row as f64 - 1.0 } else { texel.row as f64 + 1.0 } * step;
        let towards = if up { step } else { -step };
        let theta = neighbour + towards * invert_rising_side(neighbour, towards, u[2].clamp(1e-15, 1.0 - 1e-15));
        let phi = TAU * (texel.column as f64 + 0.5 + tent(texel.rest[0])) / self.image.size[0] as f64;
        let (sine, cosine) = (libm::sin(theta), libm::cos(theta));
        (self.to_world * DVec3::new(libm::sin(phi) * sine, cosine, -libm::cos(phi) * sine)).normalize()
    }

    /// Of light that goes along a unit vector: `Y(L) / ∫ Y(L) dσ` with the luminance Y.
    fn density(&self, direction: DVec3) -> Density<SolidAngle> {
        Density::new(self.radiance(direction).luminance() / self.total.luminance())
    }

    pub(super) fn sample_emission(&self, u: [f64; 5]) -> EmissionSample {
        let direction = -self.sample([u[0], u[3], u[4]]);
        EmissionSample { vertex: entry(self.id, direction, self.sphere_radius, [u[1], u[2]]), direction }
    }

    pub(super) fn emission_density(&self, x0: &Vertex, direction: DVec3) -> EdgeDensity {
        EdgeDensity {
            position: disk_density(self.sphere_radius) * x0.abs_cos(direction),
            direction: self.density(direction),
        }
    }

    pub(super) fn sample_direct(&self, x1: DVec3, u: [f64; 3]) -> DirectSample {
        let direction = self.sample(u);
        let vertex = self.beyond(x1, direction);
        let edge = Edge::from_to(x1, vertex.position);
        DirectSample { vertex, density: self.direct_density(&edge) * edge.solid_angle_to_area(&vertex) }
    }

    /// `edge` leads to infinity.
    pub(super) fn direct_density(&self, edge: &Edge) -> Density<SolidAngle> {
        self.density(-edge.direction)
    }

    /// `π R² ∫ L dσ`: what enters the sphere.
    pub(super) fn flux(&self) -> Rgb {
        self.total * (PI * self.sphere_radius * self.sphere_radius)
    }
}

/// `∫₀ᵗ τ cos(step·τ) dτ` and `∫₀ᵗ τ sin(step·τ) dτ`, by their series: closed forms cancel where steps are small.
fn moments(step: f64, t: f64) -> [f64; 2] {
    let x = step * t;
    let mut sums = [0.0; 2];
    let mut term: f64 = 1.0;
    for n in 0..32_u32 {
        let sign = if n % 4 < 2 { 1.0 } else { -1.0 };
        sums[(n % 2) as usize] += sign * term / f64::from(n + 2);
        term *= x / f64::from(n + 1);
        if term.abs() < 1e-18 {
            break;
        }
    }
    sums.map(|sum| t * t * sum)
}

/// The t in `[0, 1]` below which lies the share `u` of `∫ τ sin(from + step·τ) dτ`: a rising side of a tent on the sphere.
fn invert_rising_side(from: f64, step: f64, u: f64) -> f64 {
    let (sine, cosine) = (libm::sin(from), libm::cos(from));
    let below = |t: f64| {
        let [along_sine, along_cosine] = moments(step, t);
        sine * along_sine + cosine * along_cosine
    };
    let all = below(1.0);
    let (mut low, mut high) = (0.0, 1.0);
    let mut t = u.sqrt();
    // Newton's method, kept within what is known to hold the root.
    for _ in 0..64 {
        let excess = below(t) - u * all;
        if excess > 0.0 {
            high = t;
        } else {
            low = t;
        }
        let next = t - excess / (t * libm::sin(from + step * t));
        let next = if next > low && next < high { next } else { 0.5 * (low + high) };
        if (next - t).abs() <= f64::EPSILON * t {
            return next;
        }
        t = next;
    }
    t
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::Random;
    use crate::scene::texture::{Filter, Texels, Wrap};
    use crate::warp;

    fn bitmap(width: u32, height: u32, texels: impl Fn(u32, u32) -> [f32; 3]) -> Arc<Bitmap> {
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let texels = pixels.map(|(x, y)| texels(x, y)).map(|[r, g, b]| [r, g, b, 1.0]);
        let texels = Texels::Float(texels.collect());
        let (filter, wrap) = (Filter::Bilinear, [Wrap::Repeat, Wrap::Clamp]);
        Arc::new(Bitmap { name: String::new(), width, height, texels, filter, wrap })
    }

    fn map(bitmap: Arc<Bitmap>, to_world: DMat3) -> EnvironmentMap {
        EnvironmentMap::new(EmitterId(0), bitmap, 1.0, to_world, 1.0).expect("not black")
    }

    /// Values of Mitsuba 3.9.1 (`scalar_rgb`) for an image of 4 × 3 with red 0 … 11, row by row, along `direction`.
    #[test]
    fn radiance_is_that_of_mitsuba() {
        let map = map(bitmap(4, 3, |x, y| [(4 * y + x) as f32, 0.0, 0.0]), DMat3::IDENTITY);
        for (direction, expected) in include!("environment_map.txt") {
            let found = map.radiance(-DVec3::from_array(direction).normalize()).r;
            assert!((found - expected).abs() < 1e-5, "{direction:?}: {found}, not {expected}");
        }
    }

    /// `∫ L dσ` by 10⁶ directions, even in both numbers, against the sum over texels.
    #[test]
    fn the_integral_over_all_directions_is_exact() {
        for (width, height) in [(1, 1), (2, 3), (5, 4), (16, 9), (64, 33)] {
            let map = map(bitmap(width, height, |x, y| [(x * 7 % 5 + y) as f32 + 0.5, 1.0, 0.3]), DMat3::IDENTITY);
            let n = 1000;
            let even = |i: u32| (f64::from(i) + 0.5) / f64::from(n);
            let all = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
            let sum: f64 = all.map(|(i, j)| map.radiance(warp::uniform_sphere([even(i), even(j)])).r).sum();
            let integral = sum * 4.0 * PI / f64::from(n * n);
            assert!((integral / map.total.r - 1.0).abs() < 2e-5, "{width} × {height}: {integral}, {}", map.total.r);
        }
    }

    /// χ² over 12 × 24 cells of directions of equal solid angle; each expectation is the density at 64² points of the cell.
    /// With 10⁶ draws a cell off by 10 % shows; the bound is the 99.99 % point for 287 degrees of freedom.
    #[test]
    fn directions_are_drawn_by_their_luminance_up_to_the_poles_and_across_the_seam() {
        let turned = DMat3::from_rotation_x(0.6) * DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0));
        let spotted =
            |x: u32, y: u32| if (x + y).is_multiple_of(3) { [(x + 2 * y) as f32, 0.5, 0.0] } else { [0.0; 3] };
        let at_the_pole = |_: u32, y: u32| if y == 0 { [1.0; 3] } else { [0.0; 3] };
        let maps = [
            map(bitmap(7, 5, spotted), turned),
            map(bitmap(6, 8, at_the_pole), DMat3::IDENTITY),
            map(bitmap(2, 3, |x, _| [x as f32; 3]), DMat3::IDENTITY),
        ];
        for (number, map) in (0..).zip(&maps) {
            let (rows, columns, n) = (12_usize, 24_usize, 1_000_000_u32);
            let mut counts = vec![0.0_f64; rows * columns];
            let mut random = Random::new(5, 0, number);
            for _ in 0..n {
                let local = map.to_local * map.sample(random.uniform3());
                let height = ((1.0 - local.y) * 0.5 * rows as f64) as usize;
                let turn = (libm::atan2(local.x, -local.z) / TAU).rem_euclid(1.0);
                let column = ((turn * columns as f64) as usize).min(columns - 1);
                counts[height.min(rows - 1) * columns + column] += 1.0;
            }
            let mut chi2 = 0.0;
            for (cell, count) in counts.iter().enumerate() {
                let (row, column) = ((cell / columns) as f64, (cell % columns) as f64);
                let fine = 64;
                let points = (0..fine * fine).map(|i| {
                    let within = |i: i32| (f64::from(i) + 0.5) / f64::from(fine);
                    let y = 1.0 - 2.0 * (row + within(i / fine)) / rows as f64;
                    let phi = TAU * (column + within(i % fine)) / columns as f64;
                    let rim = (1.0 - y * y).sqrt();
                    let local = DVec3::new(libm::sin(phi) * rim, y, -libm::cos(phi) * rim);
                    map.density(-(map.to_world * local)).value()
                });
                let mean = points.sum::<f64>() / f64::from(fine * fine);
                let expected = mean * 4.0 * PI / (rows * columns) as f64 * f64::from(n);
                if expected < 5.0 {
                    assert!(*count < 30.0, "map {number}: {count} draws in cell {cell}, expected {expected}");
                    continue;
                }
                chi2 += (count - expected) * (count - expected) / expected;
            }
            assert!(chi2 < 384.0, "map {number}: χ² = {chi2}");
        }
    }

    #[test]
    fn draws_have_a_density_above_zero() {
        let map = map(bitmap(9, 6, |x, y| if (x, y) == (3, 0) { [0.0, 2.0, 0.0] } else { [0.0; 3] }), DMat3::IDENTITY);
        let mut random = Random::new(6, 0, 0);
        let edges = [0.0, 1.0 - f64::EPSILON / 2.0].map(|x| [x; 3]);
        for u in (0..10_000).map(|_| random.uniform3()).chain(edges) {
            assert!(map.density(-map.sample(u)).value() > 0.0, "{u:?}");
        }
    }
}
