//! Input that breaks naive trees: every split method and leaf size must build it and answer as the list does.

use std::sync::Arc;

use bvh_flat::geometry::glam::Vec3;
use bvh_flat::geometry::{Interval, Ray, Shape, TraversalRay, TriangleMesh};
use bvh_flat::{BuildConfig, MeshBvh, SplitMethod};

use crate::support::Random;

fn mesh_of(triangles: impl IntoIterator<Item = [Vec3; 3]>) -> TriangleMesh {
    let positions: Vec<Vec3> = triangles.into_iter().flatten().collect();
    let indices = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    TriangleMesh::new(positions, indices).expect("indices are in range")
}

fn small_triangle(at: Vec3, size: f32) -> [Vec3; 3] {
    [at, at + Vec3::new(size, 0.0, 0.25 * size), at + Vec3::new(0.0, size, 0.5 * size)]
}

/// Name, and the mesh.
fn table() -> Vec<(&'static str, TriangleMesh)> {
    let mut random = Random::new(99);
    let mut spread = |n: usize| -> Vec<Vec3> { (0..n).map(|_| 10.0 * random.vector()).collect() };
    let points = spread(400);
    let tilted = [Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, -1.0, 0.1), Vec3::new(0.0, 1.0, 0.2)];
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30];
    vec![
        ("B01 nothing", mesh_of([])),
        ("B01 all invalid", mesh_of([[Vec3::NAN; 3], [Vec3::INFINITY; 3]])),
        ("B02 one", mesh_of([tilted])),
        ("B02 two", mesh_of(points[..2].iter().map(|&p| small_triangle(p, 3.0)))),
        ("B02 five", mesh_of(points[..5].iter().map(|&p| small_triangle(p, 3.0)))),
        ("B03 identical", mesh_of([tilted; 3_000])),
        (
            "B04 concentric",
            mesh_of((0..200).map(|i| tilted.map(|p| (p - Vec3::new(0.0, -1.0 / 3.0, 0.1)) * 2.0_f32.powi(i % 40)))),
        ),
        (
            "B06 cascade of halves",
            mesh_of((0..120).map(|i| small_triangle(Vec3::X * 2.0_f32.powi(-i), 2.0_f32.powi(-i - 1)))),
        ),
        ("B07 cascade of twelfths", mesh_of((0..30).map(|i| small_triangle(Vec3::X * 12.0_f32.powi(-i), 1e-3)))),
        ("B09 teapot in a stadium", {
            let teapot = points.iter().map(|&p| small_triangle(1e-4 * p, 1e-4));
            mesh_of(teapot.chain([small_triangle(Vec3::splat(1e6), 1e6)]))
        }),
        (
            "B11 flat",
            mesh_of(
                points.iter().map(|p| {
                    [Vec3::new(p.x, p.y, 1.0), Vec3::new(p.x + 2.0, p.y, 1.0), Vec3::new(p.x, p.y + 2.0, 1.0)]
                }),
            ),
        ),
        ("B11 in a line", mesh_of((0..100).map(|i| small_triangle(Vec3::X * i as f32 * 0.1, 0.2)))),
        ("B12 on ten points", mesh_of((0..2_000).map(|i| small_triangle(points[i % 10], 2.0)))),
        ("B13 huge", mesh_of(points.iter().map(|&p| small_triangle(1e16 * p, 3e16)))),
        ("B14 denormal", mesh_of(points.iter().map(|&p| small_triangle(1e-40 * p, 1e-40)))),
        (
            "B15 mixed scales",
            mesh_of(points.iter().enumerate().map(|(i, &p)| small_triangle(p, 10.0_f32.powi(i as i32 % 12 - 8)))),
        ),
        ("B16, B17 not finite", {
            mesh_of(points.iter().enumerate().map(|(i, &p)| {
                let mut t = small_triangle(p, 3.0);
                if i % 5 == 0 {
                    t[i % 3][i / 5 % 3] = bad[i / 5 % 4];
                }
                t
            }))
        }),
        (
            "B19 no area",
            mesh_of(points.iter().enumerate().map(|(i, &p)| {
                let t = small_triangle(p, 3.0);
                match i % 4 {
                    0 => [p; 3],
                    1 => [t[0], t[1], t[0].midpoint(t[1])],
                    2 => [t[0], t[1], t[1]],
                    _ => t,
                }
            })),
        ),
        (
            "B20 zeros of both signs",
            mesh_of((0..50).map(|i| {
                let zero = if i % 2 == 0 { 0.0 } else { -0.0 };
                [Vec3::new(zero, -1.0, zero), Vec3::new(1.0, zero, -zero), Vec3::new(-zero, 1.0, i as f32 * zero)]
            })),
        ),
        (
            "B24 needles",
            mesh_of((0..200).map(|i| {
                let (a, b) = (points[i], points[i + 200]);
                [1e5 * a, 1e5 * b, 1e5 * b + Vec3::splat(1e-2)]
            })),
        ),
        ("B25 one over all", {
            let small = points.iter().map(|&p| small_triangle(p, 0.1));
            mesh_of(small.chain([[Vec3::splat(-30.0), Vec3::new(30.0, -30.0, 5.0), Vec3::new(0.0, 40.0, 2.0)]]))
        }),
    ]
}

