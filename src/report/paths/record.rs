//! One line of the path log.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::estimator::{Combination, Heuristic, RecordedTerm};
use crate::film::ReplayKey;
use crate::measure::Density;
use crate::path::{DiracDensity, Path, Roulette, Vertex, VertexDensity, VertexKind, WalkRules};
use crate::sampler::PathSampler;
use crate::scene::Scene;
use crate::scene::bsdf::Side;
use crate::wide::Wide;

/// The version of the lines that this library writes.
pub const SCHEMA: u32 = 4;

/// A term of the estimator with its path; see [the module](super) for the conventions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PathRecord {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Name of the scene.
    pub scene: String,
    /// The integrator with its settings, as the user wrote it.
    pub integrator: String,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Column and row of the pixel that the sample was drawn for.
    pub pixel: [u32; 2],
    /// Index of the sample in its pixel, from 0.
    pub sample: u64,
    /// Index of the path among those of its sample, from 0, those that a filter leaves out included.
    pub path: u64,
    /// Column and row of the pixel that sees the path: another than `pixel` where a walk from an emitter found the sensor.
    pub seen_by: [u32; 2],
    /// How the path scatters, in the letters L, D, G, S and E: [`Scene::notation`].
    pub notation: String,
    /// Length k in edges.
    pub edges: u32,
    /// Vertices drawn from the emitter.
    pub s: u32,
    /// Vertices drawn from the sensor.
    pub t: u32,
    /// Which of `techniques` drew the path, by its `sampler`: several may have the same s and t.
    pub sampler: Option<u32>,
    /// `w_i(x̄)`, the weight of the sampler that drew the path.
    pub weight: f64,
    /// `w_i f / (n_i p_i P)` by channel, what the path adds to its pixel: radiance \[W/m²/sr\].
    pub contribution: [Option<f64>; 3],
    /// `f_j(x̄)` by channel, the measurement contribution; `null` where a channel is out of the range of `f64`.
    pub f: Option<[f64; 3]>,
    /// `ln f_j(x̄)` by channel.
    pub ln_f: [Option<f64>; 3],
    /// `ln p_i(x̄)` of the sampler that drew the path, in area measure.
    pub ln_p: Option<f64>,
    /// How samplers share the path. `null`, like `roulette` and `techniques`, for an integrator that is more than a set of
    /// bidirectional techniques.
    pub heuristic: Option<Heuristic>,
    /// How the walks end.
    pub roulette: Option<RouletteRecord>,
    /// The samplers that can draw the path, in the order of the integrator's definition.
    pub techniques: Option<Vec<TechniqueRecord>>,
    /// x_0 … x_k.
    pub vertices: Vec<VertexRecord>,
}

/// How the walks from either end are truncated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RouletteRecord {
    /// Of walks from the emitters.
    pub emitter: Roulette,
    /// Of walks from the sensor.
    pub sensor: Roulette,
}

/// What a technique has to do with the path.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TechniqueRecord {
    /// Vertices drawn from the emitter.
    pub s: u32,
    /// Vertices drawn from the sensor.
    pub t: u32,
    /// Number of the sampler in the integrator's definition, from 0; those that cannot draw the path have no entry.
    pub sampler: u32,
    /// `n_i`, how many of its samples serve a pixel in one pass.
    pub n: f64,
    /// `P`, the probability that a sample estimates paths of this length at all: below one where it is drawn in advance. What
    /// is drawn has the density `P p_i`.
    pub length_probability: f64,
    /// `p_i(x̄)` in area measure, given the length, with every digit.
    pub p: Option<WideRecord>,
    /// `ln p_i(x̄)`.
    pub ln_p: Option<f64>,
    /// `w_i(x̄)` by the definition, whatever the line's own `weight` was computed by.
    pub weight: f64,
    /// `f(x̄) / p_i(x̄)` by channel: the target in this technique's primary sample space, where its own density is one.
    /// `null` where a channel is out of the range of `f64`.
    pub f_over_p: Option<[f64; 3]>,
}

/// A [`Wide`] number, `mantissa · 2^exponent`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WideRecord {
    /// In `[1, 2)`.
    pub mantissa: f64,
    /// The power of two.
    pub exponent: i64,
}

