//! Trees whose space is split: triangles are in several leaves, and no answer knows of it.

use std::sync::Arc;

use bvh_flat::bvh_build::{Reinsertion, SpatialSplits, build_split};
use bvh_flat::cache::{TreeLayout, TreeOptions};
use bvh_flat::geometry::glam::Vec3;
use bvh_flat::geometry::{Bounds3, Hit, Interval, Shape, TraversalRay, TriangleMesh, Visit, clipped_triangle_bounds};
use bvh_flat::{BuildConfig, FlatBvh, InvalidBvh, MeshBvh, RaySegment, SimdWidth, WideLayout, WideMesh};

use crate::support::{Random, only_mesh, rays_at, real_scenes};

type Bits = (u64, u32, u32, u32);

fn bits(hit: Hit) -> Bits {
    (hit.primitive, hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits())
}

/// All hits in the interval, which stays as it is.
fn all(shape: &dyn Shape, ray: &TraversalRay, interval: Interval) -> Vec<Bits> {
    let mut hits = Vec::new();
    let _ = shape.visit_hits(ray, interval, &mut |hit: Hit| {
        hits.push(bits(hit));
        Visit::Continue(interval.t_max())
    });
    hits.sort_unstable();
    hits
}

/// The preset; and planes wherever they gain anything, with and without what comes after.
fn configs() -> [BuildConfig; 4] {
    let eager = SpatialSplits::new(0.0, 1.0).with_least_references(2);
    let config = BuildConfig::highest().with_spatial_splits(Some(eager));
    let whole = Reinsertion::new(2, 0.8).with_merged_leaves(false);
    [BuildConfig::highest(), config, config.with_reinsertion(None), config.with_reinsertion(Some(whole))]
}

/// Closest hits, any hits, all hits and batches of every layout and width are those of a tree whose space is not split;
/// how many references the trees have beyond one for each triangle.
fn check(name: &str, mesh: &Arc<TriangleMesh>, count: usize, seed: u64) -> usize {
    let reference = MeshBvh::build(Arc::clone(mesh), &BuildConfig::default()).expect("the default is valid").exact();
    let rays = rays_at(mesh, &mesh.object_bound(), count, seed);
    let rays: Vec<(TraversalRay, Interval)> =
        rays.iter().filter_map(|(ray, interval)| Some((TraversalRay::new(ray)?, *interval))).collect();
    let closest: Vec<_> = rays.iter().map(|(ray, interval)| reference.intersect(ray, *interval).map(bits)).collect();
    assert!(closest.iter().flatten().count() * 5 > count, "{name}: rays that hit nothing prove nothing");
    let every: Vec<_> = rays.iter().map(|(ray, interval)| all(&reference, ray, *interval)).collect();
    let segments: Vec<RaySegment> = rays
        .iter()
        .map(|(ray, interval)| {
            let (origin, direction) = (ray.ray().origin.into(), ray.ray().direction.into());
            RaySegment { origin, t_min: interval.t_min(), direction, t_max: interval.t_max() }
        })
        .collect();
    let mut extra = 0;
    for (config, layout) in configs().into_iter().flat_map(|config| WideLayout::ALL.map(|layout| (config, layout))) {
        extra += extra_references(mesh, &config);
        let tree = WideMesh::build_observed(Arc::clone(mesh), &config, layout, &()).expect("valid");
        let options = TreeOptions::new(&config, TreeLayout::Wide(layout));
        let bytes = tree.to_bytes(&options).expect("what was built is what a file may hold");
        let loaded = WideMesh::from_bytes(&bytes, Arc::clone(mesh), Some(&options)).expect("whole");
        let built = SimdWidth::available().into_iter().map(|width| (width.name(), tree.with_simd_width(width)));
        for (from, wide) in built.chain([("a file", loaded)]) {
            let what = format!("{name} {} {from} {config:?}", layout.name());
            for (((ray, interval), closest), every) in rays.iter().zip(&closest).zip(&every) {
                assert_eq!(wide.intersect(ray, *interval).map(bits), *closest, "{what}: {ray:?} {interval:?}");
                assert_eq!(wide.intersect_p(ray, *interval), closest.is_some(), "{what}: {ray:?} {interval:?}");
                assert_eq!(all(&wide, ray, *interval), *every, "{what}: {ray:?} {interval:?}");
            }
            let mut hits = vec![None; segments.len()];
            wide.intersect_many(&segments, &mut hits);
            assert!(hits.iter().zip(&closest).all(|(hit, closest)| hit.map(bits) == *closest), "{what}: a batch");
        }
    }
    extra
}

