//! The rows: what is built, and which query answers.

use std::sync::Arc;

use bvh_flat::geometry::{Interval, Ray as GeometryRay, Shape, TraversalRay, TriangleMesh};
use bvh_flat::{BuildConfig, MeshBvh, RaySegment, SimdWidth, WideLayout, WideMesh};

use crate::{Hit, Ray};

/// A built structure that answers for one row.
pub trait Variant: Send {
    /// The closest hit of each ray.
    fn closest(&self, rays: &[Ray], hits: &mut [Hit]);

    /// Writes 1 for each ray that hits anything, else 0; false where there is no such query.
    fn any(&self, rays: &[Ray], occluded: &mut [u8]) -> bool;

    /// What is kept beside the mesh itself, in bytes.
    fn bytes(&self) -> usize;
}

/// Builds a variant, on the threads of the current rayon pool. All of it is timed.
pub type Build = fn(&Arc<TriangleMesh>) -> Box<dyn Variant>;

/// The rows by name.
pub const VARIANTS: &[(&str, Build)] = &[
    ("ours binary", |mesh| {
        let bvh = binary(mesh, BuildConfig::default());
        one_by_one(bvh.memory(), bvh)
    }),
    ("ours fastest", |mesh| wide(mesh, BuildConfig::fastest(), SimdWidth::widest())),
    ("ours fast", |mesh| wide(mesh, BuildConfig::fast(), SimdWidth::widest())),
    ("ours watertight", |mesh| wide(mesh, BuildConfig::balanced(), SimdWidth::widest())),
    ("ours high", |mesh| wide(mesh, BuildConfig::high(), SimdWidth::widest())),
    ("ours highest", |mesh| wide(mesh, BuildConfig::highest(), SimdWidth::widest())),
    ("ours batch", |mesh| {
        let wide = WideMesh::build(Arc::clone(mesh), &BuildConfig::high()).expect("the preset is valid");
        Box::new(Batch(wide))
    }),
    ("ours compact", |mesh| {
        let wide = WideMesh::build_observed(Arc::clone(mesh), &BuildConfig::high(), WideLayout::Compact, &());
        let wide = wide.expect("the preset is valid");
        one_by_one(wide.memory(), wide)
    }),
    ("ours avx2", |mesh| wide(mesh, BuildConfig::balanced(), SimdWidth::avx2().unwrap_or_default())),
    ("ours portable", |mesh| wide(mesh, BuildConfig::balanced(), SimdWidth::PORTABLE)),
    ("ours exact", |mesh| {
        let bvh = binary(mesh, BuildConfig::default());
        // The exact mesh shares the tree, and has the leaves' vertices once more.
        let own_vertices = size_of::<[[f32; 3]; 3]>() * bvh.bvh().order().len();
        one_by_one(bvh.memory() + own_vertices, bvh.exact())
    }),
];

/// A wide tree, whose leaves the collapse makes.
fn wide(mesh: &Arc<TriangleMesh>, config: BuildConfig, width: SimdWidth) -> Box<dyn Variant> {
    let wide = WideMesh::build(Arc::clone(mesh), &config).expect("the preset is valid").with_simd_width(width);
    one_by_one(wide.memory(), wide)
}

fn binary(mesh: &Arc<TriangleMesh>, config: BuildConfig) -> MeshBvh {
    MeshBvh::build(Arc::clone(mesh), &config).expect("the configuration is valid")
}

fn one_by_one<S: Shape + Send + 'static>(bytes: usize, shape: S) -> Box<dyn Variant> {
    Box::new(OneByOne { shape, bytes })
}

/// A shape that is asked one ray at a time. Preparing the ray is part of the query.
struct OneByOne<S> {
    shape: S,
    bytes: usize,
}

impl<S: Shape + Send> Variant for OneByOne<S> {
    fn closest(&self, rays: &[Ray], hits: &mut [Hit]) {
        for (ray, hit) in rays.iter().zip(hits) {
            let found = prepare(ray).and_then(|(ray, interval)| self.shape.intersect(&ray, interval));
            // A triangle's index in its mesh is 32 bits.
            *hit = found.map_or(Hit::MISS, |h| Hit { t: h.t, primitive: h.primitive as u32 });
        }
    }

    fn any(&self, rays: &[Ray], occluded: &mut [u8]) -> bool {
        for (ray, occluded) in rays.iter().zip(occluded) {
            let is_hit = prepare(ray).is_some_and(|(ray, interval)| self.shape.intersect_p(&ray, interval));
            *occluded = u8::from(is_hit);
        }
        true
    }

