//! Options that several commands share, and how their values are written.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

pub(crate) use crate::experiment::manifest::MaxLength;
use crate::report::Metric;
use crate::scene::LightSelection;
use crate::scene::description::{FilmSize, PixelFilter};
use crate::scene::gltf::MaterialModel;
use crate::scene::sensor::Pixel;
use crate::spectrum::Rgb;

use super::UsageError;

/// How to take a scene.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct SceneArgs {
    /// Image size in pixels [default: the scene's]
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = film_size)]
    pub film: Option<FilmSize>,

    /// Camera by name, by its node's name or id, or by number from 0 [default: the file's first; one that frames the scene if
    /// there is none]
    #[arg(long, value_name = "NAME")]
    pub camera: Option<String>,

    /// Radiance of a constant environment [W/m²/sr], or an image of the surroundings by longitude and latitude, upright where y
    /// points up (EXR, HDR, PNG, JPEG) [default: the scene's]
    #[arg(long, value_name = "R,G,B|GREY|FILE", value_parser = environment)]
    pub environment: Option<EnvironmentChoice>,

    /// How a pixel responds to what is seen around it: box, tent[:RADIUS], gaussian[:STDDEV], in pixels [default: the
    /// scene's]
    #[arg(long = "filter", value_name = "FILTER", value_parser = pixel_filter)]
    pub pixel_filter: Option<PixelFilter>,

    #[command(flatten)]
    pub defined: ParameterArgs,
}

/// What a scene's file leaves open.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct ParameterArgs {
    /// Value of a parameter of a Mitsuba scene, `$NAME` in the file. May be repeated [default: the file's]
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = parameter)]
    pub parameters: Vec<(String, String)>,

    /// What glTF's materials become: glTF's own model, or Mitsuba's principled, which can be exported [default: gltf; with Mitsuba
    /// among the methods principled]
    #[arg(long, value_name = "MODEL", value_parser = material_model())]
    pub materials: Option<MaterialModel>,
}

/// `gltf` or `principled`.
fn material_model() -> impl TypedValueParser<Value = MaterialModel> {
    PossibleValuesParser::new(["gltf", "principled"])
        .map(|text| if text == "principled" { MaterialModel::Principled } else { MaterialModel::Gltf })
}

/// `NAME=VALUE`.
fn parameter(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() => Ok((name.trim().into(), value.into())),
        _ => Err("expected NAME=VALUE, for example max_depth=8".into()),
    }
}

/// A whole number of edges from 1 on, or `none`.
pub(crate) fn max_length(text: &str) -> Result<MaxLength, String> {
    text.parse()
}

/// `power` or `uniform`.
pub(crate) fn light_selection() -> impl TypedValueParser<Value = LightSelection> {
    PossibleValuesParser::new(["power", "uniform"])
        .map(|text| if text == "uniform" { LightSelection::Uniform } else { LightSelection::Power })
}

/// A metric by the name of its column.
pub(crate) fn metric() -> impl TypedValueParser<Value = Metric> {
    let of = |text: String| Metric::ALL.into_iter().find(|metric| metric.name() == text).unwrap_or(Metric::Mse);
    PossibleValuesParser::new(Metric::ALL.map(Metric::name)).map(of)
}

/// `90s`, `10m`, `1h30m`; a number alone is in seconds \[s\].
pub(crate) fn duration(text: &str) -> Result<f64, String> {
    let parsed =
        text.parse::<f64>().ok().or_else(|| humantime::parse_duration(text).ok().map(|time| time.as_secs_f64()));
    let usable = parsed.filter(|&seconds| seconds > 0.0 && seconds < 1e9);
    usable.ok_or_else(|| "expected a time such as 90s, 10m or 1h30m".into())
}

