//! B21, B22: indices and counts beyond what there is room for.

use std::panic::{AssertUnwindSafe, catch_unwind};

use bvh_flat::bvh_build::build;
use bvh_flat::{BuildConfig, BuildError, BvhAggregate, FlatBvh, InvalidBvh, LinearBvhNode};
use geometry::glam::{Vec2, Vec3};
use geometry::{Axis, Bounds3, Hit, HitVisitor, Interval, MeshError, Ray, TraversalRay, TriangleMesh, Visit};
use primitive::{HitKind, Primitive, PrimitiveList, SurfaceInteraction};

use super::sweep::configs;
use crate::{Outcome, Run, Tries};

/// B21: an index that names no vertex is an error that says which. An index buffer whose length is no multiple of three
/// cannot be passed: triangles are `[u32; 3]`.
pub(super) fn indices_out_of_range(_: &Run) -> Outcome {
    let mut tries = Tries::new();
    for vertex_count in [0, 1, 3, 1_000] {
        for index in [vertex_count as u32, vertex_count as u32 + 1, 1 << 31, u32::MAX] {
            for place in 0..6 {
                let mut triangles = [[0; 3]; 2];
                if vertex_count == 0 && place > 0 {
                    continue;
                }
                triangles[place / 3][place % 3] = index;
                let mesh = TriangleMesh::new(vec![Vec3::ZERO; vertex_count], triangles.to_vec());
                let triangle = place / 3;
                let expected = MeshError::IndexOutOfRange { triangle, index, vertex_count };
                tries.check(mesh.as_ref().err() == Some(&expected), || format!("{expected:?}: {mesh:?}"));
            }
        }
    }
    for uv_count in [0, 2, 4] {
        let mesh = TriangleMesh::new(vec![Vec3::ZERO; 3], vec![[0, 1, 2]]).expect("in range");
        let mesh = mesh.with_uvs(vec![Vec2::ZERO; uv_count]);
        let expected = MeshError::UvCount { uv_count, vertex_count: 3 };
        tries.check(mesh.as_ref().err() == Some(&expected), || format!("{expected:?}: {mesh:?}"));
    }
    tries.outcome()
}

/// B22: the arithmetic of counts. Arrays of 2³¹ boxes or 2³² vertices are too large to make here; that they are refused
/// before anything is done with them is in the tests of those crates. What is left: configurations, trees from arrays
/// whose offsets are near 2³², and members that only say that they count for very many.
pub(super) fn widths_of_indices(_: &Run) -> Outcome {
    let mut tries = Tries::new();
    let unit = Bounds3::new(Vec3::ZERO, Vec3::ONE);
    for max in [0, 65_536, 1 << 31, u32::MAX] {
        let refused = build(&[unit], &BuildConfig::default().with_max_primitives_in_leaf(max));
        tries.check(matches!(refused, Err(BuildError::InvalidConfig { .. })), || format!("leaves of {max}"));
    }
    for offset in [1, 2, 1 << 16, 1 << 31, u32::MAX - 1, u32::MAX] {
        for count in [1, u16::MAX] {
            let leaf = FlatBvh::from_parts(vec![LinearBvhNode::leaf(unit, offset, count)], vec![0], 1);
            tries.check(leaf.is_err(), || format!("a leaf of {count} at {offset}"));
        }
        let nodes = vec![
            LinearBvhNode::interior(unit, Axis::X, offset),
            LinearBvhNode::leaf(unit, 0, 1),
            LinearBvhNode::leaf(unit, 1, 1),
        ];
        let tree = FlatBvh::from_parts(nodes, vec![0, 1], 2);
        tries.check(tree.is_ok() == (offset == 2), || format!("a second child at {offset}: {:?}", tree.err()));
        let order = FlatBvh::from_parts(vec![LinearBvhNode::leaf(unit, 0, 1)], vec![offset], offset);
        let is_refused = matches!(order, Err(InvalidBvh::Order { .. }));
        tries.check(is_refused, || format!("primitive {offset} of {offset}"));
    }
    for count in [1_u64 << 31, 1 << 32, 1 << 33, 1 << 60] {
        for config in configs(&[1, 4]) {
            numbers_add_up(&mut tries, count, &config);
        }
    }
    // Nested instances may count for more than 64 bits hold. No number then names all, but nothing may panic.
    let result = catch_unwind(AssertUnwindSafe(|| PrimitiveList::new(vec![Many { at: 0.0, count: 1 << 63 }; 3])));
    tries.check(result.is_ok(), || "a list of three members of 2^63 primitives panics".into());
    tries.outcome()
}

/// Hits on members of `count` primitives each are numbered in 64 bits.
fn numbers_add_up(tries: &mut Tries, count: u64, config: &BuildConfig) {
    let members: Vec<Many> = (0..7).map(|i| Many { at: i as f32, count }).collect();
    let Ok(aggregate) = BvhAggregate::build(members, config) else {
        return tries.check(false, || format!("members of {count} do not build"));
    };
    tries.check(aggregate.primitive_count() == 7 * count, || format!("{} primitives", aggregate.primitive_count()));
    for i in 0..7 {
        let ray = TraversalRay::new(&Ray::new([i as f32, 0.0, -5.0], [0.0, 0.0, 1.0])).expect("a valid ray");
        let hit = aggregate.intersect(&ray, Interval::FULL).map(|hit| hit.primitive);
        let expected = (i + 1) * count - 1;
        tries.check(hit == Some(expected), || format!("{hit:?}, not {expected}"));
    }
}

/// Says that it counts for many primitives, of which the last is hit by every ray that comes near.
#[derive(Clone, Copy)]
struct Many {
    at: f32,
    count: u64,
}

impl Primitive for Many {
    fn world_bound(&self) -> Bounds3 {
        Bounds3::from_points([-0.25, 0.25].map(|r| Vec3::new(self.at + r, r, r)))
    }

    fn primitive_count(&self) -> u64 {
        self.count
    }

    fn visit_hits(&self, ray: &TraversalRay, interval: Interval, _: HitKind, visitor: &mut dyn HitVisitor) -> Visit {
        match ray.enter(&self.world_bound(), interval) {
            Some(t) if interval.contains(t) => visitor.hit(Hit { t, u: 0.0, v: 0.0, primitive: self.count - 1 }),
            _ => Visit::Continue(interval.t_max()),
        }
    }

    fn interaction(&self, ray: &TraversalRay, hit: &Hit) -> SurfaceInteraction {
        let sphere = geometry::Sphere::new(Vec3::X * self.at, 0.25).expect("a valid sphere");
        let surface = primitive::Surface::MediumBoundary;
        primitive::GeometricPrimitive::new(sphere, surface, primitive::MediumInterface::VACUUM).interaction(ray, hit)
    }
}
