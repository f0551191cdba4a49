//! Sampling, evaluation, density, the two sides of a path and the limit of small roughness agree with each other.

use rand::RngExt;

use super::*;

fn all() -> Vec<Bsdf> {
    let mut all = vec![diffuse(), mirror(gold()), mirror(white())];
    all.extend([1e-8, 1e-4, 0.1, 1.0].map(|alpha| metal(alpha, gold())));
    for ior in [1.5, 0.7, 1.0 + 1e-9, 100.0] {
        all.push(glass(ior));
        all.extend([1e-4, 0.1, 1.0].map(|alpha| rough_glass(alpha, ior)));
    }
    for kind in [MicrofacetKind::Ggx, MicrofacetKind::Beckmann] {
        all.extend([tinted_metal(kind, [1e-8, 1e-8]), tinted_metal(kind, [1e-4, 1.0])]);
        all.extend([tinted_glass(kind, [1e-4, 1e-4], 1.5), tinted_glass(kind, [0.01, 2.0], 1.0 + 1e-9)]);
    }
    all.extend(others());
    all
}

/// Two out of three directions are random; the others are at a grazing angle.
fn any_direction(rng: &mut impl RngExt) -> DVec3 {
    let cos = 2.0 * rng.random::<f64>() - 1.0;
    let phi = rng.random_range(0.0..6.0);
    direction(if rng.random_bool(0.33) { cos * 1e-6 } else { cos }, phi)
}

#[test]
fn a_sample_is_what_evaluation_says_of_its_directions() {
    let mut rng = random_numbers(21);
    for bsdf in all().into_iter().chain(composites::all()).chain(gltf::all()) {
        let mut drawn = 0;
        for i in 0..4_000 {
            let (side, from) = (SIDES[i % 2], any_direction(&mut rng));
            let Some(sample) = bsdf.sample(side, from, rng.random()) else { continue };
            let (to_emitter, to_sensor) = side.by_role(from, sample.to);
            let (density, value) = match sample.density {
                LobeDensity::Finite(density) => {
                    assert!(bsdf.has_finite() && density == bsdf.density(from, sample.to), "{bsdf:?} {from}");
                    (density.value(), bsdf.eval(to_emitter, to_sensor))
                }
                LobeDensity::Dirac(density) => {
                    assert!(density == bsdf.density_dirac(side, from, sample.to), "{bsdf:?} {from}");
                    (density.value(), bsdf.eval_dirac(to_emitter, to_sensor))
                }
            };
            assert!(density.is_finite() && density > 0.0, "{bsdf:?} {from} → {}: {density}", sample.to);
            assert_eq!(value, sample.value, "{bsdf:?} {from} → {}", sample.to);
            assert!((sample.to.length() - 1.0).abs() < 1e-14, "{bsdf:?} {from} → {}", sample.to);
            drawn += 1;
        }
        assert!(drawn > 900, "{bsdf:?} drew {drawn}");
    }
}

/// Either walk can draw every pair of directions that scatters: what a walk from one end alone must not miss.
#[test]
fn walks_from_both_ends_draw_what_scatters() {
    let mut rng = random_numbers(25);
    for bsdf in all().into_iter().chain(composites::all()).filter(Bsdf::has_finite) {
        let mut seen = 0;
        for i in 0..10_000 {
            let a = any_direction(&mut rng);
            let drawn = bsdf.sample(SIDES[i % 2], a, rng.random());
            let b = if i % 2 == 0 { any_direction(&mut rng) } else { drawn.map_or(DVec3::Z, |s| s.to) };
            for (to_emitter, to_sensor) in [(a, b), (b, a)] {
                // Below, densities underflow.
                if bsdf.eval(to_emitter, to_sensor).max_component() > 1e-200 {
                    let densities = [bsdf.density(to_sensor, to_emitter), bsdf.density(to_emitter, to_sensor)];
                    let drawn = densities.map(|density| density.value() > 0.0);
                    assert_eq!(drawn, [true; 2], "{bsdf:?} {to_emitter} → {to_sensor}");
                    seen += 1;
                }
            }
        }
        assert!(seen > 300, "{bsdf:?}: {seen}");
    }
}

/// Helmholtz: `f_s(a→b) / η_b² = f_s(b→a) / η_a²` (Veach 1997, §5.2). The coefficients of Dirac lobes differ by the square of
/// that factor, because each stands before a distribution on its own emitter's side.
#[test]
fn scattering_is_reciprocal_up_to_the_square_of_the_index() {
    let mut rng = random_numbers(22);
    for bsdf in all().into_iter().chain(composites::reciprocal()).chain(gltf::reciprocal()) {
        let mut seen = 0;
        for i in 0..3_000 {
            let a = any_direction(&mut rng);
            let drawn = bsdf.sample(SIDES[i % 2], a, rng.random());
            let b = if i % 3 == 0 { any_direction(&mut rng) } else { drawn.map_or(DVec3::Z, |s| s.to) };
            let scale = bsdf.radiance_scale(a, b);
            assert!((scale * bsdf.radiance_scale(b, a) - 1.0).abs() < 1e-14);
            let finite = (bsdf.eval(a, b).r, bsdf.eval(b, a).r * scale);
            let dirac = (bsdf.eval_dirac(a, b).r, bsdf.eval_dirac(b, a).r * scale * scale);
            for (forth, back) in [finite, dirac] {
                assert!((forth - back).abs() <= 1e-13 * forth, "{bsdf:?} {a} {b}: {forth}, {back}");
                seen += usize::from(forth > 0.0);
            }
        }
        assert!(seen > 300, "{bsdf:?}: {seen}");
    }
}

