//! Weights of densities that differ beyond all measure, and paths that are evaluated a second time.

use glam::DVec3;

use super::super::case::{Case, Exact, Subject};
use super::super::journal::Journal;
use super::case;
use super::scenery::{FILM, scaled, unit_enclosure};
use crate::estimator::Heuristic;
use crate::scene::SceneDescription;
use crate::scene::description::{BsdfDescription, ConductorFresnel, Sphere};
use crate::spectrum::Rgb;
use crate::testing::scenes::{diffuse, material, pinhole, rectangle, room};
use crate::wide::Wide;

pub(super) fn cases() -> Vec<Case> {
    let log = |name, sweep: (&'static str, &[f64]), journal| case("algebra", name, sweep, Subject::Journal(journal));
    let new = |name, sweep: (&'static str, &[f64]), compute| case("algebra", name, sweep, Subject::Number(compute));
    vec![
        new("ratios", ("decades", &[1.0, 10.0, 100.0, 300.0, 3000.0]), |decades| partition(decades, 2.0))
            .about("densities spread over so many decades either way: the weights of all techniques add up to one"),
        new("exponents", ("exponent", &[1.0, 2.0, 10.0, 100.0]), |exponent| partition(300.0, exponent))
            .about("the power heuristic of 300 decades either way: the same"),
        log("long paths", ("edges", &[10.0, 100.0, 1000.0]), long_paths)
            .about("f, all densities and all weights of paths in a diffuse enclosure, against 60 digits"),
        log("sizes", ("factor", &[1.0, 1e-3, 1e3, 1e-6, 1e6, 1e-9, 1e9]), sizes)
            .about("the same in an enclosure that is so many times as large"),
        log("narrow lobes", ("alpha", &[1e-1, 1e-2, 1e-4, 1e-6, 1e-8]), narrow_lobes).about(
            "the same of paths between rough metal and rough glass: digits that a narrow lobe takes cancel in f/p",
        ),
        log("across a corner", ("distance", &[1e-1, 1e-3, 1e-5, 1e-7, 1e-9]), across_a_corner)
            .about("the same of connections between walls near the edge in which they meet"),
        log("powers", ("exponent", &[1.0, 2.0, 10.0, 100.0]), powers)
            .about("the same of the power heuristic, of paths through narrow lobes"),
    ]
}

/// The sum of the weights of ten techniques under the heuristic that deviates most.
fn partition(decades: f64, exponent: f64) -> Exact {
    let power = |i: i32| {
        let ten = Wide::new(10.0);
        let times = (decades * f64::from(i) / 4.5 - decades).abs().round() as u32;
        let size = (0..times).fold(Wide::ONE, |product, _| product * ten);
        if 2 * i < 9 { Wide::ONE / size } else { size }
    };
    let densities: Vec<Wide> = (0..10).map(power).collect();
    let heuristics =
        [Heuristic::Balance, Heuristic::Power { exponent }, Heuristic::Maximum, Heuristic::Cutoff { threshold: 0.1 }];
    let sum = |heuristic: &Heuristic| -> f64 {
        let weight = |i: usize| {
            let ratio = |j: usize| (densities[j] / densities[i]).to_f64();
            heuristic.weight((0..i).map(ratio), (i + 1..densities.len()).map(ratio))
        };
        (0..densities.len()).map(weight).sum()
    };
    let sums = heuristics.iter().map(sum);
    let estimate =
        sums.fold(
            1.0,
            |worst: f64, sum| if (sum - 1.0).abs() > (worst - 1.0_f64).abs() || sum.is_nan() { sum } else { worst },
        );
    Exact { estimate, truth: 1.0, tolerance: 1e-14 }
}

/// One walk through an enclosure that emits everywhere: of its paths the one with most edges.
fn long_paths(edges: f64) -> Journal {
    let settings = format!("max_length={edges}:roulette=off");
    Journal {
        scene: scaled(unit_enclosure(0.9), 10.0),
        integrator: format!("bdpt:{settings}"),
        drawn_by: Some(format!("path_bsdf:{settings}")),
        edges: edges as u32,
        paths: 2,
    }
}

fn sizes(factor: f64) -> Journal {
    let scene = scaled(unit_enclosure(0.5), factor);
    let integrator = "bdpt:max_length=30:roulette=off".to_owned();
    Journal { scene, integrator, drawn_by: None, edges: 28, paths: 10 }
}

fn narrow_lobes(alpha: f64) -> Journal {
    let integrator = "bdpt:max_length=6".to_owned();
    Journal { scene: polished(alpha), integrator, drawn_by: None, edges: 3, paths: 16 }
}

fn powers(exponent: f64) -> Journal {
    let integrator = format!("bdpt:max_length=6:heuristic=power:exponent={exponent}");
    Journal { scene: polished(1e-6), integrator, drawn_by: None, edges: 3, paths: 16 }
}

/// A room of rough metal with a ball of rough glass and diffuse blocks.
fn polished(alpha: f64) -> SceneDescription {
    let mut scene = room(FILM);
    let gold = ConductorFresnel::Ior { eta: Rgb::new(0.2, 0.4, 1.4), k: Rgb::new(3.9, 2.4, 1.6) };
    let white = scene.materials.len();
    scene.materials.extend([
        diffuse("plaster", Rgb::grey(0.7), Rgb::BLACK),
        material("glass", BsdfDescription::rough_dielectric(alpha, 1.5, 1.0), Rgb::BLACK),
    ]);
    scene.materials[0].bsdf = BsdfDescription::rough_conductor(alpha, gold);
    scene.meshes.iter_mut().filter(|mesh| mesh.name == "short").for_each(|mesh| mesh.material = white);
    scene.spheres.push(Sphere::new("ball", DVec3::new(-0.3, 1.5, 0.2), 0.25, white + 1));
    scene
}

/// Two walls that emit and meet at a right angle; the camera sees so much of them around their edge.
fn across_a_corner(distance: f64) -> Journal {
    let size = 2.0 * distance;
    let origin = DVec3::new(-1.0, 0.0, 0.0);
    let camera = pinhole(DVec3::new(0.1, 1.0, 1.0), DVec3::new(0.2, 0.0, 0.0), size.to_degrees());
    let scene = SceneDescription {
        name: "corner".into(),
        meshes: vec![
            rectangle("floor", origin, DVec3::Z * 2.0, DVec3::X * 2.0, 0),
            rectangle("wall", origin, DVec3::X * 2.0, DVec3::Y * 2.0, 0),
        ],
        materials: vec![diffuse("wall", Rgb::new(0.8, 0.6, 0.4), Rgb::WHITE)],
        sensor: Some(camera),
        film: Some(FILM),
        ..SceneDescription::default()
    };
    Journal { scene, integrator: "bdpt:max_length=4".into(), drawn_by: None, edges: 2, paths: 40 }
}
