//! Values point by point against those that Mitsuba's Python API gives in single precision.
//!
//! How far rounding takes a value is not guessed but derived: its *bound* is how much ours changes when each coordinate of each
//! direction moves by [`DIRECTION`], summed over coordinates, plus [`ARITHMETIC`] of the largest value at the same point, since
//! models subtract numbers of that size (1 − F near the critical angle). Where a feature is a step, such as the edge of a texel,
//! and the step lies within that, the bound has its height.

use std::path::Path;

use anyhow::anyhow;
use glam::{DVec2, DVec3};
use serde::{Deserialize, Deserializer};

use crate::path::{Edge, Vertex, VertexKind};
use crate::scene::bsdf::Side;
use crate::scene::{EmitterId, PrimitiveId, Scene};

use super::ParityArgs;
use super::albedo::{Albedo, Albedos};
use super::case::Case;
use super::row::{ParityRow, Verdict};

/// Rounding of a single-precision number, relative: half of the distance to the next.
const ROUNDING: f64 = 1.0 / (1 << 24) as f64;

/// A direction turned into another frame is the sum of three rounded products of rounded numbers, twice.
const DIRECTION: f64 = 8.0 * ROUNDING;

/// A model takes this many operations, if all round the same way.
const ARITHMETIC: f64 = 64.0 * ROUNDING;

/// `points.json`; `scripts/pathspace/parity/points.py` says what it holds.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Points {
    surfaces: Vec<SurfacePoint>,
    seen: Vec<Seen>,
    lights: Vec<Light>,
    rays: Vec<SensorRay>,
}

#[derive(Debug, Deserialize)]
struct SurfacePoint {
    #[serde(deserialize_with = "vector")]
    origin: DVec3,
    #[serde(deserialize_with = "vector")]
    direction: DVec3,
    #[serde(deserialize_with = "vector")]
    position: DVec3,
    pairs: Vec<Pair>,
    dirac: Vec<Pair>,
    albedos: Vec<Albedo>,
}

#[derive(Debug, Deserialize)]
struct Pair {
    #[serde(deserialize_with = "vector")]
    from: DVec3,
    #[serde(deserialize_with = "vector")]
    to: DVec3,
    value: [f64; 3],
    pdf: f64,
}

#[derive(Debug, Deserialize)]
struct Seen {
    #[serde(deserialize_with = "vector")]
    origin: DVec3,
    #[serde(deserialize_with = "vector")]
    direction: DVec3,
    radiance: [f64; 3],
}

#[derive(Debug, Deserialize)]
struct Light {
    #[serde(deserialize_with = "vector")]
    position: DVec3,
    #[serde(deserialize_with = "vector")]
    direction: DVec3,
    value: [f64; 3],
    pdf: f64,
    dirac: bool,
}

#[derive(Debug, Deserialize)]
struct SensorRay {
    film: [f64; 2],
    aperture: [f64; 2],
    #[serde(deserialize_with = "vector")]
    origin: DVec3,
    #[serde(deserialize_with = "vector")]
    direction: DVec3,
}

pub(super) fn vector<'de, D: Deserializer<'de>>(deserializer: D) -> Result<DVec3, D::Error> {
    Ok(<[f64; 3]>::deserialize(deserializer)?.into())
}

