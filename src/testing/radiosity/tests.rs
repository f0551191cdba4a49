//! Closed forms of DESIGN.md, section 5, and agreement of independent formulas.

use std::f64::consts::PI;

use glam::DVec3;

use super::polygon::subdivide;
use super::*;
use crate::scene::SceneDescription;
use crate::scene::description::{BsdfDescription, FilmSize};
use crate::spectrum::Rgb;
use crate::testing::scenes;

const FILM: FilmSize = FilmSize { width: 16, height: 16 };

fn square(origin: DVec3, u: DVec3, v: DVec3) -> [DVec3; 4] {
    [origin, origin + u, origin + u + v, origin + v]
}

fn check(what: &str, found: f64, exact: f64, tolerance: f64) {
    let error = (found / exact - 1.0).abs();
    println!("{what}: {found:.14}, relative error {error:.1e}");
    assert!(error < tolerance, "{what}: {found} is not {exact}, relative error {error:e}");
}

/// The contour integral, without and with singular edges.
#[test]
fn known_form_factors_of_pairs() {
    let floor = square(DVec3::ZERO, DVec3::X, DVec3::Y);
    let wall = square(DVec3::ZERO, DVec3::Y, DVec3::Z);
    let above = square(DVec3::Z, DVec3::Y, DVec3::X);
    let long = square(DVec3::ZERO, DVec3::X, DVec3::Y * 2.0);
    let above_long = square(DVec3::Z * 0.5, DVec3::Y * 2.0, DVec3::X);
    check("squares with an edge in common", form_factor(&floor, &wall), 0.200_043_776_075_40, 1e-11);
    check("opposed squares", form_factor(&floor, &above), 0.199_824_895_698_39, 1e-10);
    check("opposed rectangles", form_factor(&long, &above_long), 0.508_988_669_041_44, 1e-8);
    assert_eq!(form_factor(&floor, &square(DVec3::X, DVec3::X, DVec3::Y)), 0.0, "squares in one plane");
    assert_eq!(form_factor(&floor, &square(-DVec3::Z, DVec3::Y, DVec3::X)), 0.0, "back to back");
}

/// The same squares as patches, most of them integrated as far ones.
#[test]
fn known_form_factors_of_subdivided_squares() {
    let walls = [("floor", DVec3::X, DVec3::Y), ("wall", DVec3::Y, DVec3::Z)];
    let mut description = scenes::plates(FILM);
    description.meshes = walls.map(|(name, u, v)| scenes::rectangle(name, DVec3::ZERO, u, v, 0)).into();
    let scene = DiffuseScene::new(&description).unwrap();
    for edge in [1.5, 0.3, 0.1] {
        let factors = FormFactors::new(&scene, edge, 1).unwrap();
        // Each pair is in the sum twice.
        let sum = 0.5 * factors.exchange().sum();
        check(&format!("{} patches", factors.patches().len()), sum, 0.200_043_776_075_40, 3e-7);
    }
}

#[test]
fn known_form_factor_of_a_point() {
    let lamp = square(DVec3::new(-0.5, -0.5, 1.0), DVec3::Y, DVec3::X);
    let found = PI * point_form_factor(DVec3::ZERO, DVec3::Z, &lamp);
    check("point below a square", found, 0.752_274_688_454_1, 1e-12);
    let tilted = DVec3::new(0.0, -1.0, 0.0);
    let half = [lamp[0], lamp[0] + DVec3::Y * 0.5, lamp[3] + DVec3::Y * 0.5, lamp[3]];
    let clipped = point_form_factor(DVec3::ZERO, tilted, &lamp);
    check("the half above the horizon", clipped, point_form_factor(DVec3::ZERO, tilted, &half), 1e-12);
    assert_eq!(point_form_factor(DVec3::ZERO, -DVec3::Z, &lamp), 0.0, "below the horizon");
    assert_eq!(point_form_factor(DVec3::Z * 2.0, -DVec3::Z, &lamp), 0.0, "behind the lamp");
}

