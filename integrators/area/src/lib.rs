//! `area`: all vertices of a path drawn on the surfaces of the scene, uniformly by area, length by length: p(x̄) is a plain
//! product of `1/A`. It is the rendering equation over areas (Kajiya 1986) term by term, and as noisy as simple.

use std::ops::RangeInclusive;
use std::sync::Arc;

use pathspace::estimator::SamplerEntry;
use pathspace::path::{Path, Technique};
use pathspace::sampler::{PathSampler, Random, Tracer, samples_for_all_pixels};
use pathspace::scene::Scene;
use pathspace::scene::emitter::Emitter;
use pathspace::scene::sensor::Pixel;
use pathspace::wide::Wide;

/// For the registry.
pub const SAMPLER: SamplerEntry = SamplerEntry {
    name: "area",
    summary: "all vertices by area on the surfaces: p is a product of 1/A",
    build: |_| Ok(Arc::new(AreaSampler)),
};

/// `p(x̄) = A^−k p(x_k | x_{k−1})`: k points on surfaces of area A, and one on the sensor for the last of them. Each sample
/// serves whichever pixel sees it.
#[derive(Clone, Copy, Debug)]
pub struct AreaSampler;

impl PathSampler for AreaSampler {
    fn sample(
        &self,
        lengths: RangeInclusive<u32>,
        tracer: &mut Tracer<'_>,
        random: &mut Random,
        _pixel: Pixel,
        give: &mut dyn FnMut(Path),
    ) {
        let scene = tracer.scene();
        let Some(surfaces) = scene.surfaces() else { return };
        // Shorter paths are the longer ones without what they begin with at the emitter.
        let mut from_sensor = Vec::new();
        for edges in 1..=*lengths.end() {
            from_sensor.push((surfaces.sample(scene, random.uniform3()), false));
            if edges == 1 {
                let Some(direct) = scene.sensor().sample_direct(scene, &from_sensor[0].0, random) else { return };
                from_sensor.insert(0, (direct.vertex, false));
            }
            if lengths.contains(&edges)
                && let Some(path) = Path::new(from_sensor.iter().rev().copied())
            {
                give(path);
            }
        }
    }

    fn density(&self, scene: &Scene, path: &Path) -> Wide {
        let Some(surfaces) = scene.surfaces() else { return Wide::ZERO };
        let k = path.edges();
        let on_surfaces = (0..k).all(|i| path.vertex(i).scatters() && !path.is_dirac(i));
        if !on_surfaces {
            return Wide::ZERO;
        }
        let direct = scene.sensor().direct_density(path.vertex(k - 1), path.vertex(k));
        Wide::new(surfaces.density().value()).powf(k as f64) * direct.value()
    }

    fn count(&self, scene: &Scene) -> f64 {
        samples_for_all_pixels(scene)
    }

    fn technique(&self, edges: u32) -> Technique {
        Technique { s: edges, t: 1 }
    }

    fn ends(&self) -> bool {
        false
    }

    fn covers(&self, scene: &Scene) -> Result<(), String> {
        let on_surface = Emitter::is_surface;
        if !scene.emitters().iter().all(on_surface) {
            return Err("area finds light that surfaces emit, and the scene has other lights".into());
        }
        if scene.has_dirac_surfaces() {
            return Err("area draws no path over mirrors or smooth glass, which the scene has".into());
        }
        Ok(())
    }
}
