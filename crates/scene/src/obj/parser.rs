//! The statements of an OBJ file.

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::Path;

use geometry::glam::{Vec2, Vec3};

use crate::{LoadError, Place};

/// In place of the texture coordinate where a corner has none.
pub(super) const NO_UV: u32 = u32::MAX;

/// What an OBJ file holds, with every polygon as a fan around its first corner.
#[derive(Default)]
pub(super) struct Polygons {
    pub(super) positions: Vec<Vec3>,
    pub(super) uvs: Vec<Vec2>,
    /// The position of each corner.
    pub(super) triangles: Vec<[u32; 3]>,
    /// The texture coordinate of each corner; empty where no corner has one.
    pub(super) uv_triangles: Vec<[u32; 3]>,
    /// In the order of their first use.
    pub(super) materials: Vec<String>,
    /// That of the first face.
    pub(super) first_material: Option<u32>,
    /// The lines that name material libraries.
    pub(super) libraries: Vec<String>,
    /// For each face its first triangle and its line.
    faces: Vec<(u32, u32)>,
    material_numbers: HashMap<String, u32>,
    /// The material that new faces get.
    material: Option<u32>,
    small_faces: usize,
    has_lines_or_points: bool,
    has_free_forms: bool,
    has_statements: bool,
    /// The first statement that is none of OBJ, and its line.
    unknown: Option<(usize, String)>,
}

impl Polygons {
    pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Self, LoadError> {
        let mut polygons = Self::default();
        let mut rest = bytes;
        let mut number = 1;
        while !rest.is_empty() {
            let (line, len, lines) = logical_line(rest);
            let malformed = |reason| LoadError::malformed(path, Place::Line(number), reason);
            let small_faces = polygons.small_faces;
            polygons.statement(&line, number).map_err(malformed)?;
            // A face without three vertices is odd, but one that the end of the file cuts off is half a file.
            let is_last = len == rest.len() && !rest.ends_with(b"\n") && !rest.ends_with(b"\r");
            if is_last && polygons.small_faces > small_faces {
                return Err(malformed("the file ends within a face: it is truncated".to_owned()));
            }
            rest = &rest[len..];
            number += lines;
        }
        match &polygons.unknown {
            Some((line, name)) if !polygons.has_statements => {
                let reason = format!("not an OBJ file: it begins with \"{name}\"");
                Err(LoadError::malformed(path, Place::Line(*line), reason))
            }
            _ => Ok(polygons),
        }
    }

    /// Faces may come before their vertices, so this is for the end.
    pub(super) fn check_indices(&self, path: &Path) -> Result<(), LoadError> {
        let is_outside = |limit: usize| move |&&i: &&u32| i as usize >= limit && i != NO_UV;
        for (what, triangles, count) in [
            ("vertex", &self.triangles, self.positions.len()),
            ("texture coordinate", &self.uv_triangles, self.uvs.len()),
        ] {
            for (i, triangle) in triangles.iter().enumerate() {
                let Some(&index) = triangle.iter().find(is_outside(count)) else { continue };
                let face = self.faces.partition_point(|&(first, _)| first as usize <= i);
                let (_, line) = self.faces[face - 1];
                let index = u64::from(index) + 1;
                let reason = format!("face {face} uses {what} {index}, but there are only {count} (counted from 1)");
                return Err(LoadError::malformed(path, Place::Line(line as usize), reason));
            }
        }
        Ok(())
    }

