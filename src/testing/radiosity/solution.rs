//! The radiosity equation on patches, solved directly and bounce by bounce.

use std::f64::consts::PI;

use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;

use crate::spectrum::Rgb;

use super::error::RadiosityError;
use super::exchange::FormFactors;
use super::scene::{Facet, FacetPoint};

/// Above so many times the emission, errors of the form factors decide about the radiosity.
const MOST_AMPLIFICATION: f64 = 1e6;

/// Which part of the light, by the number of reflections on its way. A path of n reflections that ends at a camera has
/// n + 1 edges: `--max-length K` is `AtMost(K − 1)`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bounces {
    /// All of it: `B = (I − ρF)⁻¹ E`.
    Any,
    /// One term of the Neumann series: `B_0 = E`, `B_{n+1} = ρ F B_n`.
    Exactly(u32),
    /// Its partial sum `B_0 + … + B_n`.
    AtMost(u32),
}

/// Radiosity that is constant on each patch.
#[derive(Debug)]
pub struct Solution<'a> {
    factors: FormFactors<'a>,
    equilibrium: Vec<Rgb>,
}

impl<'a> Solution<'a> {
    /// Solves `(I − ρF) B = E` for each channel.
    ///
    /// # Errors
    /// Where reflectances are such that light does not die out.
    pub fn new(factors: FormFactors<'a>) -> Result<Self, RadiosityError> {
        let solve = |channel: usize| solve_channel(&factors, channel).ok_or(RadiosityError::NoEquilibrium);
        let channels: Vec<DVector<f64>> = (0..3).into_par_iter().map(solve).collect::<Result<_, RadiosityError>>()?;
        let patch = |i: usize| Rgb::new(channels[0][i], channels[1][i], channels[2][i]);
        let equilibrium = (0..factors.patches().len()).map(patch).collect();
        Ok(Self { factors, equilibrium })
    }

