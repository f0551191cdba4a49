#![allow(clippy::unwrap_used)]

use glam::{DVec2, DVec3};

use super::{Pixel, Sensor};
use crate::scene::description::{FilmSize, Lens, PixelFilter, Projection, SensorDescription};

/// Looks from (1, 2, 3) to (0.5, 1, −2).
fn camera(projection: Projection, window: [DVec2; 2]) -> SensorDescription {
    let forward = DVec3::new(-0.5, -1.0, -5.0).normalize();
    let up = forward.cross(DVec3::Y).normalize().cross(forward);
    SensorDescription { name: "camera".into(), position: DVec3::new(1.0, 2.0, 3.0), forward, up, projection, window }
}

const LENS: Lens = Lens { aperture_radius: 0.2, focus_distance: 3.0 };

fn perspective(lens: Option<Lens>) -> Projection {
    Projection::Perspective { vertical_fov: 50.0_f64.to_radians(), aspect: None, lens }
}

fn projections() -> [Projection; 4] {
    [
        perspective(None),
        perspective(Some(LENS)),
        Projection::Orthographic { half_width: 2.0, half_height: 1.2 },
        Projection::Window { half_width: 2.0, half_height: 1.2 },
    ]
}

fn sensor(projection: Projection, window: [DVec2; 2], film: FilmSize) -> Sensor {
    Sensor::new(&camera(projection, window), film, PixelFilter::Box, DVec3::ZERO)
}

const IMAGE: FilmSize = FilmSize { width: 40, height: 24 };
const CROP: FilmSize = FilmSize { width: 10, height: 8 };
const OFFSET: [u32; 2] = [7, 3];

/// The window of the crop in the image, moved by a share of the image.
fn window(shift: DVec2) -> [DVec2; 2] {
    let image = DVec2::new(40.0, 24.0);
    [DVec2::new(7.0, 3.0), DVec2::new(17.0, 11.0)].map(|corner| corner / image + shift)
}

#[test]
fn a_crop_sees_what_its_part_of_the_image_sees() {
    for projection in projections() {
        let whole = sensor(projection, SensorDescription::WHOLE, IMAGE);
        let crop = sensor(projection, window(DVec2::ZERO), CROP);
        let offset = DVec2::new(f64::from(OFFSET[0]), f64::from(OFFSET[1]));
        for (x, y) in (0..CROP.width).flat_map(|x| (0..CROP.height).map(move |y| (x, y))) {
            let (here, there) = (Pixel { x, y }, Pixel { x: x + OFFSET[0], y: y + OFFSET[1] });
            let raster = DVec2::new(f64::from(x) + 0.3, f64::from(y) + 0.8);
            let (xk, direction) = crop.through(raster, [0.6, 0.1]);
            let (same_xk, same_direction) = whole.through(raster + offset, [0.6, 0.1]);
            let apart = (xk.position - same_xk.position).length() + (direction - same_direction).length();
            assert!(apart < 1e-14, "{projection:?} {here:?}: {apart:e}");
            let (seen, as_seen) = (crop.importance(&xk, direction).unwrap(), whole.importance(&xk, direction).unwrap());
            assert_eq!((seen.pixel, as_seen.pixel), (here, there), "{projection:?}");
            assert!((seen.value / as_seen.value - 1.0).abs() < 1e-12, "{projection:?} {here:?}");
        }
        // What lies just beside the crop is in the image and not in the crop.
        let (xk, direction) = whole.through(offset + DVec2::new(-0.1, 0.5), [0.5; 2]);
        assert!(crop.importance(&xk, direction).is_none() && whole.importance(&xk, direction).is_some());
    }
}

/// The ray through the raster point (2.5, 5) of the crop, as `sample_ray` of Mitsuba 3.9.1 gives it in single precision.
#[test]
fn crops_and_principal_points_are_mitsubas() {
    let shift = DVec2::new(0.1, -0.2);
    let whole = SensorDescription::WHOLE;
    let through = |film, projection, window, raster: [f64; 2]| {
        sensor(projection, window, film).through(DVec2::from_array(raster), [0.3, 0.9])
    };
    let middle = [2.5, 5.0];
    for (film, window, raster, expected) in [
        (CROP, window(DVec2::ZERO), middle, [-0.46427736, -0.03916331, -0.88482356]),
        // (0.25, 0.625) of the whole film, moved.
        (IMAGE, whole.map(|corner| corner + shift), [10.0, 15.0], [-0.3215557, -0.12298779, -0.93886942]),
        (CROP, window(shift), middle, [-0.32721868, 0.12902641, -0.9360984]),
    ] {
        let (_, direction) = through(film, perspective(None), window, raster);
        assert!((direction - DVec3::from_array(expected)).length() < 1e-6, "{film:?} {window:?}: {direction}");
    }
    // The lens: the point in focus, wherever on the lens the ray starts.
    let forward = camera(perspective(None), whole).forward;
    let focus = |origin: DVec3, direction: DVec3| {
        let depth = LENS.focus_distance - (origin - DVec3::new(1.0, 2.0, 3.0)).dot(forward);
        origin + direction * (depth / direction.dot(forward))
    };
    let (xk, direction) = through(CROP, perspective(Some(LENS)), window(DVec2::ZERO), middle);
    let theirs =
        focus(DVec3::new(1.05752873, 2.14488673, 2.96424508), DVec3::new(-0.48116791, -0.08330552, -0.87266123));
    assert!((focus(xk.position, direction) - theirs).length() < 5e-6, "{theirs}");
    // Mitsuba's orthographic rays start at the near plane, 0.001 in front.
    let projection = Projection::Orthographic { half_width: 2.0, half_height: 1.2 };
    let (xk, _) = through(CROP, projection, window(DVec2::ZERO), middle);
    let theirs = DVec3::new(-0.052655, 2.39211178, 3.02581835) - forward * 1e-3;
    assert!((xk.position - theirs).length() < 1e-6, "{}", xk.position);
}
