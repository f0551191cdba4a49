use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::*;
use crate::sampler::Random;

const FILM: FilmSize = FilmSize { width: 5, height: 3 };

const MITSUBA_TENT: [f64; 6] = [1.0, 0.76, 0.52, 0.2, 0.0, 0.0];
const MITSUBA_GAUSSIAN: [f64; 6] = [0.999_255_96, 0.754_736_48, 0.324_251_38, 0.043_612_42, 0.004_749_32, 0.0];

fn descriptions() -> [PixelFilter; 6] {
    [
        PixelFilter::Tent { radius: 1.0 },
        PixelFilter::Tent { radius: 0.4 },
        PixelFilter::Tent { radius: 9.0 },
        PixelFilter::Gaussian { stddev: 0.5 },
        PixelFilter::Gaussian { stddev: 0.1 },
        PixelFilter::Gaussian { stddev: 2.0 },
    ]
}

fn filters() -> impl Iterator<Item = (PixelFilter, Filter)> {
    descriptions().into_iter().map(|description| (description, Filter::new(description, FILM).expect("no box")))
}

/// The profiles once more, as their definitions say.
fn profile(description: PixelFilter, x: f64) -> f64 {
    match description {
        PixelFilter::Box => f64::from(u8::from(x.abs() < 0.5)),
        PixelFilter::Tent { radius } => (1.0 - x.abs() / radius).max(0.0),
        PixelFilter::Gaussian { stddev } => {
            let of = |x: f64| libm::exp(-x * x / (2.0 * stddev * stddev));
            (of(x) - of(4.0 * stddev)).max(0.0)
        }
    }
}

/// `∫_a^b` of the profile around a centre, by the midpoint rule.
fn mass(description: PixelFilter, centre: f64, a: f64, b: f64) -> f64 {
    const POINTS: u32 = 20_000;
    let step = (b - a) / f64::from(POINTS);
    (0..POINTS).map(|i| profile(description, a + (f64::from(i) + 0.5) * step - centre) * step).sum()
}

fn pixels() -> impl Iterator<Item = Pixel> {
    (0..FILM.height).flat_map(|y| (0..FILM.width).map(move |x| Pixel { x, y }))
}

#[test]
fn quantiles_invert_the_integral() {
    for (description, filter) in filters() {
        let profile = &filter.columns.profile;
        let whole = profile.integral(profile.radius());
        for i in -1000..=1000 {
            let integral = whole * f64::from(i) / 1000.0;
            let x = profile.quantile(integral);
            assert!(x.abs() <= profile.radius() * (1.0 + 1e-15), "{description:?}: {x}");
            let error = (profile.integral(x) - integral).abs() / whole;
            assert!(error < 1e-14, "{description:?} at {integral}: off by {error:e}");
        }
    }
}

/// Quadrature knows nothing of the closed forms that sampling inverts.
#[test]
fn every_pixel_has_a_filter_of_integral_one_on_the_film() {
    for (description, filter) in filters() {
        for (axis, end) in [(&filter.columns, 5.0), (&filter.rows, 3.0)] {
            for (pixel, cut) in (0..).zip(&axis.cuts) {
                let expected = mass(description, centre(pixel), 0.0, end);
                assert!((cut.mass / expected - 1.0).abs() < 2e-6, "{description:?} {pixel}: {} {expected}", cut.mass);
            }
        }
    }
}

