//! What a line of the path log says is consistent with itself: weights, measures, products, digits.

use pathspace::estimator::{Integrator, Settings};
use pathspace::film::ReplayKey;
use pathspace::report::paths::{DensityRecord, DiracRecord, Origin, PathRecord, TechniqueRecord, VertexRecord};
use pathspace::scene::Scene;
use pathspace::scene::description::{FilmSize, SceneDescription};
use pathspace::spectrum::Rgb;
use pathspace::testing::scenes;
use pathspace_bdpt::Bidirectional;
use pathspace_light::LightTracer;
use pathspace_path::PathTracer;
use pathspace_path_bsdf::BsdfPathTracer;

const FILM: FilmSize = FilmSize { width: 12, height: 9 };

fn all_scenes() -> [SceneDescription; 9] {
    let enclosure = scenes::enclosure(Rgb::new(0.5, 0.7, 0.9), Rgb::new(0.3, 0.5, 0.8), FILM);
    [
        enclosure,
        scenes::room(FILM),
        scenes::cabinet(FILM),
        scenes::terrace(FILM),
        scenes::gallery(FILM),
        scenes::veneer(FILM),
        scenes::vignette(FILM),
        scenes::photometer(FILM),
        scenes::overlook(FILM),
    ]
}

fn bdpt(settings: &str) -> Bidirectional {
    Bidirectional::new(&mut Settings::parse(settings).unwrap()).unwrap()
}

/// Draws `samples` samples in every pixel and gives each record as the line of it reads back.
fn log(scene: &Scene, integrator: &dyn Integrator, samples: u64) -> Vec<PathRecord> {
    let definition = integrator.definition(8);
    let origin = Origin { scene, integrator: "test", definition: definition.as_ref() };
    let film = scene.sensor().film();
    let mut records = Vec::new();
    for pixel in (0..film.height).flat_map(|y| (0..film.width).map(move |x| (x, y))) {
        for sample in 0..samples {
            let key = ReplayKey { seed: 3, sample, pixel };
            for (index, term) in integrator.replay(scene, key).iter().enumerate() {
                let record = PathRecord::new(&origin, key, index, term);
                let line = serde_json::to_string(&record).unwrap();
                let read: PathRecord = serde_json::from_str(&line).unwrap();
                assert_eq!(read, record);
                assert_eq!(read.contribution, term.term.value.to_array().map(Some), "bit for bit");
                let placed = term.path.vertices().iter().map(|v| (v.position + scene.centre()).to_array());
                assert!(read.vertices.iter().map(|v| v.position).eq(placed), "bit for bit");
                records.push(read);
            }
        }
    }
    records
}

fn techniques(record: &PathRecord) -> &[TechniqueRecord] {
    record.techniques.as_ref().unwrap()
}

/// The technique that has drawn the path.
fn own(record: &PathRecord) -> &TechniqueRecord {
    techniques(record).iter().find(|by| (by.s, by.t) == (record.s, record.t)).unwrap()
}

/// `Σ_j n_j p_j / (n_i p_i)` over the techniques that the integrator uses, from the line alone.
fn reciprocal_weight(record: &PathRecord) -> f64 {
    let own = own(record);
    techniques(record).iter().filter_map(|j| Some(j.n / own.n * (j.ln_p? - own.ln_p?).exp())).sum()
}

#[test]
fn densities_of_a_line_recompute_its_weight_and_contribution() {
    for description in all_scenes() {
        let scene = scenes::build(&description);
        let records = log(&scene, &bdpt("max_length=6"), 20);
        assert!(records.len() > 2000, "{}: only {} paths", description.name, records.len());
        let shared = records.iter().filter(|record| record.weight < 0.9).count();
        assert!(shared > records.len() / 4, "{}: only {shared} paths have several techniques", description.name);
        for record in &records {
            let deviation = reciprocal_weight(record) * record.weight - 1.0;
            assert!(deviation.abs() < 1e-9, "{}: 1/w is off by {deviation}: {record:?}", description.name);
            let own = own(record);
            let target = own.f_over_p.unwrap();
            for (adds, f_over_p) in record.contribution.iter().zip(target) {
                let expected = record.weight / own.n * f_over_p;
                assert!((adds.unwrap() - expected).abs() <= 1e-9 * expected, "{record:?}");
            }
        }
    }
}

#[test]
fn every_integrator_tells_its_techniques() {
    let settings = || Settings::parse("max_length=5").unwrap();
    let integrators: [Box<dyn Integrator>; 3] = [
        Box::new(PathTracer::new(&mut settings()).unwrap()),
        Box::new(LightTracer::new(&mut settings()).unwrap()),
        Box::new(BsdfPathTracer::new(&mut settings()).unwrap()),
    ];
    let scene = scenes::build(&scenes::cabinet(FILM));
    for integrator in &integrators {
        let records = log(&scene, integrator.as_ref(), 10);
        assert!(records.len() > 30, "only {}", records.len());
        for record in &records {
            let deviation = reciprocal_weight(record) * record.weight - 1.0;
            assert!(deviation.abs() < 1e-9, "1/w is off by {deviation}: {record:?}");
        }
    }
}

