//! What the benchmarks share: one seeded mesh and rays at it. `cargo bench -p benchmarks`.

use bvh_flat::geometry::glam::Vec3;
use bvh_flat::geometry::{Bounds3, Ray, Shape, TraversalRay, TriangleMesh};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;

/// A bumpy closed surface of 20 · 4^`subdivisions` triangles.
pub fn bumpy_sphere(subdivisions: u32) -> TriangleMesh {
    scene::meshes::icosphere(subdivisions, |p| 1.0 + 0.1 * (9.0 * p.x).sin() * (8.0 * p.y).cos())
        .unwrap_or_else(|e| panic!("the benchmark's mesh: {e}"))
}

/// `count` rays between points of the mesh's box: every one comes near the surface.
pub fn chords(mesh: &TriangleMesh, count: usize) -> Vec<TraversalRay> {
    let bounds: Bounds3 = mesh.object_bound();
    let mut random = Pcg32::new(1, 2);
    let mut number = || (random.next_u32() >> 8) as f32 / 16_777_216.0;
    let mut point = || bounds.min + bounds.diagonal() * Vec3::new(number(), number(), number());
    (0..count)
        .filter_map(|_| {
            let (from, to) = (point(), point());
            TraversalRay::new(&Ray::new(from, to - from))
        })
        .collect()
}
