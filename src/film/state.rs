//! A film's state in a file of its own, `.film`, from which a render goes on bit for bit.
//!
//! The container is safetensors: little-endian tensors under names and one JSON text. Tensors, all f64 except `mask`:
//!
//! | name | shape | content |
//! |---|---|---|
//! | `sum`, `sum_of_squares` | height × width × 3 | over passes |
//! | `block_moments` | rows × columns × 3 × 4 | mean, second, third, largest of each block and channel |
//! | `image_moments` | 4 × 4 | the same of the whole image: red, green, blue, luminance |
//! | `mask` (u8, optional) | height × width | 1 where a pixel counts in its block |
//! | `learnt` (optional) | any number | what the integrator has learnt, in an order of its own |
//!
//! The JSON text stands under `pathspace` in the metadata: format, size, passes, counters, [`RenderInfo`] and a checksum
//! of all tensors (64-bit FNV-1a, Fowler, Noll and Vo). Sums that are not finite are what the render produced and are
//! kept; they are accepted only where the counters say so.

use std::borrow::Cow;
use std::collections::HashMap;
use std::fs;
use std::io::Write;
use std::path::Path;

use safetensors::tensor::{Dtype, SafeTensors, TensorView};
use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::Xxh3Default;

use crate::spectrum::Rgb;

use super::accumulator::Film;
use super::counters::Counters;
use super::error::FileError;
use super::moments::Moments;
use super::output::{RenderInfo, write_atomically};

/// Number of the format; it rises with every change that old files do not survive.
const FORMAT: u64 = 1;
const METADATA: &str = "pathspace";

#[derive(Serialize, Deserialize)]
struct Header {
    format: u64,
    width: u32,
    height: u32,
    passes: u64,
    counters: Counters,
    info: RenderInfo,
    checksum: String,
}

/// Writes the film and what made it; atomically, see [`write_atomically`].
///
/// # Errors
/// When the file cannot be written.
pub fn save(path: &Path, film: &Film, info: &RenderInfo) -> Result<(), FileError> {
    let failed = |source| FileError::Write { path: path.to_owned(), source };
    let tensors = tensors_of(film);
    let header = Header {
        format: FORMAT,
        width: film.width(),
        height: film.height(),
        passes: film.passes,
        counters: film.counters.clone(),
        info: info.clone(),
        checksum: checksum(tensors.iter().map(|tensor| tensor.data.as_slice())),
    };
    let header = serde_json::to_string(&header).map_err(|error| failed(error.into()))?;
    let metadata = HashMap::from([(METADATA.to_owned(), header)]);
    let named: Vec<(&str, &Tensor)> = tensors.iter().map(|tensor| (tensor.name, tensor)).collect();
    let bytes = safetensors::serialize(named, Some(metadata)).map_err(|error| failed(std::io::Error::other(error)))?;
    write_atomically(path, |file| file.write_all(&bytes))
}

/// Reads a film and what made it.
///
/// # Errors
/// When the file cannot be read, has another format, or is damaged: shapes, checksum and finiteness are checked.
pub fn load(path: &Path) -> Result<(Film, RenderInfo), FileError> {
    let damaged = |what: String| FileError::State { path: path.to_owned(), what };
    let bytes = fs::read(path).map_err(|source| FileError::Read { path: path.to_owned(), source })?;
    let (_, metadata) =
        SafeTensors::read_metadata(&bytes).map_err(|error| damaged(format!("truncated or no film ({error})")))?;
    let header = metadata.metadata().as_ref().and_then(|texts| texts.get(METADATA));
    let header = header.ok_or_else(|| damaged("it holds no pathspace metadata".to_owned()))?;
    check_format(path, header)?;
    let header: Header = serde_json::from_str(header).map_err(|error| damaged(format!("bad metadata ({error})")))?;
    let tensors = SafeTensors::deserialize(&bytes).map_err(|error| damaged(error.to_string()))?;
    let film = film_from(&header, &tensors).map_err(damaged)?;
    Ok((film, header.info))
}

fn check_format(path: &Path, header: &str) -> Result<(), FileError> {
    #[derive(Deserialize)]
    struct Format {
        format: u64,
    }
    match serde_json::from_str(header) {
        Ok(Format { format: FORMAT }) => Ok(()),
        Ok(Format { format }) => Err(FileError::Version { path: path.to_owned(), found: format, expected: FORMAT }),
        Err(error) => Err(FileError::State { path: path.to_owned(), what: format!("bad metadata ({error})") }),
    }
}

struct Tensor {
    name: &'static str,
    dtype: Dtype,
    shape: Vec<usize>,
    data: Vec<u8>,
}

impl safetensors::View for &Tensor {
    fn dtype(&self) -> Dtype {
        self.dtype
    }
    fn shape(&self) -> &[usize] {
        &self.shape
    }
    fn data(&self) -> Cow<'_, [u8]> {
        Cow::Borrowed(&self.data)
    }
    fn data_len(&self) -> usize {
        self.data.len()
    }
}

