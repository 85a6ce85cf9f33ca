//! STL files (3D Systems 1989, *StereoLithography Interface Specification*): ASCII and binary.
//!
//! An own reader, after trying the crate stl_io 0.11.0: that takes a binary file whose header begins with "solid" (many
//! do) for text, stops at the first `endsolid`, knows no place in a file, refuses NaN in text, and takes 2.4 ms for the
//! 0.5 MB of fan_ascii.stl (this one 0.8 ms). It is the reference in the tests below.
//!
//! Vertices are not merged: the format has none that are shared, and equal positions behave as one.

use std::path::Path;

use geometry::TriangleMesh;
use geometry::glam::Vec3;

use crate::{LoadError, Place, Scene};

/// A binary file: 80 bytes of anything, the number of triangles, and for each a normal, three vertices and two bytes.
const HEADER: usize = 84;
const TRIANGLE: usize = 50;

pub(crate) fn load(path: &Path) -> Result<Scene, LoadError> {
    let bytes = std::fs::read(path).map_err(|source| LoadError::Io { path: path.to_owned(), source })?;
    let (mesh, warnings) = parse(path, &bytes)?;
    Scene::of_mesh(path, mesh, Vec::new(), 0, warnings)
}

fn parse(path: &Path, bytes: &[u8]) -> Result<(TriangleMesh, Vec<String>), LoadError> {
    let mut warnings = Vec::new();
    let vertices = if is_text(bytes) { read_ascii(path, bytes)? } else { read_binary(path, bytes, &mut warnings)? };
    let triangles = (0..vertices.len() / 3).map(|i| [0, 1, 2].map(|k| (3 * i + k) as u32)).collect();
    let mesh = TriangleMesh::new(vertices, triangles);
    Ok((mesh.map_err(|e| LoadError::malformed(path, Place::Unknown, e.to_string()))?, warnings))
}

/// Both kinds may begin with "solid": a file of exactly the length that its number of triangles asks for is binary, and
/// so is one with a zero byte where text has its first lines.
fn is_text(bytes: &[u8]) -> bool {
    let is_exact = triangle_count(bytes).is_some_and(|n| (HEADER + TRIANGLE * n as usize) == bytes.len());
    let start = bytes.trim_ascii_start();
    let is_solid = start.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    is_solid && !is_exact && !bytes[..bytes.len().min(HEADER)].contains(&0)
}

fn triangle_count(bytes: &[u8]) -> Option<u32> {
    Some(u32::from_le_bytes(*bytes.get(80..)?.first_chunk()?))
}

fn read_binary(path: &Path, bytes: &[u8], warnings: &mut Vec<String>) -> Result<Vec<Vec3>, LoadError> {
    let Some(count) = triangle_count(bytes) else {
        let reason = "not an STL file: it neither begins with \"solid\" nor has the 84 bytes of a binary header";
        return Err(LoadError::malformed(path, Place::Byte(0), reason));
    };
    let body = &bytes[HEADER..];
    let (records, _) = body.as_chunks::<TRIANGLE>();
    if (records.len() as u64) < u64::from(count) || count == 0 && !body.is_empty() {
        let reason = format!(
            "the header of a binary STL says {count} triangles, but {} bytes have room for {}: the file is truncated, \
             or not STL",
            body.len(),
            records.len()
        );
        return Err(LoadError::malformed(path, Place::Byte(80), reason));
    }
    if body.len() > TRIANGLE * count as usize {
        warnings.push("there is more data in the file than its header says; it is not read".to_owned());
    }
    let vertex = |v: &[u8; 12]| {
        let coordinate = |k: usize| f32::from_le_bytes([v[k], v[k + 1], v[k + 2], v[k + 3]]);
        Vec3::new(coordinate(0), coordinate(4), coordinate(8))
    };
    let vertices = |record: &[u8; TRIANGLE]| {
        let (vectors, _) = record.as_chunks::<12>();
        [vertex(&vectors[1]), vertex(&vectors[2]), vertex(&vectors[3])]
    };
    Ok(records[..count as usize].iter().flat_map(vertices).collect())
}

/// Any number of `solid … endsolid`, one after the other, in capitals or not.
fn read_ascii(path: &Path, bytes: &[u8]) -> Result<Vec<Vec3>, LoadError> {
    let mut words = Words { path, bytes, at: 0, word: &[], facet: 0 };
    let mut vertices = Vec::new();
    while let Some(word) = words.next() {
        if !word.eq_ignore_ascii_case(b"solid") {
            return Err(words.unexpected("\"solid\""));
        }
        words.skip_line();
        loop {
            match words.next() {
                Some(word) if word.eq_ignore_ascii_case(b"facet") => {}
                Some(word) if word.eq_ignore_ascii_case(b"endsolid") => break,
                _ => return Err(words.unexpected("\"facet\" or \"endsolid\"")),
            }
            // The normal follows from the vertices; some programs write it as "-nan(ind)".
            words.expect(&["normal"])?;
            (0..3).for_each(|_| _ = words.next());
            words.expect(&["outer", "loop"])?;
            for _ in 0..3 {
                words.expect(&["vertex"])?;
                vertices.push(Vec3::new(words.number()?, words.number()?, words.number()?));
            }
            words.expect(&["endloop", "endfacet"])?;
            words.facet += 1;
        }
        words.skip_line();
    }
    Ok(vertices)
}

/// The words of a text, with the place of the last one.
struct Words<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    at: usize,
    /// The last word; empty at the end.
    word: &'a [u8],
    /// The facet that it belongs to.
    facet: usize,
}

impl<'a> Words<'a> {
    fn next(&mut self) -> Option<&'a [u8]> {
        let rest = &self.bytes[self.at..];
        let start = rest.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(rest.len());
        let len = rest[start..].iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len() - start);
        self.word = &rest[start..start + len];
        self.at += start + len;
        if len == 0 { None } else { Some(self.word) }
    }

    fn skip_line(&mut self) {
        let rest = &self.bytes[self.at..];
        self.at += rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
    }

    fn expect(&mut self, words: &[&str]) -> Result<(), LoadError> {
        for word in words {
            if !self.next().is_some_and(|found| found.eq_ignore_ascii_case(word.as_bytes())) {
                return Err(self.unexpected(&format!("\"{word}\"")));
            }
        }
        Ok(())
    }

    fn number(&mut self) -> Result<f32, LoadError> {
        let number = self.next().and_then(|word| std::str::from_utf8(word).ok()?.parse().ok());
        number.ok_or_else(|| self.unexpected("a number"))
    }

    #[cold]
    fn unexpected(&self, expected: &str) -> LoadError {
        let before = &self.bytes[..self.at - self.word.len()];
        let line = 1 + before.iter().filter(|&&b| b == b'\n').count();
        let found = match &self.word[..self.word.len().min(40)] {
            [] => "the file ends".to_owned(),
            word => format!("\"{}\" stands", word.escape_ascii()),
        };
        let reason = format!("{found} where {expected} is expected, in facet {} (counted from 0)", self.facet);
        LoadError::malformed(self.path, Place::Line(line), reason)
    }
}

#[cfg(test)]
mod tests;
