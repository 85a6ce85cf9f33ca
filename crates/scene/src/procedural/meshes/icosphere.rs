//! The icosahedron and its subdivisions.

use std::collections::HashMap;

use geometry::glam::DVec3;
use geometry::{MeshError, TriangleMesh};

use super::check_count;

/// A closed sphere whose distance from the center is `radius(direction)`: an icosahedron, each triangle of which is
/// split into four, `subdivisions` times. 20 · 4ⁿ triangles of nearly equal size.
///
/// # Errors
/// [`MeshError::TooLarge`].
pub fn icosphere(subdivisions: u32, mut radius: impl FnMut(DVec3) -> f64) -> Result<TriangleMesh, MeshError> {
    let count = 4_usize.checked_pow(subdivisions).and_then(|n| n.checked_mul(20));
    check_count("triangles", count)?;
    let mut directions: Vec<DVec3> = icosahedron_vertices().map(DVec3::normalize).to_vec();
    let mut triangles = ICOSAHEDRON.to_vec();
    for _ in 0..subdivisions {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                directions.push((directions[a as usize] + directions[b as usize]).normalize());
                directions.len() as u32 - 1
            })
        };
        let mut split = Vec::with_capacity(4 * triangles.len());
        for [a, b, c] in triangles {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            split.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = split;
    }
    TriangleMesh::new(directions.iter().map(|&d| (d * radius(d)).as_vec3()), triangles)
}

fn icosahedron_vertices() -> [DVec3; 12] {
    let g = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let signs = [(-1.0, g), (1.0, g), (-1.0, -g), (1.0, -g)];
    std::array::from_fn(|i| {
        let (one, g) = signs[i % 4];
        DVec3::from_array([[one, g, 0.0], [0.0, one, g], [g, 0.0, one]][i / 4])
    })
}

/// In the order of [`icosahedron_vertices`].
#[rustfmt::skip]
const ICOSAHEDRON: [[u32; 3]; 20] = [
    [0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11],
    [1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6], [7, 1, 8],
    [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9],
    [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1],
];
