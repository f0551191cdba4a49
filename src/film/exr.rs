//! OpenEXR files: linear images in single precision, with layers and metadata.
//!
//! One part holds all channels. The image itself is `R`, `G`, `B`; a further layer is `name.R`, `name.G`, `name.B`, the
//! convention by which viewers group channels. Metadata are attributes of the header: `software`, `comments`, and
//! `scene`, `integrator`, `settings` (JSON), `seed`, `samplesPerPixel` (both as text: they may exceed 32 bits),
//! `renderSeconds`, `pathspaceVersion`. What else a file has to say is text under a name of its own, such as `layers`, see
//! [`super::LayerListing`].

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::Path;

use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, Text};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Layer, LayerAttributes, ReadChannels, ReadLayers, SmallVec, Vec2,
    WritableImage,
};

use crate::spectrum::Rgb;

use super::error::FileError;
use super::image::{Image, pixel_count};
use super::output::{RenderInfo, write_atomically};

/// A further layer of an EXR file.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedLayer {
    /// Its name, such as `standard_error`: not empty and unlike the others.
    pub name: String,
    /// Its pixels, as many as the image has.
    pub image: Image,
}

/// Writes an image of `spp` samples per pixel with its further layers, metadata, and `texts` under their names; atomically,
/// and without loss beyond the rounding to single precision. Layers are taken one by one, so that not all of them need be
/// held in double precision.
///
/// # Errors
/// When a layer has no name, a name twice or another size, or the file cannot be written.
pub fn write_exr(
    path: &Path,
    image: &Image,
    layers: impl IntoIterator<Item = NamedLayer>,
    info: &RenderInfo,
    spp: u64,
    texts: &[(&str, String)],
) -> Result<(), FileError> {
    let mut channels = SmallVec::new();
    push_channels(&mut channels, "", image);
    let mut names = BTreeSet::new();
    for layer in layers {
        let refuse = |what| FileError::Layer { path: path.to_owned(), layer: layer.name.clone(), what };
        if layer.name.is_empty() || layer.name.len() > 200 || layer.name.contains('\0') {
            return Err(refuse("its name must have 1 to 200 bytes"));
        }
        if !names.insert(layer.name.clone()) {
            return Err(refuse("another one has the same name"));
        }
        if (layer.image.width, layer.image.height) != (image.width, image.height) {
            return Err(refuse("it has another size than the image"));
        }
        push_channels(&mut channels, &format!("{}.", layer.name), &layer.image);
    }
    let size = Vec2(image.width as usize, image.height as usize);
    let mut attributes = attributes(info, spp);
    for (name, value) in texts {
        attributes.other.insert(text(name), AttributeValue::Text(text(value)));
    }
    let layer = Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(channels));
    let file = exr::prelude::Image::from_layer(layer);
    write_atomically(path, |writer| {
        file.write().non_parallel().to_buffered(writer).map_err(|error| match error {
            exr::error::Error::Io(error) => error,
            other => io::Error::other(other),
        })
    })
}

fn text(value: &str) -> Text {
    Text::from_slice_unchecked(value.as_bytes())
}

fn string(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}

fn push_channels(channels: &mut SmallVec<[AnyChannel<FlatSamples>; 4]>, prefix: &str, image: &Image) {
    let mut push = |channel: &str, value: fn(&Rgb) -> f64| {
        let samples = image.pixels.iter().map(|pixel| value(pixel) as f32).collect();
        channels.push(AnyChannel::new(text(&format!("{prefix}{channel}")), FlatSamples::F32(samples)));
    };
    push("R", |pixel| pixel.r);
    push("G", |pixel| pixel.g);
    push("B", |pixel| pixel.b);
}

fn attributes(info: &RenderInfo, spp: u64) -> LayerAttributes {
    let mut attributes = LayerAttributes {
        software_name: Some(text(&format!("pathspace {}", info.version))),
        comments: Some(text(&format!(
            "{}, {}, {spp} samples per pixel, seed {}, {:.3} s",
            info.scene, info.integrator, info.seed, info.render_seconds
        ))),
        ..LayerAttributes::default()
    };
    let entries = [
        ("scene", info.scene.clone()),
        ("integrator", info.integrator.clone()),
        ("settings", info.settings.to_string()),
        ("seed", info.seed.to_string()),
        ("samplesPerPixel", spp.to_string()),
        ("pathspaceVersion", info.version.clone()),
    ];
    for (name, value) in entries {
        attributes.other.insert(text(name), AttributeValue::Text(text(&value)));
    }
    attributes.other.insert(text("renderSeconds"), AttributeValue::F64(info.render_seconds));
    attributes
}

