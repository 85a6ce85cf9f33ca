//! The wide tree beside the binary one, both of which decide exactly.

use std::sync::Arc;

use bvh_flat::geometry::glam::Vec3;
use bvh_flat::geometry::{Hit, Interval, Shape, TraversalRay, TriangleMesh};
use bvh_flat::{BuildConfig, MeshBvh, SimdWidth, SplitMethod, WideMesh};

use crate::support::{only_mesh, rays_at, real_scenes};

fn bits(hit: Option<Hit>) -> Option<(u32, u32, u32, u64)> {
    hit.map(|h| (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.primitive))
}

/// Closest, any and all hits of every width and split method equal those of the binary tree.
fn check(name: &str, mesh: &Arc<TriangleMesh>, count: usize, seed: u64) {
    let reference = MeshBvh::build(Arc::clone(mesh), &BuildConfig::default()).expect("the default is valid").exact();
    let rays = rays_at(mesh, &mesh.object_bound(), count, seed);
    let rays: Vec<(TraversalRay, Interval)> =
        rays.iter().filter_map(|(ray, interval)| Some((TraversalRay::new(ray)?, *interval))).collect();
    let answers: Vec<_> = rays.iter().map(|(ray, interval)| bits(reference.intersect(ray, *interval))).collect();
    assert!(answers.iter().flatten().count() > count / 4, "{name}: rays that hit nothing prove nothing");
    for method in SplitMethod::ALL {
        for leaf in [1, 4, 30] {
            let config = BuildConfig::new(method).with_max_primitives_in_leaf(leaf);
            let bvh = MeshBvh::build(Arc::clone(mesh), &config).expect("the configuration is valid");
            let wide = WideMesh::new(&bvh).expect("small enough");
            for width in SimdWidth::available() {
                let wide = wide.with_simd_width(width);
                for ((ray, interval), answer) in rays.iter().zip(&answers) {
                    let what = || format!("{name} {} {leaf} {} {ray:?} {interval:?}", method.name(), width.name());
                    assert_eq!(bits(wide.intersect(ray, *interval)), *answer, "{}", what());
                    assert_eq!(wide.intersect_p(ray, *interval), answer.is_some(), "{}", what());
                }
            }
        }
    }
}

#[test]
fn real_scenes_have_the_same_hits() {
    let Some(folder) = real_scenes("wide trees of real meshes") else { return };
    for name in ["bunny", "cow", "cad-shaft", "voxel-monu0-boxes", "q3-minia", "engine-2cylinder"] {
        let scene = scene::load(&folder.join(name).with_extension("ply")).expect("a known scene");
        check(name, &only_mesh(&scene), 4_000, 7);
    }
}

#[test]
fn small_meshes_have_the_same_hits() {
    for count in 1..30_u64 {
        let mut random = crate::support::Random::new(count);
        let positions: Vec<Vec3> = (0..3 * count).map(|_| random.vector()).collect();
        let triangles = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        check("random", &Arc::new(TriangleMesh::new(positions, triangles).expect("in range")), 200, count);
    }
}
