//! The meshes that triangles are hard in.

use std::collections::HashMap;

use geometry::glam::{DMat3, DQuat, DVec2, DVec3, Vec3};
use geometry::{MeshError, TriangleMesh};
use scene::meshes;

use crate::Random;

/// pbrt's closed test mesh: longitudes and latitudes with radii of its own for each vertex.
pub(super) fn spiky_sphere(
    size: usize,
    random: &mut Random,
    radius: impl Fn(f32) -> f64,
) -> Result<TriangleMesh, MeshError> {
    meshes::uv_sphere(size - 1, size, |_| radius(random.unit()))
}

/// A closed twisted ribbon along the x axis, `length` long: `rings` triangles of the circumradius 1, each turned
/// against the one before, with capped ends.
pub(super) fn needle(length: f64, rings: usize) -> Result<TriangleMesh, MeshError> {
    // A third of a turn from corner to corner, an angle with the cosine 12/13 from ring to ring.
    let (third, twist) = (DVec2::new(-0.5, 0.75_f64.sqrt()), DVec2::new(12.0 / 13.0, 5.0 / 13.0));
    let mut corner = DVec2::new(0.6, 0.8);
    let mut positions = Vec::new();
    for ring in 0..rings {
        let x = length * (ring as f64 / (rings - 1) as f64 - 0.5);
        for _ in 0..3 {
            positions.push(DVec3::new(x, corner.x, corner.y).as_vec3());
            corner = corner.rotate(third);
        }
        corner = corner.rotate(twist);
    }
    let mut triangles = vec![[0, 2, 1], [0, 1, 2].map(|i| (3 * (rings - 1) + i) as u32)];
    for ring in 0..rings - 1 {
        for side in 0..3 {
            let [a, b] = [side, (side + 1) % 3].map(|side| (3 * ring + side) as u32);
            triangles.extend([[a, b, b + 3], [a, b + 3, a + 3]]);
        }
    }
    TriangleMesh::new(positions, triangles)
}

/// The faces between filled and empty cells of an n × n × n grid, two triangles each, over shared lattice vertices;
/// cell (x, y, z) is filled where `is_filled` says so. Closed, though edges may have four triangles.
pub(super) fn voxels(n: i32, is_filled: impl Fn([i32; 3]) -> bool) -> Result<TriangleMesh, MeshError> {
    let filled = |c: [i32; 3]| c.iter().all(|x| (0..n).contains(x)) && is_filled(c);
    let (mut positions, mut triangles, mut indices) = (Vec::new(), Vec::new(), HashMap::new());
    let mut index = |p: [i32; 3]| {
        *indices.entry(p).or_insert_with(|| {
            positions.push(Vec3::from_array(p.map(|x| x as f32)));
            positions.len() as u32 - 1
        })
    };
    for i in 0..n * n * n {
        let cell = [i % n, i / n % n, i / (n * n)];
        if !filled(cell) {
            continue;
        }
        for face in 0..6 {
            let (axis, side) = (face / 2, face % 2);
            let mut beyond = cell;
            beyond[axis] += 2 * side as i32 - 1;
            if filled(beyond) {
                continue;
            }
            let corner = |a: i32, b: i32| {
                let mut p = cell;
                p[axis] += side as i32;
                p[(axis + 1) % 3] += a;
                p[(axis + 2) % 3] += b;
                p
            };
            let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)].map(&mut index);
            triangles.extend(if side == 1 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
        }
    }
    TriangleMesh::new(positions, triangles)
}

/// The mesh with every position mapped, and rounded again.
pub(crate) fn mapped(mesh: &TriangleMesh, map: impl Fn(DVec3) -> DVec3) -> Result<TriangleMesh, MeshError> {
    let positions: Vec<Vec3> = mesh.positions().iter().map(|p| map(p.as_dvec3()).as_vec3()).collect();
    TriangleMesh::new(positions, mesh.triangles().to_vec())
}

/// Three corners a triangle, nothing shared.
pub(crate) fn soup(triangles: impl IntoIterator<Item = [Vec3; 3]>) -> Result<TriangleMesh, MeshError> {
    let positions: Vec<Vec3> = triangles.into_iter().flatten().collect();
    let indices = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    TriangleMesh::new(positions, indices)
}

/// A rotation that is parallel to nothing.
pub(super) fn skew_rotation() -> DMat3 {
    DMat3::from_quat(DQuat::from_xyzw(0.2, 0.4, 0.4, 0.8))
}

/// Uniform among the floats between two positive ones, hence nearly uniform in the logarithm, and the same on every
/// platform.
pub(crate) fn log_uniform(random: &mut Random, low: f32, high: f32) -> f32 {
    let (low, high) = (low.to_bits(), high.to_bits());
    f32::from_bits(low + random.below((high - low) as usize) as u32)
}
