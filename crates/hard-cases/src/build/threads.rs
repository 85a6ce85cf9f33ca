//! B23, B26: any number of threads, and threads with next to no stack.

use std::sync::Arc;

use bvh_flat::{FlatBvh, MeshBvh, WideMesh};
use geometry::{Bounds3, Interval, Shape, TriangleMesh};
use rayon::ThreadPoolBuilder;

use super::meshes::{cascade_of_halves, identical, signed_cascade, teapot_in_a_stadium, uniform};
use super::sweep::{configs, expected, label, rays_at};
use crate::exact_triangles::ExactTriangles;
use crate::{Outcome, Random, Run, Tries};

/// B23, and D04: the tree is the same, bit for bit, on any number of threads.
pub(super) fn any_number(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 23);
    let mesh = uniform(run.effort.pick(20_000, 1_000_000), &mut random);
    let bounds = bounds_of(&mesh);
    let counts = if run.effort == crate::Effort::Quick { vec![1, 2, 3, 8] } else { (1..=64).collect() };
    for config in configs(&[4]) {
        let Ok(expected) = FlatBvh::build(&bounds, &config, &()) else {
            tries.check(false, || label("does not build", &config));
            continue;
        };
        for &threads in &counts {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build();
            let Ok(pool) = pool else {
                tries.check(false, || format!("{threads} threads do not start"));
                continue;
            };
            for _ in 0..run.effort.pick(1, 20) {
                let bvh = pool.install(|| FlatBvh::build(&bounds, &config, &()));
                let is_same = bvh.as_ref() == Ok(&expected);
                tries.check(is_same, || label(&format!("{threads} threads make another tree"), &config));
            }
        }
    }
    tries.outcome()
}

/// The stack of the calling thread.
const STACK: usize = 64 << 10;

/// The stack of the pool's threads. Waiting for one half of a node, a thread of rayon works on other nodes, on the same
/// stack: 64 KiB are too few, and overflow with 12 600 primitives in a cascade; 128 KiB overflow with 210 000; 256 KiB
/// do for both.
const POOL_STACK: usize = 512 << 10;

/// B26: builds and traversals of the deepest trees with little stack. An overflow would end the process.
pub(super) fn little_stack(run: &Run) -> Outcome {
    let mut random = Random::new(run.seed, 26);
    let [_, stadium] = teapot_in_a_stadium(run.effort.pick(4, 8), &mut random);
    // The cascade of many copies is as deep, and deep where builds are parallel.
    let cascade = cascade_of_halves();
    let copies = vec![&cascade; run.effort.pick(60, 5_000)];
    let meshes = [
        ("identical", identical(run.effort.pick(20_000, 1_000_000))),
        ("halves", scene::meshes::merge(copies).expect("few enough triangles")),
        ("signed halves", signed_cascade(&mut random)),
        ("stadium", stadium),
    ];
    let mut tries = Tries::new();
    for (name, mesh) in meshes {
        let rays = rays_at(&mesh, 10, &mut random);
        let mesh = Arc::new(mesh);
        let (exact, expected) = (expected(&ExactTriangles::new(Arc::clone(&mesh)), &rays), expected(&*mesh, &rays));
        for config in configs(&[1]) {
            let work = || -> Option<bool> {
                let pool = ThreadPoolBuilder::new().num_threads(2).stack_size(POOL_STACK).build().ok()?;
                let bvh = pool.install(|| MeshBvh::build(Arc::clone(&mesh), &config)).ok()?;
                let wide = pool.install(|| WideMesh::build(Arc::clone(&mesh), &config)).ok()?;
                let is_right = expected.iter().all(|(ray, hit)| bvh.intersect(ray, Interval::FULL) == *hit);
                Some(is_right && exact.iter().all(|(ray, hit)| wide.intersect(ray, Interval::FULL) == *hit))
            };
            let result = std::thread::scope(|scope| {
                let thread = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, work);
                thread.map(|thread| thread.join().ok().flatten())
            });
            let holds = matches!(result, Ok(Some(true)));
            tries.check(holds, || format!("{}: {result:?}", label(name, &config)));
        }
    }
    tries.outcome()
}

fn bounds_of(mesh: &TriangleMesh) -> Vec<Bounds3> {
    (0..mesh.len()).map(|i| mesh.triangle_bounds(i)).collect()
}
