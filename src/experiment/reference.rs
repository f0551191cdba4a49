//! What errors are measured against.

use std::path::{Path, PathBuf};

use crate::film::Image;
use crate::film::exr::read_exr;
use crate::scene::description::Reference;
use crate::spectrum::Rgb;

use super::Subject;
use super::error::ExperimentError;
use super::plan::ScenePlan;

/// Where references come from.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum ReferenceChoice {
    /// The scene names its own.
    #[default]
    Scene,
    /// This EXR file; that it holds paths of the right lengths is up to the user.
    File(PathBuf),
    /// There is none: no errors are measured.
    None,
}

/// What the errors of a scene's images are measured against.
#[derive(Clone, Debug)]
pub(super) struct Truth {
    /// In words.
    pub words: String,
    /// The image.
    pub image: Option<Image>,
    /// It is known exactly, and the same in every pixel.
    pub exact: Option<Rgb>,
}

const REMEDY: &str = "give one with --reference FILE.exr, or do without errors with --reference none";

/// Tells before anything runs whether the reference of a scene can be used.
///
/// # Errors
/// When it cannot be read, or holds another image than the scene's is to be.
pub fn check_reference(subject: &Subject, plan: &ScenePlan, choice: &ReferenceChoice) -> Result<(), ExperimentError> {
    resolve(subject, plan.longest(), choice).map(drop)
}

/// The reference of a scene for paths of at most `longest` edges.
pub(super) fn resolve(
    subject: &Subject,
    longest: Option<u32>,
    choice: &ReferenceChoice,
) -> Result<Truth, ExperimentError> {
    let scene = &subject.scene;
    let refuse = |what: String| ExperimentError::Scene(format!("{}: {what}", scene.source().display()));
    let film = scene.sensor().film();
    match (choice, scene.reference()) {
        (ReferenceChoice::None, _) => Ok(Truth { words: "none".into(), image: None, exact: None }),
        (ReferenceChoice::File(file), _) => read(subject, file),
        (ReferenceChoice::Scene, Some(Reference::Enclosure { emission, reflectance })) => {
            let exact = enclosure(*emission, *reflectance, longest);
            if !exact.is_finite() {
                return Err(refuse(format!("the enclosure has no finite radiance without a longest path; {REMEDY}")));
            }
            let image = Image::constant(film.width, film.height, exact)?;
            Ok(Truth { words: "exact: the enclosure's radiance".into(), image: Some(image), exact: Some(exact) })
        }
        (ReferenceChoice::Scene, Some(Reference::Image { file, max_length })) => {
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
        (ReferenceChoice::Scene, None) => Err(refuse(format!("it names no reference; {REMEDY}"))),
    }
}

fn read(subject: &Subject, file: &Path) -> Result<Truth, ExperimentError> {
    let film = subject.scene.sensor().film();
    let image = read_exr(file).map_err(|error| ExperimentError::Scene(format!("reference: {error}; {REMEDY}")))?;
    let refuse = |what: String| Err(ExperimentError::Scene(format!("{}: {what}", file.display())));
    if (image.width, image.height) != (film.width, film.height) {
        return refuse(format!(
            "the reference has {} × {} pixels and the image {} × {}; use --film {}x{}, or {REMEDY}",
            image.width, image.height, film.width, film.height, image.width, image.height
        ));
    }
    if !image.pixels.iter().all(|pixel| pixel.is_finite()) {
        return refuse(format!("the reference holds pixels that are not finite; {REMEDY}"));
    }
    Ok(Truth { words: file.display().to_string(), image: Some(image), exact: None })
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
