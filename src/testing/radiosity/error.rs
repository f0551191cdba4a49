//! What the solver refuses, each told in one line with place and remedy.

use thiserror::Error;

use crate::scene::BuildError;

/// Why there is no radiosity solution of a scene.
#[derive(Debug, Error)]
pub enum RadiosityError {
    /// A sphere.
    #[error("sphere '{0}': radiosity knows flat surfaces only; leave it out or make it a triangle mesh")]
    Sphere(String),
    /// A light without a surface.
    #[error("light '{0}': radiosity knows emitting surfaces only; leave it out or give a mesh an emission")]
    Light(String),
    /// An environment.
    #[error("environment: radiosity knows emitting surfaces only; leave it out or enclose the scene in emitting walls")]
    Environment,
    /// A surface that is not Lambertian.
    #[error("material '{0}': radiosity knows diffuse surfaces only; make it diffuse")]
    NotDiffuse(String),
    /// A mesh with interpolated normals.
    #[error("mesh '{0}': radiosity knows flat shading only; leave out its vertex normals")]
    ShadingNormals(String),
    /// A thin lens, or a meter.
    #[error("camera '{0}': images are averaged behind pinholes and orthographic films only; choose one without a lens")]
    Lens(String),
    /// A crop, a shifted image, or a wide filter.
    #[error(
        "camera '{0}': images are averaged over whole films with a box filter only; take the crop and the filter away"
    )]
    Film(String),
    /// The patches' size is no length.
    #[error("patch edge of {0} m: give a positive finite length")]
    PatchEdge(f64),
    /// A dense matrix of that size does not fit.
    #[error("{patches} patches are more than {most}: give a longer patch edge")]
    TooManyPatches {
        /// How many there would be.
        patches: usize,
        /// How many there may be.
        most: usize,
    },
    /// Light does not die out.
    #[error("the light of the scene has no finite equilibrium: all reflectances must be below 1 in closed scenes")]
    NoEquilibrium,
    /// It is no scene at all.
    #[error(transparent)]
    Scene(#[from] BuildError),
}
