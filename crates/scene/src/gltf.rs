//! glTF 2.0 files (Khronos 2021, *glTF 2.0 Specification*), as JSON or GLB: the triangles of one scene.
//!
//! Each mesh that the scene uses is an object with a geometry for each of its triangle primitives; each node with a
//! mesh is an instance of it in the world, placed by the product of the transforms above it. Materials are numbered as
//! in the file, and "default" comes after them where a primitive has none. The first perspective camera is the view.
//!
//! Of the crate gltf 1.4.1 only the JSON types are used. Its validation and its readers panic on an accessor out of
//! range and on one without elements, trust sizes up to overflow, and refuse attributes with a name of one's own
//! (`_ID`), which the specification allows.

mod accessor;
mod container;
mod primitive;

use std::path::Path;

use geometry::glam::{DAffine3, DQuat, DVec3};
use geometry::{Transform, TransformError};
use gltf::json::{Index, Mesh, Node};

use self::container::Document;
use crate::{Camera, LoadError, ObjectId, Scene, SceneBuilder};

pub(crate) fn load(path: &Path) -> Result<Scene, LoadError> {
    let bytes = std::fs::read(path).map_err(|source| LoadError::Io { path: path.to_owned(), source })?;
    parse(path, &bytes)
}

fn parse(path: &Path, bytes: &[u8]) -> Result<Scene, LoadError> {
    let document = Document::parse(path, bytes)?;
    let mut builder = SceneBuilder::new();
    document.warn(&mut builder);
    let instances = placed_meshes(&document, &mut builder)?;
    let objects = add_objects(&document, &instances, &mut builder)?;
    for (mesh, transform) in instances {
        if let Some(object) = objects[mesh.value()] {
            builder.add_instance(object, transform).map_err(|e| LoadError::scene(path, e))?;
        }
    }
    if builder.scene_mut().triangle_count() == 0 {
        builder.warn("no triangles");
    }
    Ok(builder.finish())
}

/// The meshes of the scene in the order of a walk down its nodes, each with its place in the world.
fn placed_meshes(
    document: &Document<'_>,
    builder: &mut SceneBuilder,
) -> Result<Vec<(Index<Mesh>, Transform)>, LoadError> {
    let mut placed = Vec::new();
    let mut is_visited = vec![false; document.root.nodes.len()];
    let mut flat = 0;
    // The next node is the last; deep hierarchies must not go deep into the machine's stack.
    let mut open: Vec<(Index<Node>, Transform)> =
        roots(document)?.into_iter().rev().map(|node| (node, Transform::IDENTITY)).collect();
    while let Some((index, parent)) = open.pop() {
        let part = || format!("node {}", index.value());
        let Some(node) = document.root.get(index) else {
            return Err(document.malformed(part(), "there is no such node"));
        };
        if std::mem::replace(&mut is_visited[index.value()], true) {
            return Err(document.malformed(part(), "it is below two nodes, or below itself"));
        }
        let transform = match local_transform(node).and_then(|local| parent.then_inside(&local)) {
            Ok(transform) => transform,
            Err(TransformError::Singular { .. }) => {
                flat += 1;
                continue;
            }
            Err(e) => return Err(document.malformed(part(), e.to_string())),
        };
        if let Some(mesh) = node.mesh {
            if document.root.get(mesh).is_none() {
                return Err(document.malformed(part(), format!("there is no mesh {}", mesh.value())));
            }
            placed.push((mesh, transform));
        }
        if let Some(camera) = node.camera {
            let Some(camera) = document.root.get(camera) else {
                return Err(document.malformed(part(), format!("there is no camera {}", camera.value())));
            };
            add_camera(camera, &transform, builder);
        }
        open.extend(node.children.iter().flatten().rev().map(|&child| (child, transform)));
    }
    if flat > 0 {
        builder.warn(format!("{flat} nodes are scaled flat; they and what is below them are left out"));
    }
    Ok(placed)
}