/// Draws of each pixel in 20 × 12 cells of the film against the filter's share there: χ² below its point of 1e-6 for 90 tests. A
/// density off by 6 % everywhere is found with probability above 0.9.
#[test]
fn points_are_drawn_by_the_filter() {
    const DRAWS: u32 = 40_000;
    let mut random = Random::new(5, 0, 0);
    let (columns, rows) = (20, 12);
    let mut tests = 0;
    for (description, filter) in filters() {
        for pixel in pixels() {
            let mut counts = vec![0_u32; columns * rows];
            for _ in 0..DRAWS {
                let (raster, _) = filter.sample(pixel, random.uniform2(), random.uniform());
                counts[(raster.y * 4.0) as usize * columns + (raster.x * 4.0) as usize] += 1;
            }
            let along = |pixel: u32, cells: usize| -> Vec<f64> {
                let cell = |i: usize| mass(description, centre(pixel), i as f64 / 4.0, (i + 1) as f64 / 4.0);
                let masses: Vec<f64> = (0..cells).map(cell).collect();
                let total: f64 = masses.iter().sum();
                masses.into_iter().map(|mass| mass / total).collect()
            };
            let (across, down) = (along(pixel.x, columns), along(pixel.y, rows));
            let (mut statistic, mut degrees, mut rest) = (0.0, -1.0, (0.0, 0.0));
            for (i, &count) in counts.iter().enumerate() {
                let expected = f64::from(DRAWS) * across[i % columns] * down[i / columns];
                if expected >= 10.0 {
                    statistic += (f64::from(count) - expected).powi(2) / expected;
                    degrees += 1.0;
                } else {
                    rest = (rest.0 + f64::from(count), rest.1 + expected);
                }
            }
            assert!((rest.0 - rest.1).abs() <= 6.0 * rest.1.sqrt(), "{description:?} {pixel:?}: {rest:?}");
            if degrees > 0.0 {
                let p = ChiSquared::new(degrees).expect("positive").sf(statistic);
                assert!(p > 1e-6, "{description:?} {pixel:?}: χ² {statistic} of {degrees}");
            }
            tests += 1;
        }
    }
    assert_eq!(tests, 90);
}

/// At points all over the film: each pixel's share of ζ is h_j/H, the shares fill `[0, 1)`, and a walk's own ζ leads back to
/// its pixel.
#[test]
fn pixels_share_a_point_by_their_filters() {
    let mut random = Random::new(6, 0, 0);
    for (description, filter) in filters() {
        for _ in 0..300 {
            let [x, y] = random.uniform2();
            let raster = DVec2::new(5.0 * x, 3.0 * y);
            let value = |pixel: Pixel| filter.columns.value(raster.x, pixel.x) * filter.rows.value(raster.y, pixel.y);
            let total: f64 = pixels().map(value).sum();
            assert!((filter.total(raster) - total).abs() <= 1e-13 * total, "{description:?} {raster}");
            if total == 0.0 {
                assert_eq!(filter.owner(raster, random.uniform()), None);
                continue;
            }
            let mut covered = 0.0;
            for pixel in pixels().filter(|&pixel| value(pixel) > 1e-7 * total) {
                let at =
                    |among: f64| filter.rows.share(raster.y, pixel.y, filter.columns.share(raster.x, pixel.x, among));
                let (first, last) = (at(0.0), at(1.0));
                assert!(((last - first) * total - value(pixel)).abs() <= 1e-12 * total, "{description:?} {pixel:?}");
                covered += last - first;
                for among in [1e-3, 0.5, 0.999] {
                    assert_eq!(filter.owner(raster, at(among)), Some(pixel), "{description:?} {raster}");
                }
            }
            assert!((covered - 1.0).abs() < 1e-5, "{description:?} {raster}: {covered}");
        }
    }
}

#[test]
fn nothing_is_outside_of_the_film() {
    for (_, filter) in filters() {
        for raster in [DVec2::new(-1e-9, 1.0), DVec2::new(5.0, 1.0), DVec2::new(2.0, -0.1), DVec2::new(2.0, 3.0)] {
            assert_eq!((filter.total(raster), filter.owner(raster, 0.3)), (0.0, None), "{raster}");
        }
    }
    for (_, filter) in filters() {
        for (pixel, u) in pixels().flat_map(|p| [0.0, 1.0_f64.next_down()].map(|u| (p, u))) {
            let (raster, zeta) = filter.sample(pixel, [u, u], u);
            assert!(raster.cmpge(DVec2::ZERO).all() && raster.x < 5.0 && raster.y < 3.0 && (0.0..1.0).contains(&zeta));
        }
    }
}

/// Values of `eval` of Mitsuba 3.9.1's filters, whose Gaussian is a polynomial within 8e-4 of the exponential.
#[test]
fn profiles_are_mitsubas() {
    let tent = PixelFilter::Tent { radius: 1.25 };
    let gaussian = PixelFilter::Gaussian { stddev: 0.4 };
    for (description, tolerance, values) in [(tent, 1e-6, MITSUBA_TENT), (gaussian, 8e-4, MITSUBA_GAUSSIAN)] {
        let filter = Filter::new(description, FILM).expect("no box");
        for (x, expected) in [0.0, 0.3, 0.6, 1.0, 1.3, 1.7].into_iter().zip(values) {
            assert!((filter.columns.profile.value(x) - expected).abs() <= tolerance, "{description:?} at {x}");
        }
    }
}
