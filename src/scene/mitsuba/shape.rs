//! Analytic shapes as Mitsuba's.

use glam::DMat3;

use super::xml::Element;
use crate::scene::description::{Cylinder, Disk, Sphere};

/// A sphere; by centre and radius where it is not turned.
pub(super) fn sphere(sphere: &Sphere) -> Element {
    let Sphere { centre, radius, axes, inward, .. } = *sphere;
    let shape = Element::plugin("shape", "sphere");
    let shape = if axes == DMat3::IDENTITY {
        shape.point("center", centre).float("radius", radius)
    } else {
        shape.frame(axes.x_axis * radius, axes.y_axis * radius, axes.z_axis * radius, centre)
    };
    // Mitsuba turns a mirrored sphere inside out.
    flipped(shape, inward != (axes.determinant() < 0.0))
}

/// A disk.
pub(super) fn disk(disk: &Disk) -> Element {
    let [u, v] = disk.axes;
    let shape = Element::plugin("shape", "disk").frame(u, v, u.cross(v).normalize(), disk.centre);
    flipped(shape, disk.flipped)
}

/// A cylinder.
pub(super) fn cylinder(cylinder: &Cylinder) -> Element {
    let Cylinder { base, axis, radius, meridian, clockwise, inward, .. } = *cylinder;
    let quarter = axis.normalize().cross(meridian);
    let quarter = if clockwise { -quarter } else { quarter };
    flipped(Element::plugin("shape", "cylinder").frame(meridian * radius, quarter * radius, axis, base), inward)
}

fn flipped(shape: Element, flip_normals: bool) -> Element {
    if flip_normals { shape.boolean("flip_normals", true) } else { shape }
}