    fn bytes(&self) -> usize {
        self.bytes
    }
}

/// A mesh that is asked all rays in one call.
struct Batch(WideMesh);

impl Batch {
    /// The rays as the library has them: the same 32 bytes.
    fn segments(rays: &[Ray]) -> impl Iterator<Item = (usize, Vec<RaySegment>)> {
        let segment = |r: &Ray| RaySegment { origin: r.o, t_min: r.t_min, direction: r.d, t_max: r.t_max };
        rays.chunks(4096).enumerate().map(move |(i, rays)| (4096 * i, rays.iter().map(segment).collect()))
    }
}

impl Variant for Batch {
    fn closest(&self, rays: &[Ray], hits: &mut [Hit]) {
        let mut found = vec![None; 4096];
        for (first, segments) in Self::segments(rays) {
            self.0.intersect_many(&segments, &mut found);
            for (hit, found) in hits[first..].iter_mut().zip(&found[..segments.len()]) {
                *hit = found.map_or(Hit::MISS, |h| Hit { t: h.t, primitive: h.primitive as u32 });
            }
        }
    }

    fn any(&self, rays: &[Ray], occluded: &mut [u8]) -> bool {
        let mut found = vec![false; 4096];
        for (first, segments) in Self::segments(rays) {
            self.0.intersect_p_many(&segments, &mut found);
            for (occluded, found) in occluded[first..].iter_mut().zip(&found[..segments.len()]) {
                *occluded = u8::from(*found);
            }
        }
        true
    }

    fn bytes(&self) -> usize {
        self.0.memory()
    }
}

#[inline]
fn prepare(ray: &Ray) -> Option<(TraversalRay, Interval)> {
    Some((TraversalRay::new(&GeometryRay::new(ray.o, ray.d))?, Interval::new(ray.t_min, ray.t_max)))
}

#[cfg(test)]
mod tests {
    use bvh_flat::geometry::glam::Vec3;

    use super::*;
    use crate::peer::Peer;

    /// A grid of small triangles in each of two parallel planes, and rays at both, across, and away.
    fn scene() -> (Vec<f32>, Vec<Ray>) {
        let cells = || (0..200_u16).map(|i| Vec3::new(f32::from(i % 10), f32::from(i / 10 % 10), f32::from(i / 100)));
        let triangles = cells().flat_map(|p| [p, p + 0.75 * Vec3::X, p + 0.75 * Vec3::Y]).flat_map(|p| p.to_array());
        let ray = |o: Vec3, d, t_max| Ray { o: o.into(), t_min: 0.0, d, t_max };
        let rays = cells().flat_map(|p| {
            let from = p + Vec3::new(0.125, 0.25, -2.5);
            [
                ray(from, [0.0, 0.0, 1.0], f32::INFINITY),
                ray(from, [0.0, 0.0, 1.0], 1.0),
                ray(from, [0.4, 0.0, 1.0], 9.0),
            ]
        });
        let invalid = ray(Vec3::ZERO, [0.0; 3], f32::INFINITY);
        (triangles.collect(), rays.chain([invalid]).collect())
    }

    #[test]
    fn every_row_finds_the_hits_of_the_mesh() {
        let (triangles, rays) = scene();
        for (name, _) in VARIANTS {
            let mut peer = Peer::prepare(name, &triangles);
            for threads in [2, 1] {
                peer.build(threads);
                let want = |ray: &Ray| {
                    let hit = prepare(ray).and_then(|(ray, interval)| peer.mesh().intersect(&ray, interval));
                    hit.map_or(Hit::MISS, |h| Hit { t: h.t, primitive: h.primitive as u32 })
                };
                let want: Vec<Hit> = rays.iter().map(want).collect();
                let mut hits = vec![Hit { t: f32::NAN, primitive: 0 }; rays.len()];
                peer.closest(&rays, &mut hits);
                assert_eq!(hits, want, "{name}");
                assert!(hits.contains(&Hit::MISS) && hits.iter().filter(|h| **h != Hit::MISS).count() > 200);
                let mut occluded = vec![2; rays.len()];
                if peer.any(&rays, &mut occluded) {
                    let want: Vec<u8> = want.iter().map(|&h| u8::from(h != Hit::MISS)).collect();
                    assert_eq!(occluded, want, "{name}");
                }
                assert!(peer.bytes() > 0, "{name}");
            }
        }
    }
}