/// All that is compared of a case.
pub(super) fn compare(
    scene: &Scene,
    case: &Case,
    folder: &Path,
    args: &ParityArgs,
    cases: usize,
) -> anyhow::Result<Vec<ParityRow>> {
    let path = folder.join("points.json");
    if !path.is_file() {
        return Ok(Vec::new());
    }
    let points: Points = serde_json::from_slice(&super::read(&path)?)
        .map_err(|error| anyhow!("{}: {error}; run again", path.display()))?;
    let mut comparisons =
        [Worst::new("hits"), Worst::new("eval"), Worst::new("pdf"), Worst::new("dirac"), Worst::new("dirac-pdf")];
    let mut albedos = Albedos::default();
    for point in &points.surfaces {
        let rounding = surface(scene, case, point, &mut comparisons);
        // Under leaning normals some directions are black here, and not in Mitsuba.
        let vertex = scene.trace(&start(scene, point.origin), point.direction);
        if let Some(vertex) = vertex.filter(|vertex| vertex.normal.dot(vertex.shading_normal) > 1.0 - 1e-9) {
            point.albedos.iter().for_each(|albedo| albedos.add(scene, &vertex, albedo, rounding, args.seed));
        }
    }
    let mut others = [Worst::new("radiance"), Worst::new("light"), Worst::new("light-pdf"), Worst::new("rays")];
    let brightest = largest(points.seen.iter().map(|seen| &seen.radiance));
    for seen in &points.seen {
        let ours = |x: &[f64]| radiance(scene, seen.origin, DVec3::from_slice(x));
        let what = || format!("from {} along {}", seen.origin, seen.direction);
        others[0].add(&ours, &seen.direction.to_array(), &seen.radiance, ARITHMETIC * brightest, what);
    }
    let brightest = largest(points.lights.iter().map(|light| &light.value));
    for light in &points.lights {
        let what = || format!("at {} from {}", light.position, light.direction);
        let towards = light.direction.to_array();
        let ours = |x: &[f64]| light_of(scene, light, DVec3::from_slice(x)).map_or([f64::NAN; 3], |(value, _)| value);
        others[1].add(&ours, &towards, &light.value, ARITHMETIC * brightest, what);
        if !light.dirac && case.same_densities() {
            let ours = |x: &[f64]| [light_of(scene, light, DVec3::from_slice(x)).map_or(f64::NAN, |(_, pdf)| pdf)];
            others[2].add(&ours, &towards, &[light.pdf], ARITHMETIC * light.pdf, what);
        }
    }
    for ray in &points.rays {
        let theirs = line(ray.origin, ray.direction, scene.centre() + scene.sensor().position());
        let [c, d] = same_place(scene, ray, &theirs);
        let ours = |x: &[f64]| sensor_ray(scene, x);
        let what = || format!("film {:?}, aperture {:?}", ray.film, ray.aperture);
        others[3].add(&ours, &[ray.film[0], ray.film[1], c, d], &theirs, ARITHMETIC * ray.origin.length(), what);
    }
    let all = comparisons.into_iter().chain(others);
    let rows = all.filter(|worst| worst.values > 0).map(|worst| worst.row(case));
    Ok(rows.chain(albedos.row(case, cases)).collect())
}

/// Compares all of a point; returns the largest bound by the largest value, what rounding may do to an albedo.
fn surface(scene: &Scene, case: &Case, point: &SurfacePoint, comparisons: &mut [Worst; 5]) -> f64 {
    let mut relative = ARITHMETIC;
    let [hits, eval, pdf, dirac, dirac_pdf] = comparisons;
    let hit = |direction: DVec3| scene.trace(&start(scene, point.origin), direction);
    let position =
        |x: &[f64]| hit(DVec3::from_slice(x)).map_or([f64::NAN; 3], |v| (v.position + scene.centre()).into());
    let ray = point.direction.to_array();
    let rounding = ARITHMETIC * (point.origin.length() + 1.0);
    let what = || format!("from {} along {}", point.origin, point.direction);
    hits.add(&position, &ray, &point.position.to_array(), rounding, what);
    let brightest = largest(point.pairs.iter().map(|pair| &pair.value));
    let rounding = (ARITHMETIC + case.table) * brightest;
    let of_density = largest(point.pairs.iter().map(|pair| std::slice::from_ref(&pair.pdf)));
    let surface = hit(point.direction);
    let taken = |pair: &&Pair| surface.is_none_or(|vertex| sides_agree(&vertex, pair));
    for pair in point.pairs.iter().filter(taken) {
        let inputs = inputs(point.direction, pair);
        let what = || format!("at {} from {} to {}", point.position, pair.from, pair.to);
        let value = |x: &[f64]| {
            let [direction, from, to] = vectors(x);
            hit(direction).map_or([f64::NAN; 3], |v| (scene.scatter(&v, to, from) * v.abs_cos(to)).to_array())
        };
        let bound = eval.add(&value, &inputs, &pair.value, rounding, what);
        relative = relative.max(bound / brightest.max(f64::MIN_POSITIVE));
        // Mitsuba's models may draw what they do not scatter.
        if case.same_densities() && pair.value != [0.0; 3] {
            let density = |x: &[f64]| {
                let [direction, from, to] = vectors(x);
                [hit(direction).map_or(f64::NAN, |v| scene.scatter_density(&v, from, to).value())]
            };
            pdf.add(&density, &inputs, &[pair.pdf], ARITHMETIC * of_density + case.fit * pair.pdf, what);
        }
    }
    for pair in point.dirac.iter().filter(taken) {
        let inputs = inputs(point.direction, pair);
        let what = || format!("at {} from {} to {}", point.position, pair.from, pair.to);
        let value = |x: &[f64]| {
            let [direction, from, to] = vectors(x);
            hit(direction).map_or([f64::NAN; 3], |v| scene.scatter_dirac(&v, to, from).to_array())
        };
        let bound = dirac.add(&value, &inputs, &pair.value, ARITHMETIC, what);
        relative = relative.max(bound / largest(std::iter::once(&pair.value)).max(ARITHMETIC));
        if case.same_densities() {
            let density = |x: &[f64]| {
                let [direction, from, to] = vectors(x);
                [hit(direction).map_or(f64::NAN, |v| scene.scatter_dirac_density(&v, Side::Sensor, from, to).value())]
            };
            dirac_pdf.add(&density, &inputs, &[pair.pdf], ARITHMETIC, what);
        }
    }
    relative
}

