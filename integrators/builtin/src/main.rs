//! The command `pathspace` with the built-in integrators.

fn main() {}
