//! The inputs of the cases B03 to B25 at one size, to see what builds of them take.

use geometry::TriangleMesh;

use super::meshes;
use crate::Random;

/// Meshes of `n` triangles, or nearly, for each kind of hard input, with the case that it is of: none should take a
/// builder much longer than the first, which is uniform. The small ones of the cases are repeated.
pub fn adversarial_meshes(n: usize, seed: u64) -> Vec<(&'static str, TriangleMesh)> {
    let mut random = Random::new(seed, 0);
    let random = &mut random;
    vec![
        ("uniform", meshes::uniform(n, random)),
        ("B03 identical", meshes::identical(n)),
        ("B04 concentric", meshes::concentric(n)),
        ("B06 cascade of halves", repeated(&meshes::cascade_of_halves(), n)),
        ("B07 cascade of twelfths", repeated(&meshes::cascade_of(12.0, 1.0), n)),
        ("B07 cascade of sixteenths", repeated(&meshes::cascade_of(16.0, 1e-30), n)),
        ("B08 signed cascade", repeated(&meshes::signed_cascade(random), n)),
        ("B09 teapot in a stadium", repeated(&meshes::teapot_in_a_stadium(5, random)[1], n)),
        ("B10 ends of the grid", repeated(&meshes::morton_extremes(0, 1.0), n)),
        ("B11 in a plane", meshes::in_a_plane(n, random)),
        ("B11 in a line", meshes::in_a_line(n)),
        ("B12 on ten points", meshes::on_ten_points(n, random)),
        ("B13 huge", meshes::scaled(n, 1e17, random)),
        ("B14 denormal", meshes::scaled(n, 1e-40, random)),
        ("B15 mixed scales", meshes::mixed_scales(n, random)),
        ("B16 NaN", meshes::not_finite(n, f32::NAN, 3, random)),
        ("B17 infinite", meshes::not_finite(n, f32::INFINITY, 1, random)),
        ("B19 without area", meshes::no_area(n, random)),
        ("B20 zeros of both signs", repeated(&meshes::zeros_of_both_signs(200, random)[0], n)),
        ("B24 needles", meshes::needles(n, random)),
        ("B25 one over all", meshes::one_over_all(n, random)),
    ]
}

/// A mesh so often that it has `n` triangles, each with vertices of its own.
fn repeated(mesh: &TriangleMesh, n: usize) -> TriangleMesh {
    meshes::mesh_of((0..n).map(|i| mesh.vertices(i % mesh.len())))
}
