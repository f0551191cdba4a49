//! Closed forms of DESIGN.md, section 5, and agreement of independent formulas.

use glam::DVec3;

use super::*;
use crate::scene::description::FilmSize;
use crate::spectrum::Rgb;
use crate::testing::scenes;

const FILM: FilmSize = FilmSize { width: 16, height: 16 };

fn square(origin: DVec3, u: DVec3, v: DVec3) -> [DVec3; 4] {
    [origin, origin + u, origin + u + v, origin + v]
}

fn check(what: &str, found: f64, exact: f64, tolerance: f64) {
    let error = (found / exact - 1.0).abs();
    println!("{what}: {found:.14}, relative error {error:.1e}");
    assert!(error < tolerance, "{what}: {found} is not {exact}, relative error {error:e}");
}

#[test]
fn known_form_factors() {
    let floor = square(DVec3::ZERO, DVec3::X, DVec3::Y);
    let wall = square(DVec3::ZERO, DVec3::Y, DVec3::Z);
    let above = square(DVec3::Z, DVec3::Y, DVec3::X);
    let long = square(DVec3::ZERO, DVec3::X, DVec3::Y * 2.0);
    let above_long = square(DVec3::Z * 0.5, DVec3::Y * 2.0, DVec3::X);
    check("squares with an edge in common", form_factor(&floor, &wall), 0.20004377607540, 1e-10);
    check("opposed squares", form_factor(&floor, &above), 0.19982489569839, 1e-10);
    check("opposed rectangles", form_factor(&long, &above_long), 0.50898866904144, 1e-10);
}
