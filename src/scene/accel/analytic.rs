//! Analytic shapes: what rays ask of them, whatever they are.

use glam::DVec3;

use crate::geometry::{Bounds, Ray};
use crate::warp;

use super::{CylinderShape, DiskShape, SphereShape};

/// A shape that is no triangle. The larger kinds are boxed: scenes of many spheres keep them close together.
#[derive(Clone, Debug, PartialEq)]
pub enum AnalyticShape {
    /// A sphere.
    Sphere(SphereShape),
    /// A disk or an ellipse.
    Disk(Box<DiskShape>),
    /// A cylinder without its ends.
    Cylinder(Box<CylinderShape>),
}

/// A point of a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapePoint {
    /// Where it is \[m\].
    pub position: DVec3,
    /// Unit normal towards the front.
    pub normal: DVec3,
}

impl AnalyticShape {
    /// The number of the scene's shape that it is.
    #[must_use]
    #[inline]
    pub fn shape(&self) -> u32 {
        match self {
            Self::Sphere(sphere) => sphere.shape,
            Self::Disk(disk) => disk.shape(),
            Self::Cylinder(cylinder) => cylinder.shape(),
        }
    }

    /// The smallest box around it.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        match self {
            Self::Sphere(sphere) => sphere.bounds(),
            Self::Disk(disk) => disk.bounds(),
            Self::Cylinder(cylinder) => cylinder.bounds(),
        }
    }

    /// Its area \[m²\].
    #[must_use]
    pub fn area(&self) -> f64 {
        match self {
            Self::Sphere(sphere) => sphere.area(),
            Self::Disk(disk) => disk.area(),
            Self::Cylinder(cylinder) => cylinder.area(),
        }
    }

    /// The nearest distance at which a ray meets it. With `starts_here` the origin lies on the shape and is no hit; what is
    /// curved may be met again on its other side.
    #[must_use]
    #[inline]
    pub fn intersect(&self, ray: &Ray, starts_here: bool) -> Option<f64> {
        match self {
            Self::Sphere(sphere) => sphere.intersect(ray, starts_here),
            Self::Disk(disk) => disk.intersect(ray).filter(|_| !starts_here),
            Self::Cylinder(cylinder) => cylinder.intersect(ray, starts_here),
        }
    }

    /// It blocks a segment of the given length, whose ends may lie on it.
    #[must_use]
    #[inline]
    pub fn blocks(&self, ray: &Ray, length: f64, starts_here: bool, ends_here: bool) -> bool {
        match self {
            Self::Sphere(sphere) => sphere.blocks(ray, length, starts_here, ends_here),
            Self::Disk(disk) => !starts_here && !ends_here && disk.intersect(ray).is_some_and(|t| t < length),
            Self::Cylinder(cylinder) => cylinder.blocks(ray, length, starts_here, ends_here),
        }
    }

    /// The point of the shape next to one that rounding has moved off it.
    #[must_use]
    #[inline]
    pub fn nearest(&self, point: DVec3) -> ShapePoint {
        match self {
            Self::Sphere(sphere) => sphere.nearest(point),
            Self::Disk(disk) => disk.nearest(point),
            Self::Cylinder(cylinder) => cylinder.nearest(point),
        }
    }

    /// A point of it, uniform by area; `u` is uniform in `[0, 1)²`.
    #[must_use]
    pub fn sample(&self, u: [f64; 2]) -> ShapePoint {
        match self {
            Self::Sphere(sphere) => sphere.along(warp::uniform_sphere(u)),
            Self::Disk(disk) => disk.at(warp::concentric_disk(u)),
            Self::Cylinder(cylinder) => cylinder.at(u),
        }
    }
}