/// A walk from the sensor carries radiance, one from the emitter energy: `f/p` is `(η_o/η_i)²` and 1. The densities of
/// the two walks along one refraction differ by the ratio of their projected solid angles.
#[test]
fn dirac_coefficients_carry_the_square_of_the_index() {
    let bsdf = glass(1.5);
    for cos in [0.9, 0.1, -0.9, -0.8] {
        let from = direction(cos, 1.0);
        let to = refracted(from, 1.5).unwrap();
        let relative = if cos > 0.0 { 1.5 } else { 1.0 / 1.5 };
        let (to_emitter, to_sensor) = (to, from);
        let sensor = bsdf.density_dirac(Side::Sensor, to_sensor, to_emitter).value();
        let emitter = bsdf.density_dirac(Side::Emitter, to_emitter, to_sensor).value();
        let value = bsdf.eval_dirac(to_emitter, to_sensor).r;
        // η_o is that of the sensor's side, where the walk comes from.
        let scale = 1.0 / (relative * relative);
        assert!((value / sensor / scale - 1.0).abs() < 1e-15);
        assert!((value / emitter - 1.0).abs() < 1e-15);
        assert!((emitter / sensor / scale - 1.0).abs() < 1e-15);
        let reflected = bsdf.density_dirac(Side::Sensor, from, mirrored(from)).value();
        assert!((sensor + reflected - 1.0).abs() < 1e-14);
        assert_eq!(bsdf.density_dirac(Side::Emitter, from, mirrored(from)).value(), reflected);
    }
}

/// At the peak of the lobe, ratios of rough densities and values tend to the ratios of the Dirac coefficients, `p_σ`
/// converted to projected solid angle: what MIS weights across a specular chain depend on.
#[test]
fn ratios_of_rough_lobes_tend_to_those_of_dirac_lobes() {
    let smooth = glass(1.5);
    let rough = rough_glass(1e-5, 1.5);
    for cos in [0.9, 0.2, -0.95] {
        let to_sensor = direction(cos, 2.0);
        for to_emitter in [mirrored(to_sensor), refracted(to_sensor, 1.5).unwrap()] {
            let from_sensor = rough.density(to_sensor, to_emitter).value() / to_emitter.z.abs();
            let from_emitter = rough.density(to_emitter, to_sensor).value() / to_sensor.z.abs();
            let value = rough.eval(to_emitter, to_sensor).r;
            let dirac_sensor = smooth.density_dirac(Side::Sensor, to_sensor, to_emitter).value();
            let dirac_emitter = smooth.density_dirac(Side::Emitter, to_emitter, to_sensor).value();
            let dirac_value = smooth.eval_dirac(to_emitter, to_sensor).r;
            let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-7, "cos {cos}: {a}, not {b}");
            close(value / from_sensor, dirac_value / dirac_sensor);
            close(value / from_emitter, dirac_value / dirac_emitter);
            close(from_sensor / from_emitter, dirac_sensor / dirac_emitter);
        }
    }
}

#[test]
fn beyond_the_critical_angle_everything_is_reflected() {
    let critical = (1.0_f64 - 1.0 / 2.25).sqrt();
    let mut rng = random_numbers(23);
    for cos in [critical * (1.0 - 1e-9), 0.5, 0.1, 1e-6] {
        let from = direction(-cos, 0.7);
        assert_eq!(glass(1.5).density_dirac(Side::Sensor, from, mirrored(from)).value(), 1.0);
        for side in SIDES {
            let sample = glass(1.5).sample(side, from, rng.random()).unwrap();
            assert!(sample.to == mirrored(from) && throughput(&sample) == Rgb::WHITE);
        }
    }
    let just_below = direction(-critical * (1.0 + 1e-6), 0.7);
    assert!(glass(1.5).density_dirac(Side::Sensor, just_below, mirrored(just_below)).value() < 0.999);
}

#[test]
fn drawn_refractions_obey_snells_law() {
    let mut rng = random_numbers(24);
    for ior in [1.5, 0.6, 1.0 + 1e-9, 1.0] {
        let bsdf = glass(ior);
        for _ in 0..1_000 {
            let from = any_direction(&mut rng);
            let sample = bsdf.sample(Side::Sensor, from, [0.0, 0.0, 1.0 - f64::EPSILON]).unwrap();
            // Total or, by rounding, certain reflection leaves nothing to compare.
            let Some(expected) = refracted(from, ior).filter(|_| sample.to.z * from.z < 0.0) else { continue };
            // Lateral components are exact; the textbook's cosine loses half of the digits near the critical angle.
            assert!((sample.to - expected).truncate().length() < 1e-15, "ior {ior}, {from}");
            assert!((sample.to.z - expected.z).abs() < 1e-15 / expected.z.abs() + 1e-15, "ior {ior}, {from}");
        }
    }
}
