//! Properties that all models share.
