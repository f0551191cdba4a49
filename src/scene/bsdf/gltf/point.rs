//! From the description of glTF's material to the model at a point.

use glam::DVec3;

use super::super::MaterialError;
use super::super::fresnel::Interface;
use super::super::perturbed::{TurnedFrame, TurnedNormal};
use super::super::source::share;
use super::facets::Facets;
use super::sheen::Sheen;
use super::{Body, Coat, Gltf};
use crate::scene::description::{GltfDescription, GltfVolume, NormalSource, Slot};
use crate::scene::texture::{SurfacePoint, clamped};
use crate::spectrum::Rgb;

/// What smaller roughness is raised to, α of the square of the roughness: narrower lobes are mirrors to the eye.
const SMALLEST_ALPHA: f64 = 1e-4;

/// What the index of refraction of a solid exceeds one by at least: below it directions lose the lobe's digits.
const SMALLEST_CONTRAST: f64 = 1e-6;

/// Refuses what no texture could make right.
pub(in super::super) fn check(description: &GltfDescription) -> Result<(), MaterialError> {
    let GltfDescription { base_color, metallic_roughness, specular, specular_color, transmission, .. } = description;
    let colour = |slot: &Slot| Rgb::new(slot.factor[0], slot.factor[1], slot.factor[2]);
    share("base_color", colour(base_color))?;
    let mut shares = vec![
        ("roughness", metallic_roughness.factor[1]),
        ("metallic", metallic_roughness.factor[2]),
        ("specular", specular.factor[3]),
        ("transmission", transmission.factor[0]),
    ];
    for channel in specular_color.factor {
        number("specular_color", channel, channel >= 0.0 && channel.is_finite(), "0 … ∞")?;
    }
    let infinite = description.ior == 0.0 && !description.transmits();
    let range = "1 … 100, or 0 for infinity where nothing is transmitted";
    number("ior", description.ior, infinite || (1.0..=100.0).contains(&description.ior), range)?;
    if let Some(GltfVolume { thickness, attenuation_color, attenuation_distance }) = &description.volume {
        let thickness = thickness.factor[1];
        number("thickness", thickness, thickness >= 0.0 && thickness.is_finite(), "0 … ∞")?;
        share("attenuation_color", *attenuation_color)?;
        number("attenuation_distance", *attenuation_distance, *attenuation_distance > 0.0, "above 0")?;
    }
    if let Some(coat) = &description.clearcoat {
        shares.extend([("clearcoat", coat.factor.factor[0]), ("clearcoat_roughness", coat.roughness.factor[1])]);
    }
    if let Some(sheen) = &description.sheen {
        share("sheen_color", colour(&sheen.color))?;
        shares.push(("sheen_roughness", sheen.roughness.factor[3]));
    }
    if let Some(anisotropy) = &description.anisotropy {
        shares.push(("anisotropy", anisotropy.strength));
        number("anisotropy_rotation", anisotropy.rotation, anisotropy.rotation.is_finite(), "any finite number")?;
    }
    shares.into_iter().try_for_each(|(name, value)| number(name, value, (0.0..=1.0).contains(&value), "0 … 1"))
}

fn number(parameter: &'static str, value: f64, valid: bool, range: &'static str) -> Result<(), MaterialError> {
    if valid { Ok(()) } else { Err(MaterialError::Number { parameter, value, range }) }
}

/// A roughness as α.
fn alpha(roughness: f64) -> f64 {
    let roughness = clamped(roughness, 0.0, 1.0);
    (roughness * roughness).max(SMALLEST_ALPHA)
}

/// How slots are looked up: at a point, or without one.
trait Lookup {
    fn slot(&self, slot: &Slot) -> [f64; 4];
    fn frame(&self, normal: &NormalSource) -> Option<TurnedFrame>;
    fn point(&self) -> Option<&SurfacePoint<'_>>;
}

impl Lookup for SurfacePoint<'_> {
    fn slot(&self, slot: &Slot) -> [f64; 4] {
        slot.at(self)
    }

    fn frame(&self, normal: &NormalSource) -> Option<TurnedFrame> {
        Some(TurnedNormal::new(normal, self).frame_as_it_is())
    }

    fn point(&self) -> Option<&SurfacePoint<'_>> {
        Some(self)
    }
}

/// Halfway, where there is a texture.
struct Typical;

impl Lookup for Typical {
    fn slot(&self, slot: &Slot) -> [f64; 4] {
        if slot.texture.is_some() { slot.factor.map(|x| 0.5 * x) } else { slot.factor }
    }

    fn frame(&self, _: &NormalSource) -> Option<TurnedFrame> {
        None
    }

    fn point(&self) -> Option<&SurfacePoint<'_>> {
        None
    }
}

