//! The integrator `path_bsdf`.
