//! The path log: what a sampler drew, path by path, with every density that is needed to think about it.
//!
//! # JSON lines, schema 4
//!
//! One line is one [`PathRecord`], a term of the estimator with its path; the fields are documented there and in the
//! types that it holds, and nowhere else. Conventions:
//!
//! - Numbers have as many digits as bring back the same bits. Densities and contributions of whole paths can be beyond
//!   every `f64`, so they are given by their natural logarithm, `ln_p` and `ln_f`, and densities as `mantissa · 2^exponent`
//!   too, `p`, without rounding.
//! - `null` is what is absent: the logarithm of zero, a plain number out of range, a density in a measure in which there is
//!   none. It is also what NaN and ∞ become, which no right contribution is.
//! - Lengths are in metres in the world. x_0 lies on an emitter, x_k on the sensor.
//!
//! Schema 2 added `sampler` of the line, and `length_probability` and `p` of its `techniques`; schema 3 `zeta` of the
//! vertices; schema 4 `local` and `shading_normal` of the vertices and `weight` of the `techniques`.
//!
//! # Recomputing weight and contribution
//!
//! Let i be the sampler that drew the path, the one of `techniques` with the line's `sampler` (s and t do not tell: several
//! samplers may have the same). With `r_j = n_j p_j / (n_i p_i)` for all samplers j of `techniques`, in that order, so that
//! `r_i = 1`, and with the line's `heuristic`,
//!
//! | kind | weight |
//! |---|---|
//! | `balance` | `1 / Σ_j r_j` |
//! | `power` | `1 / Σ_j r_j^exponent` |
//! | `maximum` | 1 where `r_j < 1` for j before i and `r_j ≤ 1` for j after it, else 0 |
//! | `cutoff` | 1 over the sum of the `r_j ≥ threshold · max r`, 0 where r_i is not among them |
//!
//! Samplers that are missing have `r_j = 0`. Maximum and cutoff compare densities that may well be equal, as those of one
//! direction by cosine and by a diffuse BSDF are: hence the digits of `p`. Rounded logarithms can be equal where densities
//! are not.
//!
//! `contribution = weight · f / (n_i p_i P)`, that is, `weight / (n_i P)` times `f_over_p` of sampler i (exp(ln_f − ln_p)
//! where a number is out of range). P is its `length_probability`: P(N = k) where a single length N is drawn in advance
//! (`terms=single`), P(N ≥ k) where all up to N are estimated (`terms=up_to`), else one. It is the same for all samplers of
//! a combination, so weights are free of it.
//!
//! An integrator whose weights depend on more than densities, such as optimal weights, has no `techniques` in its lines.
//!
//! # From vertices to p
//!
//! `p_{s,t} = ∏_{i<s} from_emitter(x_i) ∏_{i≥s} from_sensor(x_i)` in area measure. A Dirac coefficient c (`dirac`) enters
//! as c in area, `c |cos θ_i| / d²` in solid angle, and `c |cos θ_{i−1} cos θ_i| / d²` in projected solid angle, with x_{i−1}
//! the vertex before in the walk; the cosine is one at a point without a surface. With s = 1 the factor of x_0, and with
//! t = 1 that of x_k, is `direct` instead; s = t = 1 draws the end that has a position of its own first and the other for it.
//!
//! # From vertices alone
//!
//! `local`, `normal` and `shading_normal` have the bits that f and p are evaluated with, and [`SceneRecord`] the parameters of
//! materials, emitters and sensor: together they are enough to evaluate f and all p anew, with any precision.
//! `python -m pathspace.stability.exact` does.
//!
//! # Primary sample space
//!
//! A sampler is a map x̄ = S(u) from the unit cube of its random numbers, which are uniform: there its density is *one*, in
//! whatever way it was built. Its density in path space is what the map does to volumes, `p(x̄) = 1 / |∂x̄/∂u|`, so the
//! measurement becomes
//!
//! `I = ∫ f(x̄) dμ(x̄) = ∫ f(S(u)) |∂x̄/∂u| du = ∫ f(S(u)) / p(S(u)) du`
//!
//! (Kelemen et al. 2002). The target there is f/p, and each technique has a cube and an S of its own: the same path has as
//! many targets as techniques can draw it, [`TechniqueRecord::f_over_p`], while f(x̄) is one. Where f/p is flat in u, a
//! technique is good; weighted by MIS, targets are w f/p. Where the length is drawn in advance, the cube has one more side, the
//! length's random number, and the target is f/p over P where that number gives the length and zero elsewhere.

mod ply;
mod record;
mod scene;
mod table;

pub use ply::PlyWriter;
pub use record::WideRecord;
pub use record::{DensityRecord, DiracRecord, NamedId, PathRecord, RouletteRecord, TechniqueRecord, VertexRecord};
pub use record::{Origin, SCHEMA};
pub use scene::{EmitterKind, EmitterRecord, MaterialRecord, ModelRecord, SCENE_SCHEMA, SceneRecord, SensorRecord};
pub use table::PathTable;
