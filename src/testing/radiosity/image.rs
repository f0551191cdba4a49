//! Means over rectangles of an image, by integration over what is seen in them.

use glam::{DVec2, DVec3};

use crate::film::BLOCK_SIDE;
use crate::scene::PrimitiveId;
use crate::scene::description::{FilmSize, Projection};

use super::polygon::{Corners, Plane, Polygon, area_vector, centroid, subdivide};
use super::quadrature::triangle;
use super::scene::{DiffuseScene, FacetPoint};

/// How often a triangle of the image is divided at the outlines of what lies before it.
const EDGE_DIVISIONS: u32 = 4;

/// A pinhole or orthographic camera, its image at distance one or in the film's plane.
pub(super) struct View {
    position: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    half_extent: DVec2,
    parallel: bool,
    film: FilmSize,
}

/// A point that is seen, and its part of the rectangle.
pub(super) struct SeenPoint {
    pub point: FacetPoint,
    pub weight: f64,
}

impl View {
    /// The scene's.
    pub fn of(scene: &DiffuseScene) -> Self {
        let camera = scene.camera();
        let film = scene.scene().sensor().film();
        let (half_extent, parallel) = match camera.projection {
            Projection::Perspective { vertical_fov, aspect, .. } => {
                let half_height = libm::tan(0.5 * vertical_fov);
                let aspect = aspect.unwrap_or(f64::from(film.width) / f64::from(film.height));
                (DVec2::new(aspect * half_height, half_height), false)
            }
            Projection::Orthographic { half_width, half_height } => (DVec2::new(half_width, half_height), true),
            Projection::Hemisphere
            | Projection::Window { .. }
            | Projection::Ray
            | Projection::Surface { .. }
            | Projection::Distant { .. } => {
                unreachable!("DiffuseScene refuses meters")
            }
        };
        Self {
            position: camera.position,
            right: camera.forward.cross(camera.up),
            up: camera.up,
            forward: camera.forward,
            half_extent,
            parallel,
            film,
        }
    }

    /// Corners of the blocks of [`BlockGrid`](crate::film::BlockGrid) in the image, least and largest, row by row.
    pub fn blocks(&self) -> Vec<[DVec2; 2]> {
        let FilmSize { width, height } = self.film;
        let corner = |x: u32, y: u32| {
            let raster =
                DVec2::new(f64::from(x.min(width)) / f64::from(width), f64::from(y.min(height)) / f64::from(height));
            (raster * 2.0 - 1.0) * DVec2::new(1.0, -1.0) * self.half_extent
        };
        let starts = |count: u32| (0..count).step_by(BLOCK_SIDE as usize);
        let block = |x: u32, y: u32| {
            let (a, b) = (corner(x, y), corner(x + BLOCK_SIDE, y + BLOCK_SIDE));
            [a.min(b), a.max(b)]
        };
        starts(height).flat_map(|y| starts(width).map(move |x| block(x, y))).collect()
    }

    /// Points of a rectangle of the image, at least 7 · 4^`divisions` in each triangle that a facet fills of it, and
    /// more where the triangle is seen in part only. The weights are shares of the rectangle's area.
    pub fn points(&self, scene: &DiffuseScene, rectangle: [DVec2; 2], divisions: u32) -> Vec<SeenPoint> {
        let size = rectangle[1] - rectangle[0];
        let mut points = Vec::new();
        for (facet, f) in scene.facets().iter().enumerate() {
            if !self.in_front_of(f.plane()) {
                continue;
            }
            let seen = self.clip(&f.corners, rectangle);
            let image: Polygon = seen.iter().map(|&x| self.project(x)).collect();
            for i in 1..image.len().saturating_sub(1) {
                for part in subdivide([image[0], image[i], image[i + 1]], 1 << divisions) {
                    self.add_points(scene, facet, part, EDGE_DIVISIONS + divisions, &mut points);
                }
            }
        }
        points.iter_mut().for_each(|seen| seen.weight /= size.x * size.y);
        points
    }

    /// Points of a triangle of the image that a facet fills, if nothing lies before it, with areas as weights.
    fn add_points(&self, scene: &DiffuseScene, facet: usize, part: Corners, divisions: u32, out: &mut Vec<SeenPoint>) {
        let plane = scene.facets()[facet].plane();
        let area = area_vector(&part).length();
        let seen = |at: DVec3| {
            let (origin, position) = self.back(at, plane);
            let visible = scene.visible(origin, PrimitiveId::NONE, position, scene.facets()[facet].primitive);
            visible.then_some(FacetPoint { facet, position })
        };
        let middle = centroid(&part);
        // Corners lie on other triangles too.
        let corners = part.map(|corner| seen(corner.lerp(middle, 1e-3)).is_some());
        let points = triangle(part).map(|(at, weight)| (seen(at), weight * area));
        let visible = points.iter().filter(|(point, _)| point.is_some()).count();
        let agreed = corners.iter().all(|&corner| corner == (visible > 0)) && visible % points.len() == 0;
        if agreed {
            out.extend(points.into_iter().filter_map(|(point, weight)| Some(SeenPoint { point: point?, weight })));
        } else if divisions == 0 {
            out.extend(seen(middle).map(|point| SeenPoint { point, weight: area }));
        } else {
            subdivide(part, 2).into_iter().for_each(|part| self.add_points(scene, facet, part, divisions - 1, out));
        }
    }

    fn in_front_of(&self, plane: Plane) -> bool {
        if self.parallel { plane.normal.dot(self.forward) < 0.0 } else { plane.height(self.position) > 0.0 }
    }

    /// The part of a polygon that lies before the camera and within the rectangle.
    fn clip(&self, polygon: &[DVec3], [least, largest]: [DVec2; 2]) -> Polygon {
        let bound = |axis: DVec3, limit: f64, sign: f64| {
            let normal = if self.parallel { axis } else { axis - self.forward * limit };
            let offset = normal.dot(self.position) + if self.parallel { limit } else { 0.0 };
            Plane { normal, offset }.turned(sign)
        };
        let bounds = [
            Plane::at(self.position, self.forward),
            bound(self.right, least.x, 1.0),
            bound(self.right, largest.x, -1.0),
            bound(self.up, least.y, 1.0),
            bound(self.up, largest.y, -1.0),
        ];
        bounds.iter().fold(Polygon::from_slice(polygon), |polygon, bound| bound.clip(&polygon))
    }

    /// Where a point is in the image; the third coordinate is zero.
    fn project(&self, x: DVec3) -> DVec3 {
        let offset = x - self.position;
        let scale = if self.parallel { 1.0 } else { 1.0 / offset.dot(self.forward) };
        DVec3::new(offset.dot(self.right) * scale, offset.dot(self.up) * scale, 0.0)
    }

    /// Where the ray through a point of the image starts, and where it meets a plane.
    fn back(&self, image: DVec3, plane: Plane) -> (DVec3, DVec3) {
        let across = self.right * image.x + self.up * image.y;
        let (origin, direction) =
            if self.parallel { (self.position + across, self.forward) } else { (self.position, across + self.forward) };
        (origin, origin - direction * (plane.height(origin) / plane.normal.dot(direction)))
    }
}
