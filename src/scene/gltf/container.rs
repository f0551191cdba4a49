//! The outermost layer of a file: plain JSON, or the chunks of a `.glb`.

use super::fault::Fault;

const JSON: &[u8] = b"JSON";
const BIN: &[u8] = b"BIN\0";

/// The two parts of a glTF file.
pub(super) struct Chunks<'a> {
    pub json: &'a [u8],
    /// The binary chunk of a `.glb`.
    pub bin: Option<&'a [u8]>,
}

/// Takes a file apart; which form it has follows from its first bytes, not from its name.
pub(super) fn split(bytes: &[u8]) -> Result<Chunks<'_>, Fault> {
    if bytes.starts_with(b"glTF") {
        return split_binary(bytes);
    }
    let json = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    match json.iter().find(|byte| !byte.is_ascii_whitespace()) {
        Some(b'{') => Ok(Chunks { json, bin: None }),
        Some(_) => Err(Fault::NotGltf("it starts neither with \"glTF\" nor with a JSON object".into())),
        None => Err(Fault::NotGltf("it is empty".into())),
    }
}

/// A header of 12 bytes, then chunks of a length, a type and data; unknown ones are skipped (glTF 2.0, section 4.4).
fn split_binary(bytes: &[u8]) -> Result<Chunks<'_>, Fault> {
    let truncated = |problem: String| Fault::invalid("binary glTF", problem, "copy or export the file again");
    let (Some(version), Some(length)) = (u32_at(bytes, 4), u32_at(bytes, 8)) else {
        return Err(truncated("the header ends early".into()));
    };
    if version != 2 {
        let feature = format!("binary glTF files of version {version}");
        return Err(Fault::unsupported("binary glTF", feature, "export it as glTF 2.0"));
    }
    let length = length as usize;
    let Some(content) = bytes.get(..length) else {
        return Err(truncated(format!("the header promises {length} bytes, the file has {}", bytes.len())));
    };
    let mut json = None;
    let mut bin = None;
    let mut start = 12;
    while start < content.len() {
        let (Some(size), Some(kind)) = (u32_at(content, start), content.get(start + 4..start + 8)) else {
            return Err(truncated(format!("the chunk header at byte {start} ends early")));
        };
        let size = size as usize;
        let Some(data) = content.get(start + 8..).and_then(|rest| rest.get(..size)) else {
            return Err(truncated(format!("the chunk at byte {start} promises {size} bytes and ends early")));
        };
        match kind {
            JSON if json.is_none() => json = Some(data),
            BIN if bin.is_none() => bin = Some(data),
            _ => {}
        }
        start += 8 + size;
    }
    match json {
        Some(json) => Ok(Chunks { json, bin }),
        None => Err(truncated("there is no JSON chunk".into())),
    }
}

fn u32_at(bytes: &[u8], start: usize) -> Option<u32> {
    let four = bytes.get(start..)?.first_chunk::<4>()?;
    Some(u32::from_le_bytes(*four))
}
