//! The parts of a glTF file: its JSON and its buffers.

use std::borrow::Cow;
use std::path::Path;

use gltf::json::validation::Checked;
use gltf::json::{self, Buffer, Index, Root, Value, buffer};

use crate::{LoadError, Place, SceneBuilder};

/// A parsed file, of which nothing is checked but its syntax, version and extensions.
pub(super) struct Document<'a> {
    pub(super) path: &'a Path,
    pub(super) root: Root,
    /// The JSON again, for the names, which [`Root`] has only with a feature of its crate.
    names: Value,
    /// `None` for one without data: a compressed file has such.
    buffers: Vec<Option<Cow<'a, [u8]>>>,
}

impl<'a> Document<'a> {
    pub(super) fn parse(path: &'a Path, bytes: &'a [u8]) -> Result<Self, LoadError> {
        let (text, blob) = if bytes.starts_with(b"glTF") { split_glb(path, bytes)? } else { (bytes, None) };
        let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
        let error = |e: json::Error| LoadError::malformed(path, Place::Unknown, format!("not a glTF file: {e}"));
        let names: Value = json::deserialize::from_slice(text).map_err(error)?;
        check_version(path, &names)?;
        let root: Root = json::deserialize::from_slice(text).map_err(error)?;
        let mut document = Self { path, root, names, buffers: Vec::new() };
        document.check_extensions()?;
        for (i, buffer) in document.root.buffers.iter().enumerate() {
            let data = match &buffer.uri {
                Some(uri) => Some(document.resolve(i, uri)?.into()),
                None => blob.filter(|_| i == 0).map(Cow::Borrowed),
            };
            let declared = buffer.byte_length.0;
            if let Some(data) = data.as_ref().filter(|data| (data.len() as u64) < declared) {
                let reason = format!("it has {} bytes, but {declared} are declared", data.len());
                return Err(document.malformed(format!("buffer {i}"), reason));
            }
            document.buffers.push(data);
        }
        Ok(document)
    }

    pub(super) fn malformed(&self, part: impl Into<String>, reason: impl Into<String>) -> LoadError {
        LoadError::malformed(self.path, Place::Part(part.into()), reason)
    }

    fn unsupported(&self, place: Place, feature: impl Into<String>, advice: impl Into<String>) -> LoadError {
        let (feature, advice) = (feature.into(), advice.into());
        LoadError::Unsupported { path: self.path.to_owned(), place, feature, advice }
    }

    /// The name of an entry of one of the file's lists, or an empty one.
    pub(super) fn name(&self, list: &str, i: usize) -> &str {
        self.names.get(list).and_then(|list| list.get(i)?.get("name")?.as_str()).unwrap_or_default()
    }

    pub(super) fn material_names(&self) -> Vec<String> {
        let name = |i| match self.name("materials", i) {
            "" => format!("material {i}"),
            name => name.to_owned(),
        };
        (0..self.root.materials.len()).map(name).collect()
    }

    /// How many bytes all buffers have.
    pub(super) fn data_len(&self) -> u64 {
        self.buffers.iter().flatten().map(|data| data.len() as u64).sum()
    }

    /// The bytes of a buffer view.
    pub(super) fn view(&self, index: Index<buffer::View>) -> Result<&[u8], LoadError> {
        let part = || format!("bufferView {}", index.value());
        let view = self.root.get(index).ok_or_else(|| self.malformed(part(), "there is no such view"))?;
        let data = self.buffers.get(view.buffer.value());
        let data = data.ok_or_else(|| self.malformed(part(), format!("there is no buffer {}", view.buffer.value())))?;
        let data = data.as_deref().ok_or_else(|| self.without_data(view.buffer))?;
        let (start, len) = (view.byte_offset.unwrap_or_default().0, view.byte_length.0);
        let range = usize::try_from(start).ok().zip(start.checked_add(len).and_then(|end| usize::try_from(end).ok()));
        range.and_then(|(start, end)| data.get(start..end)).ok_or_else(|| {
            let reason = format!("bytes {start} and {len} more are wanted of a buffer of {}", data.len());
            self.malformed(part(), reason)
        })
    }