fn split_tree(mesh: &TriangleMesh, config: &BuildConfig) -> FlatBvh {
    let bounds: Vec<Bounds3> = (0..mesh.len()).map(|i| mesh.triangle_bounds(i)).collect();
    let clipped = |i: u32, to: &Bounds3| clipped_triangle_bounds(&mesh.vertices(i as usize), to);
    FlatBvh::from_tree(build_split(bounds.len(), |i| bounds[i as usize], &clipped, config, &()).expect("valid"))
}

fn extra_references(mesh: &TriangleMesh, config: &BuildConfig) -> usize {
    split_tree(mesh, &config.with_max_primitives_in_leaf(1)).extra_references() as usize
}

/// Long and short triangles in all directions, some of them flat boxes, needles, and without area.
fn mixed(count: usize, seed: u64) -> Arc<TriangleMesh> {
    let mut random = Random::new(seed);
    let mut positions = Vec::new();
    for i in 0..count {
        let (p, size) = (random.vector(), [1.5, 0.3, 0.02][i % 3]);
        let mut corners = [p, p + size * random.vector(), p + size * random.vector()];
        match i % 8 {
            0 => corners.iter_mut().for_each(|corner| corner[i % 3] = p[i % 3]),
            1 => corners[2] = corners[0].lerp(corners[1], 0.75),
            2 => corners[2] = corners[0] + 1e-6 * random.vector(),
            _ => {}
        }
        positions.extend(corners);
    }
    // Invalid ones keep their numbers.
    positions[4] = Vec3::NAN;
    let triangles = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Arc::new(TriangleMesh::new(positions, triangles).expect("in range"))
}

#[test]
fn made_meshes_have_the_same_hits() {
    for (seed, count) in [(1, 5), (2, 40), (3, 400), (4, 2000)] {
        let extra = check("mixed", &mixed(count, seed), 500, seed);
        assert!(count < 400 || extra > count, "{count}: {extra}");
    }
}

#[test]
fn real_scenes_have_the_same_hits() {
    let Some(folder) = real_scenes("split trees of real meshes") else { return };
    for name in ["suzanne", "cow", "legocar"] {
        let scene = scene::load(&folder.join(name).with_extension("ply")).expect("a known scene");
        let extra = check(name, &only_mesh(&scene), 500, 5);
        assert!(extra > 100, "{name}: {extra}");
    }
}

/// A leaf has only a part of each triangle, and kernels in f32 rely on its own box.
#[test]
fn whoever_needs_whole_triangles_refuses_parts() {
    let mesh = mixed(2000, 4);
    let bvh = split_tree(&mesh, &configs()[1]);
    assert!(bvh.extra_references() > 0);
    let again = |extra| FlatBvh::from_split_parts(bvh.nodes().into(), bvh.order().into(), bvh.primitive_count(), extra);
    assert_eq!(again(bvh.extra_references()).as_ref(), Ok(&bvh));
    assert!(matches!(again(bvh.extra_references() - 1), Err(InvalidBvh::Order { .. })));
    assert!(FlatBvh::from_parts(bvh.nodes().into(), bvh.order().into(), bvh.primitive_count()).is_err());
    assert!(matches!(MeshBvh::from_parts(mesh, bvh), Err(InvalidBvh::Geometry(_))));
}

#[test]
fn threads_change_nothing() {
    let mesh = mixed(20_000, 6);
    let [one, three] = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads can start");
        pool.install(|| split_tree(&mesh, &configs()[1]))
    });
    assert!(one == three && one.extra_references() > 10_000);
}