/// Stokes' contours against Lambert's formula integrated over the other triangle, also where planes cut triangles.
#[test]
fn contours_agree_with_lambert() {
    let p = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let shifts = [DVec3::new(0.3, 0.2, 0.8), DVec3::new(-1.5, 0.7, 0.4), DVec3::new(0.2, 0.1, 4.0)];
    let shapes = [
        [DVec3::ZERO, DVec3::Y, DVec3::X],
        [DVec3::ZERO, DVec3::new(0.1, 0.9, 0.5), DVec3::new(0.8, -0.2, 0.6)],
        [DVec3::new(0.1, 0.1, 0.0), DVec3::new(0.3, 0.2, 0.9), DVec3::new(1.0, 0.5, -0.3)],
    ];
    for shift in shifts {
        for shape in shapes {
            let q = shape.map(|c| c + shift);
            let points = subdivide(p, 24).into_iter().flat_map(quadrature::triangle);
            let lambert: f64 = points.map(|(x, w)| w / 576.0 * point_form_factor(x, DVec3::Z, &q)).sum();
            let found = form_factor(&p, &q);
            assert!((found - lambert).abs() < 5e-5 * lambert + 1e-12, "{q:?}: {found} is not {lambert}");
        }
    }
}

fn solved(scene: &DiffuseScene, edge: f64) -> Solution<'_> {
    Solution::new(FormFactors::new(scene, edge, 1).unwrap()).unwrap()
}

/// `L_e / (1 − ρ)`, its partial sums and its terms, on patches and at points.
#[test]
fn the_closed_enclosure() {
    let (emission, reflectance) = (Rgb::new(0.3, 0.7, 1.0), Rgb::new(0.8, 0.5, 0.2));
    let scene = DiffuseScene::new(&scenes::enclosure(emission, reflectance, FILM)).unwrap();
    let solution = solved(&scene, 0.6);
    let closure = solution.factors().closure_error();
    println!("{} patches, row sums off by {closure:.1e}", solution.factors().patches().len());
    assert!(closure < 1e-6, "row sums off by {closure:e}");
    let mean = solution.mesh_radiosity(0, Bounces::Any) / PI;
    assert!((mean.r / 1.5 - 1.0).abs() < 1e-6, "{mean:?}");
    let corners = scene.facets()[0].corners;
    let point = FacetPoint { facet: 0, position: corners[0] * 0.2 + corners[1] * 0.7 + corners[2] * 0.1 };
    for (bounces, expected) in [
        (Bounces::Any, |e: f64, r: f64| e / (1.0 - r)),
        (Bounces::Exactly(0), |e, _| e),
        (Bounces::Exactly(3), |e, r| e * r.powi(3)),
        (Bounces::AtMost(0), |e, _| e),
        (Bounces::AtMost(4), |e, r| e * (1.0 - r.powi(5)) / (1.0 - r)),
    ] as [(Bounces, fn(f64, f64) -> f64); 5]
    {
        let patches = solution.radiosity(bounces).into_iter().map(|b| b / PI);
        for radiance in patches.chain(solution.radiance(&[point], bounces)) {
            for c in 0..3 {
                let exact = expected(emission.to_array()[c], reflectance.to_array()[c]);
                let error = (radiance.to_array()[c] / exact - 1.0).abs();
                assert!(error < 5.0 * closure + 1e-12, "{bounces:?}: {radiance:?}, channel {c} is not {exact}");
            }
        }
    }
}

/// A box in the enclosure hides its parts from each other, and radiance stays what it is: the error is visibility's.
#[test]
fn the_furnished_enclosure() {
    let mut description = scenes::enclosure(Rgb::WHITE, Rgb::grey(0.5), FILM);
    let (min, max) = (DVec3::new(-0.4, -0.5, -0.6), DVec3::new(0.35, 0.1, -0.1));
    description.meshes.push(scenes::cuboid("box", min, max, false, 0));
    let scene = DiffuseScene::new(&description).unwrap();
    let truth = Extrapolation::new(&scene, 0.8).unwrap();
    let off = |solution: &Solution<'_>| {
        let sums = solution.factors().row_sums();
        let square: f64 = sums.iter().map(|s| (s - 1.0).powi(2)).sum();
        (square / sums.len() as f64).sqrt()
    };
    let (coarse, fine) = (off(truth.coarse()), off(truth.fine()));
    println!("row sums off by {coarse:.1e} and {fine:.1e} in the root mean square");
    assert!(coarse < 3e-3 && fine < 0.6 * coarse, "{coarse:e} {fine:e}");
    for block in truth.block_means(Bounces::Any) {
        let error = (block.value.g - 2.0).abs();
        assert!(error < 5e-3 && error < block.error.g, "{block:?} is not 2");
    }
}

