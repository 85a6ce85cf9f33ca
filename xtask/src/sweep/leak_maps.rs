//! Leaks, seen: a mesh looked at by rays that are aimed at its edges and vertices, with kernels that lose some of them
//! beside others that lose none.

use std::sync::Arc;

use anyhow::{Context, Result};
use bvh_flat::geometry::glam::Vec3;
use bvh_flat::geometry::{Interval, Naive, Ray, Shape, TraversalRay, TriangleMesh};
use bvh_flat::{BuildConfig, MeshBvh, WideMesh};
use hard_cases::Random;
use rayon::prelude::*;
use scene::{Camera, Scene, SceneShape, meshes};

use super::results::{LeakMap, LeakMaps};
use crate::input::SEED;

/// Rays of each pixel.
const RAYS: u32 = 8;

/// A hit that is so many pixels behind the surface is none of it.
const BEHIND: f32 = 2.0;

/// What one pixel shows.
#[derive(Clone, Copy, Default)]
struct Pixel {
    shade: u8,
    /// Of naive and of watertight kernels.
    missed: [u8; 2],
}

/// Maps of the scene's largest closed mesh, else of its largest, in its own space. What is there, exact kernels say,
/// which the sweep compares with the oracle.
pub fn leak_maps(scene: &Scene, size: [u32; 2]) -> Result<LeakMaps> {
    let (mesh, is_closed) = largest(scene).context("no mesh to look at")?;
    let exact = WideMesh::build(Arc::clone(&mesh), &BuildConfig::default())?;
    let watertight = MeshBvh::build(Arc::clone(&mesh), &BuildConfig::default())?;
    let naive = watertight.with_kernels::<Naive>();
    let kernels: [&dyn Shape; 2] = [&naive, &watertight];
    let view = Camera::looking_at_bounds(&mesh.object_bound()).view(size[0], size[1])?;
    let pixel = |i: u32| {
        let (x, y) = (f64::from(i % size[0]) + 0.5, f64::from(i / size[0]) + 0.5);
        let ray = view.ray(x, y, 0.0);
        let beside = view.ray(x + 1.0, y, 0.0).direction;
        let mut random = Random::new(SEED, u64::from(i));
        look(&mesh, &exact, kernels, &ray, (beside - ray.direction).length(), &mut random)
    };
    let pixels: Vec<Pixel> = (0..size[0] * size[1]).into_par_iter().map(pixel).collect();
    let map = |k: usize, name: &str| LeakMap {
        kernels: name.to_owned(),
        missed: pixels.iter().map(|p| p.missed[k]).collect(),
    };
    Ok(LeakMaps {
        size,
        triangles: mesh.len() as u64,
        is_closed,
        shade: pixels.iter().map(|p| p.shade).collect(),
        rays_per_pixel: RAYS,
        kernels: vec![map(0, "naive"), map(1, "watertight")],
    })
}

fn largest(scene: &Scene) -> Option<(Arc<TriangleMesh>, bool)> {
    let shapes = scene.geometries().iter().map(|geometry| &geometry.shape);
    let all = shapes.filter_map(|shape| match shape {
        SceneShape::Mesh(mesh) if mesh.object_bound().is_valid() => Some((Arc::clone(mesh), meshes::is_closed(mesh))),
        _ => None,
    });
    all.max_by_key(|(mesh, is_closed)| (*is_closed, mesh.len()))
}

/// Looks along `ray`, and at the edges of the triangle it hits as far as they are in the same pixel, which is `width`
/// wide at t = 1.
fn look(
    mesh: &TriangleMesh,
    exact: &WideMesh,
    kernels: [&dyn Shape; 2],
    ray: &Ray,
    width: f32,
    random: &mut Random,
) -> Pixel {
    let mut pixel = Pixel::default();
    let Some(through_middle) = TraversalRay::new(ray) else { return pixel };
    let Some(hit) = exact.intersect(&through_middle, Interval::FULL) else { return pixel };
    let [a, b, c] = mesh.vertices(hit.primitive as usize);
    let n = (b - a).cross(c - a).normalize_or_zero();
    pixel.shade = (60.0 + 180.0 * n.dot(ray.direction.normalize_or_zero()).abs()) as u8;
    let p = ray.origin + hit.t * ray.direction;
    let reach = 0.75 * hit.t * width;
    for _ in 0..RAYS {
        let [from, to] = [[a, b], [b, c], [c, a]][random.below(3)];
        let along = to - from;
        let nearest = ((p - from).dot(along) / along.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
        let jitter = reach * random.signed() / along.length().max(f32::MIN_POSITIVE);
        let target: Vec3 = from + (nearest + jitter).clamp(0.0, 1.0) * along;
        if (target - p).length() > 2.0 * reach {
            continue;
        }
        let Some(aimed) = TraversalRay::new(&Ray::new(ray.origin, target - ray.origin)) else { continue };
        let Some(there) = exact.intersect(&aimed, Interval::FULL) else { continue };
        let tolerance = BEHIND * hit.t * width / aimed.ray().direction.length();
        for (k, kernel) in kernels.iter().enumerate() {
            let seen = kernel.intersect(&aimed, Interval::FULL).map_or(f32::INFINITY, |hit| hit.t);
            let is_lost = seen > there.t + tolerance;
            pixel.missed[k] +=
                u8::from(is_lost && is_inside(exact, ray.origin, target, there.t, [0.25 * reach, tolerance]));
        }
    }
    pixel
}

/// Whether the surface goes on around `target`, so that it is no point of an outline: there, f32 and exact arithmetic
/// may differ about which side a ray passes, and neither leaks.
fn is_inside(exact: &WideMesh, eye: Vec3, target: Vec3, t: f32, [aside, tolerance]: [f32; 2]) -> bool {
    let along = target - eye;
    let (u, v) = along.normalize_or(Vec3::Z).any_orthonormal_pair();
    [u, -u, v, -v].into_iter().all(|side| {
        let beside = TraversalRay::new(&Ray::new(eye, along + aside * side));
        let hit = beside.and_then(|ray| exact.intersect(&ray, Interval::FULL));
        hit.is_some_and(|hit| (hit.t - t).abs() <= tolerance)
    })
}
