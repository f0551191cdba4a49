//! Measures as types: a density knows what it is a density of.
//!
//! A density with respect to solid angle and one with respect to area are different quantities, related by a
//! [`Jacobian`]. Adding or dividing them by mistake does not compile:
//!
//! ```compile_fail
//! use pathspace::measure::{Area, Density, SolidAngle};
//! let directional = Density::<SolidAngle>::new(0.3);
//! let by_area = Density::<Area>::new(0.2);
//! let wrong = directional / by_area;
//! ```
//!
//! ```
//! use pathspace::measure::{Area, Density, Jacobian, SolidAngle};
//! let directional = Density::<SolidAngle>::new(0.3);
//! let by_area: Density<Area> = directional * Jacobian::solid_angle_to_area(0.5, 4.0);
//! assert_eq!(by_area.value(), 0.3 * 0.5 / 4.0);
//! ```

use std::marker::PhantomData;
use std::ops::{Div, Mul};

/// Surface area, `dA(x)` \[m²\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area;

/// Solid angle, `dσ(ω)` \[sr\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolidAngle;

/// Projected solid angle, `dσ⊥(ω) = |cos θ| dσ(ω)` \[sr\], with the cosine of the geometric normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProjectedSolidAngle;

/// Counting measure: a probability mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Discrete;

/// The value of a probability density with respect to the measure `M`, in the reciprocal of its unit.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Density<M> {
    value: f64,
    measure: PhantomData<M>,
}

/// A probability, that is, a density with respect to the counting measure.
pub type Probability = Density<Discrete>;

impl<M> Density<M> {
    /// The density zero: this technique never draws the sample in question.
    pub const ZERO: Self = Self::new(0.0);

    /// Declares `value` to be a density with respect to `M`.
    #[must_use]
    pub const fn new(value: f64) -> Self {
        Self { value, measure: PhantomData }
    }

    /// The bare number, in the reciprocal unit of `M`.
    #[must_use]
    pub const fn value(self) -> f64 {
        self.value
    }
}

/// Multiplying by a probability or a count keeps the measure.
impl<M> Mul<f64> for Density<M> {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self::new(self.value * factor)
    }
}

/// A choice made first, with the given probability, keeps the measure of what is drawn after it.
impl<M> Mul<Density<M>> for f64 {
    type Output = Density<M>;
    fn mul(self, density: Density<M>) -> Density<M> {
        density * self
    }
}

/// The ratio of two densities of the same measure is a plain number, as MIS weights need it.
impl<M> Div for Density<M> {
    type Output = f64;
    fn div(self, other: Self) -> f64 {
        self.value / other.value
    }
}

/// `dFrom / dTo`: the factor that turns a density with respect to `From` into one with respect to `To`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jacobian<From, To> {
    factor: f64,
    measures: PhantomData<(From, To)>,
}

impl<From, To> Jacobian<From, To> {
    const fn new(factor: f64) -> Self {
        Self { factor, measures: PhantomData }
    }

    /// The bare factor.
    #[must_use]
    pub const fn value(self) -> f64 {
        self.factor
    }
}

impl Jacobian<SolidAngle, Area> {
    /// `dσ_x / dA(y) = |cos θ_y| / ‖x−y‖²` (Veach 1997, §8.2).
    #[must_use]
    pub fn solid_angle_to_area(abs_cos_y: f64, distance_squared: f64) -> Self {
        Self::new(abs_cos_y / distance_squared)
    }
}

impl Jacobian<Area, SolidAngle> {
    /// `dA(y) / dσ_x = ‖x−y‖² / |cos θ_y|`.
    #[must_use]
    pub fn area_to_solid_angle(abs_cos_y: f64, distance_squared: f64) -> Self {
        Self::new(distance_squared / abs_cos_y)
    }
}

impl Jacobian<ProjectedSolidAngle, Area> {
    /// `dσ⊥_x / dA(y) = |cos θ_x cos θ_y| / ‖x−y‖²`, the geometry factor without its visibility.
    #[must_use]
    pub fn projected_to_area(abs_cos_x: f64, abs_cos_y: f64, distance_squared: f64) -> Self {
        Self::new(abs_cos_x * abs_cos_y / distance_squared)
    }
}

impl Jacobian<ProjectedSolidAngle, SolidAngle> {
    /// `dσ⊥ / dσ = |cos θ|`.
    #[must_use]
    pub fn projected_to_solid_angle(abs_cos: f64) -> Self {
        Self::new(abs_cos)
    }
}

impl Jacobian<SolidAngle, ProjectedSolidAngle> {
    /// `dσ / dσ⊥ = 1 / |cos θ|`.
    #[must_use]
    pub fn solid_angle_to_projected(abs_cos: f64) -> Self {
        Self::new(1.0 / abs_cos)
    }
}

impl<From, To> Mul<Jacobian<From, To>> for Density<From> {
    type Output = Density<To>;
    fn mul(self, jacobian: Jacobian<From, To>) -> Density<To> {
        Density::new(self.value * jacobian.factor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conversions_compose() {
        let solid_angle = Density::<SolidAngle>::new(2.0);
        let direct = solid_angle * Jacobian::solid_angle_to_area(0.25, 8.0);
        let by_projection = solid_angle
            * Jacobian::solid_angle_to_projected(0.5)
            * Jacobian::<ProjectedSolidAngle, Area>::projected_to_area(0.5, 0.25, 8.0);
        assert_eq!(direct, by_projection);
    }
}
