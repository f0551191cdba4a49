//! `render --layers`: which layers a render keeps, and whether it could.

use std::path::Path;

use anyhow::bail;
use clap::{Args, ValueEnum};

use crate::film::{Film, Layer, LayerSelection, OutputFormat};

use super::{UsageError, args};

/// Which layers to keep.
#[derive(Clone, Debug, Args)]
pub(super) struct LayerArgs {
    /// Write an image of each path length (L_0, L_1, …), of each technique (s2_t3.weighted and .unweighted), or both into the
    /// EXR file too, as layers with standard errors; its metadata count samples, rays and time of each technique
    #[arg(long, value_name = "WHICH", value_enum, value_delimiter = ',', conflicts_with = "replay")]
    layers: Vec<LayersBy>,

    /// Memory that layers may take [GiB]; about half as much again is needed to write them
    #[arg(long, value_name = "GIB", default_value_t = 2.0, value_parser = args::gibibytes, requires = "layers")]
    layer_memory: f64,
}

/// What layers are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum LayersBy {
    /// The paths of a length: L_k has k + 1 edges
    Length,
    /// A technique (s, t): s vertices from the emitter, t from the sensor
    Technique,
}

impl LayerArgs {
    /// Told before anything is loaded: layers have a place to go, and begin with the film.
    pub(super) fn check(&self, output: Option<&Path>, resume: Option<&Path>) -> Result<(), UsageError> {
        if self.layers.is_empty() {
            return Ok(());
        }
        if let Some(state) = resume {
            return Err(UsageError(format!(
                "{}: the state of a film holds no layers; render anew without --resume, or go on without --layers",
                state.display()
            )));
        }
        match output {
            Some(image) if OutputFormat::from_path(image).is_ok_and(|format| format == OutputFormat::Png) => {
                Err(UsageError(format!(
                    "{}: a PNG holds no layers; write -o {} and make a picture of it with `pathspace pyramid`",
                    image.display(),
                    image.with_extension("exr").display()
                )))
            }
            _ => Ok(()),
        }
    }

    /// Tells the film.
    pub(super) fn keep_in(&self, film: &mut Film) -> anyhow::Result<()> {
        let selection = LayerSelection {
            length: self.layers.contains(&LayersBy::Length),
            technique: self.layers.contains(&LayersBy::Technique),
        };
        if selection != LayerSelection::default() {
            film.keep_layers(selection, (self.layer_memory * f64::from(1 << 30)) as u64)?;
        }
        Ok(())
    }
}

/// The layers are those of the whole image, or it is an error.
pub(super) fn check_kept(integrator: &str, film: &Film, image: &Path) -> anyhow::Result<()> {
    let Some(layers) = film.layers() else { return Ok(()) };
    let standing = match film.passes() {
        0 => "nothing is written".to_owned(),
        passes => format!("{} holds the {passes} before", image.display()),
    };
    if let Some(refused) = layers.refused() {
        bail!(
            "layers: {refused}; {standing}; raise --layer-memory, or ask for less: --layers length, a shorter \
             --max-length, a smaller --film"
        );
    }
    if layers.passes() != film.passes() {
        bail!(
            "layers: integrator {integrator} gives none; {} is written without them; leave out --layers",
            image.display()
        );
    }
    Ok(())
}

/// Which layers an image has, to be said behind its name.
pub(super) fn told(film: &Film) -> String {
    let Some(layers) = film.layers() else { return String::new() };
    let all = layers.layers();
    let count = |wanted: fn(&Layer) -> bool| all.iter().filter(|layer| wanted(layer)).count();
    let lengths = count(|layer| matches!(layer, Layer::Length { .. }));
    let techniques = count(|layer| matches!(layer, Layer::Weighted(_)));
    let named = [(lengths, "path lengths"), (techniques, "techniques")];
    let named: Vec<String> = named.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")).collect();
    if named.is_empty() { String::new() } else { format!(" with layers of {}", named.join(" and ")) }
}