impl Gltf {
    /// At a point, with the values of the textures there, clamped to what the model can use.
    pub(in super::super) fn at(description: &GltfDescription, at: &SurfacePoint<'_>) -> Self {
        Self::look_up(description, at)
    }

    /// The same without a point: textures are halfway.
    pub(in super::super) fn typical(description: &GltfDescription) -> Self {
        Self::look_up(description, &Typical)
    }

    fn look_up(description: &GltfDescription, at: &impl Lookup) -> Self {
        let one = |x: f64| clamped(x, 0.0, 1.0);
        let rgb = |slot: &Slot| {
            let [r, g, b, _] = at.slot(slot);
            Rgb::new(r, g, b)
        };
        let [_, roughness, metallic, _] = at.slot(&description.metallic_roughness);
        let along_normal = (1.0 - description.ior) / (1.0 + description.ior);
        let colour = rgb(&description.specular_color).map(|x| clamped(x, 0.0, f64::MAX));
        let frame = description.normal.as_ref().and_then(|normal| at.frame(normal));
        let anisotropy = description.anisotropy.as_ref().map(|_| facets(description, alpha(roughness), at, frame));
        Self {
            base: rgb(&description.base_color).map(one),
            metallic: one(metallic),
            facets: anisotropy.unwrap_or_else(|| Facets::isotropic(alpha(roughness))),
            f0: (colour * (along_normal * along_normal)).map(one),
            specular: one(at.slot(&description.specular)[3]),
            transmission: one(at.slot(&description.transmission)[0]),
            body: body(description, at),
            sheen: description.sheen.as_ref().map(|sheen| {
                let roughness = clamped(at.slot(&sheen.roughness)[3], 0.0, 1.0);
                Sheen::new(rgb(&sheen.color).map(one), roughness)
            }),
            coat: description.clearcoat.as_ref().map(|coat| Coat {
                share: one(at.slot(&coat.factor)[0]),
                facets: Facets::isotropic(alpha(at.slot(&coat.roughness)[1])),
                frame: coat.normal.as_ref().and_then(|normal| at.frame(normal)),
            }),
            frame,
        }
    }
}

fn body(description: &GltfDescription, at: &impl Lookup) -> Body {
    if !description.transmits() {
        return Body::Opaque;
    }
    let Some(volume) = description.volume.as_ref().filter(|volume| !volume.thickness.vanishes(1)) else {
        return Body::Thin;
    };
    let depth = clamped(at.slot(&volume.thickness)[1], 0.0, f64::MAX) / volume.attenuation_distance;
    // A path crosses the surface twice.
    let tint = volume.attenuation_color.map(|x| libm::pow(x, 0.5 * depth));
    Body::Solid { interface: Interface::new(description.ior.max(1.0 + SMALLEST_CONTRAST), 1.0), tint }
}

/// α of the direction is `mix(α, 1, strength²)` (KHR_materials_anisotropy).
fn facets(description: &GltfDescription, alpha: f64, at: &impl Lookup, frame: Option<TurnedFrame>) -> Facets {
    let Some(anisotropy) = &description.anisotropy else { return Facets::isotropic(alpha) };
    let (mut direction, mut strength) = ([1.0, 0.0], anisotropy.strength);
    if let (Some(texture), Some(point)) = (&anisotropy.texture, at.point()) {
        let [r, g, b, _] = texture.eval(point);
        let (x, y) = (2.0 * r - 1.0, 2.0 * g - 1.0);
        let length = (x * x + y * y).sqrt();
        if length > 0.0 && length.is_finite() {
            direction = [x / length, y / length];
        }
        strength *= clamped(b, 0.0, 1.0);
    }
    let (s, c) = libm::sincos(anisotropy.rotation);
    let [x, y] = [c * direction[0] - s * direction[1], s * direction[0] + c * direction[1]];
    // The second axis goes against v.
    let against_v = at.point().is_some_and(|point| {
        let along_v = frame.map_or(point.tangents[1], |frame| frame.to_nested(point.tangents[1]));
        along_v.y >= 0.0
    });
    let axis = [x, if against_v { -y } else { y }];
    Facets::along(axis, [alpha + (1.0 - alpha) * strength * strength, alpha])
}

/// `(1 − cos θ)⁵`, Schlick's approximation of how Fresnel's reflectance rises to one.
#[inline]
pub(super) fn schlick(cos: f64) -> f64 {
    let x = (1.0 - cos).max(0.0);
    (x * x) * (x * x) * x
}

/// Mirrored at the surface.
#[inline]
pub(super) fn mirrored(v: DVec3) -> DVec3 {
    DVec3::new(v.x, v.y, -v.z)
}
