//! Two subdivisions, and what they tell about the error.

use crate::spectrum::Rgb;

use super::error::RadiosityError;
use super::exchange::FormFactors;
use super::image::{SeenPoint, View};
use super::scene::{DiffuseScene, FacetPoint};
use super::solution::{Bounces, Solution};

/// A value and how far it may be off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Richardson's extrapolation `fine + (fine − coarse) / 3`, in the unit of the quantity.
    pub value: Rgb,
    /// `⅔ |fine − coarse|` per channel: how far the extrapolated value is off if the error falls only in proportion to the
    /// patches' size, as where a shadow has a sharp edge. Where it falls with the square, a bound with much to spare.
    /// Not a standard deviation.
    pub error: Rgb,
}

impl Estimate {
    fn new(coarse: Rgb, fine: Rgb) -> Self {
        let correction = (fine - coarse) / 3.0;
        Self { value: fine + correction, error: correction.map(|c| 2.0 * c.abs()) }
    }
}

/// The solution with patches of two sizes, one half of the other, extrapolated to none (Richardson 1911).
#[derive(Debug)]
pub struct Extrapolation<'a> {
    coarse: Solution<'a>,
    fine: Solution<'a>,
}

impl<'a> Extrapolation<'a> {
    /// Solves with patches whose edges are at most `edge` \[m\], and with half of that.
    ///
    /// # Errors
    /// Where `edge` is no length or too short, or light does not die out.
    pub fn new(scene: &'a DiffuseScene, edge: f64) -> Result<Self, RadiosityError> {
        let solve = |refinement| Solution::new(FormFactors::new(scene, edge, refinement)?);
        Ok(Self { coarse: solve(1)?, fine: solve(2)? })
    }

    /// The coarser of the two.
    #[must_use]
    pub fn coarse(&self) -> &Solution<'a> {
        &self.coarse
    }

    /// The finer of the two.
    #[must_use]
    pub fn fine(&self) -> &Solution<'a> {
        &self.fine
    }

    /// Mean radiosity of a mesh \[W/m²\], by its index in the description; both sides of a two-sided one.
    #[must_use]
    pub fn mesh_radiosity(&self, mesh: usize, bounces: Bounces) -> Estimate {
        Estimate::new(self.coarse.mesh_radiosity(mesh, bounces), self.fine.mesh_radiosity(mesh, bounces))
    }

    /// Irradiance at points \[W/m²\], by point.
    #[must_use]
    pub fn irradiance(&self, points: &[FacetPoint], bounces: Bounces) -> Vec<Estimate> {
        both(&self.coarse.irradiance(points, bounces), &self.fine.irradiance(points, bounces))
    }

    /// Radiance that leaves points towards anywhere in front of them \[W/m²/sr\], by point.
    #[must_use]
    pub fn radiance(&self, points: &[FacetPoint], bounces: Bounces) -> Vec<Estimate> {
        both(&self.coarse.radiance(points, bounces), &self.fine.radiance(points, bounces))
    }

    /// Mean radiance of each block of [`BlockGrid`](crate::film::BlockGrid) in the camera's image \[W/m²/sr\], row by row
    /// of blocks. The finer solution is integrated over the image more finely too, so that the error is that of both.
    #[must_use]
    pub fn block_means(&self, bounces: Bounces) -> Vec<Estimate> {
        both(&block_means(&self.coarse, bounces, 0), &block_means(&self.fine, bounces, 1))
    }
}

fn both(coarse: &[Rgb], fine: &[Rgb]) -> Vec<Estimate> {
    coarse.iter().zip(fine).map(|(&coarse, &fine)| Estimate::new(coarse, fine)).collect()
}

fn block_means(solution: &Solution<'_>, bounces: Bounces, divisions: u32) -> Vec<Rgb> {
    let scene = solution.factors().scene();
    let view = View::of(scene);
    let blocks: Vec<_> = view.blocks().into_iter().map(|block| view.points(scene, block, divisions)).collect();
    let points: Vec<FacetPoint> = blocks.iter().flatten().map(|seen| seen.point).collect();
    let mut radiance = solution.radiance(&points, bounces).into_iter();
    let mean = |block: &Vec<SeenPoint>| {
        block.iter().zip(radiance.by_ref()).map(|(seen, radiance)| radiance * seen.weight).sum()
    };
    blocks.iter().map(mean).collect()
}
