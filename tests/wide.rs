//! The wide tree beside the binary one, both of which decide exactly.

use std::sync::Arc;

use bvh_flat::geometry::glam::Vec3;
use bvh_flat::geometry::{Hit, Interval, Ray, Shape, TraversalRay, TriangleMesh};
use bvh_flat::{BuildConfig, MeshBvh, RaySegment, SimdWidth, SplitMethod, WideLayout, WideMesh};

use scene::BuiltIn;

use crate::support::{only_mesh, rays_at, real_scenes};

fn bits(hit: Option<Hit>) -> Option<(u32, u32, u32, u64)> {
    hit.map(|h| (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.primitive))
}

fn segment((ray, interval): &(TraversalRay, Interval)) -> RaySegment {
    let ray = ray.ray();
    let (origin, direction) = (ray.origin.into(), ray.direction.into());
    RaySegment { origin, t_min: interval.t_min(), direction, t_max: interval.t_max() }
}

/// Closest and any hits of every width and split method equal those of the binary tree.
fn check(name: &str, mesh: &Arc<TriangleMesh>, count: usize, least_hits: usize, seed: u64) {
    let reference = MeshBvh::build(Arc::clone(mesh), &BuildConfig::default()).expect("the default is valid").exact();
    let rays = rays_at(mesh, &mesh.object_bound(), count, seed);
    let rays: Vec<(TraversalRay, Interval)> =
        rays.iter().filter_map(|(ray, interval)| Some((TraversalRay::new(ray)?, *interval))).collect();
    let segments: Vec<RaySegment> = rays.iter().map(segment).collect();
    let answers: Vec<_> = rays.iter().map(|(ray, interval)| bits(reference.intersect(ray, *interval))).collect();
    assert!(answers.iter().flatten().count() >= least_hits, "{name}: rays that hit nothing prove nothing");
    for method in SplitMethod::ALL {
        for leaf in [1, 30] {
            let config = BuildConfig::new(method).with_max_primitives_in_leaf(leaf);
            let bvh = MeshBvh::build(Arc::clone(mesh), &config).expect("the configuration is valid");
            let layouts = WideLayout::ALL.map(|layout| WideMesh::new(&bvh, layout).expect("small enough"));
            for (layout, width) in layouts.iter().flat_map(|l| SimdWidth::available().into_iter().map(move |w| (l, w)))
            {
                let wide = layout.with_simd_width(width);
                for ((ray, interval), answer) in rays.iter().zip(&answers) {
                    let what = || format!("{name} {} {leaf} {} {ray:?} {interval:?}", method.name(), width.name());
                    assert_eq!(bits(wide.intersect(ray, *interval)), *answer, "{}", what());
                    assert_eq!(wide.intersect_p(ray, *interval), answer.is_some(), "{}", what());
                }
                let mut hits = vec![None; segments.len()];
                wide.intersect_many(&segments, &mut hits);
                assert!(hits.iter().zip(&answers).all(|(hit, answer)| bits(*hit) == *answer), "{name}: a batch");
                let mut occluded = vec![false; segments.len()];
                wide.intersect_p_many(&segments, &mut occluded);
                assert!(occluded.iter().zip(&answers).all(|(any, answer)| *any == answer.is_some()), "{name}: a batch");
            }
        }
    }
}

#[test]
fn real_scenes_have_the_same_hits() {
    let Some(folder) = real_scenes("wide trees of real meshes") else { return };
    for name in ["bunny", "cow", "cad-shaft", "voxel-monu0-boxes", "q3-minia", "engine-2cylinder"] {
        let scene = scene::load(&folder.join(name).with_extension("ply")).expect("a known scene");
        check(name, &only_mesh(&scene), 4_000, 1_000, 7);
    }
}

#[test]
fn small_meshes_have_the_same_hits() {
    for count in 1..30_u64 {
        let mut random = crate::support::Random::new(count);
        let positions: Vec<Vec3> = (0..3 * count).map(|_| random.vector()).collect();
        let triangles = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        check("random", &Arc::new(TriangleMesh::new(positions, triangles).expect("in range")), 200, 50, count);
    }
}

/// All in one plane, line or place: quantised boxes have no extent there, and lanes without a child are met like the
/// others.
#[test]
fn flat_meshes_have_the_same_hits() {
    for (count, axes) in (1..40_u64).flat_map(|count| [1, 2].map(|axes| (count, axes))) {
        let mut random = crate::support::Random::new(count);
        let mut positions: Vec<Vec3> = (0..3 * count).map(|_| random.vector()).collect();
        positions.iter_mut().for_each(|p| p[count as usize % 3] = 0.25);
        if axes == 2 {
            // Walls too, so that rays along the first plane hit something.
            positions.chunks_mut(6).for_each(|p| p[..3].iter_mut().for_each(|p| *p = Vec3::new(p.y, p.z, p.x)));
        }
        let triangles = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        check("flat", &Arc::new(TriangleMesh::new(positions, triangles).expect("in range")), 200, 20, count);
    }
}