/// The top nodes of the file's scene; without one, those of its first, or else all that are below no other.
fn roots(document: &Document<'_>) -> Result<Vec<Index<Node>>, LoadError> {
    let root = &document.root;
    let scene = root.scene.unwrap_or(Index::new(0));
    if let Some(scene) = root.get(scene) {
        return Ok(scene.nodes.clone());
    }
    if root.scene.is_some() {
        return Err(document.malformed("scene", format!("there is no scene {}", scene.value())));
    }
    let mut is_child = vec![false; root.nodes.len()];
    for child in root.nodes.iter().filter_map(|node| node.children.as_ref()).flatten() {
        if let Some(is_child) = is_child.get_mut(child.value()) {
            *is_child = true;
        }
    }
    let tops = is_child.iter().enumerate().filter(|(_, is_child)| !**is_child);
    Ok(tops.map(|(i, _)| Index::new(i as u32)).collect())
}

fn local_transform(node: &Node) -> Result<Transform, TransformError> {
    if let Some(columns) = node.matrix {
        let entry = |row: usize, column: usize| f64::from(columns[4 * column + row]);
        return Transform::from_rows([0, 1, 2, 3].map(|row| [0, 1, 2, 3].map(|column| entry(row, column))));
    }
    let vector = |v: Option<[f32; 3]>, default| v.map_or(default, |v| DVec3::from_array(v.map(f64::from)));
    let rotation = DQuat::from_array(node.rotation.unwrap_or_default().0.map(f64::from));
    Transform::from_affine(DAffine3::from_scale_rotation_translation(
        vector(node.scale, DVec3::ONE),
        rotation.normalize(),
        vector(node.translation, DVec3::ZERO),
    ))
}

/// A camera looks along -z of its node, with y up.
fn add_camera(camera: &gltf::json::Camera, to_world: &Transform, builder: &mut SceneBuilder) {
    let Some(perspective) = &camera.perspective else {
        builder.warn("orthographic cameras are not modelled");
        return;
    };
    // The angle is that of the vertical side; ours that of the shorter one.
    let tangent =
        (f64::from(perspective.yfov) / 2.0).tan() * f64::from(perspective.aspect_ratio.unwrap_or(1.0).min(1.0));
    let eye = to_world.point(DVec3::ZERO);
    // As far before the eye as tells the two apart in f32.
    let look = eye + to_world.vector(DVec3::NEG_Z).normalize() * eye.length().max(1.0);
    builder.scene_mut().camera.get_or_insert(Camera {
        eye: eye.as_vec3().to_array(),
        look: look.as_vec3().to_array(),
        up: to_world.vector(DVec3::Y).as_vec3().to_array(),
        fov: (2.0 * tangent.atan()).to_degrees() as f32,
        ..Camera::default()
    });
}

/// The objects of those meshes that are placed and have triangles, in file order; for each mesh of the file its object.
fn add_objects(
    document: &Document<'_>,
    placed: &[(Index<Mesh>, Transform)],
    builder: &mut SceneBuilder,
) -> Result<Vec<Option<ObjectId>>, LoadError> {
    let mut is_placed = vec![false; document.root.meshes.len()];
    placed.iter().for_each(|(mesh, _)| is_placed[mesh.value()] = true);
    let mut names = document.material_names();
    let mut budget = primitive::Budget::new(document);
    let mut objects = Vec::new();
    for (i, mesh) in document.root.meshes.iter().enumerate() {
        let geometries = match is_placed[i] {
            true => primitive::geometries(document, i, mesh, &mut names, &mut budget, builder)?,
            false => Vec::new(),
        };
        if geometries.is_empty() {
            objects.push(None);
            continue;
        }
        let error = |e| LoadError::scene(document.path, e);
        objects.push(Some(builder.begin_object(document.name("meshes", i)).map_err(error)?));
        for geometry in geometries {
            builder.add_geometry(geometry).map_err(error)?;
        }
        builder.end_object();
    }
    builder.scene_mut().names.materials = names;
    Ok(objects)
}

#[cfg(test)]
mod tests;
