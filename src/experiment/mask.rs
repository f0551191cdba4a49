//! Where light walks cannot see: a surface that scatters by Dirac lobes alone cannot be connected to the sensor.

use rayon::prelude::*;

use crate::estimator::driver::random_of;
use crate::film::BlockGrid;
use crate::scene::Scene;
use crate::scene::sensor::Pixel;

/// Methods that connect light walks to the sensor and do nothing else.
pub const LIGHT_METHODS: [&str; 2] = ["light", "mitsuba:ptracer"];

/// Sensor walks that look at each pixel.
const LOOKS: u64 = 64;

/// For each pixel, row by row: it, or one of its eight neighbours, sees a Dirac-only surface first. A surface that covers a
/// share s of a pixel and of its neighbours' is overlooked with a probability below `(1 − s)^64`.
#[must_use]
pub fn sees_dirac(scene: &Scene) -> Vec<bool> {
    let film = scene.sensor().film();
    let (width, height) = (film.width as usize, film.height as usize);
    let seen: Vec<bool> = (0..width * height)
        .into_par_iter()
        .map(|index| {
            let pixel = Pixel { x: (index % width) as u32, y: (index / width) as u32 };
            (0..LOOKS).any(|look| {
                let (from, direction) = scene.sensor().sample(scene, pixel, &mut random_of(scene, 0, pixel, look));
                scene.trace(&from, direction).is_some_and(|vertex| vertex.scatters() && !scene.has_finite(&vertex))
            })
        })
        .collect();
    (0..width * height)
        .map(|index| {
            let (x, y) = (index % width, index / width);
            let columns = x.saturating_sub(1)..(x + 2).min(width);
            (y.saturating_sub(1)..(y + 2).min(height)).any(|y| seen[y * width..][columns.clone()].contains(&true))
        })
        .collect()
}

/// The blocks without such a pixel, or `None` if those are all.
#[must_use]
pub fn blocks_without_dirac(scene: &Scene) -> Option<Vec<bool>> {
    let film = scene.sensor().film();
    let grid = BlockGrid::new(film.width, film.height, None).ok()?;
    let mut keep = vec![true; grid.len()];
    for (index, seen) in (0..).zip(sees_dirac(scene)) {
        if seen {
            keep[grid.block_of(index % film.width, index / film.width)] = false;
        }
    }
    keep.contains(&false).then_some(keep)
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;
    use crate::scene::description::{BsdfDescription, FilmSize, Sphere};
    use crate::spectrum::Rgb;
    use crate::testing::scenes::{build, enclosure, material};

    #[test]
    fn a_glass_ball_is_masked_with_a_border_and_nothing_else() {
        let film = FilmSize { width: 64, height: 48 };
        let mut description = enclosure(Rgb::WHITE, Rgb::grey(0.5), film);
        assert_eq!(blocks_without_dirac(&build(&description)), None);
        let glass = BsdfDescription::dielectric(1.5, 1.0);
        description.materials.push(material("glass", glass, Rgb::BLACK));
        let centre = DVec3::new(-0.05, 0.0, 0.0);
        description.spheres.push(Sphere::new("ball", centre, 0.1, 1));
        let scene = build(&description);
        let mask = sees_dirac(&scene);
        let hit = |index: usize| {
            let raster = DVec2::new((index % 64) as f64 + 0.5, (index / 64) as f64 + 0.5);
            let (from, direction) = scene.sensor().through(raster, [0.5; 2]);
            scene.trace(&from, direction).is_some_and(|vertex| !scene.has_finite(&vertex))
        };
        let hits = (0..64 * 48).filter(|&index| hit(index)).count();
        let masked = mask.iter().filter(|&&masked| masked).count();
        assert!((0..64 * 48).all(|index| mask[index] || !hit(index)));
        assert!(hits > 20 && masked > hits && masked < 3 * hits, "{hits} {masked}");
        let keep = blocks_without_dirac(&scene).expect("a block is masked");
        assert!(keep.contains(&true) && keep.contains(&false));
    }
}
