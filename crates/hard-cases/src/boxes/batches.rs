//! S24: several rays on their way at once.

use std::sync::Arc;

use bvh_flat::{BuildConfig, RaySegment, SimdWidth, WideLayout, WideMesh};
use geometry::glam::Vec3;
use geometry::{Hit, Interval, Ray, Shape, TraversalRay, TriangleMesh};
use scene::meshes;

use crate::triangles::findings::{Fallible, Findings, in_chunks, outcome_of};
use crate::{Aim, Outcome, Random, Run};

/// Rays to a batch.
const BATCH: usize = 512;

/// Batches of different rays, of copies of one, of rays from one point to neighbouring vertices, which go together, and
/// with what is no ray or no interval between them, in a tree so large that others are interleaved and in a small one:
/// each ray is answered as alone.
pub(super) fn independent(run: &Run) -> Outcome {
    let try_all = || -> Fallible<Findings> {
        let mut random = Random::new(run.seed, 124);
        let large = meshes::icosphere(7, |_| 1.0 + 0.01 * f64::from(random.unit()))?;
        let small = meshes::icosphere(2, |_| 1.0 + 0.3 * f64::from(random.unit()))?;
        let mut trees = Vec::new();
        for mesh in [large, small].map(Arc::new) {
            for layout in WideLayout::ALL {
                let mesh = Arc::clone(&mesh);
                trees.push(WideMesh::build_observed(mesh, &BuildConfig::default(), layout, &())?);
            }
        }
        let mut findings = in_chunks(run, 0x624, run.effort.pick(48, 24_000), |i, random, findings| {
            let widths = SimdWidth::available();
            let tree = trees[i % trees.len()].with_simd_width(widths[i / trees.len() % widths.len()]);
            let rays = batch(i, tree.mesh(), random);
            let (mut hits, mut any) = (vec![None; rays.len()], vec![false; rays.len()]);
            tree.intersect_many(&rays, &mut hits);
            tree.intersect_p_many(&rays, &mut any);
            for (ray, (hit, any)) in rays.iter().zip(hits.into_iter().zip(any)) {
                let alone = alone(&tree, ray);
                findings.count("hits", u64::from(alone.is_some()));
                findings.check(hit == alone && any == alone.is_some(), || {
                    format!("{}: {ray:?} hits {hit:?}, any {any}, and alone {alone:?}", tree.layout().name())
                });
            }
        });
        findings.require_count("hits", run.effort.pick(8_000, 4_000_000));
        Ok(findings)
    };
    outcome_of(try_all())
}

/// The `i`-th batch.
fn batch(i: usize, mesh: &TriangleMesh, random: &mut Random) -> Vec<RaySegment> {
    let copies = [1, 1, 7, 8, 64, 0][i % 6];
    let mut rays = Vec::with_capacity(BATCH);
    while rays.len() < BATCH {
        let origin = 2.0 * random.vector();
        let t_max = [f32::INFINITY, random.unit(), 2.0 * random.unit()][random.below(3)];
        let ray = |target: Vec3| {
            let direction = target - origin;
            RaySegment { origin: origin.into(), t_min: 0.0, direction: direction.into(), t_max }
        };
        if copies == 0 {
            let first = random.below(mesh.len());
            let triangles = (0..64).map(|j| mesh.vertices((first + j / 3) % mesh.len()));
            rays.extend(triangles.enumerate().map(|(j, vertices)| ray(vertices[j % 3])));
        } else {
            let ray = ray(Aim::ALL[random.below(4)].target(mesh, random));
            rays.extend(std::iter::repeat_n(ray, copies));
        }
    }
    rays.truncate(BATCH);
    if i % 2 == 1 {
        for _ in 0..BATCH / 4 {
            let (bad, axis) = ([f32::NAN, f32::INFINITY, 0.0][random.below(3)], random.below(3));
            let ray = &mut rays[random.below(BATCH)];
            match random.below(4) {
                0 => ray.origin[axis] = bad,
                1 => ray.direction[axis] = bad,
                2 => ray.direction = [bad; 3],
                _ => ray.t_max = -bad,
            }
        }
    }
    rays
}

/// The answer to the ray by itself; what is no ray hits nothing.
fn alone(tree: &WideMesh, segment: &RaySegment) -> Option<Hit> {
    let ray = TraversalRay::new(&Ray::new(segment.origin, segment.direction))?;
    tree.intersect(&ray, Interval::new(segment.t_min, segment.t_max))
}