    /// The patches and their form factors.
    #[must_use]
    pub fn factors(&self) -> &FormFactors<'a> {
        &self.factors
    }

    /// Radiosity of each patch \[W/m²\].
    #[must_use]
    pub fn radiosity(&self, bounces: Bounces) -> Vec<Rgb> {
        let mut term = self.of_facets(|facet| facet.emission);
        match bounces {
            Bounces::Any => self.equilibrium.clone(),
            Bounces::Exactly(n) => {
                for _ in 0..n {
                    term = self.reflected(&term);
                }
                term
            }
            Bounces::AtMost(n) => {
                let mut sum = term.clone();
                for _ in 0..n {
                    term = self.reflected(&term);
                    sum.iter_mut().zip(&term).for_each(|(sum, &term)| *sum += term);
                }
                sum
            }
        }
    }

    /// The radiosity that surfaces need to have for the light to arrive that has then gone through `bounces`.
    fn before_last(&self, bounces: Bounces) -> Vec<Rgb> {
        match bounces {
            Bounces::Any => self.equilibrium.clone(),
            Bounces::Exactly(0) | Bounces::AtMost(0) => vec![Rgb::BLACK; self.equilibrium.len()],
            Bounces::Exactly(n) => self.radiosity(Bounces::Exactly(n - 1)),
            Bounces::AtMost(n) => self.radiosity(Bounces::AtMost(n - 1)),
        }
    }

    /// `ρ F B`.
    fn reflected(&self, radiosity: &[Rgb]) -> Vec<Rgb> {
        let channel = |c: usize| {
            let b = DVector::from_iterator(radiosity.len(), radiosity.iter().map(|b| b.to_array()[c]));
            self.factors.exchange() * b
        };
        let [r, g, b] = [channel(0), channel(1), channel(2)];
        let reflectance = self.of_facets(|facet| facet.reflectance);
        let patches = self.factors.patches().iter().zip(reflectance).enumerate();
        patches.map(|(i, (patch, reflectance))| reflectance * Rgb::new(r[i], g[i], b[i]) / patch.area).collect()
    }

    fn of_facets(&self, value: impl Fn(&Facet) -> Rgb) -> Vec<Rgb> {
        let facets = self.factors.scene().facets();
        self.factors.patches().iter().map(|patch| value(&facets[patch.facet])).collect()
    }

    /// Mean radiosity of a mesh \[W/m²\], by its index in the description; both sides of a two-sided one.
    #[must_use]
    pub fn mesh_radiosity(&self, mesh: usize, bounces: Bounces) -> Rgb {
        let facets = self.factors.scene().facets();
        let patches = self.factors.patches().iter().zip(self.radiosity(bounces));
        let (mut flux, mut area) = (Rgb::BLACK, 0.0);
        for (patch, radiosity) in patches.filter(|(patch, _)| facets[patch.facet].mesh == mesh) {
            flux += radiosity * patch.area;
            area += patch.area;
        }
        if area > 0.0 { flux / area } else { Rgb::BLACK }
    }

    /// Irradiance at points \[W/m²\], by point: the sum over patches of point-to-patch form factor and radiosity,
    /// whose error is of second order in the patches' size (the iterated solution, Sloan 1976).
    #[must_use]
    pub fn irradiance(&self, points: &[FacetPoint], bounces: Bounces) -> Vec<Rgb> {
        self.gather(points, &self.before_last(bounces))
    }

    /// Radiance that leaves points towards anywhere in front of them \[W/m²/sr\], by point: `L_e + ρ X / π` with the
    /// irradiance X.
    #[must_use]
    pub fn radiance(&self, points: &[FacetPoint], bounces: Bounces) -> Vec<Rgb> {
        let facets = self.factors.scene().facets();
        let emits = !matches!(bounces, Bounces::Exactly(1..));
        let irradiance = self.irradiance(points, bounces);
        let radiosity = points.iter().zip(irradiance).map(|(x, irradiance)| {
            let facet = &facets[x.facet];
            let emission = if emits { facet.emission } else { Rgb::BLACK };
            emission + facet.reflectance * irradiance
        });
        radiosity.map(|radiosity| radiosity / PI).collect()
    }

    fn gather(&self, points: &[FacetPoint], radiosity: &[Rgb]) -> Vec<Rgb> {
        let irradiance = |&x: &FacetPoint| {
            let factors = self.factors.of_point(x);
            factors.iter().zip(radiosity).map(|(&factor, &radiosity)| radiosity * factor).sum()
        };
        points.par_iter().map(irradiance).collect()
    }
}

/// `B = E + √(ρ/A) w` with `(I − S) w = √(ρ/A) A F E` and `S = √(ρ/A) (A F) √(ρ/A)`: the same equation, symmetric and
/// positive definite, also where ρ = 0. `None` where it is not, because light does not die out.
fn solve_channel(factors: &FormFactors<'_>, channel: usize) -> Option<DVector<f64>> {
    let facets = factors.scene().facets();
    let patches = factors.patches();
    let n = patches.len();
    let of = |value: fn(&Facet) -> Rgb, i: usize| value(&facets[patches[i].facet]).to_array()[channel];
    let emission = DVector::from_fn(n, |i, _| of(|f| f.emission, i));
    let scale = DVector::from_fn(n, |i, _| (of(|f| f.reflectance, i) / patches[i].area).sqrt());
    let exchange = factors.exchange();
    let matrix = DMatrix::from_fn(n, n, |i, j| {
        let identity = if i == j { 1.0 } else { 0.0 };
        identity - scale[i] * exchange[(i, j)] * scale[j]
    });
    let right = scale.component_mul(&(exchange * &emission));
    let scattered = Cholesky::new(matrix)?.solve(&right);
    let largest = MOST_AMPLIFICATION * emission.amax();
    let radiosity = emission + scale.component_mul(&scattered);
    (radiosity.amax() <= largest).then_some(radiosity)
}
