//! Textures: images, how they are sampled, and where on the surface.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use glam::{DAffine2, DMat2, DVec2};
use serde_json::Value;

use super::accessor::Accessors;
use super::buffers;
use super::document::Document;
use super::exact::{Sampler, TextureInfo};
use super::fault::{Fault, place};
use super::tally::Tally;
use crate::scene::texture::{self, Bitmap, Filter, ImageError, Texture, Wrap};

/// Most bytes of an image's file.
const MOST_BYTES: u64 = 1 << 30;

/// What the mesh's vertex colours are called.
pub(super) const COLOURS: &str = "vertex_color_0";

/// What a set of texture coordinates is called that is not the mesh's first.
pub(super) fn coordinates_name(set: usize) -> String {
    format!("vertex_texcoord_{set}")
}

/// Reads the textures of one file, each image once for every way in which it is used.
pub(super) struct Textures<'a> {
    pub document: &'a Document,
    pub accessors: &'a Accessors<'a>,
    pub folder: &'a Path,
    bitmaps: HashMap<(usize, bool, Option<usize>), Arc<Bitmap>>,
}

impl<'a> Textures<'a> {
    pub(super) fn new(document: &'a Document, accessors: &'a Accessors<'a>, folder: &'a Path) -> Self {
        Self { document, accessors, folder, bitmaps: HashMap::new() }
    }

    /// A texture of a material. `raw` says that its numbers are no colours; `main` is the set of texture coordinates that the
    /// meshes of the material have as their own.
    pub(super) fn read(
        &mut self,
        info: &TextureInfo,
        raw: bool,
        main: usize,
        here: &str,
        tally: &mut Tally,
    ) -> Result<Texture, Fault> {
        let Transform { to_uv, set } = Transform::of(info, here)?;
        let bitmap = self.bitmap(info.index, raw, here, tally)?;
        let texture = Texture::Bitmap { bitmap, to_uv };
        Ok(if set == main {
            texture
        } else {
            Texture::OtherCoordinates { of: Box::new(texture), attribute: coordinates_name(set) }
        })
    }

    fn bitmap(&mut self, index: usize, raw: bool, here: &str, tally: &mut Tally) -> Result<Arc<Bitmap>, Fault> {
        let invalid = |problem: String| Fault::invalid(here, problem, "correct the file or export it again");
        let exact = &self.document.exact;
        let Some(found) = exact.textures.get(index) else {
            return Err(invalid(format!("textures[{index}] does not exist")));
        };
        let Some(image) = found.source else {
            let feature = format!("textures without a PNG or JPEG image (textures[{index}])");
            return Err(Fault::unsupported(here, feature, "export its image as PNG or JPEG"));
        };
        let sampler = match found.sampler {
            None => Sampler::default(),
            Some(sampler) => match exact.samplers.get(sampler) {
                Some(found) => found.clone(),
                None => return Err(invalid(format!("samplers[{sampler}] does not exist"))),
            },
        };
        tally.mipmaps |= sampler.min_filter.is_some_and(|filter| (9984..=9987).contains(&filter));
        let key = (image, raw, found.sampler);
        if let Some(known) = self.bitmaps.get(&key) {
            return Ok(known.clone());
        }
        let wrap = [wrap(sampler.wrap_s, here)?, wrap(sampler.wrap_t, here)?];
        let filter = match sampler.mag_filter {
            None | Some(9729) => Filter::Bilinear,
            Some(9728) => Filter::Nearest,
            Some(other) => return Err(invalid(format!("magFilter {other} is unknown"))),
        };
        let (name, (width, height, texels)) = self.image(image, raw)?;
        let bitmap = Arc::new(Bitmap { name, width, height, texels, filter, wrap });
        self.bitmaps.insert(key, bitmap.clone());
        Ok(bitmap)
    }

    fn image(&self, index: usize, raw: bool) -> Result<(String, (u32, u32, texture::Texels)), Fault> {
        let image = self.document.exact.images.get(index);
        let here = place("images", index, image.and_then(|image| image.name.as_deref()));
        let invalid = |problem: String, remedy: &str| Fault::invalid(&here, problem, remedy);
        let Some(image) = image else {
            return Err(invalid("does not exist".into(), "correct the file or export it again"));
        };
        let (name, bytes) = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => {
                let name = if uri.starts_with("data:") { here.clone() } else { uri.clone() };
                (name, buffers::fetch(uri, MOST_BYTES, self.folder, &here)?)
            }
            (None, Some(view)) => (here.clone(), self.accessors.bytes(view, &here)?.to_vec()),
            (None, None) => {
                return Err(invalid(
                    "has neither `uri` nor `bufferView`".into(),
                    "correct the file or export it again",
                ));
            }
        };
        let cause = |error: ImageError| match error {
            ImageError::Unreadable { cause, .. } | ImageError::Broken { cause, .. } => cause,
        };
        let decoded = texture::decode(&bytes, &name, raw).map_err(|error| {
            invalid(format!("is no image that can be read ({})", cause(error)), "store it as PNG or JPEG")
        })?;
        Ok((name, decoded))
    }
}

fn wrap(mode: Option<u32>, here: &str) -> Result<Wrap, Fault> {
    match mode {
        None | Some(10497) => Ok(Wrap::Repeat),
        Some(33648) => Ok(Wrap::Mirror),
        Some(33071) => Ok(Wrap::Clamp),
        Some(other) => Err(Fault::invalid(
            here,
            format!("the wrapping mode {other} is unknown"),
            "correct the file or export it again",
        )),
    }
}

/// From the mesh's texture coordinates to the image's (KHR_texture_transform): scaled, turned, then moved.
pub(super) struct Transform {
    pub to_uv: DAffine2,
    /// The set of texture coordinates.
    pub set: usize,
}

impl Transform {
    pub(super) fn of(info: &TextureInfo, here: &str) -> Result<Self, Fault> {
        let Some(extension) = info.extensions.get("KHR_texture_transform") else {
            return Ok(Self { to_uv: DAffine2::IDENTITY, set: info.tex_coord });
        };
        let wrong = |key: &str| {
            let place = format!("{here}.KHR_texture_transform.{key}");
            Fault::invalid(
                place,
                "is not what it must be",
                "give finite numbers: two for offset and scale, one for rotation",
            )
        };
        let pair = |key: &str, default: f64| match extension.get(key) {
            None => Ok(DVec2::splat(default)),
            Some(value) => serde_json::from_value::<[f64; 2]>(value.clone())
                .ok()
                .map(DVec2::from)
                .filter(|pair| pair.is_finite())
                .ok_or_else(|| wrong(key)),
        };
        let rotation = match extension.get("rotation") {
            None => 0.0,
            Some(value) => value.as_f64().ok_or_else(|| wrong("rotation"))?,
        };
        let (offset, scale) = (pair("offset", 0.0)?, pair("scale", 1.0)?);
        let (s, c) = libm::sincos(rotation);
        // Counter-clockwise where v points up, and in images it points down.
        let turn = DMat2::from_cols(DVec2::new(c, -s), DVec2::new(s, c));
        let set = extension.get("texCoord").and_then(Value::as_u64).map_or(info.tex_coord, |set| set as usize);
        Ok(Self { to_uv: DAffine2 { matrix2: turn * DMat2::from_diagonal(scale), translation: offset }, set })
    }
}
