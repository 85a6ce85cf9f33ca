//! PLY files (Turk 1994, *The PLY Polygon File Format*): ASCII, and binary in both byte orders.
//!
//! An own reader, after measuring the crate ply-rs-bw 4.0.1 with typed elements. That reads a binary file of 1.4
//! million triangles in 60 to 91 ms (least and median; this one in 47 to 69 ms, with all the rest of loading) and an
//! ASCII one of 11 thousand in 2.4 ms (1.2 ms). But it refuses the ASCII numbers `nan`, `.5` and `1.`, refuses a
//! comment that is not UTF-8, knows no place in a binary body, and an element without properties keeps it busy for as
//! many rounds as the header says. It is the reference in the tests below.

mod header;
mod source;

use std::path::Path;

use geometry::TriangleMesh;
use geometry::glam::{Vec2, Vec3};
use primitive::{MaterialId, MediumInterface, Surface};

use self::header::{Element, Encoding, Header, Kind};
use self::source::{Ascii, Binary, Source};
use crate::{Geometry, LoadError, Place, Scene, SceneBuilder, SceneError, SceneShape};

pub(crate) fn load(path: &Path) -> Result<Scene, LoadError> {
    let (mesh, warnings) = load_mesh(path)?;
    Scene::of_mesh(path, mesh, Vec::new(), 0, warnings)
}

/// The mesh of the file, and what is to be warned of. Polygons become fans around their first vertex.
fn load_mesh(path: &Path) -> Result<(TriangleMesh, Vec<String>), LoadError> {
    let bytes = std::fs::read(path).map_err(|source| LoadError::Io { path: path.to_owned(), source })?;
    parse(path, &bytes)
}

impl Scene {
    /// A scene of one mesh, with material number `material` of `materials`, or with "default" where there are none.
    pub(crate) fn of_mesh(
        path: &Path,
        mesh: TriangleMesh,
        mut materials: Vec<String>,
        material: u32,
        warnings: Vec<String>,
    ) -> Result<Self, LoadError> {
        if materials.is_empty() {
            materials.push("default".to_owned());
        }
        let mut builder = SceneBuilder::new();
        builder.scene_mut().names.materials = materials;
        warnings.into_iter().for_each(|w| builder.warn(w));
        if mesh.is_empty() {
            builder.warn("no triangles");
        }
        let material = MaterialId::from_index(material).ok_or_else(|| LoadError::scene(path, SceneError::TooLarge))?;
        builder
            .add_geometry(Geometry {
                shape: SceneShape::Mesh(mesh.into()),
                surface: Surface::of_material(material),
                media: MediumInterface::VACUUM,
            })
            .map_err(|e| LoadError::scene(path, e))?;
        Ok(builder.finish())
    }
}

fn parse(path: &Path, bytes: &[u8]) -> Result<(TriangleMesh, Vec<String>), LoadError> {
    let header = Header::parse(path, bytes)?;
    match header.encoding {
        Encoding::Ascii => Body::new(path, &header, Ascii::new(bytes, header.len)).read(),
        Encoding::LittleEndian => Body::new(path, &header, Binary::<false>::new(bytes, header.len)).read(),
        Encoding::BigEndian => Body::new(path, &header, Binary::<true>::new(bytes, header.len)).read(),
    }
}

/// What follows the header, being read.
struct Body<'a, S> {
    path: &'a Path,
    header: &'a Header,
    source: S,
    positions: Vec<Vec3>,
    uvs: Vec<Vec2>,
    triangles: Vec<[u32; 3]>,
    warnings: Vec<String>,
}

impl<'a, S: Source> Body<'a, S> {
    fn new(path: &'a Path, header: &'a Header, source: S) -> Self {
        let (positions, uvs, triangles) = Default::default();
        Self { path, header, source, positions, uvs, triangles, warnings: Vec::new() }
    }

    fn read(mut self) -> Result<(TriangleMesh, Vec<String>), LoadError> {
        let mut unread = Vec::new();
        for element in &self.header.elements {
            // Without properties there is nothing to read, however often.
            if element.properties.is_empty() || element.count == 0 {
                continue;
            }
            self.check_room(element)?;
            match element.name.as_str() {
                "vertex" => self.read_vertices(element)?,
                "face" => self.read_faces(element)?,
                _ => {
                    self.skip(element)?;
                    unread.push(format!("\"{}\"", element.name));
                }
            }
        }
        if !unread.is_empty() {
            self.warnings.push(format!("elements other than vertex and face are not read: {}", unread.join(", ")));
        }
        if self.source.has_more() {
            self.warnings.push("there is more data in the file than its header says; it is not read".to_owned());
        }
        let malformed = |e: geometry::MeshError| LoadError::malformed(self.path, Place::Unknown, e.to_string());
        let has_uvs = !self.uvs.is_empty();
        let mesh = TriangleMesh::new(self.positions, self.triangles).map_err(malformed)?;
        Ok((if has_uvs { mesh.with_uvs(self.uvs).map_err(malformed)? } else { mesh }, self.warnings))
    }

