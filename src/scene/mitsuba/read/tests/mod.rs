//! Tests of the reader, on scenes written as text.

mod bad_files;
mod format;
mod lights_and_sensors;
mod materials;
mod shapes;
mod shared;

use std::path::Path;

use super::{ReadOptions, from_bytes};
use crate::scene::description::{BsdfDescription, SceneDescription};

/// The scene that the elements make.
fn scene(body: &str) -> SceneDescription {
    scene_with(body, &[])
}

fn scene_with(body: &str, parameters: &[(&str, &str)]) -> SceneDescription {
    read_text(&document(body), parameters).unwrap_or_else(|error| panic!("{error}"))
}

/// Why it is none.
fn refusal(body: &str) -> String {
    read_text(&document(body), &[]).expect_err(body)
}

fn document(body: &str) -> String {
    format!("<scene version=\"3.0.0\">\n{body}\n</scene>")
}

fn read_text(text: &str, parameters: &[(&str, &str)]) -> Result<SceneDescription, String> {
    let parameters = parameters.iter().map(|&(name, value)| (name.into(), value.into())).collect();
    let options = ReadOptions { camera: None, parameters };
    from_bytes(text.as_bytes(), Path::new("room/scene.xml"), &options).map_err(|error| error.to_string())
}

/// The only model of a scene.
fn bsdf(element: &str) -> BsdfDescription {
    let scene = scene(&format!("<shape type=\"sphere\">{element}</shape>"));
    scene.materials[0].bsdf.clone()
}
