//! Cameras: which one, and how it stands.

use glam::{DAffine3, DVec3};
use gltf::json::Index;

use super::document::Document;
use super::exact;
use super::extras::{self, CameraExtras, nearest};
use super::fault::{Fault, place};
use super::hierarchy::{Placed, node_place};
use super::tally::Tally;
use crate::scene::description::{FilmSize, Projection, SensorDescription};

/// The chosen camera and the size of its image, where it gives one.
pub(super) type Chosen = (SensorDescription, Option<FilmSize>);

/// The camera called `wanted`, by name or by its number among the scene's cameras; else the first one, if any.
pub(super) fn choose(
    document: &Document,
    nodes: &[Placed],
    wanted: Option<&str>,
    tally: &mut Tally,
) -> Result<Option<Chosen>, Fault> {
    let camera_of = |placed: &Placed| document.root.nodes[placed.node].camera.as_ref().map(Index::value);
    let cameras: Vec<(&Placed, usize)> =
        nodes.iter().filter_map(|placed| camera_of(placed).map(|camera| (placed, camera))).collect();
    let names: Vec<[Option<&str>; 2]> =
        cameras.iter().map(|(placed, camera)| names(document, placed, *camera)).collect();
    let number = match wanted {
        Some(wanted) => {
            let named = names.iter().position(|both| both.contains(&Some(wanted)));
            let numbered = || wanted.parse().ok().filter(|&number| number < cameras.len());
            named.or_else(numbered).ok_or_else(|| unknown(wanted, &names))?
        }
        None => 0,
    };
    let Some(&(placed, camera)) = cameras.get(number) else {
        return Ok(None);
    };
    if wanted.is_none() && cameras.len() > 1 {
        let others: Vec<String> = (1..cameras.len()).map(|i| label(names[i], i)).collect();
        tally.others.push(format!("the first of {} cameras is used; the others: {}", cameras.len(), others.join(", ")));
    }
    let name = names[number].iter().flatten().next().map_or_else(|| format!("camera {camera}"), ToString::to_string);
    read(document, placed, camera, name, tally).map(Some)
}

/// A camera answers to its own name and to that of its node.
fn names<'a>(document: &'a Document, placed: &Placed, camera: usize) -> [Option<&'a str>; 2] {
    [document.root.cameras[camera].name.as_deref(), document.root.nodes[placed.node].name.as_deref()]
}

fn label(names: [Option<&str>; 2], number: usize) -> String {
    names.into_iter().flatten().next().map_or_else(|| number.to_string(), |name| format!("{name:?}"))
}

fn unknown(wanted: &str, names: &[[Option<&str>; 2]]) -> Fault {
    let problem = format!("there is no camera {wanted:?}");
    let remedy = match nearest(wanted, names.iter().flatten().flatten().copied()) {
        Some(name) => format!("did you mean {name:?}?"),
        None if names.is_empty() => "the scene has none: leave the choice out".into(),
        None => format!("give a number below {}", names.len()),
    };
    Fault::invalid("cameras", problem, remedy)
}

fn read(document: &Document, placed: &Placed, camera: usize, name: String, tally: &mut Tally) -> Result<Chosen, Fault> {
    let found = &document.exact.cameras[camera];
    let here = place("cameras", camera, document.root.cameras[camera].name.as_deref());
    let ours: CameraExtras = extras::read(found.extras.as_ref(), &here)?;
    let (forward, up) = orientation(&placed.world).ok_or_else(|| {
        let problem = "its transform leaves the camera no viewing direction";
        Fault::invalid(node_place(document, placed.node), problem, "give it and its parents a scale other than zero")
    })?;
    if placed.world.matrix3.determinant() < 0.0 {
        tally.others.push(format!("camera {name:?} stands in a mirroring transform; its image is not mirrored"));
    }
    let projection = projection(found, &ours, &here)?;
    let position = placed.world.translation;
    Ok((SensorDescription { name, position, forward, up, projection, window: SensorDescription::WHOLE }, ours.film))
}

fn projection(camera: &exact::Camera, ours: &CameraExtras, here: &str) -> Result<Projection, Fault> {
    let invalid = |problem: String, remedy: &str| Err(Fault::invalid(here, problem, remedy));
    if let Some(perspective) = &camera.perspective {
        let (fov, aspect) = (perspective.yfov, perspective.aspect_ratio);
        if !(fov > 0.0 && fov < std::f64::consts::PI) {
            return invalid(format!("yfov is {fov}"), "give an angle between 0 and π, in radians");
        }
        if aspect.is_some_and(|aspect| aspect <= 0.0 || !aspect.is_finite()) {
            return invalid("aspectRatio is not positive".into(), "give width over height, or leave it out");
        }
        return Ok(Projection::Perspective { vertical_fov: fov, aspect, lens: ours.lens });
    }
    let Some(orthographic) = &camera.orthographic else {
        return invalid("is neither perspective nor orthographic".into(), "say which");
    };
    if ours.lens.is_some() {
        return invalid("an orthographic camera has no lens".into(), "remove `lens` from its extras");
    }
    // Negative magnifications would mirror the image; the specification advises against them.
    let (half_width, half_height) = (orthographic.xmag, orthographic.ymag);
    if !(half_width > 0.0 && half_height > 0.0) {
        return invalid(format!("xmag and ymag are {half_width} and {half_height}"), "make both positive");
    }
    Ok(Projection::Orthographic { half_width, half_height })
}

/// The images of −Z and +Y, orthonormal: scale and shear are left out.
fn orientation(world: &DAffine3) -> Option<(DVec3, DVec3)> {
    let forward = direction(world)?;
    let up = world.matrix3.y_axis.try_normalize()?;
    let up = (up - forward * up.dot(forward)).try_normalize()?;
    Some((forward, up))
}

/// Where −Z goes, of length one: the axis of cameras and lights.
pub(super) fn direction(world: &DAffine3) -> Option<DVec3> {
    (-world.matrix3.z_axis).try_normalize()
}
