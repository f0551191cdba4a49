//! A reference as it lies in the cache.

use std::path::Path;

use crate::film::exr::{NamedLayer, write_exr};
use crate::film::{Film, Image, RenderInfo, state};
use crate::report::{Agreement, AgreementSettings, Reference};

use super::by_mitsuba::PASS_SPP;
use crate::experiment::error::ExperimentError;
use crate::experiment::method::{Method, MethodKind};

/// The setting that says how many samples per pixel a pass of the film has, where that is not one.
const PASS: &str = "pass_spp";

/// A reference that is kept.
#[derive(Debug)]
pub struct Kept {
    /// Its method, as the user wrote it.
    pub method: String,
    /// Its film.
    pub film: Film,
    /// What made it.
    pub info: RenderInfo,
}

/// All that a method's image depends on.
pub(super) fn settings(method: &Method) -> serde_json::Value {
    let mut settings = serde_json::json!(method.settings);
    if let MethodKind::Mitsuba(_) = method.kind {
        settings[PASS] = PASS_SPP.to_string().into();
    }
    settings
}

impl Kept {
    pub(super) fn read(file: &Path) -> Result<Self, ExperimentError> {
        let (film, info) = state::load(file)?;
        Ok(Self { method: info.integrator.clone(), film, info })
    }

    /// It was rendered as `method` would go on.
    pub(super) fn check(self, file: &Path, method: &Method) -> Result<Self, ExperimentError> {
        if self.info.settings == settings(method) {
            return Ok(self);
        }
        let what = format!("{}: was rendered with other settings; remove it", file.display());
        Err(ExperimentError::Scene(what))
    }

    /// From now on this version takes part.
    pub(super) fn made_by(&mut self, renderer: &str) {
        let version = &mut self.info.version;
        if version.is_empty() {
            renderer.clone_into(version);
        } else if !version.split("; ").any(|known| known == renderer) {
            *version = format!("{version}; {renderer}");
        }
    }

    /// With the variance of its pixels.
    #[must_use]
    pub fn reference(&self) -> Reference {
        let square = |error: Image| Image { pixels: error.pixels.iter().map(|&e| e * e).collect(), ..error };
        Reference { mean: self.film.mean_image(), variance: self.film.standard_error_image().map(square) }
    }

    /// Samples per pixel.
    #[must_use]
    pub fn spp(&self) -> u64 {
        spp(&self.film, &self.info)
    }

    /// What it is, in words.
    #[must_use]
    pub fn words(&self) -> String {
        format!("{}, {} spp in {:.0} s", self.method, self.spp(), self.info.render_seconds)
    }

    /// Root mean square of its pixels' standard errors over the mean of the image; `None` below two passes, and where it is black
    /// or not finite.
    #[must_use]
    pub fn noise(&self) -> Option<f64> {
        noise(&self.film)
    }

    /// Writes it as `read_reference` reads it: the mean, the standard error of each pixel, and how it was made.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, file: &Path) -> Result<(), ExperimentError> {
        let error = self.film.standard_error_image();
        let error = error.map(|image| NamedLayer { name: "standard_error".into(), image });
        Ok(write_exr(file, &self.film.mean_image(), error, &self.info, self.spp(), &[])?)
    }
}

pub(super) fn spp(film: &Film, info: &RenderInfo) -> u64 {
    let of_a_pass = info.settings.get(PASS).and_then(|spp| spp.as_str()?.parse().ok());
    film.passes() * of_a_pass.unwrap_or(1)
}

/// See [`Kept::noise`].
pub(super) fn noise(film: &Film) -> Option<f64> {
    let error = film.standard_error_image()?;
    let values = |image: &Image| image.pixels.iter().flat_map(|pixel| pixel.to_array()).collect::<Vec<_>>();
    let (errors, means) = (values(&error), values(&film.mean_image()));
    let count = errors.len() as f64;
    let square = errors.iter().map(|error| error * error).sum::<f64>() / count;
    let noise = square.sqrt() / (means.iter().sum::<f64>() / count);
    noise.is_finite().then_some(noise)
}

/// Whether two references of a scene are of the same image; `None` where one has too few passes to say.
///
/// # Errors
/// Where they are of different sizes.
pub fn compare(a: &Kept, b: &Kept) -> Result<Option<Agreement>, ExperimentError> {
    let settings = AgreementSettings::default();
    if a.film.passes().min(b.film.passes()) < settings.smallest_passes {
        return Ok(None);
    }
    let both = (a.film.block_statistics(), b.film.block_statistics());
    Ok(Some(Agreement::test_with(both, both, &settings)?))
}
