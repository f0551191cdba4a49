//! Materials as surfaces carry them.

use super::bsdf::{Bsdf, Composite};

/// How a surface scatters, and on which sides.
#[derive(Clone, Debug)]
pub(super) struct SurfaceMaterial {
    pub(super) scattering: Scattering,
    /// A uniform model, for which the back is as the front.
    pub(super) two_sided: bool,
    /// Light passes through.
    pub(super) transmits: bool,
}

/// What scatters.
#[derive(Clone, Debug)]
pub(super) enum Scattering {
    /// The same model everywhere.
    Uniform(Bsdf),
    /// A model that depends on the point, or is made of others.
    Varying(Box<Composite>),
}

impl SurfaceMaterial {
    pub(super) fn new(model: Composite, two_sided: bool) -> Self {
        let transmits = model.transmits();
        match model.into_uniform() {
            Ok(bsdf) => Self { scattering: Scattering::Uniform(bsdf), two_sided: two_sided && !transmits, transmits },
            Err(model) => {
                let model = if two_sided { model.two_sided() } else { model };
                Self { scattering: Scattering::Varying(Box::new(model)), two_sided: false, transmits }
            }
        }
    }

    /// It depends on the point of the surface.
    pub(super) fn varies(&self) -> bool {
        matches!(self.scattering, Scattering::Varying(_))
    }
}

impl Scattering {
    #[inline]
    pub(super) fn has_finite(&self) -> bool {
        match self {
            Self::Uniform(bsdf) => bsdf.has_finite(),
            Self::Varying(model) => model.has_finite(),
        }
    }

    pub(super) fn has_dirac(&self) -> bool {
        match self {
            Self::Uniform(bsdf) => bsdf.has_dirac(),
            Self::Varying(model) => model.has_dirac(),
        }
    }

    pub(super) fn is_glossy(&self) -> bool {
        match self {
            Self::Uniform(bsdf) => bsdf.is_glossy(),
            Self::Varying(model) => model.is_glossy(),
        }
    }
}