/// An edge as the line has it.
struct Geometry {
    /// |cos θ| at the vertex before and at the vertex itself; one at a point.
    cosines: [f64; 2],
    distance: f64,
}

impl Geometry {
    fn new(before: &VertexRecord, at: &VertexRecord) -> Self {
        let [a, b] = [before, at].map(|v| glam::DVec3::from_array(v.position));
        let direction = (b - a).normalize();
        let cosine = |v: &VertexRecord| v.normal.map_or(1.0, |n| glam::DVec3::from_array(n).dot(direction).abs());
        Self { cosines: [cosine(before), cosine(at)], distance: (b - a).length() }
    }

    /// How far positions rounded in the world, coordinates of a few metres, move the ratios of measures.
    fn tolerance(&self) -> f64 {
        1e-12 + 1e-14 / (self.distance * self.cosines[0].min(self.cosines[1]))
    }
}

fn assert_close(a: f64, b: f64, tolerance: f64, record: &PathRecord) {
    assert!((a - b).abs() <= tolerance * b.abs(), "{a} is not {b} within {tolerance}: {record:?}");
}

/// The measures of one density agree; returns how many conversions there were.
fn check_measures(density: &DensityRecord, edge: &Geometry, record: &PathRecord) -> usize {
    let ([before, at], tolerance) = (edge.cosines, edge.tolerance());
    let DensityRecord { solid_angle, projected_solid_angle, area, .. } = *density;
    let Some(solid_angle) = solid_angle else {
        assert!(projected_solid_angle.is_none() && density.dirac.is_some(), "{record:?}");
        return 0;
    };
    assert!(density.dirac.is_none(), "{record:?}");
    if let Some(projected) = projected_solid_angle {
        assert_close(projected * before, solid_angle, tolerance, record);
    }
    if let Some(area) = area {
        assert_close(solid_angle * at / (edge.distance * edge.distance), area, tolerance, record);
    }
    usize::from(projected_solid_angle.is_some()) + usize::from(area.is_some())
}

#[test]
fn the_measures_of_a_line_agree_with_its_geometry() {
    let mut kinds = [0; 3];
    for description in all_scenes() {
        let scene = scenes::build(&description);
        let mut conversions = 0;
        for record in &log(&scene, &bdpt("max_length=6"), 10) {
            let (vertices, k) = (&record.vertices, record.edges as usize);
            assert_eq!(vertices.len(), k + 1);
            assert_eq!(vertices.iter().map(|v| v.letter).collect::<String>(), record.notation);
            for i in 1..=k {
                let (a, b) = (&vertices[i - 1], &vertices[i]);
                let edge = Geometry::new(a, b);
                let back = Geometry { cosines: [edge.cosines[1], edge.cosines[0]], ..edge };
                let (along, against) = (b.from_emitter.as_ref().unwrap(), a.from_sensor.as_ref());
                conversions += check_measures(along, &edge, record);
                conversions += against.map_or(0, |density| check_measures(density, &back, record));
                if i >= 2 {
                    assert_eq!(along.dirac.is_some(), a.dirac, "{record:?}");
                    kinds[0] += usize::from(a.dirac);
                    kinds[1] += usize::from(a.letter == 'G');
                }
            }
            let (first, last) = (vertices[0].from_emitter.unwrap(), vertices[k].from_sensor.unwrap());
            assert!(first.solid_angle.is_none() && last.solid_angle.is_none(), "an end has no direction");
            let starts = vertices[0].direct.unwrap();
            let edge = Geometry::new(&vertices[1], &vertices[0]);
            kinds[2] += usize::from(starts.dirac.is_some());
            if starts.solid_angle.is_some() {
                conversions += check_measures(&starts, &edge, record);
            }
        }
        assert!(conversions > 2000, "{}: only {conversions} conversions", description.name);
    }
    assert!(kinds.iter().all(|&n| n > 50), "Dirac steps, glossy vertices, Dirac emitters: {kinds:?}");
}

/// `ln` of the density of `at` in area measure, Dirac coefficients turned to it.
fn ln_in_area(density: &DensityRecord, before: Option<&VertexRecord>, at: &VertexRecord) -> f64 {
    let Some(dirac) = density.dirac else { return density.area.unwrap().ln() };
    let edge = || Geometry::new(before.unwrap(), at);
    match dirac {
        DiracRecord::Area(c) => c.ln(),
        DiracRecord::SolidAngle(c) => (c * edge().cosines[1] / edge().distance.powi(2)).ln(),
        DiracRecord::ProjectedSolidAngle(c) => {
            (c * edge().cosines[0] * edge().cosines[1] / edge().distance.powi(2)).ln()
        }
    }
}

