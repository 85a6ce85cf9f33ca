//! Trees over geometry that moved: the answers are those of a new build, bit for bit.

use std::sync::Arc;

use bvh_flat::geometry::glam::Vec3;
use bvh_flat::geometry::{Bounds3, Hit, Interval, Shape, TraversalRay, TriangleMesh};
use bvh_flat::{BuildConfig, FlatBvh, MeshBvh, RefitError, WideLayout, WideMesh};

use crate::support::{Random, rays_at};

/// A grid of triangles, bent by a function of the place.
fn grid(size: u32, bend: impl Fn(f32, f32) -> Vec3) -> Arc<TriangleMesh> {
    let positions = (0..=size).flat_map(|y| (0..=size).map(move |x| (x, y)));
    let positions: Vec<Vec3> = positions.map(|(x, y)| bend(x as f32 / size as f32, y as f32 / size as f32)).collect();
    let triangles = (0..size * size).flat_map(|i| {
        let a = i / size * (size + 1) + i % size;
        [[a, a + 1, a + size + 2], [a, a + size + 2, a + size + 1]]
    });
    Arc::new(TriangleMesh::new(positions, triangles.collect()).expect("the indices are in range"))
}

fn bits(hit: Option<Hit>) -> Option<[u64; 4]> {
    hit.map(|h| [h.t, h.u, h.v].map(|x| u64::from(x.to_bits()))).zip(hit).map(|([t, u, v], h)| [t, u, v, h.primitive])
}

/// Whether both answer the same; how many rays hit. Fewer are asked of larger meshes: each may have to look at all
/// triangles.
fn agree(a: &dyn Shape, b: &dyn Shape, mesh: &Arc<TriangleMesh>) -> usize {
    let rays = rays_at(mesh, &mesh.object_bound(), (200_000 / mesh.len()).min(1000), 3);
    let rays = rays.into_iter().filter_map(|(ray, _)| TraversalRay::new(&ray));
    rays.filter(|ray| {
        let [a, b] = [a, b].map(|shape| bits(shape.intersect(ray, Interval::FULL)));
        assert_eq!(a, b, "{ray:?}");
        a.is_some()
    })
    .count()
}

fn bounds(mesh: &TriangleMesh) -> Vec<Bounds3> {
    (0..mesh.len()).map(|i| mesh.watertight_bounds(i)).collect()
}

/// Flat, waving, rolled up, torn to pieces, and all in one point.
fn moves(size: u32) -> Vec<(&'static str, Arc<TriangleMesh>)> {
    let mut random = Random::new(7);
    let noise: Vec<Vec3> = (0..=size).flat_map(|_| 0..=size).map(|_| random.vector()).collect();
    let place =
        |x: f32, y: f32| ((y * size as f32).round() as u32 * (size + 1) + (x * size as f32).round() as u32) as usize;
    vec![
        ("flat", grid(size, |x, y| Vec3::new(x, 0.0, y))),
        ("waves", grid(size, |x, y| Vec3::new(x, 0.2 * (9.0 * x).sin() * (7.0 * y).cos(), y))),
        ("rolled", grid(size, |x, y| Vec3::new((9.0 * x).cos() * (0.2 + x), y, (9.0 * x).sin() * (0.2 + x)))),
        ("torn", grid(size, |x, y| 3.0 * noise[place(x, y)])),
        ("a point", grid(size, |_, _| Vec3::ONE)),
    ]
}

#[test]
fn a_refitted_wide_tree_answers_as_a_new_one() {
    // The larger one has several blocks of lines for threads.
    for size in [3, 40, 160] {
        let moves = moves(size);
        for layout in WideLayout::ALL {
            let build = |mesh: &Arc<TriangleMesh>| {
                WideMesh::build_observed(Arc::clone(mesh), &BuildConfig::balanced(), layout, &()).expect("valid")
            };
            let mut tree = build(&moves[1].1);
            let mut hits = 0;
            for (name, mesh) in &moves {
                let clone = tree.clone();
                let before = clone.mesh().clone();
                let ratio = tree.refit(Arc::clone(mesh)).expect("as many triangles, all active");
                assert!(ratio.is_finite() && ratio > 0.0, "{name}: {ratio}");
                hits += agree(&tree, &build(mesh), mesh);
                // A clone is what it was.
                agree(&clone, &build(&before), &before);
            }
            assert!(size != 40 || hits > 100, "{hits}");
            // Back to what it was built of: so are the boxes, and the cost.
            tree.refit(Arc::clone(&moves[1].1)).expect("as many triangles");
            let torn = tree.refit(Arc::clone(&moves[3].1)).expect("as many triangles");
            let back = tree.refit(Arc::clone(&moves[1].1)).expect("as many triangles");
            assert!(size == 3 || torn > 2.0, "{size}: a torn mesh is worse: {torn}");
            assert!((torn * back - 1.0).abs() < 1e-9, "{torn} {back}");
        }
    }
}

