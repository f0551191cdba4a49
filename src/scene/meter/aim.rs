//! From what a meter says to a sensor in a scene.

use glam::DVec3;

use super::surface::Rectangle;
use super::{Meter, MeterError, Region};
use crate::scene::SceneDescription;
use crate::scene::description::{LightKind, Projection, SensorDescription};

/// How a meter is read off a film.
#[derive(Clone, Debug, PartialEq)]
pub struct Aim {
    /// What is measured.
    pub quantity: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// The sensor.
    pub sensor: SensorDescription,
    /// What the mean over its pixels is multiplied by.
    pub scale: f64,
}

impl Meter {
    /// Its sensor in a scene.
    ///
    /// # Errors
    /// Where the scene has no such surface, or the quantity has no value in it.
    pub fn aim(&self, scene: &SceneDescription) -> Result<Aim, MeterError> {
        match self {
            &Self::Irradiance { position, normal } => {
                let sensor =
                    sensor("irradiance", position, normal, normal.any_orthonormal_vector(), Projection::Hemisphere);
                Ok(Aim { quantity: "irradiance", unit: "W/m²", sensor, scale: 1.0 })
            }
            Self::MeanIrradiance(region) => Ok(Aim {
                quantity: "mean irradiance",
                unit: "W/m²",
                sensor: region.rectangle(scene)?.window(),
                scale: 1.0,
            }),
            Self::Flux(region) => Ok(flux("flux", region.rectangle(scene)?)),
            Self::FluxLeaving(name) => {
                let front = Rectangle::in_front_of(scene, name)?;
                Ok(flux("flux leaving", Rectangle { forward: -front.forward, ..front }))
            }
            &Self::Radiance { position, direction } => {
                refuse_point_lights(scene, position, direction)?;
                let right = direction.any_orthonormal_vector();
                let sensor = sensor("radiance", position, direction, right, Projection::Ray);
                Ok(Aim { quantity: "radiance", unit: "W/m²/sr", sensor, scale: 1.0 })
            }
            &Self::Intensity { direction } => intensity(direction, scene),
        }
    }

    /// Whether the surface that it names, if any, is there and can be measured at.
    ///
    /// # Errors
    /// As [`aim`](Self::aim), for that reason alone.
    pub fn check_surface(&self, scene: &SceneDescription) -> Result<(), MeterError> {
        match self {
            Self::MeanIrradiance(Region::Surface(name))
            | Self::Flux(Region::Surface(name))
            | Self::FluxLeaving(name) => Rectangle::in_front_of(scene, name).map(|_| ()),
            _ => Ok(()),
        }
    }
}

impl Region {
    fn rectangle(&self, scene: &SceneDescription) -> Result<Rectangle, MeterError> {
        match self {
            Self::Surface(name) => Rectangle::in_front_of(scene, name),
            &Self::Rectangle { corner, u, v } => Ok(Rectangle {
                centre: corner + 0.5 * (u + v),
                right: u.normalize(),
                forward: u.cross(v).normalize(),
                half: [0.5 * u.length(), 0.5 * v.length()],
            }),
        }
    }
}

impl Rectangle {
    fn window(&self) -> SensorDescription {
        let [half_width, half_height] = self.half;
        sensor("window", self.centre, self.forward, self.right, Projection::Window { half_width, half_height })
    }
}

fn flux(quantity: &'static str, rectangle: Rectangle) -> Aim {
    Aim { quantity, unit: "W", sensor: rectangle.window(), scale: rectangle.area() }
}

fn sensor(name: &str, position: DVec3, forward: DVec3, right: DVec3, projection: Projection) -> SensorDescription {
    SensorDescription {
        name: name.into(),
        position,
        forward,
        up: right.cross(forward),
        projection,
        window: SensorDescription::WHOLE,
    }
}

/// The radiance of a point is a Dirac distribution.
fn refuse_point_lights(scene: &SceneDescription, position: DVec3, direction: DVec3) -> Result<(), MeterError> {
    for light in &scene.lights {
        let (LightKind::Point { position: at, .. } | LightKind::Spot { position: at, .. }) = light.kind else {
            continue;
        };
        let along = (at - position).dot(direction);
        let beside = (at - position - direction * along).length();
        if along > 0.0 && beside < 1e-9 * along {
            return Err(MeterError::new(
                format!(
                    "the ray meets the point light '{}', whose radiance is no number but a Dirac distribution",
                    light.name
                ),
                "ask for its irradiance",
            ));
        }
    }
    Ok(())
}

/// A parallel projection of everything: `I(ω) = ∫ L cos θ dA` over its film.
fn intensity(direction: DVec3, scene: &SceneDescription) -> Result<Aim, MeterError> {
    if let Some(light) = scene.lights.first() {
        return Err(MeterError::new(
            format!("the light '{}' has no surface, so nothing sees it from afar", light.name),
            "its intensity is its own: take it from the scene",
        ));
    }
    if scene.environment.is_some() {
        let problem = "the environment would be seen behind everything";
        return Err(MeterError::new(problem, "measure in a scene without one"));
    }
    let no_surfaces = || MeterError::new("the scene has no surfaces", "add some");
    let bounds = scene.bounds().ok_or_else(no_surfaces)?;
    let (centre, radius) = (bounds.centre(), bounds.radius() * 1.001);
    let right = direction.any_orthonormal_vector();
    let projection = Projection::Orthographic { half_width: radius, half_height: radius };
    let sensor = sensor("intensity", centre + direction * (2.0 * radius), -direction, right, projection);
    Ok(Aim { quantity: "intensity", unit: "W/sr", sensor, scale: 4.0 * radius * radius })
}