    /// A buffer has no data where it stands for what a decoder would make.
    fn without_data(&self, buffer: Index<Buffer>) -> LoadError {
        match self.root.extensions_used.iter().find(|name| name.ends_with("meshopt_compression")) {
            Some(name) => self.unsupported(Place::Unknown, name, advice(name)),
            None => self
                .malformed(format!("buffer {}", buffer.value()), "it has no data: neither an address nor a BIN chunk"),
        }
    }

    /// What the file says and is not modelled.
    pub(super) fn warn(&self, builder: &mut SceneBuilder) {
        let root = &self.root;
        if !root.skins.is_empty() {
            builder.warn("skins are not modelled; meshes keep the shape that they have without");
        }
        if !root.animations.is_empty() {
            builder.warn("animations are not modelled; nodes stay where they are without");
        }
        let mut primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
        if primitives.any(|p| p.targets.as_ref().is_some_and(|targets| !targets.is_empty())) {
            builder.warn("morph targets are not modelled; meshes keep the shape that they have without");
        }
        if root.scenes.len() > 1 {
            builder.warn(format!("the file has {} scenes; only one of them is read", root.scenes.len()));
        }
        let names: Vec<&str> = root.extensions_used.iter().map(String::as_str).filter(|name| !is_known(name)).collect();
        if !names.is_empty() {
            builder.warn(format!("extensions that are not modelled: {}", names.join(", ")));
        }
    }

    fn check_extensions(&self) -> Result<(), LoadError> {
        match self.root.extensions_required.iter().find(|name| !is_known(name)) {
            Some(name) => Err(self.unsupported(Place::Unknown, name, advice(name))),
            None => Ok(()),
        }
    }

    /// The data behind the address of a buffer: in the address itself, or in a file beside this one.
    fn resolve(&self, i: usize, uri: &str) -> Result<Vec<u8>, LoadError> {
        let part = || format!("buffer {i}");
        if let Some(data) = uri.strip_prefix("data:") {
            let text = data.split_once(";base64,").map(|(_, text)| text);
            let text = text.ok_or_else(|| self.malformed(part(), "a data URI without \";base64,\""))?;
            return base64(text).ok_or_else(|| self.malformed(part(), "its data URI is not base64"));
        }
        if uri
            .split_once(':')
            .is_some_and(|(scheme, _)| scheme.len() > 1 && scheme.bytes().all(|b| b.is_ascii_alphanumeric()))
        {
            let shown: String = uri.chars().take(80).collect();
            return Err(self.unsupported(
                Place::Part(part()),
                format!("an address like \"{shown}\""),
                "; put the data beside the file",
            ));
        }
        let name = percent_decoded(uri);
        let file = self.path.parent().unwrap_or(Path::new("")).join(&name);
        // Of a device or a pipe there may be no end.
        match std::fs::metadata(&file) {
            Ok(metadata) if !metadata.is_file() => Err(self.malformed(part(), format!("\"{name}\" is not a file"))),
            Ok(_) => std::fs::read(&file).map_err(|source| LoadError::Io { path: file, source }),
            Err(source) => Err(self.malformed(part(), format!("\"{}\" cannot be read: {source}", file.display()))),
        }
    }
}

/// Whether an extension is supported, or is of no concern to geometry.
fn is_known(name: &str) -> bool {
    let concerns_surfaces = ["KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "EXT_materials_"];
    name == "KHR_mesh_quantization"
        || name.starts_with("KHR_xmp")
        || concerns_surfaces.iter().any(|p| name.starts_with(p))
}

fn advice(extension: &str) -> &'static str {
    match extension {
        name if name.ends_with("meshopt_compression") => "; decompress the file first, for example with gltfpack -noq",
        "KHR_draco_mesh_compression" => "; export the file again without Draco compression",
        _ => "",
    }
}

