//! `<shape>`: meshes, analytic shapes, groups and their instances.

use glam::{DAffine3, DMat3, DMat4, DVec3};

use super::fault::{Fault, Result};
use super::mesh::{self, Local};
use super::node::Kind;
use super::props::Props;
use super::reader::Reader;
use crate::geometry::Frame;
use crate::names::did_you_mean;
use crate::scene::description::{Cylinder, Disk, Mesh, ShapeIndex, Sphere};

/// Most triangles that instances may make of groups.
const MOST_INSTANCED: usize = 20_000_000;

/// How far a transform may be from a similarity, relatively.
const SIMILAR: f64 = 1e-4;

const PLUGINS: [&str; 10] =
    ["obj", "ply", "serialized", "rectangle", "cube", "sphere", "disk", "cylinder", "shapegroup", "instance"];

/// A shape in its own coordinates, with what places it and makes its surface.
#[derive(Clone, Debug)]
pub(super) struct Part {
    name: String,
    form: Form,
    material: usize,
    /// What measures at it.
    sensor: Option<usize>,
}

#[derive(Clone, Debug)]
enum Form {
    /// Placed already, but for the instance.
    Mesh(Local),
    /// From the unit sphere.
    Sphere { to_world: DMat4, inward: bool },
    /// From the unit disk, its front on the side of +z.
    Disk { to_world: DMat4, flip: bool },
    /// From the unit cylinder from z = 0 to z = 1.
    Cylinder { to_world: DMat4, inward: bool },
}

