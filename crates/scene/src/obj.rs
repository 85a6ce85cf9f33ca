//! Wavefront OBJ files (Wavefront 1995, *Advanced Visualizer Manual*, appendix B1): the polygons in them.
//!
//! The whole file is one mesh, in file order; `o`, `g` and `s` change nothing. The names after `usemtl` become the
//! scene's materials; a mesh has one surface, that of its first face.
//!
//! An own reader, after trying the crate tobj 4.0.5: its errors name neither line nor face ("face vertex index out of
//! bounds"), it forgets the names of materials whose library is missing, and it makes a mesh of each run of a material,
//! with its own copy of the vertices. It is no faster: sponza.obj takes it 26 to 31 ms (least and median), and this one
//! 24 to 29 ms. It is the reference in the tests below.

mod parser;

use std::collections::HashMap;
use std::path::Path;

use geometry::TriangleMesh;
use geometry::glam::Vec2;

use self::parser::{NO_UV, Polygons};
use crate::{LoadError, Place, Scene};

pub(crate) fn load(path: &Path) -> Result<Scene, LoadError> {
    let bytes = std::fs::read(path).map_err(|source| LoadError::Io { path: path.to_owned(), source })?;
    parse(path, &bytes)
}

fn parse(path: &Path, bytes: &[u8]) -> Result<Scene, LoadError> {
    let mut polygons = Polygons::parse(path, bytes)?;
    polygons.check_indices(path)?;
    let mut warnings = polygons.warnings();
    warnings.extend(missing_library(path, &polygons.libraries));
    let (materials, material) = (std::mem::take(&mut polygons.materials), polygons.first_material.unwrap_or(0));
    if let [_, _, ..] = materials[..] {
        let (count, name) = (materials.len(), &materials[material as usize]);
        warnings.push(format!("{count} materials are used, and a mesh has one: all of it is \"{name}\""));
    }
    let mesh = mesh(polygons).map_err(|e| LoadError::malformed(path, Place::Unknown, e.to_string()))?;
    Scene::of_mesh(path, mesh, materials, material, warnings)
}

/// One vertex for each position, or where there are texture coordinates for each pair of both that is used.
fn mesh(polygons: Polygons) -> Result<TriangleMesh, geometry::MeshError> {
    let Polygons { positions, uvs, triangles, uv_triangles, .. } = polygons;
    if uv_triangles.is_empty() {
        return TriangleMesh::new(positions, triangles);
    }
    let mut numbers = HashMap::new();
    let (mut pair_positions, mut pair_uvs) = (Vec::new(), Vec::new());
    let mut number = |v: u32, vt: u32| {
        *numbers.entry((v, vt)).or_insert_with(|| {
            pair_positions.push(positions[v as usize]);
            pair_uvs.push(if vt == NO_UV { Vec2::ZERO } else { uvs[vt as usize] });
            (pair_positions.len() - 1) as u32
        })
    };
    let triangles = std::iter::zip(triangles, uv_triangles);
    let triangles = triangles.map(|(v, vt)| [0, 1, 2].map(|k| number(v[k], vt[k]))).collect();
    TriangleMesh::new(pair_positions, triangles)?.with_uvs(pair_uvs)
}

/// A warning of the first library that is missing. It is only looked for: materials are names here.
fn missing_library(path: &Path, libraries: &[String]) -> Option<String> {
    let is_there = |name: &str| path.parent().is_some_and(|folder| folder.join(name).is_file());
    // A line names one library, with spaces in its name or without, or several.
    let missing = libraries.iter().find(|line| !is_there(line) && !line.split_whitespace().all(is_there))?;
    Some(format!("the material library \"{missing}\" is not there; materials are names only"))
}

#[cfg(test)]
mod tests;
