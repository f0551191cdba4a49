//! Textures as Mitsuba's, and the image files that they need.

use std::path::Path;
use std::sync::Arc;

use glam::DAffine2;
use image::{DynamicImage, Rgb32FImage, RgbImage};

use super::error::ExportError;
use super::xml::Element;
use crate::scene::description::SceneDescription;
use crate::scene::texture::{Bitmap, Filter, Texels, Texture, Wrap};

/// The images that a scene's textures need, each once.
#[derive(Default)]
pub(super) struct Images {
    bitmaps: Vec<(Arc<Bitmap>, String)>,
}

impl Images {
    /// `<texture name="…">`. `raw` says that the numbers are no colours.
    pub(super) fn element(
        &mut self,
        texture: &Texture,
        raw: bool,
        name: &str,
        scene: &SceneDescription,
        place: &str,
    ) -> Result<Element, ExportError> {
        Ok(match texture {
            Texture::Constant([r, g, b, _]) if raw && r == g && g == b => {
                Element::new("float").with("name", name).with("value", format!("{r:?}"))
            }
            Texture::Constant([r, g, b, _]) => {
                Element::new("rgb").with("name", name).with("value", format!("{r:?}, {g:?}, {b:?}"))
            }
            Texture::Bitmap { bitmap, to_uv } => {
                let file = self.file(bitmap);
                let wrap = wrap_mode(bitmap, scene, place)?;
                let filter = if bitmap.filter == Filter::Nearest { "nearest" } else { "bilinear" };
                let element = Element::plugin("texture", "bitmap")
                    .with("name", name)
                    .string("filename", &file)
                    .string("filter_type", filter)
                    .string("wrap_mode", wrap)
                    .boolean("raw", raw && !matches!(bitmap.texels, Texels::Srgb8(_)));
                with_to_uv(element, to_uv)
            }
            Texture::Checkerboard { colours, to_uv } => {
                let element = Element::plugin("texture", "checkerboard").with("name", name);
                let element = element
                    .child(self.element(&colours[0], raw, "color0", scene, place)?)
                    .child(self.element(&colours[1], raw, "color1", scene, place)?);
                with_to_uv(element, to_uv)
            }
            Texture::Attribute { name: attribute } => {
                Element::plugin("texture", "mesh_attribute").with("name", name).string("name", attribute)
            }
            Texture::OtherCoordinates { .. } => {
                let what = "a texture with its own set of texture coordinates";
                return Err(ExportError::unsupported(&scene.name, place, what, "use one set for all textures"));
            }
            Texture::Step { .. } | Texture::Product(_) | Texture::Channel { .. } | Texture::Remapped { .. } => {
                let (bitmap, to_uv) = baked(texture).ok_or_else(|| {
                    let what = "a texture that is computed from several";
                    ExportError::unsupported(&scene.name, place, what, "bake it into one image")
                })?;
                return self.element(&Texture::Bitmap { bitmap: Arc::new(bitmap), to_uv }, raw, name, scene, place);
            }
        })
    }

    /// The file that a bitmap will be in, relative to the scene's.
    pub(super) fn file(&mut self, bitmap: &Arc<Bitmap>) -> String {
        if let Some((_, file)) = self.bitmaps.iter().find(|(known, _)| Arc::ptr_eq(known, bitmap)) {
            return file.clone();
        }
        let ending = if matches!(bitmap.texels, Texels::Float(_)) { "exr" } else { "png" };
        let file = format!("textures/{:04}.{ending}", self.bitmaps.len());
        self.bitmaps.push((bitmap.clone(), file.clone()));
        file
    }

    /// Writes all images below a folder.
    pub(super) fn write(&self, folder: &Path) -> Result<(), ExportError> {
        for (bitmap, file) in &self.bitmaps {
            let path = folder.join(file);
            if let Some(parent) = path.parent() {
                std::fs::create_dir_all(parent).map_err(ExportError::io(parent))?;
            }
            let failed = |error: image::ImageError| ExportError::io(&path)(std::io::Error::other(error));
            picture(bitmap).save(&path).map_err(failed)?;
        }
        Ok(())
    }
}