#[test]
fn degenerate_meshes_build_and_answer_as_the_list_does() {
    for (name, mesh) in table() {
        let mesh = Arc::new(mesh);
        let mut random = Random::new(7);
        let rays: Vec<TraversalRay> = (0..300)
            .filter_map(|i| {
                let target = match mesh.len() {
                    0 => Vec3::ZERO,
                    n => mesh.vertices(random.below(n)).into_iter().sum::<Vec3>() / 3.0,
                };
                let from = if i % 2 == 0 { target + target.abs() * random.vector() } else { 20.0 * random.vector() };
                TraversalRay::new(&Ray::new(from, target - from))
            })
            .collect();
        for method in SplitMethod::ALL {
            for leaf in [1, 2, 4, 8, 16] {
                let config = BuildConfig::new(method).with_max_primitives_in_leaf(leaf);
                let bvh = MeshBvh::build(Arc::clone(&mesh), &config).expect(name);
                let tree = bvh.bvh();
                let again =
                    bvh_flat::FlatBvh::from_parts(tree.nodes().to_vec(), tree.order().to_vec(), tree.primitive_count());
                assert_eq!(again.as_ref(), Ok(tree), "{name}");
                assert!(MeshBvh::from_parts(Arc::clone(&mesh), tree.clone()).is_ok(), "{name}");
                for ray in &rays {
                    let hit = bvh.intersect(ray, Interval::FULL);
                    assert_eq!(hit, mesh.intersect(ray, Interval::FULL), "{name} {} {leaf}", method.name());
                    assert_eq!(hit.is_some(), bvh.intersect_p(ray, Interval::FULL), "{name} {} {leaf}", method.name());
                    assert!(hit.is_none_or(|h| h.t > 0.0 && h.u >= 0.0 && h.v >= 0.0), "{name}: {hit:?}");
                }
            }
        }
    }
}

/// B16: what cannot be hit leaves the others alone, and every triangle keeps its number.
#[test]
fn inactive_triangles_change_nothing_for_the_others() {
    let (_, mesh) = table().into_iter().find(|(name, _)| name.starts_with("B16")).expect("it is in the table");
    let mut random = Random::new(4);
    let bvh = MeshBvh::build(mesh.clone(), &BuildConfig::default()).expect("the configuration is valid");
    assert_eq!(bvh.bvh().order().len(), 320);
    for _ in 0..2_000 {
        let ray = TraversalRay::new(&Ray::new(10.0 * random.vector(), random.vector())).expect("valid");
        if let Some(hit) = bvh.intersect(&ray, Interval::FULL) {
            assert!(mesh.triangle_bounds(hit.primitive as usize).is_valid());
        }
    }
}

/// Rays of any bits: a hit or a miss, never a panic and never NaN.
#[test]
fn rays_of_any_bits_are_answered() {
    let mesh = scene::meshes::icosphere(2, |_| 1.0).expect("a mesh");
    let bvh = MeshBvh::build(mesh, &BuildConfig::default()).expect("the configuration is valid");
    let mut random = Random::new(17);
    let special =
        [0.0, -0.0, 1.0, -1.0, f32::NAN, f32::INFINITY, f32::MAX, f32::MIN_POSITIVE, 1e-45, -1e-45, 1e30, -1e-30];
    let mut valid = 0;
    for i in 0..200_000 {
        let mut number = || match i % 3 {
            0 => f32::from_bits(random.bits()),
            _ => special[random.below(special.len())],
        };
        let ray = Ray::new([number(), number(), number()], [number(), number(), number()]).at_time(number());
        let interval = Interval::new(number(), number());
        let Some(ray) = TraversalRay::new(&ray) else { continue };
        valid += 1;
        let hit = bvh.intersect(&ray, interval);
        assert_eq!(hit.is_some(), bvh.intersect_p(&ray, interval), "{ray:?} {interval:?}");
        if let Some(hit) = hit {
            assert!(interval.contains(hit.t) && !hit.u.is_nan() && !hit.v.is_nan(), "{ray:?} {hit:?}");
            let p = bvh.surface_point(&ray, &hit);
            assert!(p.p.is_finite() && !p.p_error.is_nan() && p.n.is_finite(), "{ray:?} {p:?}");
        }
    }
    assert!(valid > 10_000);
}
