//! A light that shines an image from one point.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use crate::measure::Density;
use crate::scene::texture::{Bitmap, Filter, Wrap, clamped};
use crate::spectrum::Rgb;

use super::texels::{TexelChoice, tent};
use super::{DirectSample, EdgeDensity, EmissionSample, EmitterId, point_vertex};

/// Shines an image as a pinhole camera would take it: Dirac in x_0, directions in proportion to the image's luminance on the
/// plane at distance one. The image is a sum of tents around its texels, which makes that exact.
#[derive(Clone, Debug)]
pub struct Projector {
    id: EmitterId,
    position: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// Half the size of the image on the plane at distance one.
    half_size: DVec2,
    bitmap: Arc<Bitmap>,
    scale: Rgb,
    choice: TexelChoice,
    /// The mean of `scale · image`.
    mean: Rgb,
}

/// What is negative in the file is black.
fn colour([r, g, b, _]: [f64; 4]) -> Rgb {
    Rgb::from([r, g, b].map(|x| clamped(x, 0.0, f64::MAX)))
}

impl Projector {
    /// At `position`, along `forward` with the top of the image towards `up`, unit vectors at right angles; with a full
    /// horizontal field of view \[rad\]. `None` where the image is black or not finite.
    #[must_use]
    pub fn new(
        id: EmitterId,
        position: DVec3,
        [forward, up]: [DVec3; 2],
        horizontal_fov: f64,
        bitmap: Arc<Bitmap>,
        scale: Rgb,
    ) -> Option<Self> {
        let size = [bitmap.width as usize, bitmap.height as usize];
        let texel = |column: usize, row: usize| colour(bitmap.texel(column as i64, row as i64)) * scale;
        let choice = TexelChoice::new(size, texel, |_| 1.0)?;
        let texels = (0..size[1]).flat_map(|row| (0..size[0]).map(move |column| (column, row)));
        let mean = texels.map(|(column, row)| texel(column, row)).sum::<Rgb>() / (size[0] * size[1]) as f64;
        let half_width = libm::tan(0.5 * horizontal_fov);
        let half_size = DVec2::new(half_width, half_width * size[1] as f64 / size[0] as f64);
        let right = forward.cross(up);
        let is_usable = mean.is_finite() && mean.luminance() > 0.0;
        is_usable.then_some(Self { id, position, right, up, forward, half_size, bitmap, scale, choice, mean })
    }

    /// `scale · image` where a unit direction meets the image's plane, and the cosine against the axis.
    fn image(&self, direction: DVec3) -> (Rgb, f64) {
        let cos = direction.dot(self.forward);
        let uv = DVec2::new(direction.dot(self.right), -direction.dot(self.up)) / (cos * self.half_size);
        let uv = uv * 0.5 + 0.5;
        let inside = cos > 0.0 && uv.cmpge(DVec2::ZERO).all() && uv.cmple(DVec2::ONE).all();
        (if inside { colour(self.bitmap.eval(uv)) * self.scale } else { Rgb::BLACK }, cos)
    }

    /// Intensity along a unit direction, `π · scale · image / cos³ θ` \[W/sr\].
    #[must_use]
    pub fn intensity(&self, direction: DVec3) -> Rgb {
        let (image, cos) = self.image(direction);
        if image.is_black() { image } else { image * (PI / (cos * cos * cos)) }
    }

    pub(super) fn sample_emission(&self, u: [f64; 5]) -> EmissionSample {
        let texel = self.choice.sample([u[3], u[4]]);
        let along = |place: usize, rest: f64, count: u32, wrap: Wrap| {
            let count = f64::from(count);
            let at = match self.bitmap.filter {
                Filter::Nearest => place as f64 + rest,
                Filter::Bilinear => place as f64 + 0.5 + tent(rest),
            };
            let folded = match wrap {
                Wrap::Repeat => at.rem_euclid(count),
                // Half a texel beyond the edge is the edge's own colour.
                Wrap::Mirror | Wrap::Clamp => {
                    if at < 0.0 {
                        -at
                    } else if at > count {
                        2.0 * count - at
                    } else {
                        at
                    }
                }
            };
            (folded / count).clamp(1e-9, 1.0 - 1e-9)
        };
        let [along_u, along_v] = self.bitmap.wrap;
        let u = along(texel.column, texel.rest[0], self.bitmap.width, along_u);
        let v = along(texel.row, texel.rest[1], self.bitmap.height, along_v);
        let at = (DVec2::new(u, v) * 2.0 - 1.0) * self.half_size;
        let direction = (self.forward + self.right * at.x - self.up * at.y).normalize();
        EmissionSample { vertex: point_vertex(self.id, self.position), direction }
    }

