//! The built-in integrators and samplers, all in one registry.

use pathspace::estimator::Registry;

/// What `pathspace list` shows.
#[must_use]
pub fn registry() -> Registry {
    Registry::default()
        .with(pathspace_bdpt::ENTRY)
        .with(pathspace_path::ENTRY)
        .with(pathspace_light::ENTRY)
        .with(pathspace_path_bsdf::ENTRY)
        .with_sampler(pathspace_direct::SAMPLER)
        .with_sampler(pathspace_area::SAMPLER)
        .with_sampler(pathspace_walks::SAMPLER)
}
