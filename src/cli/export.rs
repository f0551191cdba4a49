//! `export`: the same scene for Mitsuba.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;

use crate::scene::mitsuba::{self, ExportOptions};

use super::Outcome;
use super::args::{self, MaxLength, SceneArgs};
use super::scene::{self, LoadOptions};

/// Write a scene for Mitsuba 3: DIR/scene.xml and its meshes
///
/// Radiance keeps its unit and one path length is the other's: max_depth is --max-length. The pixel filter is the scene's.
/// Sensors besides the camera, in the scene's extras, are left out.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pathspace export cornell_box /tmp/cornell_box")]
pub(super) struct ExportArgs {
    /// A .gltf, .glb or Mitsuba .xml file, a folder with one, or the name of a folder in scenes/
    scene: PathBuf,

    /// Folder to write into; made where it is missing
    #[arg(value_name = "DIR")]
    folder: PathBuf,

    /// Samples per pixel that the file asks for
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..))]
    spp: u32,

    /// Longest path in edges, or none [default: the scene's]
    #[arg(long, value_name = "EDGES", value_parser = args::max_length)]
    max_length: Option<MaxLength>,

    #[command(flatten)]
    take: SceneArgs,
}

pub(super) fn run(args: &ExportArgs) -> anyhow::Result<Outcome> {
    let SceneArgs { film, camera, environment, pixel_filter: filter, defined } = args.take.clone();
    let (parameters, materials) = (defined.parameters, defined.materials.unwrap_or_default());
    let options = LoadOptions { camera, film, environment, filter, parameters, materials, ..LoadOptions::default() };
    let loaded = scene::load(&args.scene, &options)?;
    scene::show(&loaded.notes);
    let options = ExportOptions {
        film: loaded.scene.sensor().film(),
        max_length: args.max_length.map_or(loaded.scene.hints().max_length, |length| length.0),
        spp: args.spp,
        ..ExportOptions::default()
    };
    let file = mitsuba::export(&loaded.description, &options, &args.folder)?;
    let image = args.folder.join("mitsuba.exr");
    let mut out = io::stdout().lock();
    writeln!(out, "wrote {}", file.display())?;
    writeln!(out, "render it with Mitsuba 3 (pip install mitsuba==3.9.1):")?;
    writeln!(out, "  mitsuba -m scalar_rgb -o '{}' '{}'", image.display(), file.display())?;
    out.flush()?;
    Ok(Outcome::Done)
}
