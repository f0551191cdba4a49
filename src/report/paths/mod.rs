//! The path log: what a sampler drew, path by path, with every density that is needed to think about it.
//!
//! # JSON lines, schema 1
//!
//! One line is one [`PathRecord`], a term of the estimator with its path; the fields are documented there and in the
//! types that it holds, and nowhere else. Conventions:
//!
//! - Numbers have as many digits as bring back the same bits. Densities and contributions of whole paths can be beyond
//!   every `f64`, so they are given by their natural logarithm, `ln_p` and `ln_f`.
//! - `null` is what is absent: the logarithm of zero, a plain number out of range, a density in a measure in which there is
//!   none. It is also what NaN and ∞ become, which no right contribution is.
//! - Lengths are in metres in the world. x_0 lies on an emitter, x_k on the sensor.
//!
//! # Recomputing the weight
//!
//! With the balance heuristic, over the techniques j of the integrator,
//!
//! `1 / weight = Σ_j n_j p_j / (n_i p_i) = Σ_j (n_j / n_i) exp(ln_p_j − ln_p_i)`.
//!
//! `contribution = weight · f / (n_i p_i)`, that is, `weight / n` times `f_over_p` of the path's own technique.
//!
//! # From vertices to p
//!
//! `p_{s,t} = ∏_{i<s} from_emitter(x_i) ∏_{i≥s} from_sensor(x_i)` in area measure. A Dirac coefficient c (`dirac`) enters
//! as c in area, `c |cos θ_i| / d²` in solid angle, and `c |cos θ_{i−1} cos θ_i| / d²` in projected solid angle, with x_{i−1}
//! the vertex before in the walk; the cosine is one at a point without a surface. With s = 1 the factor of x_0, and with
//! t = 1 that of x_k, is `direct` instead; s = t = 1 draws the end that has a position of its own first and the other for it.
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
//! technique is good; weighted by MIS, targets are w f/p.

mod ply;
mod record;
mod table;

pub use ply::PlyWriter;
pub use record::{DensityRecord, DiracRecord, NamedId, PathRecord, RouletteRecord, TechniqueRecord, VertexRecord};
pub use record::{Origin, SCHEMA};
pub use table::PathTable;