/// A vertex of the path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VertexRecord {
    /// Where it is in the world \[m\]; on the sphere around the scene that stands for infinity where `kind` is `infinity`.
    pub position: [f64; 3],
    /// The same relative to the scene's centre, as it is computed with: `position` rounds its sum with the centre \[m\].
    pub local: [f64; 3],
    /// Unit geometric normal; `null` at a point light and a pinhole.
    pub normal: Option<[f64; 3]>,
    /// Unit shading normal; `null` where it is the geometric one.
    pub shading_normal: Option<[f64; 3]>,
    /// Its letter in `notation`.
    pub letter: char,
    /// `surface`, `emitter` (a surface that emits), `light` (a point or spot light), `infinity` or `sensor`.
    pub kind: String,
    /// The path takes a Dirac lobe here.
    pub dirac: bool,
    /// At the sensor: ζ in `[0, 1)`, which of the pixels is meant that share the point of the film. The line's densities are
    /// those of the path together with it.
    pub zeta: Option<f64>,
    /// What the surface is made of.
    pub material: Option<NamedId>,
    /// The emitter that it lies on.
    pub emitter: Option<NamedId>,
    /// The density with which a walk from the emitter draws it, given x_0 … x_{i−1}; `null` where no such walk comes here.
    pub from_emitter: Option<DensityRecord>,
    /// The density with which a walk from the sensor, for the pixel `seen_by`, draws it, given x_{i+1} … x_k.
    pub from_sensor: Option<DensityRecord>,
    /// At the ends: the density with which it is drawn for its neighbour (s = 1 at x_0, t = 1 at x_k).
    pub direct: Option<DensityRecord>,
}

/// Number and name of a material or an emitter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NamedId {
    /// Its index in the scene.
    pub id: u32,
    /// Its name in the file; of an emitter, that of its mesh, sphere or light.
    pub name: String,
}

/// [`VertexDensity`] in numbers: the density of a vertex in each measure that it has a value in.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DensityRecord {
    /// In solid angle at the vertex before \[1/sr\].
    pub solid_angle: Option<f64>,
    /// In projected solid angle at the vertex before \[1/sr\].
    pub projected_solid_angle: Option<f64>,
    /// In area \[1/m²\].
    pub area: Option<f64>,
    /// What there is instead of a density.
    pub dirac: Option<DiracRecord>,
    /// Survival probability of roulette, contained in the other fields; `null` where the integrator's rules are unknown,
    /// whose densities are without roulette.
    pub survival: Option<f64>,
}

/// [`DiracDensity`] in numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "measure", content = "coefficient", rename_all = "snake_case")]
pub enum DiracRecord {
    /// A point.
    Area(f64),
    /// A direction.
    SolidAngle(f64),
    /// A direction that a mirror or a smooth glass gives.
    ProjectedSolidAngle(f64),
}

/// Where the terms of a log come from.
#[derive(Clone, Copy)]
pub struct Origin<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The integrator as the user wrote it.
    pub integrator: &'a str,
    /// What its weights are by definition.
    pub definition: Option<&'a Combination>,
}

impl PathRecord {
    /// Of the term number `index` of the sample `key`.
    #[must_use]
    pub fn new(origin: &Origin<'_>, key: ReplayKey, index: usize, recorded: &RecordedTerm) -> Self {
        let RecordedTerm { term, path } = recorded;
        let Origin { scene, integrator, definition } = *origin;
        let f = scene.contribution(path).map(|contribution| contribution.value);
        let techniques = definition.map(|definition| techniques(definition, scene, path, f));
        let own = techniques.iter().flatten().find(|by| {
            (by.s, by.t) == (term.technique.s, term.technique.t) && term.sampler.is_none_or(|own| own == by.sampler)
        });
        let rules = definition.and_then(Combination::rules);
        Self {
            schema: SCHEMA,
            scene: scene.name().to_owned(),
            integrator: integrator.to_owned(),
            seed: key.seed,
            pixel: key.pixel.into(),
            sample: key.sample,
            path: index as u64,
            seen_by: [term.pixel.x, term.pixel.y],
            notation: scene.notation(path),
            edges: path.edges() as u32,
            s: term.technique.s,
            t: term.technique.t,
            sampler: own.map(|own| own.sampler).or(term.sampler),
            weight: term.weight,
            contribution: term.value.to_array().map(finite),
            f: f.and_then(plain),
            ln_f: f.map_or([None; 3], |f| f.map(|channel| finite(channel.ln()))),
            ln_p: own.and_then(|own| own.ln_p),
            heuristic: definition.map(|d| d.heuristic),
            roulette: rules.map(|rules| RouletteRecord { emitter: rules.emitter, sensor: rules.sensor }),
            vertices: vertices(scene, rules, path),
            techniques,
        }
    }
}