    /// `p_σ = Y(image) / (mean Y · A cos³ θ)` for the luminance Y and the image's area A on the plane.
    pub(super) fn emission_density(&self, direction: DVec3) -> EdgeDensity {
        let (image, cos) = self.image(direction);
        let area = 4.0 * self.half_size.x * self.half_size.y;
        let on_plane = image.luminance() / (self.mean.luminance() * area);
        let direction = if on_plane > 0.0 { Density::new(on_plane / (cos * cos * cos)) } else { Density::ZERO };
        EdgeDensity { position: Density::new(1.0), direction }
    }

    pub(super) fn sample_direct(&self) -> DirectSample {
        DirectSample { vertex: point_vertex(self.id, self.position), density: Density::new(1.0) }
    }

    /// `π A mean(scale · image)`.
    pub(super) fn flux(&self) -> Rgb {
        self.mean * (PI * 4.0 * self.half_size.x * self.half_size.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::Random;
    use crate::scene::texture::Texels;

    fn projector(wrap: Wrap, filter: Filter) -> Projector {
        let texels = Texels::Float((0..6).map(|i| [1.0 + i as f32, 0.5, 0.0, 1.0]).collect());
        let bitmap = Bitmap { name: String::new(), width: 3, height: 2, texels, filter, wrap: [wrap; 2] };
        let axes = [DVec3::new(2.0, -1.0, 2.0) / 3.0, DVec3::new(1.0, 4.0, 1.0).normalize()];
        let (fov, scale) = (50.0_f64.to_radians(), Rgb::grey(0.5));
        Projector::new(EmitterId(0), DVec3::ZERO, axes, fov, bitmap.into(), scale).expect("not black")
    }

    /// Where the image's plane is met, right and up from the axis, and the weight of Mitsuba 3.9.1's `sample_direction` times the
    /// squared distance, for an image that repeats and for one that is clamped.
    const INTENSITIES: [([f64; 2], [f64; 2]); 8] = [
        ([0.0, 0.0], [5.497788, 5.497788]),
        ([0.3, 0.1], [6.342742, 6.342742]),
        ([-0.3, 0.1], [2.84507, 2.84507]),
        ([0.2, -0.2], [9.191111, 9.949307]),
        ([0.45, 0.3], [8.078558, 6.924476]),
        ([-0.45, -0.3], [8.078561, 9.232638]),
        ([-0.1, 0.29], [5.351437, 3.01704]),
        ([0.5, 0.0], [0.0, 0.0]),
    ];

    #[test]
    fn intensity_is_that_of_mitsuba() {
        for ([x, y], expected) in INTENSITIES {
            for (wrap, expected) in [Wrap::Repeat, Wrap::Clamp].into_iter().zip(expected) {
                let projector = projector(wrap, Filter::Bilinear);
                let direction = (projector.forward + projector.right * x + projector.up * y).normalize();
                let found = projector.intensity(direction).r;
                assert!((found - expected).abs() < 1e-5, "{x}, {y}, {wrap:?}: {found}, not {expected}");
            }
        }
    }

    /// Drawn in proportion to the luminance: `I / p_σ` has the luminance of the whole flux, for every direction drawn. And by
    /// 10⁶ even directions, the flux is the integral of the intensity.
    #[test]
    fn directions_are_drawn_by_their_luminance() {
        let mut random = Random::new(4, 0, 0);
        for (wrap, filter) in [
            (Wrap::Repeat, Filter::Bilinear),
            (Wrap::Clamp, Filter::Bilinear),
            (Wrap::Mirror, Filter::Bilinear),
            (Wrap::Repeat, Filter::Nearest),
        ] {
            let projector = projector(wrap, filter);
            let flux = projector.flux().luminance();
            for _ in 0..10_000 {
                let direction = projector.sample_emission(random.uniform5()).direction;
                let density = projector.emission_density(direction).direction.value();
                let ratio = projector.intensity(direction).luminance() / density;
                assert!((ratio / flux - 1.0).abs() < 1e-9, "{wrap:?}, {filter:?}: {ratio}, not {flux}");
            }
            let n = 2000;
            let even = |i: u32| (f64::from(i) + 0.5) / f64::from(n);
            let directions = (0..n).flat_map(|i| (0..n).map(move |j| crate::warp::uniform_sphere([even(i), even(j)])));
            let sum: f64 = directions.map(|direction| projector.intensity(direction).luminance()).sum();
            let integral = sum * 4.0 * PI / f64::from(n * n);
            assert!((integral / flux - 1.0).abs() < 2e-3, "{wrap:?}, {filter:?}: {integral}, not {flux}");
        }
    }
}