/// Shading and geometric normal have each direction on the same side; where they do not, surfaces are black here, and not in
/// Mitsuba.
fn sides_agree(vertex: &Vertex, pair: &Pair) -> bool {
    [pair.from, pair.to].iter().all(|way| way.dot(vertex.normal) * way.dot(vertex.shading_normal) > 0.0)
}

fn largest<'a>(values: impl Iterator<Item = &'a (impl AsRef<[f64]> + ?Sized + 'a)>) -> f64 {
    values.flat_map(AsRef::as_ref).fold(0.0, |largest, x| largest.max(x.abs()))
}

fn inputs(ray: DVec3, pair: &Pair) -> Vec<f64> {
    [ray, pair.from, pair.to].iter().flat_map(DVec3::to_array).collect()
}

fn vectors(x: &[f64]) -> [DVec3; 3] {
    [0, 3, 6].map(|at| DVec3::from_slice(&x[at..]))
}

/// A vertex without a surface at a point of the world.
fn start(scene: &Scene, position: DVec3) -> Vertex {
    let (position, normal) = (position - scene.centre(), DVec3::ZERO);
    let kind = VertexKind::Sensor { zeta: 0.0, primitive: PrimitiveId::NONE };
    Vertex { position, normal, shading_normal: normal, kind }
}

/// Emitted radiance that comes along a ray.
fn radiance(scene: &Scene, origin: DVec3, direction: DVec3) -> [f64; 3] {
    let direction = direction.normalize();
    let Some(vertex) = scene.trace(&start(scene, origin), direction) else { return [0.0; 3] };
    let Some(id) = vertex.emitter() else { return [0.0; 3] };
    scene.emitter(id).emission(scene, &vertex, -direction).to_array()
}

/// What a light sends to a point: its value and the density of drawing it, both per solid angle or of a Dirac one. `None` where
/// there is no light in this direction.
fn light_of(scene: &Scene, light: &Light, direction: DVec3) -> Option<([f64; 3], f64)> {
    /// Off the surface, so that it is not hit \[m\].
    const OFF: f64 = 1e-3;
    let x1 = light.position - scene.centre();
    if light.dirac {
        // Of such lights a case has one.
        let emitter = scene.emitter(EmitterId(0));
        let drawn = emitter.sample_direct(scene.accel(), x1, [0.5; 3])?;
        let edge = Edge::from_to(x1, drawn.vertex.position);
        let factor = edge.solid_angle_to_area(&drawn.vertex);
        let value = emitter.emission(scene, &drawn.vertex, -edge.direction) * factor.value() / drawn.density.value();
        return (edge.direction.distance(direction.normalize()) < 1e-4).then_some((value.to_array(), 1.0));
    }
    let direction = direction.normalize();
    let x0 = scene.trace(&start(scene, light.position + direction * OFF), direction)?;
    let emitter = scene.emitter(x0.emitter()?);
    let edge = Edge::from_to(x1, x0.position);
    let density = emitter.direct_density(scene.accel(), x1, &x0, &edge);
    let per_solid_angle = density.value() / edge.solid_angle_to_area(&x0).value();
    Some((emitter.emission(scene, &x0, -direction).to_array(), per_solid_angle))
}