#[test]
fn the_vertices_of_a_line_multiply_to_the_density_of_every_technique() {
    for description in all_scenes() {
        let scene = scenes::build(&description);
        let mut products = 0;
        for record in &log(&scene, &bdpt("max_length=6:roulette=local:roulette_start=1"), 8) {
            let (x, k) = (&record.vertices, record.edges as usize);
            for technique in techniques(record).iter().filter(|technique| (technique.s, technique.t) != (1, 1)) {
                let Some(ln_p) = technique.ln_p else { continue };
                let s = technique.s as usize;
                let from_emitter = (0..s).map(|i| match s {
                    1 => ln_in_area(&x[0].direct.unwrap(), Some(&x[1]), &x[0]),
                    _ => ln_in_area(&x[i].from_emitter.unwrap(), i.checked_sub(1).map(|j| &x[j]), &x[i]),
                });
                let from_sensor = (s..=k).map(|i| match technique.t {
                    1 => ln_in_area(&x[k].direct.unwrap(), Some(&x[k - 1]), &x[k]),
                    _ => ln_in_area(&x[i].from_sensor.unwrap(), x.get(i + 1), &x[i]),
                });
                let sum: f64 = from_emitter.chain(from_sensor).sum();
                assert!((sum - ln_p).abs() < 1e-8, "s={s}: {sum} is not {ln_p}: {record:?}");
                products += 1;
            }
        }
        assert!(products > 1500, "{}: only {products} products", description.name);
    }
}

#[test]
fn long_paths_are_told_by_their_logarithms() {
    let film = FilmSize { width: 1, height: 1 };
    let mut description = scenes::enclosure(Rgb::WHITE, Rgb::grey(0.9), film);
    description.meshes[0].positions.iter_mut().for_each(|position| *position *= 40.0);
    let scene = scenes::build(&description);
    let bsdf = BsdfPathTracer::new(&mut Settings::parse("max_length=400:roulette=off").unwrap()).unwrap();
    let key = ReplayKey { seed: 1, sample: 0, pixel: (0, 0) };
    let terms = bsdf.replay(&scene, key);
    let definition = Integrator::definition(&bsdf, 8);
    let origin = Origin { scene: &scene, integrator: "path_bsdf", definition: definition.as_ref() };
    let record = PathRecord::new(&origin, key, 399, &terms[399]);
    let line: serde_json::Value = serde_json::from_str(&serde_json::to_string(&record).unwrap()).unwrap();
    assert_eq!(line["edges"], 400);
    assert!(line["f"].is_null(), "beyond every f64");
    let (ln_f, ln_p) = (line["ln_f"][1].as_f64().unwrap(), line["ln_p"].as_f64().unwrap());
    assert!(ln_f < -2000.0 && ln_p < -2000.0, "{ln_f} {ln_p}");
    // Each bounce off walls of albedo 0.9 leaves 0.9.
    let expected = 399.0 * 0.9_f64.ln();
    assert!((ln_f - ln_p - expected).abs() < 1e-8, "{}", ln_f - ln_p);
    assert!((line["techniques"][0]["f_over_p"][1].as_f64().unwrap().ln() - expected).abs() < 1e-8);
}

#[test]
fn any_number_reads_back_bit_for_bit() {
    let scene = scenes::build(&scenes::room(FILM));
    let key = ReplayKey { seed: 1, sample: 0, pixel: (6, 4) };
    let terms = bdpt("max_length=4").replay(&scene, key);
    let origin = Origin { scene: &scene, integrator: "bdpt", definition: None };
    let mut record = PathRecord::new(&origin, key, 0, &terms[0]);
    let mut random = pathspace::sampler::Random::new(5, 0, 0);
    let mut seen = 0;
    while seen < 20_000 {
        let bits = ((random.uniform() * 2f64.powi(32)) as u64) << 32 | (random.uniform() * 2f64.powi(32)) as u64;
        let number = f64::from_bits(bits);
        if number.is_finite() {
            record.weight = number;
            let read: PathRecord = serde_json::from_str(&serde_json::to_string(&record).unwrap()).unwrap();
            assert_eq!(read.weight.to_bits(), bits);
            seen += 1;
        }
    }
    record.contribution[1] = None;
    assert!(serde_json::to_string(&record).unwrap().contains(",null,"));
}

#[test]
fn an_integrator_without_a_definition_leaves_out_what_is_unknown() {
    let scene = scenes::build(&scenes::cabinet(FILM));
    let integrator = bdpt("max_length=5");
    let key = ReplayKey { seed: 2, sample: 0, pixel: (5, 5) };
    let terms = integrator.replay(&scene, key);
    assert!(!terms.is_empty());
    let origin = Origin { scene: &scene, integrator: "custom", definition: None };
    for term in &terms {
        let record = PathRecord::new(&origin, key, 0, term);
        assert!(record.techniques.is_none() && record.ln_p.is_none() && record.heuristic.is_none());
        assert!(record.f.is_some() && record.vertices[1].from_emitter.unwrap().survival.is_none());
    }
}
