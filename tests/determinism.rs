//! The same bytes for any number of threads.

use bvh_flat::geometry::TriangleMesh;
use bvh_flat::{BuildConfig, MeshBvh, SplitMethod};

use crate::support::Random;

fn soup(count: usize) -> TriangleMesh {
    let mut random = Random::new(5);
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..count as u32 {
        let at = 100.0 * random.vector();
        positions.extend([at, at + random.vector(), at + random.vector()]);
        triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    TriangleMesh::new(positions, triangles).expect("indices are in range")
}

#[test]
fn trees_have_the_same_bytes_for_any_number_of_threads() {
    let mesh = std::sync::Arc::new(soup(30_000));
    for method in SplitMethod::ALL {
        let build = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            let bvh = pool.install(|| MeshBvh::build(mesh.clone(), &BuildConfig::new(method)));
            bvh.expect("the configuration is valid").bvh().clone()
        };
        let one = build(1);
        assert!(one.nodes().len() > 10_000);
        for threads in [2, 3, 8] {
            assert_eq!(one, build(threads), "{} with {threads} threads", method.name());
        }
    }
}
