//! Rays at things that move.

use std::sync::Arc;

use geometry::glam::Vec3;
use geometry::{AnimatedTransform, Interval, TraversalRay};
use primitive::{Placement, Primitive, TransformedPrimitive};

use super::data::still;
use super::motion::{any_linear, motion, transform};
use crate::instances::{AnyPrimitive, Placed, bumpy, mesh_primitive};
use crate::spheres::in_parallel;
use crate::{Outcome, Random, Run};

fn moving(random: &mut Random) -> Option<AnimatedTransform> {
    let mut key = || transform(any_linear(random), random.vector().as_dvec3() * 2.0);
    motion([(0.0, key()?), (0.4, key()?), (1.0, key()?)])
}

/// A08: a mesh that moves in a space that moves, or stands in one, or that stands in one that moves in one that moves:
/// at each time its answers are those of an instance that stands where they carry it then, held against exact
/// arithmetic.
pub(super) fn nested(run: &Run) -> Outcome {
    in_parallel(run, 208, run.effort.pick(120, 600_000), |number, random, trials| {
        let Some(mesh) = bumpy(random, Vec3::ZERO, 1.0) else { return };
        // From the world inwards.
        let mut chain: Vec<Placement> = Vec::new();
        for level in 0..2 + number % 2 {
            let is_moving = (number / 2) & (1 << level) == 0;
            let placement =
                if is_moving { moving(random).map(Placement::from) } else { still(random).map(Placement::from) };
            chain.extend(placement);
        }
        let Some(mut primitive) = mesh_primitive(&mesh) else { return };
        for placement in chain.iter().rev() {
            primitive = Arc::new(TransformedPrimitive::new(primitive, placement.clone()));
        }
        for _ in 0..6 {
            let time = [0.0, 1.0, 0.4, random.unit(), random.unit(), 2.0 * random.signed()][random.below(6)];
            let now = chain.iter().map(|placement| placement.at(time)).collect();
            let Some(mut placed) = Placed::new(Arc::clone(&mesh), now) else { continue };
            placed.primitive = Arc::clone(&primitive);
            for _ in 0..6 {
                placed.judge(trials, &placed.aimed(random).at_time(time));
            }
        }
    })
}

/// A10: an instance that stands still, said to move through equal keyframes, answers as one that stands, to the bit, at
/// every time, and has its box.
pub(super) fn standing(run: &Run) -> Outcome {
    in_parallel(run, 210, run.effort.pick(200, 1_000_000), |_, random, trials| {
        let (Some(place), Some(mesh)) = (still(random), bumpy(random, Vec3::ZERO, 1.0)) else { return };
        let count = 1 + random.below(5);
        let Some(motion) = motion((0..count).map(|i| (i as f32, place))) else { return };
        let Some(object) = mesh_primitive(&mesh) else { return };
        let moving: AnyPrimitive = Arc::new(TransformedPrimitive::new(Arc::clone(&object), motion.clone()));
        let Some(placed) = Placed::new(mesh, vec![place]) else { return };
        let boxes = (moving.world_bound(), placed.primitive.world_bound());
        trials.check(boxes.0 == boxes.1 && motion.is_static(), || format!("{placed:?}: {boxes:?}"));
        for _ in 0..16 {
            let time = 8.0 * random.signed();
            let Some(ray) = TraversalRay::new(&placed.aimed(random).at_time(time)) else { continue };
            let answer = |primitive: &AnyPrimitive| {
                let hit = primitive.intersect(&ray, Interval::FULL);
                (hit, hit.map(|hit| primitive.interaction(&ray, &hit)), primitive.intersect_p(&ray, Interval::FULL))
            };
            let (moves, stands) = (answer(&moving), answer(&placed.primitive));
            trials.count("hits", u64::from(stands.2));
            trials.check(moves == stands, || format!("{placed:?} {:?}: {moves:?}, standing {stands:?}", ray.ray()));
        }
    })
}
