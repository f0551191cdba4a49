//! Where the bytes come from: files beside the scene, data URIs, the binary chunk.

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use gltf::json;

use super::fault::Fault;

/// Exporters do not agree on padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// The bytes of every buffer; `None` where the file gives no source for them.
pub(super) type Buffers<'a> = Vec<Option<Cow<'a, [u8]>>>;

/// Reads all buffers of a scene in `folder`, each at least as long as it says.
pub(super) fn read<'a>(root: &json::Root, bin: Option<&'a [u8]>, folder: &Path) -> Result<Buffers<'a>, Fault> {
    root.buffers.iter().enumerate().map(|(number, buffer)| read_one(number, buffer, bin, folder)).collect()
}

fn read_one<'a>(
    number: usize,
    buffer: &json::Buffer,
    bin: Option<&'a [u8]>,
    folder: &Path,
) -> Result<Option<Cow<'a, [u8]>>, Fault> {
    let length = buffer.byte_length.0;
    let place = format!("buffers[{number}]");
    let data = match (&buffer.uri, bin) {
        (Some(uri), _) => Cow::Owned(fetch(uri, length, folder, &place)?),
        (None, Some(bin)) if number == 0 => Cow::Borrowed(bin),
        (None, _) => return Ok(None),
    };
    if (data.len() as u64) < length {
        let problem = format!("is truncated: {length} bytes are promised, there are {}", data.len());
        return Err(Fault::invalid(place, problem, "copy or export the file again"));
    }
    Ok(Some(data))
}

/// The bytes behind a URI: data, or at most `limit` bytes of a file below the scene's folder.
pub(super) fn fetch(uri: &str, limit: u64, folder: &Path, place: &str) -> Result<Vec<u8>, Fault> {
    match uri.strip_prefix("data:") {
        Some(rest) => decode(rest, place),
        None => read_beside(uri, limit, folder, place),
    }
}

fn decode(uri: &str, place: &str) -> Result<Vec<u8>, Fault> {
    let Some((_, text)) = uri.split_once(";base64,") else {
        return Err(Fault::unsupported(place, "data URIs other than base64", "store it as a file"));
    };
    BASE64.decode(text).map_err(|error| {
        Fault::invalid(place, format!("its base64 is broken ({error})"), "copy or export the file again")
    })
}

fn read_beside(uri: &str, length: u64, folder: &Path, place: &str) -> Result<Vec<u8>, Fault> {
    let relative = path_inside(uri, place)?;
    read_file(&folder.join(&relative), length).map_err(|error| {
        let problem = format!("{} cannot be read ({error})", relative.display());
        Fault::invalid(place, problem, "put the file beside the scene")
    })
}

/// A path that stays below the scene's folder: a scene from elsewhere shall not read what is not its own.
fn path_inside(uri: &str, place: &str) -> Result<PathBuf, Fault> {
    let scheme = uri.split_once(':').map(|(scheme, _)| scheme);
    if let Some(scheme) = scheme.filter(|s| s.len() > 1 && s.bytes().all(|b| b.is_ascii_alphanumeric())) {
        let feature = format!("files behind {scheme}: addresses");
        return Err(Fault::unsupported(place, feature, "store it beside the scene"));
    }
    let Some(decoded) = percent_decode(uri) else {
        return Err(Fault::invalid(place, format!("{uri:?} is no valid URI"), "correct its percent codes"));
    };
    let path = PathBuf::from(decoded);
    if path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir)) {
        Ok(path)
    } else {
        let problem = format!("{uri:?} leads out of the scene's folder");
        Err(Fault::invalid(place, problem, "put the file beside the scene and name it without .. or a leading /"))
    }
}

/// `%41` → `A`; `None` where a code is broken or the result is not UTF-8.
fn percent_decode(uri: &str) -> Option<String> {
    let mut decoded = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&byte, after)) = rest.split_first() {
        if byte == b'%' {
            let digits = after.get(..2)?;
            if !digits.iter().all(u8::is_ascii_hexdigit) {
                return None;
            }
            decoded.push(u8::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()?);
            rest = &after[2..];
        } else {
            decoded.push(byte);
            rest = after;
        }
    }
    String::from_utf8(decoded).ok()
}

/// At most `limit` bytes of a regular file; a pipe or device could go on for ever.
pub(super) fn read_file(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let metadata = std::fs::metadata(path)?;
    if !metadata.is_file() {
        return Err(io::Error::other("it is not a regular file"));
    }
    let mut bytes = Vec::new();
    File::open(path)?.take(limit).read_to_end(&mut bytes)?;
    Ok(bytes)
}