/// Reads `R`, `G`, `B` of the first part that has them, of any sample type.
///
/// # Errors
/// When the file cannot be read, is damaged, holds no `R`, `G`, `B`, or more than 2²⁸ pixels.
pub fn read_exr(path: &Path) -> Result<Image, FileError> {
    let failed = |error| failed(path, error);
    check_sizes(path)?;
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| Image { width: side(size.0), height: side(size.1), pixels: vec![Rgb::BLACK; size.area()] },
            |image: &mut Image, Vec2(x, y), (r, g, b): (f32, f32, f32)| {
                image.pixels[y * image.width as usize + x] = Rgb::new(f64::from(r), f64::from(g), f64::from(b));
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_file(path)
        .map_err(failed)?;
    Ok(image.layer_data.channel_data.pixels)
}

/// A file with all its layers.
#[derive(Clone, Debug, PartialEq)]
pub struct LayeredImage {
    /// By name; the image itself has none. Only those with all of `R`, `G`, `B`.
    pub layers: BTreeMap<String, Image>,
    /// Metadata that are text, by name.
    pub texts: BTreeMap<String, String>,
}

/// Reads all layers of the first part that `wanted` names; the empty name is that of the image itself.
///
/// # Errors
/// When the file cannot be read, is damaged, or has more than 2²⁸ pixels.
pub fn read_layers(path: &Path, wanted: impl Fn(&str) -> bool) -> Result<LayeredImage, FileError> {
    check_sizes(path)?;
    let read = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer();
    let read = read.all_attributes().non_parallel().from_file(path).map_err(|error| failed(path, error))?;
    let Vec2(width, height) = read.layer_data.size;
    let mut layers: BTreeMap<String, [Option<FlatSamples>; 3]> = BTreeMap::new();
    for channel in read.layer_data.channel_data.list {
        let name = string(&channel.name);
        let (layer, colour) = name.rsplit_once('.').unwrap_or(("", &name));
        let place = ["R", "G", "B"].iter().position(|&known| known == colour);
        if let Some(place) = place.filter(|_| wanted(layer) && channel.sampling == Vec2(1, 1)) {
            layers.entry(layer.to_owned()).or_default()[place] = Some(channel.sample_data);
        }
    }
    let whole = layers.into_iter().filter_map(|(name, channels)| {
        let [Some(r), Some(g), Some(b)] = channels else { return None };
        let colours = r.values_as_f32().zip(g.values_as_f32()).zip(b.values_as_f32());
        let pixels = colours.map(|((r, g), b)| Rgb::new(r.into(), g.into(), b.into())).collect();
        Some((name, Image::new(side(width), side(height), pixels)))
    });
    let broken = |error: super::FilmError| FileError::Exr { path: path.to_owned(), what: error.to_string() };
    let layers: Result<_, _> = whole.map(|(name, image)| Ok((name, image.map_err(broken)?))).collect();
    let texts = read.layer_data.attributes.other.iter().filter_map(|(name, value)| match value {
        AttributeValue::Text(value) => Some((string(name), string(value))),
        _ => None,
    });
    Ok(LayeredImage { layers: layers?, texts: texts.collect() })
}

fn failed(path: &Path, error: exr::error::Error) -> FileError {
    match error {
        exr::error::Error::Io(source) if source.kind() != io::ErrorKind::UnexpectedEof => {
            FileError::Read { path: path.to_owned(), source }
        }
        exr::error::Error::Io(_) => FileError::Exr { path: path.to_owned(), what: "it ends too early".to_owned() },
        other => FileError::Exr { path: path.to_owned(), what: other.to_string() },
    }
}

fn side(length: usize) -> u32 {
    u32::try_from(length).unwrap_or(u32::MAX)
}

/// The size that a damaged header claims must not be allocated unseen.
fn check_sizes(path: &Path) -> Result<(), FileError> {
    let headers = MetaData::read_from_file(path, false).map_err(|error| failed(path, error))?.headers;
    for header in &headers {
        let Vec2(width, height) = header.layer_size;
        pixel_count(side(width), side(height))
            .map_err(|error| FileError::Exr { path: path.to_owned(), what: error.to_string() })?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn image(factor: f64) -> Image {
        let value = |x: u32, y: u32| factor * (f64::from(x) + 0.125 * f64::from(y));
        Image::from_fn(21, 33, |x, y| Rgb::new(value(x, y), value(y, x), -value(x, x))).unwrap()
    }

    fn layer(name: &str, image: &Image) -> NamedLayer {
        NamedLayer { name: name.into(), image: image.clone() }
    }

    fn info() -> RenderInfo {
        let settings = serde_json::json!({"max_length": 8});
        RenderInfo { scene: "Würfel".into(), settings, seed: u64::MAX, render_seconds: 1.5, ..RenderInfo::default() }
    }

    #[test]
    fn an_image_reads_back_in_single_precision_whatever_layers_stand_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let (main, other) = (image(1.0 / 3.0), image(2.0));
        let layers = [layer("standard_error", &other), layer("A.b", &other)];
        write_exr(&path, &main, layers, &info(), 64, &[("layers", "ünlisted".to_owned())]).unwrap();
        let read = read_exr(&path).unwrap();
        assert_eq!((read.width, read.height), (21, 33));
        for (a, b) in read.pixels.iter().zip(&main.pixels) {
            assert_eq!(*a, b.map(|value| f64::from(value as f32)));
        }
        let all = read_layers(&path, |name| name != "standard_error").unwrap();
        assert_eq!(all.layers.keys().collect::<Vec<_>>(), ["", "A.b"]);
        assert_eq!((&all.layers[""], &all.layers["A.b"]), (&read, &other));
        assert_eq!(all.texts["layers"], "ünlisted");
    }

    #[test]
    fn layers_and_metadata_carry_their_documented_names() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        write_exr(&path, &image(1.0), [layer("standard_error", &image(2.0))], &info(), 64, &[]).unwrap();
        let header = &MetaData::read_from_file(&path, true).unwrap().headers[0];
        let names: Vec<String> = header.channels.list.iter().map(|channel| channel.name.to_string()).collect();
        assert_eq!(names, ["B", "G", "R", "standard_error.B", "standard_error.G", "standard_error.R"]);
        let other = &header.own_attributes.other;
        assert_eq!(other[&text("samplesPerPixel")], AttributeValue::Text(text("64")));
        assert_eq!(other[&text("seed")], AttributeValue::Text(text("18446744073709551615")));
        assert_eq!(other[&text("settings")], AttributeValue::Text(text(r#"{"max_length":8}"#)));
        assert_eq!(other[&text("scene")], AttributeValue::Text(text("Würfel")));
        assert_eq!(other[&text("renderSeconds")], AttributeValue::F64(1.5));
    }

    #[test]
    fn layers_that_do_not_fit_are_refused() {
        let path = Path::new("unwritten.exr");
        let (main, small) = (image(1.0), Image::constant(2, 2, Rgb::WHITE).unwrap());
        let refused = |layers: &[NamedLayer]| {
            let written = write_exr(path, &main, layers.iter().cloned(), &info(), 1, &[]);
            assert!(matches!(written, Err(FileError::Layer { .. })));
        };
        refused(&[layer("", &main)]);
        refused(&[layer("a", &small)]);
        refused(&[layer("a", &main), layer("a", &main)]);
        assert!(!path.exists());
    }

    #[test]
    fn half_precision_and_foreign_layers_are_read_and_an_image_without_colours_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("half.exr");
        let samples = |value: f32| FlatSamples::F16(vec![exr::prelude::f16::from_f32(value); 6]);
        let write = |names: [&str; 4]| {
            let list = names.iter().zip([0.5, 1.5, 2.5, 3.5]).map(|(&name, v)| AnyChannel::new(name, samples(v)));
            exr::prelude::Image::from_channels((3, 2), AnyChannels::sort(list.collect()))
                .write()
                .to_file(&path)
                .unwrap();
        };
        write(["R", "G", "B", "Z"]);
        assert_eq!(read_exr(&path).unwrap(), Image::constant(3, 2, Rgb::new(0.5, 1.5, 2.5)).unwrap());
        write(["Y", "RY", "BY", "Z"]);
        assert!(matches!(read_exr(&path), Err(FileError::Exr { .. })));
    }

    #[test]
    fn damaged_files_are_errors_and_never_panics() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        assert!(matches!(read_exr(&path), Err(FileError::Read { .. })));
        write_exr(&path, &image(1.0), [], &info(), 1, &[]).unwrap();
        let whole = fs::read(&path).unwrap();
        for length in (0..whole.len()).step_by(37) {
            fs::write(&path, &whole[..length]).unwrap();
            let message = read_exr(&path).expect_err("a truncated file is read").to_string();
            assert!(message.contains("a.exr") && !message.contains('\n'), "{message}");
        }
        for place in 0..whole.len().min(1500) {
            for bit in [0x01, 0x80] {
                let mut bytes = whole.clone();
                bytes[place] ^= bit;
                fs::write(&path, &bytes).unwrap();
                let _ = read_exr(&path);
                let _ = read_layers(&path, |_| true);
            }
        }
    }
}
