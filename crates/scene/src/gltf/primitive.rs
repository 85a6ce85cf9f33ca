//! The triangles of a mesh.

use geometry::TriangleMesh;
use gltf::json::accessor::ComponentType::{F32, I8, I16, U8, U16, U32};
use gltf::json::accessor::Type;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Index, Mesh};
use primitive::{MaterialId, MediumInterface, Surface};

use super::accessor::Elements;
use super::container::{Document, valid};
use crate::{Geometry, LoadError, SceneBuilder, SceneError, SceneShape};

/// How many more indices may be used. Primitives may share their indices, but a small file must not fill the memory so.
pub(super) struct Budget(u64);

impl Budget {
    /// Each byte of the buffers may be used sixteen times as an index.
    pub(super) fn new(document: &Document<'_>) -> Self {
        Self(document.data_len().saturating_mul(16).saturating_add(1 << 16))
    }

    fn take(&mut self, document: &Document<'_>, count: usize) -> Result<(), LoadError> {
        let too_often = || document.malformed("meshes", "their primitives use the same indices too often");
        self.0 = self.0.checked_sub(count as u64).ok_or_else(too_often)?;
        Ok(())
    }
}

/// A geometry for each primitive of triangles. A default material is added to `materials` where one is needed.
pub(super) fn geometries(
    document: &Document<'_>,
    number: usize,
    mesh: &Mesh,
    materials: &mut Vec<String>,
    budget: &mut Budget,
    builder: &mut SceneBuilder,
) -> Result<Vec<Geometry>, LoadError> {
    let mut geometries = Vec::new();
    for (i, primitive) in mesh.primitives.iter().enumerate() {
        let error = |reason: String| document.malformed(format!("mesh {number}, primitive {i}"), reason);
        let mode = valid(primitive.mode).ok_or_else(|| error("its mode is not one of glTF".to_owned()))?;
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            builder.warn("points and lines are left out");
            continue;
        }
        let Some(&positions) = primitive.attributes.get(&Checked::Valid(Semantic::Positions)) else {
            builder.warn("primitives without positions are left out");
            continue;
        };
        let corners = corners(document, primitive, positions, budget)?;
        if mode == Mode::Triangles && corners.len() % 3 != 0 {
            builder
                .warn("the corners of some primitives are no multiple of three; those that are left over are left out");
        }
        let mesh = triangle_mesh(document, primitive, positions, triangles(mode, &corners), &error)?;
        let material = match primitive.material {
            Some(material) if document.root.get(material).is_some() => material.value(),
            Some(material) => return Err(error(format!("there is no material {}", material.value()))),
            None => {
                let count = document.root.materials.len();
                if materials.len() == count {
                    materials.push("default".to_owned());
                }
                count
            }
        };
        let material = u32::try_from(material).ok().and_then(MaterialId::from_index);
        let material = material.ok_or_else(|| LoadError::scene(document.path, SceneError::TooLarge))?;
        geometries.push(Geometry {
            shape: SceneShape::Mesh(mesh.into()),
            surface: Surface::of_material(material),
            media: MediumInterface::VACUUM,
        });
    }
    Ok(geometries)
}

/// The vertices of all corners: the indices, or without them all vertices in order.
fn corners(
    document: &Document<'_>,
    primitive: &Primitive,
    positions: Index<Accessor>,
    budget: &mut Budget,
) -> Result<Vec<u32>, LoadError> {
    match primitive.indices {
        Some(indices) => {
            let indices = Elements::new(document, indices, Type::Scalar, &[U8, U16, U32])?;
            budget.take(document, indices.len())?;
            Ok((0..indices.len()).map(|i| indices.index(i)).collect())
        }
        None => {
            let positions = Elements::new(document, positions, Type::Vec3, POSITION)?;
            budget.take(document, positions.len())?;
            Ok((0..positions.len()).map(|i| i as u32).collect())
        }
    }
}

/// Triangles, a strip or a fan, each triangle with its corners in the order of the specification (section 3.7.2.1).
fn triangles(mode: Mode, corners: &[u32]) -> Vec<[u32; 3]> {
    let strip = |(i, c): (usize, &[u32])| [c[0], c[1 + i % 2], c[2 - i % 2]];
    match (mode, corners) {
        (Mode::Triangles, _) => corners.as_chunks().0.to_vec(),
        (Mode::TriangleStrip, _) => corners.windows(3).enumerate().map(strip).collect(),
        (Mode::TriangleFan, [first, rest @ ..]) => rest.windows(2).map(|edge| [edge[0], edge[1], *first]).collect(),
        _ => Vec::new(),
    }
}

/// The components of positions, with those of KHR_mesh_quantization.
const POSITION: &[gltf::json::accessor::ComponentType] = &[F32, I8, U8, I16, U16];

/// The mesh of `triangles`. Where primitives share a large array of vertices, each copies only those that it uses.
fn triangle_mesh(
    document: &Document<'_>,
    primitive: &Primitive,
    positions: Index<Accessor>,
    mut triangles: Vec<[u32; 3]>,
    error: &dyn Fn(String) -> LoadError,
) -> Result<TriangleMesh, LoadError> {
    let positions = Elements::new(document, positions, Type::Vec3, POSITION)?;
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(index) = corners.iter().find(|&&i| i as usize >= positions.len()) {
            let count = positions.len();
            return Err(error(format!(
                "triangle {triangle} uses vertex {index}, but there are only {count} (from 0 on)"
            )));
        }
    }
    let mut used: Vec<u32> = if positions.len() > 3 * triangles.len() {
        let mut used = triangles.as_flattened().to_vec();
        used.sort_unstable();
        used.dedup();
        triangles.as_flattened_mut().iter_mut().for_each(|i| *i = used.partition_point(|u| u < i) as u32);
        used
    } else {
        (0..positions.len() as u32).collect()
    };
    used.shrink_to_fit();
    let vertices = used.iter().map(|&i| positions.vector(i as usize));
    let mesh = TriangleMesh::new(vertices, triangles).map_err(|e| error(e.to_string()))?;
    let Some(&uvs) = primitive.attributes.get(&Checked::Valid(Semantic::TexCoords(0))) else { return Ok(mesh) };
    let uvs = Elements::new(document, uvs, Type::Vec2, &[F32, U8, U16, I8, I16])?;
    if uvs.len() != positions.len() {
        return Err(error(format!("{} texture coordinates for {} vertices", uvs.len(), positions.len())));
    }
    let uvs = used.iter().map(|&i| uvs.vector(i as usize));
    mesh.with_uvs(uvs).map_err(|e| error(e.to_string()))
}