/// The mean over a patch of what is gathered at its points is what the matrix says: Lambert's formula against Stokes'.
#[test]
fn gathering_agrees_with_the_matrix() {
    let scene = DiffuseScene::new(&scenes::plates(FILM)).unwrap();
    let solution = solved(&scene, 0.5);
    let (n, facets) = (3, scene.facets());
    let radiosity = solution.radiosity(Bounces::Any);
    for (patch, radiosity) in solution.factors().patches().iter().zip(radiosity) {
        let parts = subdivide(patch.corners, n).into_iter().flat_map(quadrature::triangle);
        let (points, weights): (Vec<_>, Vec<_>) =
            parts.map(|(position, w)| (FacetPoint { facet: patch.facet, position }, w / (n * n) as f64)).unzip();
        let gathered: Rgb = solution.irradiance(&points, Bounces::Any).iter().zip(weights).map(|(&x, w)| x * w).sum();
        let f = &facets[patch.facet];
        let expected = f.emission + f.reflectance * gathered;
        assert!((expected.g / radiosity.g - 1.0).abs() < 1e-6, "{radiosity:?} is not {expected:?}");
    }
}

/// At a point the error falls with the square of the patches' size, and Richardson's estimate holds it.
#[test]
fn the_error_estimate_holds() {
    let scene = DiffuseScene::new(&scenes::plates(FILM)).unwrap();
    let [a, b, c] = scene.facets()[2].corners;
    let point = [FacetPoint { facet: 2, position: a * 0.5 + b * 0.3 + c * 0.2 }];
    let at = |edge: f64| Extrapolation::new(&scene, edge).unwrap().irradiance(&point, Bounces::Any)[0];
    let (coarse, middle, fine) = (at(0.8), at(0.4), at(0.2));
    println!("{coarse:?}\n{middle:?}\n{fine:?}");
    assert!((coarse.value.g - fine.value.g).abs() < coarse.error.g, "{coarse:?} {fine:?}");
    assert!((middle.value.g - fine.value.g).abs() < middle.error.g, "{middle:?} {fine:?}");
    assert!(middle.error.g < 0.35 * coarse.error.g, "not of second order: {coarse:?} {middle:?}");
}

type Change<'a> = &'a dyn Fn(&mut SceneDescription);

#[test]
fn what_is_not_diffuse_is_refused_by_name() {
    let refusal = |change: Change| {
        let mut description = scenes::plates(FILM);
        change(&mut description);
        DiffuseScene::new(&description).unwrap_err().to_string()
    };
    let cabinet = scenes::cabinet(FILM);
    let cases: [(&str, Change); 6] = [
        ("sphere 'metal ball'", &|d| d.spheres = cabinet.spheres.clone()),
        ("light 'point'", &|d| d.lights = cabinet.lights.clone()),
        ("environment", &|d| d.environment = Some(Rgb::WHITE.into())),
        ("material 'glass'", &|d| {
            d.materials[0] = scenes::material("glass", BsdfDescription::dielectric(1.5, 1.0), Rgb::BLACK);
        }),
        ("mesh 'lower'", &|d| d.meshes[0].normals = Some(vec![DVec3::new(0.6, 0.8, 0.0); 4])),
        ("camera 'camera'", &|d| d.sensor = d.sensor.clone().map(|s| scenes::with_lens(s, 0.1, 1.0))),
    ];
    for (named, change) in cases {
        let message = refusal(change);
        assert!(message.starts_with(named) && !message.contains('\n'), "{message}");
    }
    let scene = DiffuseScene::new(&scenes::plates(FILM)).unwrap();
    for edge in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(FormFactors::new(&scene, edge, 1), Err(RadiosityError::PatchEdge(_))), "{edge}");
    }
    assert!(matches!(FormFactors::new(&scene, 1e-9, 1), Err(RadiosityError::TooManyPatches { .. })));
    let bright = DiffuseScene::new(&scenes::enclosure(Rgb::WHITE, Rgb::WHITE, FILM)).unwrap();
    let solution = Solution::new(FormFactors::new(&bright, 2.0, 1).unwrap());
    assert!(matches!(solution, Err(RadiosityError::NoEquilibrium)));
}