#[test]
fn a_refitted_flat_tree_answers_as_a_new_one() {
    let moves = moves(90); // More nodes than one thread adapts.
    let config = BuildConfig::default();
    let mut bvh = FlatBvh::build(&bounds(&moves[1].1), &config, &()).expect("valid");
    let first = bvh.clone();
    for (name, mesh) in &moves {
        let ratio = bvh.refit(&bounds(mesh)).expect("as many triangles, all active");
        assert!(ratio.is_finite() && ratio > 0.0, "{name}: {ratio}");
        // The validator sees that every leaf contains its triangles, and every box what is below.
        let refitted = MeshBvh::from_parts(Arc::clone(mesh), bvh.clone()).expect("a tree of this mesh");
        agree(&refitted, &MeshBvh::build(Arc::clone(mesh), &config).expect("valid"), mesh);
    }
    bvh.refit(&bounds(&moves[1].1)).expect("as many triangles");
    assert_eq!(bvh, first, "the smallest boxes, as a builder makes them");
}

#[test]
fn threads_change_nothing() {
    let moves = moves(160);
    let [one, four] = [1, 4].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads can start");
        pool.install(|| {
            let mut wide = WideMesh::build(Arc::clone(&moves[1].1), &BuildConfig::balanced()).expect("valid");
            let mut flat = FlatBvh::build(&bounds(&moves[1].1), &BuildConfig::default(), &()).expect("valid");
            let ratios = [
                wide.refit(Arc::clone(&moves[3].1)).expect("as many").to_bits(),
                flat.refit(&bounds(&moves[3].1)).expect("as many").to_bits(),
            ];
            (ratios, flat, wide)
        })
    });
    assert_eq!((one.0, &one.1), (four.0, &four.1));
    agree(&one.2, &four.2, &moves[3].1);
}

#[test]
fn what_cannot_be_refitted_is_refused_and_left_alone() {
    let moves = moves(20);
    let waves = &moves[1].1;
    let count = waves.len();
    let mut wide = WideMesh::build(Arc::clone(waves), &BuildConfig::balanced()).expect("valid");
    let mut flat = FlatBvh::build(&bounds(waves), &BuildConfig::default(), &()).expect("valid");
    let before = flat.clone();

    let fewer = grid(19, |x, y| Vec3::new(x, 0.0, y));
    let error = RefitError::Count { expected: count, found: fewer.len() };
    assert_eq!(wide.refit(Arc::clone(&fewer)), Err(error.clone()));
    assert_eq!(flat.refit(&bounds(&fewer)), Err(error));

    let broken = grid(20, |x, y| if x == 0.5 && y == 0.5 { Vec3::NAN } else { Vec3::new(x, 0.0, y) });
    let primitive = (0..count).find(|&i| !broken.triangle_bounds(i).is_valid()).expect("six are");
    assert_eq!(wide.refit(Arc::clone(&broken)), Err(RefitError::Activity { primitive }));
    assert_eq!(flat.refit(&bounds(&broken)), Err(RefitError::Activity { primitive }));
    let mut of_broken = WideMesh::build(Arc::clone(&broken), &BuildConfig::balanced()).expect("valid");
    assert_eq!(of_broken.refit(Arc::clone(waves)), Err(RefitError::Activity { primitive }));
    // Those that stay inactive are no reason.
    let broken_too = grid(20, |x, y| if x == 0.5 && y == 0.5 { Vec3::INFINITY } else { Vec3::new(y, x, 0.1) });
    assert!(of_broken.refit(Arc::clone(&broken_too)).is_ok());
    agree(&of_broken, &WideMesh::build(Arc::clone(&broken_too), &BuildConfig::balanced()).expect("valid"), &broken_too);

    assert_eq!(flat, before);
    agree(&wide, &WideMesh::build(Arc::clone(waves), &BuildConfig::balanced()).expect("valid"), waves);

    // A plane through many triangles.
    let eager = bvh_flat::bvh_build::SpatialSplits::new(0.0, 1.0).with_least_references(2);
    let config = BuildConfig::high().with_spatial_splits(Some(eager));
    let mut split = WideMesh::build(Arc::clone(&moves[3].1), &config).expect("valid");
    assert_eq!(split.refit(Arc::clone(waves)), Err(RefitError::Split));
}
