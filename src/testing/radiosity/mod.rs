//! An independent truth for diffuse scenes: the radiosity equation, solved without random numbers.
//!
//! On surfaces that scatter by Lambert's law radiance does not depend on direction, and with the radiosity `B = π L`
//! the rendering equation becomes `B(x) = E(x) + ρ(x) ∫ B(y) cos θ_x cos θ_y / (π r²) V(x,y) dA(y)` (Goral et al. 1984).
//! [`FormFactors`] divide the surfaces into patches, [`Solution`] solves the linear system that follows, and
//! [`Extrapolation`] does both for two sizes of patches and tells its own error. Nothing here shares code with samplers;
//! what it has in common with the integrators is the scene's triangles, and for images whether the camera sees a point.
//!
//! - Form factors of unobstructed pairs are exact to about 10⁻⁸. What triangles hide from a point is cut out exactly; what
//!   they hide of a pair is the mean over points of the smaller patch.
//! - Radiosity is constant on each patch (Galerkin). Means over meshes, and what is gathered at points from all patches,
//!   are of second order in the patches' size; of first order only where radiosity jumps within a patch, as below a block
//!   that stands on the floor.
//! - Time and memory grow with the square of the number of patches, and the direct solution with its third power: 1600
//!   patches take about 2 s on two cores. Obstacles that hide much make it several times slower.
//!
//! ```
//! use pathspace::scene::description::FilmSize;
//! use pathspace::spectrum::Rgb;
//! use pathspace::testing::radiosity::{Bounces, DiffuseScene, Extrapolation};
//! use pathspace::testing::scenes;
//!
//! let film = FilmSize { width: 16, height: 16 };
//! let scene = DiffuseScene::new(&scenes::enclosure(Rgb::WHITE, Rgb::grey(0.5), film))?;
//! let truth = Extrapolation::new(&scene, 2.0)?;
//! let block = truth.block_means(Bounces::Any)[0];
//! assert!((block.value.g - 2.0).abs() < 1e-5, "L = L_e / (1 − ρ)");
//! # Ok::<(), pathspace::testing::radiosity::RadiosityError>(())
//! ```

mod error;
mod exchange;
mod extrapolation;
mod form_factor;
mod image;
mod obstacle;
mod polygon;
mod quadrature;
mod scene;
mod solution;
#[cfg(test)]
mod tests;

pub use error::RadiosityError;
pub use exchange::{FormFactors, Patch};
pub use extrapolation::{Estimate, Extrapolation};
pub use form_factor::{form_factor, point_form_factor};
pub use scene::{DiffuseScene, Facet, FacetPoint};
pub use solution::{Bounces, Solution};