/// A ray as a line: its direction, and its point that is nearest to `centre`.
fn line(origin: DVec3, direction: DVec3, centre: DVec3) -> [f64; 6] {
    let direction = direction.normalize();
    let offset = origin - centre;
    let nearest = offset - direction * offset.dot(direction);
    let ([a, b, c], [d, e, f]) = (direction.to_array(), nearest.to_array());
    [a, b, c, d, e, f]
}

fn sensor_ray(scene: &Scene, x: &[f64]) -> [f64; 6] {
    let size = scene.sensor().film();
    let raster = DVec2::new(x[0] * f64::from(size.width), x[1] * f64::from(size.height));
    let (vertex, direction) = scene.sensor().through(raster, [x[2], x[3]]);
    line(vertex.position, direction, scene.sensor().position())
}

/// The aperture sample with which our ray is nearest to Mitsuba's, of those that the square's symmetries make of its own: discs
/// are uniform whichever way they are drawn.
fn same_place(scene: &Scene, ray: &SensorRay, theirs: &[f64; 6]) -> [f64; 2] {
    let [x, y] = ray.aperture;
    let flips = [[x, y], [1.0 - x, y], [x, 1.0 - y], [1.0 - x, 1.0 - y]];
    let places = flips.into_iter().flat_map(|[x, y]| [[x, y], [y, x]]);
    let distance = |place: &[f64; 2]| {
        let ours = sensor_ray(scene, &[ray.film[0], ray.film[1], place[0], place[1]]);
        ours.iter().zip(theirs).map(|(a, b)| (a - b) * (a - b)).sum::<f64>()
    };
    places.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(ray.aperture)
}

/// The comparison whose error is the largest multiple of its bound.
struct Worst {
    name: &'static str,
    ratio: f64,
    error: f64,
    bound: f64,
    values: usize,
    beyond: usize,
    what: String,
}

impl Worst {
    fn new(name: &'static str) -> Self {
        Self { name, ratio: -1.0, error: 0.0, bound: 0.0, values: 0, beyond: 0, what: String::new() }
    }

    /// Compares `ours` at `inputs` with `theirs`, which arithmetic may have taken `arithmetic` away; returns the largest bound.
    fn add<const N: usize>(
        &mut self,
        ours: &dyn Fn(&[f64]) -> [f64; N],
        inputs: &[f64],
        theirs: &[f64; N],
        arithmetic: f64,
        what: impl Fn() -> String,
    ) -> f64 {
        let value = ours(inputs);
        let mut bounds = [arithmetic; N];
        let mut moved = inputs.to_vec();
        for i in 0..inputs.len() {
            let mut change = [0.0_f64; N];
            for step in [DIRECTION, -DIRECTION] {
                moved[i] = inputs[i] + step;
                for (change, (a, b)) in change.iter_mut().zip(ours(&moved).into_iter().zip(value)) {
                    *change = change.max((a - b).abs());
                }
            }
            moved[i] = inputs[i];
            bounds.iter_mut().zip(change).for_each(|(bound, change)| *bound += change);
        }
        let scale = theirs.iter().chain(&value).fold(0.0_f64, |scale, x| scale.max(x.abs()));
        for ((ours, theirs), bound) in value.into_iter().zip(theirs).zip(bounds) {
            if ours == 0.0 && *theirs == 0.0 {
                continue;
            }
            self.values += 1;
            let error = (ours - theirs).abs();
            let ratio = if error.is_nan() { f64::INFINITY } else { error / bound.max(f64::MIN_POSITIVE) };
            self.beyond += usize::from(ratio > 1.0);
            if ratio > self.ratio {
                let what = format!("{}: ours {ours:.6e}, Mitsuba's {theirs:.6e}", what());
                (self.ratio, self.error, self.bound, self.what) = (ratio, error / scale, bound / scale, what);
            }
        }
        bounds.into_iter().fold(0.0, f64::max)
    }

    fn row(self, case: &Case) -> ParityRow {
        let verdict = if self.beyond > 0 { Verdict::Differ } else { Verdict::Agree };
        let details = format!("{} of {} beyond their bound; furthest {}", self.beyond, self.values, self.what);
        ParityRow {
            largest_error: Some(self.error),
            bound: Some(self.bound),
            values: Some(self.values),
            ..ParityRow::new(&case.name, self.name, verdict, details)
        }
    }
}