impl PathRecord {
    /// What the sampler that drew the path has to do with it.
    #[must_use]
    pub fn own(&self) -> Option<&TechniqueRecord> {
        self.techniques.iter().flatten().find(|by| Some(by.sampler) == self.sampler)
    }
}

/// Of the samplers that can draw the path.
fn techniques(definition: &Combination, scene: &Scene, path: &Path, f: Option<[Wide; 3]>) -> Vec<TechniqueRecord> {
    let length_probability = definition.lengths.probability(path.edges() as u32);
    let densities = definition.densities(scene, path);
    let record = |(i, sampler): (usize, &Arc<dyn PathSampler>)| {
        let (p, technique) = (sampler.density(scene, path), sampler.technique(path.edges() as u32));
        (!p.is_zero()).then(|| TechniqueRecord {
            s: technique.s,
            t: technique.t,
            sampler: i as u32,
            n: sampler.count(scene),
            length_probability,
            p: WideRecord::new(p),
            ln_p: finite(p.ln()),
            weight: definition.weight(&densities, i),
            f_over_p: f.and_then(|f| plain(f.map(|channel| channel / p))),
        })
    };
    definition.samplers.iter().enumerate().filter_map(record).collect()
}

fn vertices(scene: &Scene, rules: Option<WalkRules>, path: &Path) -> Vec<VertexRecord> {
    let k = path.edges();
    let densities = |side, roulette| scene.vertex_densities(path, side, roulette);
    let from_emitter = densities(Side::Emitter, rules.map_or(Roulette::Off, |rules| rules.emitter));
    let from_sensor = densities(Side::Sensor, rules.map_or(Roulette::Off, |rules| rules.sensor));
    let (direct_emitter, direct_sensor) = scene.direct_densities(path);
    let record = |density: VertexDensity| DensityRecord::new(density, rules.is_some());
    let vertex = |(i, vertex): (usize, &Vertex)| VertexRecord {
        position: (vertex.position + scene.centre()).to_array(),
        local: vertex.position.to_array(),
        normal: (vertex.normal != glam::DVec3::ZERO).then(|| vertex.normal.to_array()),
        shading_normal: (vertex.shading_normal != vertex.normal).then(|| vertex.shading_normal.to_array()),
        letter: scene.letter(path, i),
        kind: vertex.kind.name().to_owned(),
        dirac: path.is_dirac(i),
        zeta: if let VertexKind::Sensor { zeta, .. } = vertex.kind { Some(zeta) } else { None },
        material: match vertex.kind {
            VertexKind::Surface { material, .. } => {
                Some(NamedId { id: material.0, name: scene.material_name(material).to_owned() })
            }
            _ => None,
        },
        emitter: vertex.emitter().map(|id| NamedId { id: id.0, name: scene.emitter_name(id).to_owned() }),
        from_emitter: from_emitter[i].map(record),
        from_sensor: from_sensor[i].map(record),
        direct: match i {
            0 => direct_emitter.map(record),
            _ if i == k => direct_sensor.map(record),
            _ => None,
        },
    };
    path.vertices().iter().enumerate().map(vertex).collect()
}

impl WideRecord {
    fn new(number: Wide) -> Option<Self> {
        let (mantissa, exponent) = number.parts();
        mantissa.is_finite().then_some(Self { mantissa, exponent })
    }
}

impl DensityRecord {
    fn new(density: VertexDensity, rules_known: bool) -> Self {
        Self {
            solid_angle: value(density.solid_angle),
            projected_solid_angle: value(density.projected_solid_angle),
            area: value(density.area),
            dirac: density.dirac.map(|dirac| match dirac {
                DiracDensity::Area(d) => DiracRecord::Area(d.value()),
                DiracDensity::SolidAngle(d) => DiracRecord::SolidAngle(d.value()),
                DiracDensity::ProjectedSolidAngle(d) => DiracRecord::ProjectedSolidAngle(d.value()),
            }),
            survival: rules_known.then_some(density.survival),
        }
    }
}

fn value<M>(density: Option<Density<M>>) -> Option<f64> {
    density.map(Density::value).and_then(finite)
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// All channels as plain numbers, or nothing.
fn plain([r, g, b]: [Wide; 3]) -> Option<[f64; 3]> {
    Some([r.to_normal()?, g.to_normal()?, b.to_normal()?])
}
