//! What a PLY file says of itself.

use std::path::Path;

use crate::{LoadError, Place};

/// The parsed header.
pub(super) struct Header {
    pub(super) encoding: Encoding,
    /// In the order of their data.
    pub(super) elements: Vec<Element>,
    /// How many vertices there are to be.
    pub(super) vertex_count: u64,
    /// Where the data begin.
    pub(super) len: usize,
}

/// How the data are written.
#[derive(Clone, Copy)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// So many things with these properties.
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
}

#[derive(Clone, Copy)]
pub(super) enum Kind {
    Scalar(Scalar),
    List { count: Scalar, items: Scalar },
}

#[derive(Clone, Copy)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::I8 => "char",
            Self::U8 => "uchar",
            Self::I16 => "short",
            Self::U16 => "ushort",
            Self::I32 => "int",
            Self::U32 => "uint",
            Self::F32 => "float",
            Self::F64 => "double",
        }
    }

    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

impl Header {
    pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Self, LoadError> {
        if !(bytes.starts_with(b"ply") && matches!(bytes.get(3), Some(b'\n' | b'\r' | b' ' | b'\t'))) {
            let start = bytes[..bytes.len().min(8)].escape_ascii();
            let reason = format!("not a PLY file: it begins with \"{start}\", not with a line \"ply\"");
            return Err(LoadError::malformed(path, Place::Byte(0), reason));
        }
        let (mut encoding, mut elements, mut len) = (None, Vec::new(), 0);
        for number in 1.. {
            let at = |reason: String| LoadError::malformed(path, Place::Line(number), reason);
            let line = line(bytes, len).ok_or_else(|| at("the file ends before the header's end_header".to_owned()))?;
            len += line.len();
            let line = String::from_utf8_lossy(line);
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            match words[..] {
                ["end_header"] => break,
                [] | ["ply"] | ["comment" | "obj_info", ..] => {}
                ["format", name, _version] => encoding = Some(Encoding::from_name(name).map_err(at)?),
                ["element", name, count] => {
                    let count = count.parse().map_err(|_| at(format!("\"{count}\" is no number of elements")))?;
                    if matches!(name, "vertex" | "face") && elements.iter().any(|e: &Element| e.name == name) {
                        return Err(at(format!("element {name} is declared twice")));
                    }
                    elements.push(Element { name: name.to_owned(), count, properties: Vec::new() });
                }
                ["property", ref words @ ..] => {
                    let element = elements.last_mut().ok_or_else(|| at("a property of no element".to_owned()))?;
                    element.properties.push(Property::parse(words).map_err(at)?);
                }
                _ => {
                    let line: String = line.trim().chars().take(40).collect();
                    return Err(at(format!("\"{}\" is no line of a PLY header", line.escape_debug())));
                }
            }
        }
        let reason = "the header has no line \"format\"";
        let encoding = encoding.ok_or_else(|| LoadError::malformed(path, Place::Part("header".to_owned()), reason))?;
        let vertex_count = elements.iter().find(|e| e.name == "vertex").map_or(0, |e| e.count);
        Ok(Self { encoding, elements, vertex_count, len })
    }
}

/// The line from byte `start` with its end. Lines end as the first one does: with a line feed, with or without a
/// carriage return before it, or (old Macintosh) with a carriage return alone.
fn line(bytes: &[u8], start: usize) -> Option<&[u8]> {
    let first = bytes.iter().position(|b| matches!(b, b'\n' | b'\r'))?;
    let end = if bytes[first] == b'\r' && bytes.get(first + 1) != Some(&b'\n') { b'\r' } else { b'\n' };
    let rest = bytes.get(start..)?;
    Some(&rest[..=rest.iter().position(|&b| b == end)?])
}

impl Encoding {
    fn from_name(name: &str) -> Result<Self, String> {
        match name {
            "ascii" => Ok(Self::Ascii),
            "binary_little_endian" => Ok(Self::LittleEndian),
            "binary_big_endian" => Ok(Self::BigEndian),
            _ => Err(format!("\"{name}\" is no PLY format; known are ascii, binary_little_endian, binary_big_endian")),
        }
    }
}

impl Property {
    fn parse(words: &[&str]) -> Result<Self, String> {
        let scalar = |name: &str| Scalar::from_name(name).ok_or_else(|| format!("\"{name}\" is no PLY type"));
        match *words {
            ["list", count, items, name] => {
                let (count_type, items) = (scalar(count)?, scalar(items)?);
                if !count_type.is_integer() {
                    return Err(format!("a list cannot have \"{count}\" many entries"));
                }
                Ok(Self { name: name.to_owned(), kind: Kind::List { count: count_type, items } })
            }
            [kind, name] => Ok(Self { name: name.to_owned(), kind: Kind::Scalar(scalar(kind)?) }),
            _ => Err("a property needs a type and a name".to_owned()),
        }
    }
}
