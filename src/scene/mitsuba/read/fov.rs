//! Fields of view as cameras and projectors have them.

use super::fault::Result;
use super::props::Props;

/// Diagonal of a 35 mm film \[mm\]: √(36² + 24²).
const FILM_DIAGONAL: f64 = 43.266_615_305_567_87;

/// The full horizontal field of view \[rad\] of an image of this width over height.
pub(super) fn horizontal(props: &Props<'_>, aspect: f64) -> Result<f64> {
    #[derive(Clone, Copy)]
    enum Axis {
        X,
        Y,
        Diagonal,
        Smaller,
        Larger,
    }
    let axes = [
        ("x", Axis::X),
        ("y", Axis::Y),
        ("diagonal", Axis::Diagonal),
        ("smaller", Axis::Smaller),
        ("larger", Axis::Larger),
    ];
    if props.has("fov") && props.has("focal_length") {
        return Err(props.wrong("has a fov and a focal_length", "give one of the two"));
    }
    let (tan, axis) = match props.float("fov")? {
        Some(fov) => {
            if !(fov > 0.0 && fov < 180.0) {
                return Err(props.fault("fov", format!("is {fov}°"), "give an angle between 0 and 180".into()));
            }
            (libm::tan(0.5 * fov.to_radians()), props.choice("fov_axis", &axes)?)
        }
        None => {
            let text = props.text("focal_length")?.unwrap_or("50mm");
            let millimetres = text.trim().trim_end_matches("mm").trim().parse().ok().filter(|&f: &f64| f > 0.0);
            let Some(millimetres) = millimetres else {
                let problem = format!("{text:?} is no focal length");
                return Err(props.fault("focal_length", problem, "write for example 50mm".into()));
            };
            (FILM_DIAGONAL / (2.0 * millimetres), Axis::Diagonal)
        }
    };
    let tan = match axis {
        Axis::X => tan,
        Axis::Y => tan * aspect,
        Axis::Smaller => tan * if aspect > 1.0 { aspect } else { 1.0 },
        Axis::Larger => tan * if aspect > 1.0 { 1.0 } else { aspect },
        Axis::Diagonal => tan / (1.0 + 1.0 / (aspect * aspect)).sqrt(),
    };
    Ok(2.0 * libm::atan(tan))
}
