//! What errors are measured against.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::Xxh3Default;

use crate::film::Image;
use crate::film::exr::read_layers;
use crate::report::Reference;
use crate::scene::description;
use crate::spectrum::Rgb;

use super::Subject;
use super::cache::{Cache, Until, Wanted};
use super::error::ExperimentError;
use super::plan::ScenePlan;

/// Where a reference comes from. Written as `scene`, `none`, the name of an EXR file, or
/// `{ method = "bdpt", seconds = 600 }`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written")]
pub enum ReferencePolicy {
    /// The scene names its own.
    #[default]
    Scene,
    /// There is none: no errors are measured.
    None,
    /// This EXR file, with the standard error in its layer `standard_error` if it has one; that it holds paths of the right
    /// lengths is up to the user.
    File(PathBuf),
    /// Rendered once and kept, see [`super::cache`].
    Rendered(RenderedReference),
}

/// A reference by a method of the registry or of Mitsuba.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RenderedReference {
    /// `name:key=value:…`, of the registry or of Mitsuba.
    pub method: String,
    /// Rendering time at least spent on it \[s\].
    pub seconds: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(untagged, expecting = "expected scene, none, an EXR file, or { method = \"bdpt\", seconds = 600 }")]
enum Written {
    Word(String),
    Rendered(RenderedReference),
}

impl std::str::FromStr for ReferencePolicy {
    type Err = std::convert::Infallible;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(match text {
            "scene" => Self::Scene,
            "none" => Self::None,
            file => Self::File(file.into()),
        })
    }
}

impl TryFrom<Written> for ReferencePolicy {
    type Error = String;

    fn try_from(written: Written) -> Result<Self, String> {
        match written {
            Written::Word(word) => word.parse().map_err(|error: std::convert::Infallible| match error {}),
            Written::Rendered(rendered) if rendered.seconds > 0.0 && rendered.seconds < 1e9 => {
                Ok(Self::Rendered(rendered))
            }
            Written::Rendered(rendered) => {
                Err(format!("reference: seconds = {}: expected a time in seconds above 0", rendered.seconds))
            }
        }
    }
}

impl From<ReferencePolicy> for Written {
    fn from(policy: ReferencePolicy) -> Self {
        match policy {
            ReferencePolicy::Scene => Self::Word("scene".into()),
            ReferencePolicy::None => Self::Word("none".into()),
            ReferencePolicy::File(file) => Self::Word(file.to_string_lossy().into_owned()),
            ReferencePolicy::Rendered(rendered) => Self::Rendered(rendered),
        }
    }
}

/// What the errors of a scene's images are measured against.
#[derive(Clone, Debug)]
pub(super) struct Truth {
    /// In words.
    pub words: String,
    /// The image.
    pub reference: Option<Reference>,
    /// It is known exactly, and the same in every pixel.
    pub exact: Option<Rgb>,
}

impl Truth {
    /// A number that changes with the image.
    pub fn fingerprint(&self) -> String {
        let Some(Reference { mean, variance }) = &self.reference else { return "none".into() };
        let mut hash = Xxh3Default::new();
        for image in [Some(mean), variance.as_ref()].into_iter().flatten() {
            for pixel in &image.pixels {
                pixel.to_array().iter().for_each(|x| hash.update(&x.to_le_bytes()));
            }
        }
        format!("{:016x}", hash.digest())
    }
}

const REMEDY: &str = "give one with --reference FILE.exr, or do without errors with --reference none";

