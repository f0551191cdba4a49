//! The surfaces: triangles and analytic shapes relative to the centre, and where on them textures are.

use std::collections::BTreeSet;

use glam::{DMat3, DVec3, Vec2, Vec3};

use crate::geometry::Bounds;
use crate::scene::accel::{Accel, AnalyticShape, CylinderShape, DiskShape, SphereShape, Triangle};
use crate::scene::description::{Cylinder, Disk, Mesh, Sphere};
use crate::scene::mapping::{Mapping, Placement};
use crate::scene::material::SurfaceMaterial;
use crate::scene::texture::{Parameter, Texture};
use crate::scene::{MaterialId, SceneDescription, Shape};

use super::Builder;

/// The shapes' numbers have this order: meshes, spheres, disks, cylinders.
struct Analytic {
    shape: AnalyticShape,
    placement: Placement,
}

fn sphere(sphere: &Sphere, centre: DVec3, shape: u32) -> Analytic {
    let Sphere { radius, axes, inward, .. } = *sphere;
    let centre = sphere.centre - centre;
    Analytic {
        shape: AnalyticShape::Sphere(SphereShape::new(centre, radius, inward, shape)),
        placement: Placement::new(centre, axes * radius),
    }
}

fn disk(disk: &Disk, centre: DVec3, shape: u32) -> Analytic {
    let [u, v] = disk.axes;
    let centre = disk.centre - centre;
    Analytic {
        shape: AnalyticShape::Disk(Box::new(DiskShape::new(centre, disk.axes, disk.flipped, shape))),
        placement: Placement::new(centre, DMat3::from_cols(u, v, u.cross(v).normalize())),
    }
}

fn cylinder(cylinder: &Cylinder, centre: DVec3, shape: u32) -> Analytic {
    let Cylinder { axis, radius, meridian, clockwise, inward, .. } = *cylinder;
    let base = cylinder.base - centre;
    let quarter = axis.normalize().cross(meridian) * radius;
    let quarter = if clockwise { -quarter } else { quarter };
    Analytic {
        shape: AnalyticShape::Cylinder(Box::new(CylinderShape::new(base, axis, radius, inward, shape))),
        placement: Placement::new(base, DMat3::from_cols(meridian * radius, quarter, axis)),
    }
}

impl SceneDescription {
    fn analytic(&self, centre: DVec3) -> Vec<Analytic> {
        let first = self.meshes.len();
        let numbered = |offset: usize, i: usize| (first + offset + i) as u32;
        let Self { spheres, disks, cylinders, .. } = self;
        let after_disks = spheres.len() + disks.len();
        let spheres = spheres.iter().enumerate().map(|(i, s)| sphere(s, centre, numbered(0, i)));
        let disks = disks.iter().enumerate().map(|(i, d)| disk(d, centre, numbered(self.spheres.len(), i)));
        let cylinders = cylinders.iter().enumerate().map(|(i, c)| cylinder(c, centre, numbered(after_disks, i)));
        spheres.chain(disks).chain(cylinders).collect()
    }

    /// Name and material of all shapes, in the order of their numbers.
    pub(super) fn shape_materials(&self) -> impl Iterator<Item = (&String, usize)> {
        let meshes = self.meshes.iter().map(|mesh| (&mesh.name, mesh.material));
        let spheres = self.spheres.iter().map(|sphere| (&sphere.name, sphere.material));
        let disks = self.disks.iter().map(|disk| (&disk.name, disk.material));
        let cylinders = self.cylinders.iter().map(|cylinder| (&cylinder.name, cylinder.material));
        meshes.chain(spheres).chain(disks).chain(cylinders)
    }
}

/// The triangles of all meshes, one mesh after the other.
struct Triangles<'a> {
    meshes: &'a [Mesh],
    /// Where each mesh ends.
    ends: Vec<usize>,
}

impl<'a> Triangles<'a> {
    fn new(meshes: &'a [Mesh]) -> Self {
        let mut end = 0;
        let mut ends = Vec::with_capacity(meshes.len());
        for mesh in meshes {
            end += mesh.triangles.len();
            ends.push(end);
        }
        Self { meshes, ends }
    }

    fn count(&self) -> usize {
        self.ends.last().copied().unwrap_or(0)
    }

    /// The number of a triangle's mesh, that mesh, and the triangle's number in it.
    fn locate(&self, triangle: u32) -> (usize, &'a Mesh, usize) {
        let triangle = triangle as usize;
        let number = self.ends.partition_point(|&end| end <= triangle);
        let mesh = &self.meshes[number];
        (number, mesh, triangle + mesh.triangles.len() - self.ends[number])
    }

    /// A value for each triangle's id; `unused` where no triangle has it.
    fn by_id<T: Copy>(&self, order: &[Option<u32>], unused: T, value: impl Fn(&Mesh, usize) -> T) -> Vec<T> {
        let value = |triangle: u32| {
            let (_, mesh, local) = self.locate(triangle);
            value(mesh, local)
        };
        order.iter().map(|triangle| triangle.map_or(unused, value)).collect()
    }
}

