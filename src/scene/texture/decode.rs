//! Image files: PNG, JPEG, Radiance HDR and OpenEXR.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use exr::meta::MetaData;
use exr::prelude::{ReadChannels, ReadLayers};
use image::{ColorType, DynamicImage, ImageFormat, ImageReader, Limits};
use thiserror::Error;

use super::Texels;

/// Longest side of an image, in pixels.
const LONGEST_SIDE: u32 = 32_768;

/// Most pixels of an image: 16384 × 8192. A small file can promise as many as it likes, and hold as many that are alike.
const MOST_PIXELS: u64 = 1 << 27;

/// Most memory that decoding may take \[B\].
const MOST_MEMORY: u64 = 4 << 30;

/// Why an image cannot be read.
#[derive(Debug, Error)]
pub enum ImageError {
    /// The file is not there or not readable.
    #[error("{} cannot be read ({cause})", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// Why.
        cause: String,
    },
    /// Its content is no image.
    #[error(
        "{name} is no image that can be read ({cause}): PNG, JPEG, HDR and EXR are, up to 32768 pixels a side and 2²⁷ in all"
    )]
    Broken {
        /// The file, or its place in another.
        name: String,
        /// Why.
        cause: String,
    },
}

/// Reads a file. `raw` says that its numbers are not colours: what is stored by the curve of sRGB is linear then.
///
/// # Errors
/// The file is missing, too large or no image.
pub fn read(file: &Path, raw: bool) -> Result<(u32, u32, Texels), ImageError> {
    let unreadable = |cause: String| ImageError::Unreadable { file: file.into(), cause };
    let metadata = std::fs::metadata(file).map_err(|error| unreadable(error.to_string()))?;
    if !metadata.is_file() {
        return Err(unreadable("it is not a regular file".into()));
    }
    let bytes = std::fs::read(file).map_err(|error| unreadable(error.to_string()))?;
    decode(&bytes, &file.display().to_string(), raw)
}

/// The same for the bytes of a file; `name` is for messages.
///
/// # Errors
/// As [`read`].
pub fn decode(bytes: &[u8], name: &str, raw: bool) -> Result<(u32, u32, Texels), ImageError> {
    // Radiance's format has two names for itself, of which the decoder knows one.
    if let Some(rest) = bytes.strip_prefix(b"#?RGBE\n") {
        return decode(&[b"#?RADIANCE\n", rest].concat(), name, raw);
    }
    let broken = |cause: String| ImageError::Broken { name: name.into(), cause };
    let mut reader =
        ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|error| broken(error.to_string()))?;
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(LONGEST_SIDE), Some(LONGEST_SIDE));
    limits.max_alloc = Some(MOST_MEMORY);
    reader.limits(limits);
    if reader.format().is_none() {
        return Err(broken("unknown format".into()));
    }
    let sized = ImageReader::new(Cursor::new(bytes)).with_guessed_format().ok().map(ImageReader::into_dimensions);
    if let Some(Ok((width, height))) = sized
        && u64::from(width) * u64::from(height) > MOST_PIXELS
    {
        return Err(broken(format!("it has {width} × {height} pixels")));
    }
    let floats = matches!(reader.format(), Some(ImageFormat::OpenExr | ImageFormat::Hdr));
    let is_exr = matches!(reader.format(), Some(ImageFormat::OpenExr));
    let image = match reader.decode() {
        Ok(image) => image,
        Err(error) => {
            let grey = if is_exr { grey_exr(bytes) } else { None };
            return grey.ok_or_else(|| broken(error.to_string()));
        }
    };
    let (width, height) = (image.width(), image.height());
    if width == 0 || height == 0 {
        return Err(broken("it has no pixels".into()));
    }
    Ok((width, height, texels(image, floats, raw)))
}

/// An EXR image of a single channel, whatever its name, which the decoder of colours refuses; `None` where it is none.
fn grey_exr(bytes: &[u8]) -> Option<(u32, u32, Texels)> {
    let header = MetaData::read_from_buffered(Cursor::new(bytes), false).ok()?.headers.into_iter().next()?;
    let (width, height) = (u32::try_from(header.layer_size.x()).ok()?, u32::try_from(header.layer_size.y()).ok()?);
    let memory = u64::from(width) * u64::from(height) * size_of::<[f32; 4]>() as u64;
    if width.max(height) > LONGEST_SIDE || memory > MOST_MEMORY || header.channels.list.len() != 1 {
        return None;
    }
    let reader = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels();
    let image = reader.first_valid_layer().all_attributes().non_parallel().from_buffered(Cursor::new(bytes)).ok()?;
    let channel = image.layer_data.channel_data.list.first()?;
    let texels: Vec<[f32; 4]> = channel.sample_data.values_as_f32().map(|x| [x, x, x, 1.0]).collect();
    (texels.len() == width as usize * height as usize).then_some((width, height, Texels::Float(texels)))
}

fn texels(image: DynamicImage, floats: bool, raw: bool) -> Texels {
    if floats {
        return Texels::Float(image.into_rgba32f().pixels().map(|p| p.0).collect());
    }
    let eight_bits = matches!(image.color(), ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8);
    if eight_bits {
        let pixels = image.into_rgba8().pixels().map(|p| p.0).collect();
        return if raw { Texels::Linear8(pixels) } else { Texels::Srgb8(pixels) };
    }
    let pixels = image.into_rgba32f().pixels().map(|p| p.0).collect::<Vec<_>>();
    let linear = |x: f32| super::bitmap::srgb_to_linear(f64::from(x)) as f32;
    Texels::Float(if raw {
        pixels
    } else {
        pixels.into_iter().map(|[r, g, b, a]| [linear(r), linear(g), linear(b), a]).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A PNG of this size in grey, as far as its header goes.
    fn promise(width: u32, height: u32) -> Vec<u8> {
        let chunk = [b"IHDR", &width.to_be_bytes()[..], &height.to_be_bytes(), &[8, 0, 0, 0, 0]].concat();
        let mut crc = flate2::Crc::new();
        crc.update(&chunk);
        let ending = b"\0\0\0\x01IDAT\0";
        [b"\x89PNG\r\n\x1a\n\0\0\0\x0d", &chunk[..], &crc.sum().to_be_bytes(), ending].concat()
    }

    #[test]
    fn absurd_sizes_are_refused_before_memory_is_taken() {
        for (width, height) in [(40_000, 1), (1, 40_000), (30_000, 30_000), (u32::MAX, u32::MAX), (0, 7)] {
            let error = decode(&promise(width, height), "a.png", false).unwrap_err().to_string();
            assert!(error.starts_with("a.png is no image that can be read"), "{error}");
        }
        let error = decode(&promise(30_000, 30_000), "a.png", false).unwrap_err().to_string();
        assert!(error.contains("it has 30000 × 30000 pixels"), "{error}");
    }
}
