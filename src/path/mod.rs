//! Light paths and the two functions that everything here is about: the measurement contribution f(x̄) and the densities
//! p_{s,t}(x̄). Both are pure functions of a path, whoever drew it: they are the *definition* that fast integrators are
//! tested against.
//!
//! A path is x̄ = x_0 … x_k, from an emitter to the sensor. `I_j = ∫ f_j dμ` with `dμ(x̄) = ∏ dA(x_i)` (Veach 1997, §8.2).

mod contribution;
mod density;
mod expression;
mod light_path;
mod notation;
mod roulette;
mod vertex;
mod vertex_density;

pub use contribution::Contribution;
pub use density::{Step, WalkRules};
pub use expression::{ExpressionError, PathExpression};
pub use light_path::{Path, Technique};
pub use roulette::Roulette;
pub use vertex::{Edge, Vertex, VertexKind};
pub use vertex_density::{DiracDensity, VertexDensity};
