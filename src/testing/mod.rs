//! Checks that an author of an integrator calls, and the small scenes to call them on.

pub mod definition;
pub mod ends;
pub mod radiosity;
pub mod scenes;
pub mod stability;
pub mod verify;