/// In the order that the checksum takes.
fn tensors_of(film: &Film) -> Vec<Tensor> {
    let floats = |name, shape: &[usize], values: &mut dyn Iterator<Item = f64>| Tensor {
        name,
        dtype: Dtype::F64,
        shape: shape.to_vec(),
        data: values.flat_map(f64::to_le_bytes).collect(),
    };
    let (width, height) = (film.width() as usize, film.height() as usize);
    let grid = film.statistics.grid();
    let colours = |pixels: &[Rgb]| pixels.iter().flat_map(|pixel| pixel.to_array()).collect::<Vec<_>>().into_iter();
    let numbers = |m: &Moments| [m.mean, m.second, m.third, m.largest];
    let mut tensors = vec![
        floats("sum", &[height, width, 3], &mut colours(&film.sum)),
        floats("sum_of_squares", &[height, width, 3], &mut colours(&film.sum_of_squares)),
        floats(
            "block_moments",
            &[grid.rows(), grid.columns(), 3, 4],
            &mut film.statistics.blocks.iter().flatten().flat_map(numbers),
        ),
        floats("image_moments", &[4, 4], &mut film.statistics.image.iter().flat_map(numbers)),
    ];
    if let Some(mask) = &film.mask {
        let data = mask.iter().map(|&counts| u8::from(counts)).collect();
        tensors.push(Tensor { name: "mask", dtype: Dtype::U8, shape: vec![height, width], data });
    }
    if !film.learnt.is_empty() {
        tensors.push(floats("learnt", &[film.learnt.len()], &mut film.learnt.iter().copied()));
    }
    tensors
}

fn film_from(header: &Header, tensors: &SafeTensors<'_>) -> Result<Film, String> {
    let (width, height) = (header.width as usize, header.height as usize);
    let mask = match tensors.tensor("mask") {
        Ok(_) => Some(bytes_of(tensors, "mask", Dtype::U8, &[height, width])?.iter().map(|&byte| byte != 0).collect()),
        Err(_) => None,
    };
    // Before the film is allocated, the file must be seen to hold its pixels.
    let sum = bytes_of(tensors, "sum", Dtype::F64, &[height, width, 3])?;
    let mut film = Film::new(header.width, header.height, mask).map_err(|error| error.to_string())?;
    let squares = bytes_of(tensors, "sum_of_squares", Dtype::F64, &[height, width, 3])?;
    let grid = film.statistics.grid();
    let blocks = bytes_of(tensors, "block_moments", Dtype::F64, &[grid.rows(), grid.columns(), 3, 4])?;
    let image = bytes_of(tensors, "image_moments", Dtype::F64, &[4, 4])?;
    let mask = tensors.tensor("mask").ok();
    let learnt = tensors.tensor("learnt").ok();
    if learnt.as_ref().is_some_and(|learnt| learnt.dtype() != Dtype::F64) {
        return Err("'learnt' holds no numbers of 64 bits".to_owned());
    }
    let optional = [&mask, &learnt].into_iter().flatten().map(TensorView::data);
    let all = [sum, squares, blocks, image].into_iter().chain(optional);
    if checksum(all) != header.checksum {
        return Err("its checksum is wrong: the file was damaged after it was written".to_owned());
    }
    let finite = [sum, squares, blocks, image].into_iter().flat_map(floats_of).all(f64::is_finite);
    if !finite && header.counters.invalid == 0 {
        return Err("it holds values that are not finite, which its counters deny".to_owned());
    }
    fill_colours(&mut film.sum, sum);
    fill_colours(&mut film.sum_of_squares, squares);
    for (moments, &pixels) in film.statistics.blocks.iter_mut().zip(film.statistics.grid.pixels()) {
        moments.iter_mut().for_each(|moments| moments.count = if pixels == 0 { 0 } else { header.passes });
    }
    film.statistics.image.iter_mut().for_each(|moments| moments.count = header.passes);
    fill_moments(film.statistics.blocks.as_flattened_mut(), blocks);
    fill_moments(&mut film.statistics.image, image);
    film.passes = header.passes;
    film.counters = header.counters.clone();
    film.learnt = learnt.iter().flat_map(|learnt| floats_of(learnt.data())).collect();
    Ok(film)
}

fn bytes_of<'data>(
    tensors: &SafeTensors<'data>,
    name: &str,
    dtype: Dtype,
    shape: &[usize],
) -> Result<&'data [u8], String> {
    let tensor = tensors.tensor(name).map_err(|_| format!("it holds no '{name}'"))?;
    if tensor.dtype() != dtype || tensor.shape() != shape {
        return Err(format!("'{name}' is {} {:?}, and {dtype} {shape:?} was expected", tensor.dtype(), tensor.shape()));
    }
    Ok(tensor.data())
}