/// `0.5%`, as a share of one.
pub(crate) fn percentage(text: &str) -> Result<f64, String> {
    let parsed = text.strip_suffix('%').and_then(|number| number.trim().parse().ok());
    let usable = parsed.filter(|&percent: &f64| percent > 0.0 && percent <= 100.0);
    usable.map(|percent| percent / 100.0).ok_or_else(|| "expected a percentage such as 0.5%".into())
}

/// `X,Y`.
pub(crate) fn pixel(text: &str) -> Result<Pixel, String> {
    let parse = || {
        let (x, y) = text.split_once(',')?;
        Some(Pixel { x: x.trim().parse().ok()?, y: y.trim().parse().ok()? })
    };
    parse().ok_or_else(|| "expected column and row from the top left, for example 12,34".into())
}

/// The pixel lies on the film.
///
/// # Errors
/// Where it does not; `option` is what named it.
pub(crate) fn check_pixel(option: &str, pixel: Pixel, film: FilmSize) -> Result<(), UsageError> {
    if pixel.x < film.width && pixel.y < film.height {
        return Ok(());
    }
    let (right, bottom) = (film.width.saturating_sub(1), film.height.saturating_sub(1));
    let Pixel { x, y } = pixel;
    Err(UsageError(format!("{option}: pixel {x},{y} is outside the film, which ends at {right},{bottom}")))
}

/// `WIDTHxHEIGHT`. Zero is left to the scene to refuse, which knows the largest size too.
pub(crate) fn film_size(text: &str) -> Result<FilmSize, String> {
    let parse = || {
        let (width, height) = text.split_once(['x', 'X', '×'])?;
        Some(FilmSize { width: width.trim().parse().ok()?, height: height.trim().parse().ok()? })
    };
    parse().ok_or_else(|| "expected WIDTHxHEIGHT in pixels, for example 640x480".into())
}

/// `box`, `tent:1` or `gaussian:0.5`.
pub(crate) fn pixel_filter(text: &str) -> Result<PixelFilter, String> {
    text.parse().map_err(str::to_owned)
}

/// Three channels, or one for all.
pub(crate) fn radiance(text: &str) -> Result<Rgb, String> {
    let channels: Result<Vec<f64>, _> = text.split(',').map(|channel| channel.trim().parse()).collect();
    let valid = channels.ok().filter(|c| c.iter().all(|c| (0.0..f64::INFINITY).contains(c)));
    match valid.as_deref() {
        Some(&[grey]) => Ok(Rgb::grey(grey)),
        Some(&[r, g, b]) => Ok(Rgb::new(r, g, b)),
        _ => Err("expected one or three numbers from 0 on, for example 1 or 0.5,0.6,0.8".into()),
    }
}

/// What stands for the scene's environment.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum EnvironmentChoice {
    /// The same radiance from everywhere \[W/m²/sr\].
    Constant(Rgb),
    /// An image file.
    Image(PathBuf),
}

/// Numbers, or else a file, which is looked for later.
pub(crate) fn environment(text: &str) -> Result<EnvironmentChoice, String> {
    let starts_with_letter = |ending: &OsStr| ending.as_encoded_bytes().first().is_some_and(u8::is_ascii_alphabetic);
    match radiance(text) {
        Ok(radiance) => Ok(EnvironmentChoice::Constant(radiance)),
        Err(_) if Path::new(text).extension().is_some_and(starts_with_letter) => {
            Ok(EnvironmentChoice::Image(text.into()))
        }
        Err(why) => Err(format!("{why}; or an image file")),
    }
}

/// A time above zero \[s\].
pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(seconds) if seconds > 0.0 && seconds < 1e9 => Ok(seconds),
        _ => Err("expected a time in seconds above 0, for example 10 or 0.5".into()),
    }
}

/// A size of memory above zero \[GiB\].
pub(crate) fn gibibytes(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(size) if size > 0.0 && size <= 1e6 => Ok(size),
        _ => Err("expected a size in GiB above 0, for example 4 or 0.5".into()),
    }
}

/// A finite number.
pub(crate) fn finite(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(|| "expected a finite number".into())
}