impl Reader<'_> {
    /// A shape of the scene.
    pub(super) fn shape(&mut self, index: usize) -> Result<()> {
        match self.document.nodes[index].plugin.as_str() {
            // Seen through its instances only.
            "shapegroup" => self.group(index).map(drop),
            "instance" => self.instance(index),
            _ => {
                let part = self.part(index, false)?;
                let sensor = part.sensor;
                let shape = self.place(part, None, index)?;
                self.sensors.extend(sensor.map(|sensor| (sensor, Some(shape))));
                Ok(())
            }
        }
    }

    fn part(&mut self, index: usize, in_group: bool) -> Result<Part> {
        let props = Props::new(self.document, index);
        let form = self.form(&props)?;
        self.refuse_media(&props)?;
        if let Some((_, property)) = props.objects(Kind::Texture).first() {
            let problem = "attributes of shapes by textures are not supported";
            return Err(Fault::new(&property.place, problem, "give the texture to the model"));
        }
        // Of no consequence but for derivatives.
        props.ignore(&["silhouette_sampling_weight"]);
        let bsdf = props.object(Kind::Bsdf)?;
        let emitter = props.object(Kind::Emitter)?;
        let sensor = props.object(Kind::Sensor)?;
        props.finish()?;
        if in_group && (emitter.is_some() || sensor.is_some()) {
            let problem = "shines or measures inside of a group, which Mitsuba does not support either";
            return Err(props.wrong(problem, "take it out of the group"));
        }
        let material = self.material(bsdf, emitter)?;
        Ok(Part { name: self.name_of(index), form, material, sensor })
    }

    fn form(&mut self, props: &Props<'_>) -> Result<Form> {
        let to_world = props.to_world()?;
        if to_world.determinant() == 0.0 || !to_world.inverse().is_finite() {
            return Err(props.fault(
                "to_world",
                "makes the shape flat".into(),
                "scale by other numbers than zero".into(),
            ));
        }
        Ok(match props.node.plugin.as_str() {
            "rectangle" => Form::Mesh(mesh::rectangle(props, &to_world)?),
            "cube" => Form::Mesh(mesh::cube(props, &to_world)?),
            "obj" | "ply" | "serialized" => {
                Form::Mesh(mesh::file(self.document, props, &to_world, &mut self.warnings)?)
            }
            "sphere" => {
                let centre = props.vector("center")?.unwrap_or(DVec3::ZERO);
                let radius = props.float_or("radius", 1.0)?;
                if radius == 0.0 {
                    return Err(props.fault("radius", "is zero".into(), "give a radius above zero".into()));
                }
                let own = to_world * DMat4::from_translation(centre) * DMat4::from_scale(DVec3::splat(radius));
                // A mirrored sphere of Mitsuba is inside out.
                let inward = props.boolean_or("flip_normals", false)? != (own.determinant() < 0.0);
                Form::Sphere { to_world: own, inward }
            }
            "disk" => Form::Disk { to_world, flip: props.boolean_or("flip_normals", false)? },
            "cylinder" => {
                let radius = props.float_or("radius", 1.0)?;
                let p0 = props.vector("p0")?.unwrap_or(DVec3::ZERO);
                let p1 = props.vector("p1")?.unwrap_or(DVec3::Z);
                let length = (p1 - p0).length();
                if length == 0.0 || radius == 0.0 {
                    return Err(
                        props.wrong("has no length or no radius", "keep p0 and p1 apart, and radius above zero")
                    );
                }
                let frame = Frame::around((p1 - p0) / length);
                let columns = [frame.x * radius, frame.y * radius, frame.z * length].map(|axis| axis.extend(0.0));
                let own = DMat4::from_cols(columns[0], columns[1], columns[2], p0.extend(1.0));
                let inward = props.boolean_or("flip_normals", false)?;
                Form::Cylinder { to_world: to_world * own, inward }
            }
            "shapegroup" | "instance" => {
                return Err(props.wrong("stands inside of a group", "put simple shapes into groups"));
            }
            other => {
                let problem = format!("is the unsupported shape {other:?}{}", did_you_mean(other, PLUGINS));
                return Err(props.wrong(problem, format!("use one of {}", PLUGINS.join(", "))));
            }
        })
    }

    /// Adds a shape to the scene, by an instance or directly.
    fn place(&mut self, part: Part, instance: Option<&DMat4>, index: usize) -> Result<ShapeIndex> {
        let node = &self.document.nodes[index].place;
        let Part { name, form, material, .. } = part;
        let by = instance.copied().unwrap_or(DMat4::IDENTITY);
        Ok(match form {
            Form::Mesh(local) => {
                let local = if instance.is_some() { local.placed(&by, false, true) } else { local };
                let Local { positions, normals, texcoords, attributes, triangles } = local;
                self.scene.meshes.push(Mesh { name, positions, normals, texcoords, attributes, triangles, material });
                ShapeIndex::Mesh(self.scene.meshes.len() - 1)
            }
            Form::Sphere { to_world, inward } => {
                let m = self.finite(by * to_world, index)?;
                let radius = m.x_axis.length();
                let axes = DMat3::from_mat4(m) * (1.0 / radius);
                let off = axes.transpose() * axes - DMat3::IDENTITY;
                if off.to_cols_array().iter().any(|x| x.abs() > SIMILAR) {
                    let problem = "is turned into an ellipsoid by its transform";
                    return Err(Fault::new(node, problem, "scale it alike along all axes"));
                }
                let centre = m.w_axis.truncate();
                let axes = DMat3::from_cols(axes.x_axis, axes.y_axis, axes.z_axis);
                self.scene.spheres.push(Sphere { name, centre, radius, axes, inward, material });
                ShapeIndex::Sphere(self.scene.spheres.len() - 1)
            }
            Form::Disk { to_world, flip } => {
                self.scene.disks.push(Disk::transformed(
                    name,
                    &DAffine3::from_mat4(self.finite(by * to_world, index)?),
                    flip,
                    material,
                ));
                ShapeIndex::Disk(self.scene.disks.len() - 1)
            }
            Form::Cylinder { to_world, inward } => {
                let m = self.finite(by * to_world, index)?;
                let [x, y, axis] = [m.x_axis, m.y_axis, m.z_axis].map(glam::DVec4::truncate);
                let radius = x.length();
                let length = axis.length();
                let slant =
                    [x.dot(y) / (radius * radius), x.dot(axis) / (radius * length), y.dot(axis) / (radius * length)];
                let uneven = y.length() / radius - 1.0;
                if slant.iter().chain(&[uneven]).any(|off| off.abs() > SIMILAR) {
                    let problem = "is made oblique or elliptic by its transform";
                    return Err(Fault::new(node, problem, "scale it alike across its axis"));
                }
                self.scene.cylinders.push(Cylinder::transformed(name, &DAffine3::from_mat4(m), inward, material));
                ShapeIndex::Cylinder(self.scene.cylinders.len() - 1)
            }
        })
    }

    /// The matrix, unless numbers are beyond what can be told apart.
    fn finite(&self, matrix: DMat4, index: usize) -> Result<DMat4> {
        if matrix.is_finite() && matrix.determinant().is_normal() {
            return Ok(matrix);
        }
        let problem = "is too large or too small for its transform and size";
        Err(Fault::new(&self.document.nodes[index].place, problem, "use numbers around one"))
    }

    /// The shapes of a group.
    fn group(&mut self, index: usize) -> Result<Vec<Part>> {
        if let Some(known) = self.groups.get(&index) {
            return Ok(known.clone());
        }
        let props = Props::new(self.document, index);
        let shapes = props.objects(Kind::Shape);
        // Mitsuba reads the transform of a group and does not use it.
        props.ignore(&["to_world"]);
        props.finish()?;
        let parts = shapes.into_iter().map(|(shape, _)| self.part(shape, true)).collect::<Result<Vec<_>>>()?;
        self.groups.insert(index, parts.clone());
        Ok(parts)
    }

    fn instance(&mut self, index: usize) -> Result<()> {
        let props = Props::new(self.document, index);
        let to_world = props.to_world()?;
        let shapes = props.objects(Kind::Shape);
        props.finish()?;
        if to_world.determinant() == 0.0 || !to_world.inverse().is_finite() {
            return Err(props.fault(
                "to_world",
                "makes the instance flat".into(),
                "scale by other numbers than zero".into(),
            ));
        }
        let group = match shapes.as_slice() {
            [(group, _)] if self.document.nodes[*group].plugin == "shapegroup" => *group,
            _ => return Err(props.wrong("does not hold one shapegroup", "put a <ref> to one into it")),
        };
        let parts = self.group(group)?;
        let size: usize = parts.iter().map(Part::size).sum();
        self.instanced = self.instanced.saturating_add(size);
        if self.instanced > MOST_INSTANCED {
            let problem =
                format!("instances are copies here, and they make more than {MOST_INSTANCED} triangles or vertices");
            return Err(props.wrong(problem, "use fewer instances"));
        }
        let name = self.name_of(index);
        for mut part in parts {
            part.name = format!("{name}: {}", part.name);
            self.place(part, Some(&to_world), index)?;
        }
        Ok(())
    }
}

impl Part {
    /// Triangles, or vertices where these are more.
    fn size(&self) -> usize {
        match &self.form {
            Form::Mesh(local) => local.triangles.len().max(local.positions.len()),
            _ => 1,
        }
    }
}