fn picture(bitmap: &Bitmap) -> DynamicImage {
    let (width, height) = (bitmap.width, bitmap.height);
    match &bitmap.texels {
        Texels::Srgb8(texels) | Texels::Linear8(texels) => RgbImage::from_fn(width, height, |x, y| {
            let [r, g, b, _] = texels[y as usize * width as usize + x as usize];
            image::Rgb([r, g, b])
        })
        .into(),
        Texels::Float(texels) => Rgb32FImage::from_fn(width, height, |x, y| {
            let [r, g, b, _] = texels[y as usize * width as usize + x as usize];
            image::Rgb([r, g, b])
        })
        .into(),
    }
}

fn wrap_mode(bitmap: &Bitmap, scene: &SceneDescription, place: &str) -> Result<&'static str, ExportError> {
    match bitmap.wrap {
        [Wrap::Repeat, Wrap::Repeat] => Ok("repeat"),
        [Wrap::Mirror, Wrap::Mirror] => Ok("mirror"),
        [Wrap::Clamp, Wrap::Clamp] => Ok("clamp"),
        _ => {
            let what = "a texture that is wrapped differently along u and v";
            Err(ExportError::unsupported(&scene.name, place, what, "wrap it alike"))
        }
    }
}

fn with_to_uv(element: Element, to_uv: &DAffine2) -> Element {
    if *to_uv == DAffine2::IDENTITY {
        return element;
    }
    let (m, t) = (to_uv.matrix2, to_uv.translation);
    // Of a matrix of nine numbers Mitsuba would drop the translation.
    let rows = [[m.x_axis.x, m.y_axis.x, 0.0, t.x], [m.x_axis.y, m.y_axis.y, 0.0, t.y], [0.0, 0.0, 1.0, 0.0]];
    let rows = rows.as_flattened().iter().chain(&[0.0, 0.0, 0.0, 1.0]);
    let value = rows.map(|x| format!("{x:?}")).collect::<Vec<_>>().join(" ");
    element.child(Element::new("transform").with("name", "to_uv").child(Element::new("matrix").with("value", value)))
}

/// One image in place of an expression of one image and constants; `None` where interpolation would not commute with it: it
/// does with what is linear, and without interpolation with everything.
fn baked(texture: &Texture) -> Option<(Bitmap, DAffine2)> {
    let mut found = None;
    let (mut simple, mut linear) = (true, true);
    texture.visit(&mut |part| match part {
        Texture::Bitmap { bitmap, to_uv } if found.is_none() => found = Some((bitmap.clone(), *to_uv)),
        Texture::Bitmap { .. }
        | Texture::Checkerboard { .. }
        | Texture::Attribute { .. }
        | Texture::OtherCoordinates { .. } => simple = false,
        Texture::Step { .. } | Texture::Remapped { squared: true, .. } => linear = false,
        _ => {}
    });
    let (bitmap, to_uv) = found.filter(|(bitmap, _)| simple && (linear || bitmap.filter == Filter::Nearest))?;
    let texels = (0..bitmap.height).flat_map(|y| (0..bitmap.width).map(move |x| (x, y)));
    let texels = texels.map(|(x, y)| of_texel(texture, bitmap.texel(x.into(), y.into())).map(|x| x as f32));
    let texels = Texels::Float(texels.collect());
    Some((Bitmap { texels, ..(*bitmap).clone() }, to_uv))
}

/// The expression where its image has this value.
fn of_texel(texture: &Texture, texel: [f64; 4]) -> [f64; 4] {
    match texture {
        Texture::Constant(value) => *value,
        Texture::Product(factors) => factors.iter().fold([1.0; 4], |product, factor| {
            let value = of_texel(factor, texel);
            std::array::from_fn(|i| product[i] * value[i])
        }),
        Texture::Channel { of, channel } => {
            let value = of_texel(of, texel)[*channel];
            [value, value, value, 1.0]
        }
        Texture::Remapped { of, scale, offset, squared } => of_texel(of, texel).map(|x| {
            let y = scale * x + offset;
            if *squared { y * y } else { y }
        }),
        Texture::Step { of, threshold } => of_texel(of, texel).map(|x| if x >= *threshold { 1.0 } else { 0.0 }),
        // The last three are never asked for.
        Texture::Bitmap { .. }
        | Texture::Checkerboard { .. }
        | Texture::Attribute { .. }
        | Texture::OtherCoordinates { .. } => texel,
    }
}