impl Builder<'_> {
    /// The primitives, the shading normals of the triangles' corners, and the old position of each triangle id.
    pub(super) fn geometry(
        &self,
        analytic: &[AnalyticShape],
        centre: DVec3,
    ) -> (Accel, Vec<[Vec3; 3]>, Vec<Option<u32>>) {
        let triangles = Triangles::new(&self.description.meshes);
        let triangle = |i: u32| {
            let (shape, mesh, local) = triangles.locate(i);
            let corners = mesh.triangles[local].map(|i| mesh.positions[i as usize] - centre);
            Triangle { corners, shape: shape as u32 }
        };
        let (accel, order) = Accel::build(triangles.count(), triangle, analytic);
        let smooth = self.description.meshes.iter().any(|m| m.normals.is_some());
        let corners = |mesh: &Mesh, local: usize| {
            let normal = |i: u32| mesh.normals.as_ref().map_or(Vec3::ZERO, |n| n[i as usize].as_vec3());
            mesh.triangles[local].map(normal)
        };
        let normals = if smooth { triangles.by_id(&order, [Vec3::ZERO; 3], corners) } else { Vec::new() };
        (accel, normals, order)
    }

    /// The analytic shapes and where they are, both in the order of the description.
    pub(super) fn analytic(&self, centre: DVec3) -> (Vec<AnalyticShape>, Vec<Placement>) {
        self.description.analytic(centre).into_iter().map(|a| (a.shape, a.placement)).unzip()
    }

    /// What the materials ask of the meshes' triangles, in the order of their ids, and of the analytic shapes.
    pub(super) fn mapping(
        &self,
        accel: &Accel,
        placements: &[Placement],
        order: &[Option<u32>],
        materials: &[SurfaceMaterial],
    ) -> Mapping {
        let first = self.description.meshes.len();
        let placements = accel.analytic().iter().map(|a| placements[a.shape() as usize - first]).collect();
        let asks = |mesh: &Mesh| {
            let emission = &self.description.materials[mesh.material].emission;
            materials[mesh.material].varies() || matches!(emission, Parameter::Texture(_))
        };
        if !self.description.meshes.iter().any(asks) {
            return Mapping { placements, ..Mapping::default() };
        }
        let none = [Vec2::NAN; 3];
        let corners = |mesh: &Mesh, triangle: usize| {
            mesh.texcoords.as_ref().map_or(none, |all| mesh.triangles[triangle].map(|i| all[i as usize]))
        };
        let triangles = Triangles::new(&self.description.meshes);
        let texcoords =
            triangles.by_id(order, none, |mesh, triangle| if asks(mesh) { corners(mesh, triangle) } else { none });
        let table = |name: &String| {
            let missing = [[0.0, 0.0, 0.0, 1.0]; 3];
            triangles.by_id(order, missing, |mesh, triangle| {
                let attribute = mesh.attributes.iter().find(|attribute| attribute.name == *name);
                attribute.map_or(missing, |attribute| attribute.corners(triangle, mesh.triangles[triangle]))
            })
        };
        let attributes = self.attributes_asked_for().iter().map(|name| (name.clone(), table(name))).collect();
        Mapping { texcoords, attributes, placements }
    }

    fn attributes_asked_for(&self) -> BTreeSet<String> {
        let mut names = BTreeSet::new();
        let mut see = |texture: &Texture| {
            if let Texture::Attribute { name } | Texture::OtherCoordinates { attribute: name, .. } = texture {
                names.insert(name.clone());
            }
        };
        for material in &self.description.materials {
            material.bsdf.visit_textures(&mut see);
            if let Some(texture) = material.emission.texture() {
                texture.visit(&mut see);
            }
        }
        names
    }

    pub(super) fn shapes(&self) -> Vec<Shape> {
        let materials = self.description.shape_materials();
        materials.map(|(_, m)| Shape { material: MaterialId(m as u32), emitter: None }).collect()
    }
}

/// The box of each mesh and shape.
pub(super) fn boxes(description: &SceneDescription) -> Vec<Bounds> {
    let around = |m: &Mesh| Bounds::around(m.triangles.iter().flatten().map(|&i| m.positions[i as usize]));
    let analytic = description.analytic(DVec3::ZERO).into_iter().map(|analytic| analytic.shape.bounds());
    description.meshes.iter().map(around).chain(analytic).collect()
}

pub(super) fn bounds(description: &SceneDescription) -> Bounds {
    boxes(description).into_iter().fold(Bounds::EMPTY, Bounds::union)
}

/// What is so much larger than all smaller things together has no say in where the centre is.
const FAR_LARGER: f64 = 4096.0;

/// The point that positions are relative to: of everything, but without what is so large that details beside it would lose
/// their digits. `points` are where rays start from or end at, besides.
pub(super) fn centre(mut boxes: Vec<Bounds>, points: Bounds) -> DVec3 {
    boxes.retain(|bounds| !bounds.is_empty());
    boxes.sort_by(|a, b| a.radius().total_cmp(&b.radius()));
    let mut details = points;
    for bounds in boxes {
        let larger = !details.is_empty() && details.radius() > 0.0 && bounds.radius() > FAR_LARGER * details.radius();
        if larger {
            break;
        }
        details = details.union(bounds);
    }
    details.centre()
}
