//! Cameras with views, lenses and films far from the usual.

use glam::DVec2;

use super::super::case::{Case, Stage, Subject};
use super::case;
use super::scenery::unit_enclosure;
use crate::scene::description::Projection;
use crate::testing::scenes::with_lens;

pub(super) fn cases() -> Vec<Case> {
    let new = |name, sweep: (&'static str, &[f64]), stage| case("sensor", name, sweep, Subject::Scene(stage));
    vec![
        new("narrow view", ("degrees", &[60.0, 1.0, 0.1, 1e-2, 1e-3]), view).about("in the closed box: L = 1"),
        new("wide view", ("degrees", &[60.0, 120.0, 170.0, 179.0, 179.9]), view).about("the same"),
        new("aperture", ("radius", &[1e-3, 1e-6, 1e-9, 0.1, 0.6]), |radius| lens(radius, 1.0))
            .about("the same, through a thin lens"),
        new("near focus", ("distance", &[1.0, 0.1, 1e-2, 1e-3]), |distance| lens(0.01, distance)).about("the same"),
        new("far focus", ("distance", &[1.0, 1e3, 1e6, 1e9]), |distance| lens(0.01, distance)).about("the same"),
        new("edge of the film", ("part of the image", &[1.0, 1e-2, 1e-4, 1e-6, 1e-9]), |part| {
            let mut stage = view(60.0);
            if let Some(camera) = &mut stage.scene.sensor {
                camera.window = [DVec2::splat(1.0 - part), DVec2::ONE];
            }
            stage
        })
        .about("the last corner of the image: the same"),
    ]
}

fn view(degrees: f64) -> Stage {
    let mut scene = unit_enclosure(0.5);
    if let Some(camera) = &mut scene.sensor
        && let Projection::Perspective { vertical_fov, .. } = &mut camera.projection
    {
        *vertical_fov = degrees.to_radians();
    }
    Stage::new(scene, 1.0)
}

fn lens(radius: f64, distance: f64) -> Stage {
    let mut stage = view(60.0);
    stage.scene.sensor = stage.scene.sensor.map(|camera| with_lens(camera, radius, distance));
    stage
}
