//! Rays on behalf of one sample, counted.

use glam::DVec3;

use crate::path::Vertex;
use crate::scene::Scene;

/// A scene through the eyes of an integrator: the same queries, counted.
#[derive(Debug)]
pub struct Tracer<'a> {
    scene: &'a Scene,
    rays: u64,
}

impl<'a> Tracer<'a> {
    /// No rays yet.
    #[must_use]
    pub fn new(scene: &'a Scene) -> Self {
        Self { scene, rays: 0 }
    }

    /// The scene.
    #[must_use]
    #[inline]
    pub fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// Rays and segments traced so far.
    #[must_use]
    pub fn rays(&self) -> u64 {
        self.rays
    }

    /// Counts rays that another one has traced for the same sample.
    pub fn count(&mut self, rays: u64) {
        self.rays += rays;
    }

    /// [`Scene::trace`], counted.
    #[must_use]
    #[inline]
    pub fn trace(&mut self, from: &Vertex, direction: DVec3) -> Option<Vertex> {
        self.rays += 1;
        self.scene.trace(from, direction)
    }

    /// [`Scene::visible`], counted.
    #[must_use]
    #[inline]
    pub fn visible(&mut self, a: &Vertex, b: &Vertex) -> bool {
        self.rays += 1;
        self.scene.visible(a, b)
    }
}