    pub(super) fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.small_faces > 0 {
            let count = self.small_faces;
            warnings.push(format!("{count} faces have fewer than three vertices; they are left out"));
        }
        if self.has_lines_or_points {
            warnings.push("lines and points are left out".to_owned());
        }
        if self.has_free_forms {
            warnings.push("free-form curves and surfaces are left out".to_owned());
        }
        if let Some((line, name)) = &self.unknown {
            warnings.push(format!("statements are left out that are not OBJ; the first is \"{name}\" in line {line}"));
        }
        warnings
    }

    fn statement(&mut self, line: &[u8], number: usize) -> Result<(), String> {
        let line = line.trim_ascii();
        let (name, rest) = line.split_at(line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len()));
        match name {
            [] | [b'#', ..] => return Ok(()),
            b"v" => {
                let [x, y, z] = numbers(rest, 3)?;
                self.positions.push(Vec3::new(x, y, z));
            }
            b"vt" => {
                let [u, v] = numbers(rest, 1)?;
                self.uvs.push(Vec2::new(u, v));
            }
            b"f" | b"fo" => self.face(rest, number)?,
            b"usemtl" => self.material = Some(self.material_number(text(rest))),
            b"mtllib" => self.libraries.push(text(rest)),
            b"l" | b"p" => self.has_lines_or_points = true,
            b"cstype" | b"curv" | b"curv2" | b"surf" => self.has_free_forms = true,
            b"o" | b"g" | b"s" | b"mg" | b"vn" | b"vp" | b"lod" | b"bevel" | b"c_interp" | b"d_interp" | b"maplib"
            | b"usemap" | b"shadow_obj" | b"trace_obj" | b"deg" | b"bmat" | b"step" | b"parm" | b"trim" | b"hole"
            | b"scrv" | b"sp" | b"end" | b"con" | b"ctech" | b"stech" | b"call" | b"csh" => {}
            _ => {
                self.unknown.get_or_insert_with(|| (number, quoted(name)));
                return Ok(());
            }
        }
        self.has_statements = true;
        Ok(())
    }

    fn material_number(&mut self, name: String) -> u32 {
        *self.material_numbers.entry(name).or_insert_with_key(|name| {
            self.materials.push(name.clone());
            self.materials.len() as u32 - 1
        })
    }

    fn face(&mut self, corners: &[u8], line: usize) -> Result<(), String> {
        let face = self.faces.len() + 1;
        let first_triangle = u32::try_from(self.triangles.len()).map_err(|_| "more than 2^32 triangles".to_owned())?;
        let (mut first, mut previous, mut count) = ((0, 0), (0, 0), 0);
        for corner in words(corners) {
            let mut parts = corner.split(|&b| b == b'/');
            let v = parts.next().unwrap_or_default();
            let v = index(v, self.positions.len()).map_err(|e| format!("face {face} uses {e} as a vertex"))?;
            let vt = match parts.next() {
                None | Some([]) => NO_UV,
                Some(vt) => {
                    index(vt, self.uvs.len()).map_err(|e| format!("face {face} uses {e} as a texture coordinate"))?
                }
            };
            match count {
                0 => first = (v, vt),
                1 => {}
                _ => self.triangle([first, previous, (v, vt)]),
            }
            previous = (v, vt);
            count += 1;
        }
        self.faces.push((first_triangle, line as u32));
        if count < 3 {
            self.small_faces += 1;
        } else if self.first_material.is_none() {
            self.first_material = Some(self.material.unwrap_or_else(|| self.material_number("default".to_owned())));
        }
        Ok(())
    }

    fn triangle(&mut self, corners: [(u32, u32); 3]) {
        let has_uv = corners.iter().any(|&(_, vt)| vt != NO_UV);
        if has_uv || !self.uv_triangles.is_empty() {
            self.uv_triangles.resize(self.triangles.len(), [NO_UV; 3]);
            self.uv_triangles.push(corners.map(|(_, vt)| vt));
        }
        self.triangles.push(corners.map(|(v, _)| v));
    }
}

/// The first line of `bytes`, its length with its end, and how many lines of text it is: one that ends in a backslash
/// goes on in the next, unless it is a comment.
fn logical_line(bytes: &[u8]) -> (Cow<'_, [u8]>, usize, usize) {
    let (first, mut len) = text_line(bytes);
    let is_comment = first.trim_ascii_start().starts_with(b"#");
    let Some(start) = first.strip_suffix(b"\\").filter(|_| !is_comment) else { return (first.into(), len, 1) };
    let (mut whole, mut lines) = (start.to_vec(), 1);
    while len < bytes.len() {
        let (line, line_len) = text_line(&bytes[len..]);
        let start = line.strip_suffix(b"\\");
        whole.push(b' ');
        whole.extend_from_slice(start.unwrap_or(line));
        (len, lines) = (len + line_len, lines + 1);
        if start.is_none() {
            break;
        }
    }
    (whole.into(), len, lines)
}

/// The first line, without its end, and its length with it.
fn text_line(bytes: &[u8]) -> (&[u8], usize) {
    let end = bytes.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(bytes.len());
    let end_len = match bytes[end..] {
        [b'\r', b'\n', ..] => 2,
        [] => 0,
        _ => 1,
    };
    (&bytes[..end], end + end_len)
}

/// Up to a comment.
fn words(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    let words = bytes.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    words.take_while(|word| !word.starts_with(b"#"))
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).trim().to_owned()
}

/// The first `N` numbers, of which `least` must be there; the others are 0.
fn numbers<const N: usize>(bytes: &[u8], least: usize) -> Result<[f32; N], String> {
    let mut words = words(bytes);
    let mut numbers = [0.0; N];
    for (i, number) in numbers.iter_mut().enumerate() {
        match words.next() {
            Some(word) => *number = parse(word).ok_or_else(|| format!("\"{}\" is no number", quoted(word)))?,
            None if i < least => return Err(format!("{i} numbers where {least} are needed")),
            None => break,
        }
    }
    Ok(numbers)
}

/// From a number counted from 1, or from the end with a minus, to an index; above `count` for what may come yet.
fn index(word: &[u8], count: usize) -> Result<u32, String> {
    let number: i64 = parse(word).ok_or_else(|| format!("\"{}\"", quoted(word)))?;
    let index = if number < 0 { (count as i64).checked_add(number) } else { number.checked_sub(1) };
    match index.and_then(|i| u32::try_from(i).ok()) {
        Some(index) if index != NO_UV => Ok(index),
        _ => Err(format!("{number} ({count} come before it)")),
    }
}

fn parse<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

fn quoted(word: &[u8]) -> String {
    word[..word.len().min(40)].escape_ascii().to_string()
}