/// The reference of a scene. Where it is to be rendered and is not there yet, `cache` renders it.
pub(super) fn resolve(
    subject: &Subject,
    plan: &ScenePlan,
    policy: &ReferencePolicy,
    cache: &mut Cache<'_>,
) -> Result<Truth, ExperimentError> {
    let scene = &subject.scene;
    let longest = plan.longest();
    let refuse = |what: String| ExperimentError::Scene(format!("{}: {what}", scene.source().display()));
    let film = scene.sensor().film();
    match (policy, scene.reference()) {
        (ReferencePolicy::None, _) => Ok(Truth { words: "none".into(), reference: None, exact: None }),
        (ReferencePolicy::File(file), _) => read(subject, file),
        (ReferencePolicy::Rendered(RenderedReference { method, seconds }), _) => {
            let wanted = Wanted { subject, plan, method, until: Until::Seconds(*seconds) };
            let (reference, words) = cache.reference(&wanted)?;
            Ok(Truth { words, reference: Some(reference), exact: None })
        }
        (ReferencePolicy::Scene, Some(description::Reference::Enclosure { emission, reflectance })) => {
            let exact = enclosure(*emission, *reflectance, longest);
            if !exact.is_finite() {
                return Err(refuse(format!("the enclosure has no finite radiance without a longest path; {REMEDY}")));
            }
            let constant = |value| Image::constant(film.width, film.height, value);
            let reference = Reference::exact(constant(exact)?);
            Ok(Truth {
                words: "exact: the enclosure's radiance".into(),
                reference: Some(reference),
                exact: Some(exact),
            })
        }
        (ReferencePolicy::Scene, Some(description::Reference::Image { file, max_length })) => {
            if *max_length != longest {
                let length = |length: &Option<u32>| length.map_or("none".into(), |edges: u32| edges.to_string());
                return Err(refuse(format!(
                    "its reference holds paths of --max-length {}, and the run is of {}; make them equal, or {REMEDY}",
                    length(max_length),
                    length(&longest)
                )));
            }
            read(subject, &scene.source().parent().unwrap_or(Path::new("")).join(file))
        }
        (ReferencePolicy::Scene, None) => Err(refuse(format!("it names no reference; {REMEDY}"))),
    }
}

fn read(subject: &Subject, file: &Path) -> Result<Truth, ExperimentError> {
    let film = subject.scene.sensor().film();
    let reference = read_reference(file)?;
    let image = &reference.mean;
    if (image.width, image.height) != (film.width, film.height) {
        return Err(ExperimentError::Scene(format!(
            "{}: the reference has {} × {} pixels and the image {} × {}; use --film {}x{}, or {REMEDY}",
            file.display(),
            image.width,
            image.height,
            film.width,
            film.height,
            image.width,
            image.height
        )));
    }
    Ok(Truth { words: file.display().to_string(), reference: Some(reference), exact: None })
}

/// A reference with its variance, where the file has it.
///
/// # Errors
/// Where it cannot be read, or holds no image or one that is not finite.
pub fn read_reference(file: &Path) -> Result<Reference, ExperimentError> {
    let failed = |error| ExperimentError::Scene(format!("reference: {error}; {REMEDY}"));
    let mut layers = read_layers(file, |name| ["", "standard_error"].contains(&name)).map_err(failed)?.layers;
    let refuse = |what: &str| ExperimentError::Scene(format!("{}: {what}; {REMEDY}", file.display()));
    let mean = layers.remove("").ok_or_else(|| refuse("holds no image of channels R, G, B"))?;
    if !mean.pixels.iter().all(|pixel| pixel.is_finite()) {
        return Err(refuse("the reference holds pixels that are not finite"));
    }
    let square = |image: Image| Image { pixels: image.pixels.iter().map(|&error| error * error).collect(), ..image };
    let variance = layers.remove("standard_error").map(square).filter(|v| v.pixels.iter().all(|p| p.is_finite()));
    Ok(Reference { mean, variance })
}

/// `emission Σ_{i<K} reflectance^i` for paths of at most K edges, `emission / (1 − reflectance)` without limit.
fn enclosure(emission: Rgb, reflectance: Rgb, longest: Option<u32>) -> Rgb {
    let sum = reflectance.map(|rho| match longest {
        Some(edges) if rho == 1.0 => f64::from(edges),
        Some(edges) => (1.0 - libm::pow(rho, f64::from(edges))) / (1.0 - rho),
        None => 1.0 / (1.0 - rho),
    });
    emission * sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_enclosure_is_the_partial_sum_of_its_series() {
        let (emission, rho) = (Rgb::new(0.25, 1.0, 2.0), Rgb::new(0.5, 0.0, 1.0));
        assert_eq!(enclosure(emission, rho, Some(1)), emission);
        let two = enclosure(emission, rho, Some(3));
        assert!((two.r - 0.25 * 1.75).abs() < 1e-15 && two.g == 1.0 && two.b == 6.0);
        assert_eq!(enclosure(emission, Rgb::grey(0.5), None), emission * 2.0);
    }
}