    /// Nothing is allocated for elements that cannot be there.
    fn check_room(&self, element: &Element) -> Result<(), LoadError> {
        let (left, least) = (self.source.remaining() as u64, S::least_len(element));
        if element.count.saturating_mul(least) <= left {
            return Ok(());
        }
        let Element { name, count, .. } = element;
        let reason = format!(
            "the header says {count} times {name}, of at least {least} bytes each, but {left} bytes are left: the file \
             is truncated, or its header wrong"
        );
        Err(LoadError::malformed(self.path, self.source.place(), reason))
    }

    fn read_vertices(&mut self, element: &Element) -> Result<(), LoadError> {
        let slots: Vec<usize> = element.properties.iter().map(|p| slot(&p.name, p.kind)).collect();
        if let Some(missing) = (0..3).find(|s| !slots.contains(s)) {
            let reason = format!("element vertex has no number {}", ["x", "y", "z"][missing]);
            return Err(LoadError::malformed(self.path, Place::Part("header".to_owned()), reason));
        }
        let has_uvs = slots.contains(&3) && slots.contains(&4);
        self.positions.reserve_exact(element.count as usize);
        self.uvs.reserve_exact(if has_uvs { element.count as usize } else { 0 });
        for i in 0..element.count {
            let mut values = [0.0; IGNORED + 1];
            for (property, &slot) in element.properties.iter().zip(&slots) {
                let value = match property.kind {
                    Kind::Scalar(scalar) => self.source.next(scalar),
                    list @ Kind::List { .. } => self.source.skip(list).map(|()| 0.0),
                };
                values[slot] = value.ok_or_else(|| self.fault(element, i))?;
            }
            let [x, y, z, u, v, _] = values.map(|v| v as f32);
            self.positions.push(Vec3::new(x, y, z));
            if has_uvs {
                self.uvs.push(Vec2::new(u, v));
            }
        }
        Ok(())
    }

    fn read_faces(&mut self, element: &Element) -> Result<(), LoadError> {
        let is_indices = |name: &str| name == "vertex_indices" || name == "vertex_index";
        let indices =
            element.properties.iter().position(|p| is_indices(&p.name) && matches!(p.kind, Kind::List { .. }));
        let Some(indices) = indices else {
            let reason = "element face has no list vertex_indices or vertex_index";
            return Err(LoadError::malformed(self.path, Place::Part("header".to_owned()), reason));
        };
        let mut small = 0_u64;
        // A triangle takes four bytes or more.
        self.triangles.reserve((element.count as usize).min(self.source.remaining() / 4));
        for face in 0..element.count {
            for (i, property) in element.properties.iter().enumerate() {
                if i != indices {
                    self.source.skip(property.kind).ok_or_else(|| self.fault(element, face))?;
                } else if self.read_fan(element, face, property.kind)? < 3 {
                    small += 1;
                }
            }
        }
        if small > 0 {
            self.warnings.push(format!("{small} faces have fewer than three vertices; they are left out"));
        }
        Ok(())
    }

    /// Reads one list of vertices as a fan of triangles; how many vertices there were.
    fn read_fan(&mut self, element: &Element, face: u64, kind: Kind) -> Result<u64, LoadError> {
        let Kind::List { count, items } = kind else { return Ok(0) };
        let len = self.source.next(count).ok_or_else(|| self.fault(element, face))?;
        if len < 0.0 {
            let reason = format!("face {face} has {len} vertices");
            return Err(LoadError::malformed(self.path, self.source.place(), reason));
        }
        let (mut first, mut previous) = (0, 0);
        for corner in 0..len as u64 {
            let index = self.source.next(items).ok_or_else(|| self.fault(element, face))?;
            if !(index >= 0.0 && index < self.header.vertex_count as f64 && index.fract() == 0.0) {
                return Err(self.no_vertex(face, index));
            }
            let index = index as u32;
            match corner {
                0 => first = index,
                1 => {}
                _ => self.triangles.push([first, previous, index]),
            }
            previous = index;
        }
        Ok(len as u64)
    }

    fn skip(&mut self, element: &Element) -> Result<(), LoadError> {
        for i in 0..element.count {
            for property in &element.properties {
                self.source.skip(property.kind).ok_or_else(|| self.fault(element, i))?;
            }
        }
        Ok(())
    }

    #[cold]
    fn fault(&self, element: &Element, number: u64) -> LoadError {
        let Element { name, count, .. } = element;
        let reason = format!("{} in {name} {number} of {count} (counted from 0)", self.source.why());
        LoadError::malformed(self.path, self.source.place(), reason)
    }

    #[cold]
    fn no_vertex(&self, face: u64, index: f64) -> LoadError {
        let count = self.header.vertex_count;
        let reason = match count {
            0 => format!("face {face} uses vertex {index}, but there are no vertices"),
            _ => format!("face {face} uses vertex {index}, but there are only {count} (0 to {})", count - 1),
        };
        LoadError::malformed(self.path, self.source.place(), reason)
    }
}

/// Where the values go that are not used.
const IGNORED: usize = 5;

/// What a property of a vertex is: x, y, z, u, v or nothing of use.
fn slot(name: &str, kind: Kind) -> usize {
    match (kind, name) {
        (Kind::List { .. }, _) => IGNORED,
        (_, "x") => 0,
        (_, "y") => 1,
        (_, "z") => 2,
        (_, "u" | "s" | "texture_u" | "texture_s") => 3,
        (_, "v" | "t" | "texture_v" | "texture_t") => 4,
        _ => IGNORED,
    }
}

#[cfg(test)]
pub(crate) mod tests;