/// A tree so large that the rays of a batch are interleaved.
#[test]
fn interleaved_rays_have_the_same_hits() {
    let terrain = BuiltIn::parse("terrain:300k").and_then(|terrain| terrain.scene(1)).expect("built in");
    let mesh = only_mesh(&terrain);
    let wide = WideMesh::build(Arc::clone(&mesh), &BuildConfig::default()).expect("the default is valid");
    assert!(wide.memory() > 16 << 20);
    let mut segments: Vec<RaySegment> = rays_at(&mesh, &mesh.object_bound(), 9_000, 3)
        .iter()
        .filter_map(|(ray, interval)| Some(segment(&(TraversalRay::new(ray)?, *interval))))
        .collect();
    for i in (0..segments.len()).step_by(50) {
        segments[i].direction[i % 3] = f32::NAN;
    }
    let mut hits = vec![None; segments.len() - 7];
    wide.intersect_many(&segments, &mut hits);
    let mut in_parallel = vec![None; segments.len()];
    wide.par_intersect_many(&segments, &mut in_parallel);
    let mut found = 0;
    for (i, ray) in segments.iter().enumerate() {
        let interval = Interval::new(ray.t_min, ray.t_max);
        let alone = TraversalRay::new(&Ray::new(ray.origin, ray.direction)).and_then(|r| wide.intersect(&r, interval));
        found += usize::from(alone.is_some());
        assert_eq!(bits(in_parallel[i]), bits(alone), "{ray:?}");
        assert!(hits.get(i).is_none_or(|hit| bits(*hit) == bits(alone)), "{ray:?}");
    }
    assert!(found > segments.len() / 4);
}

/// Triangles smaller than what f32 can tell of their distance: products of two errors count, not only of error and
/// extent.
#[test]
fn small_and_far_triangles_are_hit() {
    let corners = [[32.0, 32.015625, 31.75], [32.0, 32.0625, 32.0625], [32.0, 31.75, 32.015625]].map(Vec3::from);
    let mesh = Arc::new(TriangleMesh::new(corners, vec![[0, 1, 2]]).expect("in range"));
    let far = 2.0_f32.powi(30);
    let ray = TraversalRay::new(&Ray::new([far; 3], [-1.0; 3])).expect("valid");
    let bvh = MeshBvh::build(Arc::clone(&mesh), &BuildConfig::default()).expect("the default is valid");
    let expected = bits(bvh.exact().intersect(&ray, Interval::FULL));
    assert!(expected.is_some());
    for (layout, width) in
        WideLayout::ALL.into_iter().flat_map(|l| SimdWidth::available().into_iter().map(move |w| (l, w)))
    {
        let wide = WideMesh::new(&bvh, layout).expect("small enough").with_simd_width(width);
        assert_eq!(bits(wide.intersect(&ray, Interval::FULL)), expected, "{} {}", layout.name(), width.name());
        assert!(wide.intersect_p(&ray, Interval::FULL));
    }
}

/// A ray that was transformed, and whose origin f32 holds as a denormal number, or as zero: what that lost is more than
/// a part of the origin. Each box is left right behind the place where it is met.
#[test]
fn origins_that_f32_rounds_to_nothing_miss_no_box() {
    let unit = f64::from(f32::from_bits(1));
    let mut hits = 0;
    for axis in 0..3 {
        for (origin, plane) in [(0.3, 1.0), (0.49, 1.0), (-0.7, 0.0), (-1.4, 0.0), (2.51, 4.0)] {
            let direction = 2.0_f64.powi(-59);
            // Where the plane is met.
            let t = (plane - origin) * unit / direction;
            let place = |a: f64, b: f64| {
                let mut v = [(plane * unit) as f32, (t * a) as f32, (t * b) as f32];
                v.rotate_right(axis);
                v
            };
            // The first one is hit, the others are far from it, so many that they make nodes.
            let mut positions = vec![place(0.0, 0.0), place(1.002, 1.0), place(1.0, 1.002)];
            let far = |k: u32| [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|[x, y]| [x + 100.0 + k as f32, y, 50.0]);
            positions.extend((0..64).flat_map(far));
            let triangles: Vec<[u32; 3]> = (0..65).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
            let mesh = Arc::new(TriangleMesh::new(positions, triangles).expect("valid"));
            let config = BuildConfig::default().with_max_primitives_in_leaf(1);
            let bvh = MeshBvh::build(Arc::clone(&mesh), &config).expect("valid");
            let mut o = [origin * unit, 0.0, 0.0];
            let mut d = [direction, 1.0, 1.0];
            o.rotate_right(axis);
            d.rotate_right(axis);
            let ray = TraversalRay::from_f64(o.into(), d.into(), 0.0).expect("valid");
            assert!(ray.is_rounded() && ray.is_regular());
            let expected = bits(bvh.exact().intersect(&ray, Interval::FULL));
            hits += usize::from(expected.is_some());
            for layout in WideLayout::ALL {
                // Over the very boxes of the triangles, which those of a binary tree are larger than.
                let wide = WideMesh::build_observed(Arc::clone(&mesh), &config, layout, &()).expect("valid");
                for width in SimdWidth::available() {
                    let hit = wide.clone().with_simd_width(width).intersect(&ray, Interval::FULL);
                    assert_eq!(bits(hit), expected, "{axis} {origin} {} {}", layout.name(), width.name());
                }
            }
        }
    }
    assert!(hits >= 9, "{hits}");
}