fn floats_of(bytes: &[u8]) -> impl Iterator<Item = f64> + '_ {
    let (numbers, _) = bytes.as_chunks::<8>();
    numbers.iter().map(|&number| f64::from_le_bytes(number))
}

fn fill_colours(pixels: &mut [Rgb], bytes: &[u8]) {
    let mut floats = floats_of(bytes);
    for pixel in pixels {
        *pixel = [0; 3].map(|_| floats.next().unwrap_or(f64::NAN)).into();
    }
}

fn fill_moments(moments: &mut [Moments], bytes: &[u8]) {
    let mut floats = floats_of(bytes);
    for moments in moments {
        let [mean, second, third, largest] = [0; 4].map(|_| floats.next().unwrap_or(f64::NAN));
        *moments = Moments { count: moments.count, mean, second, third, largest };
    }
}

fn checksum<'data>(parts: impl Iterator<Item = &'data [u8]>) -> String {
    let mut hash = Xxh3Default::new();
    parts.for_each(|part| hash.update(part));
    format!("{:016x}", hash.digest())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::ReplayKey;

    fn pass(index: u32) -> Vec<Rgb> {
        let value = |i: u32| 1.0 / f64::from(1 + (i * 7919 + index * 104_729) % 1009);
        (0..20 * 18).map(|i| Rgb::new(value(i), value(i + 1), value(3 * i))).collect()
    }

    fn film(passes: std::ops::Range<u32>, mask: Option<Vec<bool>>) -> Film {
        let mut film = Film::new(20, 18, mask).unwrap();
        passes.for_each(|index| film.add_pass(&pass(index)).unwrap());
        film.counters.rays = u64::MAX;
        film.learnt = vec![0.5, f64::MIN_POSITIVE, -3e300];
        film.counters.keep_for_replay(ReplayKey { seed: u64::MAX, sample: 3, pixel: (19, 17) });
        film
    }

    fn info() -> RenderInfo {
        let settings = serde_json::json!({"max_length": 8, "heuristic": "power"});
        RenderInfo { scene: "Würfel".into(), settings, seed: u64::MAX, render_seconds: 12.5, ..RenderInfo::default() }
    }

    #[test]
    fn what_is_loaded_equals_what_was_saved_and_goes_on_bit_for_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.film");
        let mask: Vec<bool> = (0..20 * 18).map(|i| i % 20 < 16 && i % 5 != 0).collect();
        for mask in [None, Some(mask)] {
            let half = film(0..5, mask.clone());
            save(&path, &half, &info()).unwrap();
            let (mut resumed, read) = load(&path).unwrap();
            assert_eq!(resumed, half);
            assert_eq!(read, info());
            (5..9).for_each(|index| resumed.add_pass(&pass(index)).unwrap());
            assert_eq!(resumed, film(0..9, mask));
        }
    }

    #[test]
    fn every_truncation_and_every_flipped_byte_is_a_clear_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.film");
        save(&path, &film(0..3, None), &info()).unwrap();
        let whole = fs::read(&path).unwrap();
        let refused = |bytes: &[u8]| {
            fs::write(&path, bytes).unwrap();
            let message = load(&path).expect_err("damage goes unnoticed").to_string();
            assert!(message.contains("a.film") && !message.contains('\n'), "{message}");
        };
        (0..whole.len()).step_by(97).for_each(|length| refused(&whole[..length]));
        let data_begins = 8 + u64::from_le_bytes(whole[..8].try_into().unwrap()) as usize;
        for place in (0..8).chain((data_begins..whole.len()).step_by(101)) {
            let mut bytes = whole.clone();
            bytes[place] ^= 0x10;
            refused(&bytes);
        }
        // In the header a changed digit or letter may be another valid header; it must not panic.
        for place in 8..data_begins {
            let mut bytes = whole.clone();
            bytes[place] ^= 0x01;
            fs::write(&path, &bytes).unwrap();
            let _ = load(&path);
        }
    }

    #[test]
    fn another_format_is_named_and_values_that_are_not_finite_need_a_counter() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.film");
        let mut film = film(0..2, None);
        save(&path, &film, &info()).unwrap();
        let mut bytes = fs::read(&path).unwrap();
        let format = br#"{\"format\":"#;
        let place = bytes.windows(format.len()).position(|part| part == format).unwrap() + format.len();
        assert_eq!(bytes[place..place + 2], *b"1,");
        bytes[place] = b'7';
        fs::write(&path, bytes).unwrap();
        assert!(matches!(load(&path), Err(FileError::Version { found: 7, expected: 1, .. })));

        film.add_pass(&[Rgb::grey(f64::NAN); 20 * 18]).unwrap();
        save(&path, &film, &info()).unwrap();
        assert!(load(&path).is_err());
        film.counters.invalid = 1;
        save(&path, &film, &info()).unwrap();
        assert!(load(&path).unwrap().0.mean_image().pixels[0].r.is_nan());
    }
}