fn check_version(path: &Path, json: &Value) -> Result<(), LoadError> {
    match json.get("asset").and_then(|asset| asset.get("version")?.as_str()) {
        Some(version) if version.starts_with("2.") => Ok(()),
        Some(version) => Err(LoadError::Unsupported {
            path: path.to_owned(),
            place: Place::Unknown,
            feature: format!("glTF version {}", version.chars().take(20).collect::<String>()),
            advice: "; convert the file to glTF 2.0".to_owned(),
        }),
        None => Err(LoadError::malformed(path, Place::Unknown, "not a glTF file: it has no asset.version")),
    }
}

/// The JSON and the binary chunk of a GLB file. Chunks of other types are passed over, as the specification asks.
fn split_glb<'a>(path: &Path, bytes: &'a [u8]) -> Result<(&'a [u8], Option<&'a [u8]>), LoadError> {
    let word = |at: usize| Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?));
    let at = |byte: usize, reason: String| LoadError::malformed(path, Place::Byte(byte as u64), reason);
    let (Some(version), Some(len)) = (word(4), word(8)) else {
        return Err(at(bytes.len(), "the file ends in its header".to_owned()));
    };
    if version != 2 {
        return Err(at(4, format!("GLB version {version}; known is 2")));
    }
    if bytes.len() < len as usize {
        return Err(at(
            8,
            format!("the header says {len} bytes, but there are {}: the file is truncated", bytes.len()),
        ));
    }
    let (mut text, mut blob, mut start) = (None, None, 12);
    while start < len as usize {
        let (Some(chunk_len), Some(kind)) = (word(start), bytes.get(start + 4..start + 8)) else {
            return Err(at(start, "the file ends in the header of a chunk".to_owned()));
        };
        let Some(chunk) = bytes.get(start + 8..).and_then(|rest| rest.get(..chunk_len as usize)) else {
            return Err(at(start, format!("a chunk of {chunk_len} bytes goes beyond the end of the file")));
        };
        match kind {
            b"JSON" => text = text.or(Some(chunk)),
            b"BIN\0" => blob = blob.or(Some(chunk)),
            _ => {}
        }
        start += 8 + chunk.len();
    }
    Ok((text.ok_or_else(|| at(12, "there is no JSON chunk".to_owned()))?, blob))
}

/// RFC 4648, section 4; the padding may be missing.
fn base64(text: &str) -> Option<Vec<u8>> {
    let digits = text.trim_end_matches('=').as_bytes();
    let mut bytes = Vec::with_capacity(digits.len() / 4 * 3 + 2);
    for group in digits.chunks(4) {
        let mut bits = 0_u32;
        for &digit in group {
            let value = match digit {
                b'A'..=b'Z' => digit - b'A',
                b'a'..=b'z' => digit - b'a' + 26,
                b'0'..=b'9' => digit - b'0' + 52,
                b'+' => 62,
                b'/' => 63,
                _ => return None,
            };
            bits = bits << 6 | u32::from(value);
        }
        bits <<= 6 * (4 - group.len());
        match group.len() {
            1 => return None,
            len => bytes.extend(&bits.to_be_bytes()[1..len]),
        }
    }
    Some(bytes)
}

/// RFC 3986, section 2.1.
fn percent_decoded(uri: &str) -> String {
    let (mut bytes, mut rest) = (Vec::new(), uri.as_bytes());
    while let [first, tail @ ..] = rest {
        let code = tail.get(..2).and_then(|hex| u8::from_str_radix(std::str::from_utf8(hex).ok()?, 16).ok());
        match code.filter(|_| *first == b'%') {
            Some(code) => {
                bytes.push(code);
                rest = &tail[2..];
            }
            None => {
                bytes.push(*first);
                rest = tail;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// The value of a checked field.
pub(super) fn valid<T: Copy>(checked: Checked<T>) -> Option<T> {
    match checked {
        Checked::Valid(value) => Some(value),
        Checked::Invalid => None,
    }
}
