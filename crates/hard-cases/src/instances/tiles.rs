//! Two instances side by side.

use std::sync::Arc;

use bvh_flat::{BuildConfig, BvhAggregate};
use geometry::glam::{DAffine3, DMat3, DVec3, Vec3};
use geometry::{Interval, Ray, Transform, TraversalRay, TriangleMesh};
use primitive::Primitive;

use super::placed::{AnyPrimitive, Placed};
use super::single::rotation;
use crate::spheres::in_parallel;
use crate::{Outcome, Random, Run};

/// How many squares a tile has along an edge.
const SQUARES: u32 = 6;

/// A tile of the plane, 1 wide and 2 high, on the side of x < 0 or of x > 0, in multiples of `size`. Both have the same
/// vertices at x = 0, where `heights` says how high they are.
fn tile(random: &mut Random, left: bool, heights: &[f32], at: Vec3, size: f32) -> Option<Arc<TriangleMesh>> {
    let mut positions = Vec::new();
    for y in 0..=SQUARES {
        for x in 0..=SQUARES {
            let [u, v] = [x, y].map(|i| i as f32 / SQUARES as f32);
            let z = if x == 0 { heights[y as usize] } else { 0.1 * random.signed() };
            positions.push(at + size * Vec3::new(if left { -u } else { u }, 2.0 * v - 1.0, z));
        }
    }
    let corner = |x: u32, y: u32| y * (SQUARES + 1) + x;
    let squares = (0..SQUARES).flat_map(|y| (0..SQUARES).map(move |x| (x, y)));
    let triangles = squares.flat_map(|(x, y)| {
        let [a, b, c, d] = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
        [[a, b, c], [a, c, d]]
    });
    TriangleMesh::new(positions, triangles.collect()).ok().map(Arc::new)
}

/// I12: two tiles share an edge. With equal transforms, none of the rays aimed at it passes between them. With
/// different ones, which put the second tile's own coordinates elsewhere, a ray that passes the edge at the bound's
/// distance or more is not lost; those nearer are counted.
pub(super) fn side_by_side(run: &Run) -> Outcome {
    in_parallel(run, 112, run.effort.pick(400, 10_000_000), |number, random, trials| {
        let heights: Vec<f32> = (0..=SQUARES).map(|_| 0.1 * random.signed()).collect();
        // Of their own coordinates the tiles are near to the origin, or as many as 10⁵ sizes away.
        let at = (random.vector() * [0.0, 8.0, 1000.0, 100_000.0][random.below(4)]).round();
        let squeeze = DVec3::new(1.0, f64::from(random.power_of_two(-3.0, 3.0)), 1.0);
        // Every other time the seam lies in a face of both tiles' boxes.
        let turn = if random.below(2) == 0 { DMat3::IDENTITY } else { rotation(random) };
        let linear = turn * DMat3::from_diagonal(squeeze) * f64::from(random.power_of_two(-5.0, 5.0));
        let matrix =
            DAffine3::from_mat3_translation(linear, random.vector().as_dvec3() * 10.0 - linear * at.as_dvec3());
        let is_same = number % 2 == 0;
        // A whole number of sizes, so that the second tile is the same set of points, but for the rounding of z.
        let shift = if is_same { Vec3::ZERO } else { (16.0 * random.vector()).round() };
        let other = matrix * DAffine3::from_translation(-shift.as_dvec3());
        let (Ok(first), Ok(second)) = (Transform::from_affine(matrix), Transform::from_affine(other)) else { return };
        let left = tile(random, true, &heights, at, 1.0).and_then(|m| Placed::new(m, vec![first]));
        let right = tile(random, false, &heights, at + shift, 1.0).and_then(|m| Placed::new(m, vec![second]));
        let (Some(left), Some(right)) = (left, right) else { return };
        let members: Vec<AnyPrimitive> = vec![left.primitive.clone(), right.primitive.clone()];
        let Ok(both) = BvhAggregate::build(members, &BuildConfig::default()) else { return };
        for _ in 0..32 {
            let square = random.below(SQUARES as usize - 2) + 1;
            let [a, b] = [0, 1].map(|i| left.mesh.positions()[(square + i) * (SQUARES as usize + 1)].as_dvec3());
            let along = if random.below(3) == 0 { 0.0 } else { f64::from(random.unit()) };
            let seam = a + along * (b - a);
            // Slanting, or in the plane of the seam.
            let aside = if random.below(2) == 0 { 0.0 } else { random.signed() };
            let way = Vec3::new(aside, random.signed(), 2.0 + 4.0 * random.unit());
            let from = seam + way.as_dvec3();
            let o = left.to_world(from).as_vec3();
            let towards = |target: DVec3| Ray::new(o, (left.to_world(target) - o.as_dvec3()).as_vec3());
            let Some(traversal) = TraversalRay::new(&towards(seam)) else { continue };
            // The different tiles' corners themselves are rounded: by half an ulp of their coordinates.
            let rounding = f64::from(f32::EPSILON) * (at.abs() + shift.abs() + 2.0).max_element() as f64;
            let gap = left.bound_of(&traversal, 1.0) + right.bound_of(&traversal, 1.0) + rounding;
            let k = if is_same { 0.0 } else { 3.0 * f64::from(random.signed()) };
            let ray = towards(seam + k * gap * DVec3::X);
            let Some(traversal) = TraversalRay::new(&ray) else { continue };
            let hit = both.intersect_p(&traversal, Interval::FULL);
            if is_same || k.abs() >= 1.5 {
                trials
                    .check(hit, || format!("{left:?} and {right:?}: {ray:?} passes between, {k} bounds from the edge"));
            } else {
                trials.count("lost within the bound", u64::from(!hit));
            }
        }
    })
}
