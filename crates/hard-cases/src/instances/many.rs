//! Many instances, at one place and in any order.

use std::sync::Arc;

use bvh_flat::{BuildConfig, BvhAggregate, SplitMethod};
use geometry::glam::{DAffine3, Vec3};
use geometry::{Hit, Interval, Ray, Sphere, Transform, TraversalRay};
use primitive::{Primitive, PrimitiveList, TransformedPrimitive};

use super::placed::{AnyPrimitive, bumpy, mesh_primitive};
use super::single::{rotation, translation};
use crate::spheres::{Trials, ball, in_parallel};
use crate::{Outcome, Random, Run};

type Instances = Vec<TransformedPrimitive<AnyPrimitive>>;

fn rays_at(random: &mut Random, count: usize) -> Vec<TraversalRay> {
    let ray = |_| {
        let o = 6.0 * random.direction();
        TraversalRay::new(&Ray::new(o, 1.5 * random.vector() - o))
    };
    (0..count).filter_map(ray).collect()
}

/// Whether trees over the instances answer as the list of them does, to the bit.
fn agree(trials: &mut Trials, members: &Instances, rays: &[TraversalRay]) -> Vec<Option<Hit>> {
    let list = PrimitiveList::new(members.clone());
    let wanted: Vec<Option<Hit>> = rays.iter().map(|ray| list.intersect(ray, Interval::FULL)).collect();
    for split_method in SplitMethod::ALL {
        for leaf in [1, 16] {
            let config = BuildConfig::new(split_method).with_max_primitives_in_leaf(leaf);
            let Ok(bvh) = BvhAggregate::build(members.clone(), &config) else {
                trials.check(false, || format!("{config:?} cannot be built"));
                continue;
            };
            for (ray, wanted) in rays.iter().zip(&wanted) {
                let hit = bvh.intersect(ray, Interval::FULL);
                trials.check(hit == *wanted && bvh.intersect_p(ray, Interval::FULL) == hit.is_some(), || {
                    format!("{} instances, {config:?} {:?}: {hit:?} instead of {wanted:?}", members.len(), ray.ray())
                });
            }
        }
    }
    wanted
}

/// I13: instances with one transform, and with one of eight overlapping ones. The first of equals is hit.
pub(super) fn identical(run: &Run) -> Outcome {
    let mut random = Random::new(run.seed, 113 << 32);
    let mut trials = Trials::default();
    let count = run.effort.pick(10_000, 1_000_000);
    let Some(ball) = Sphere::new(Vec3::ZERO, 1.0).ok().and_then(ball) else { return trials.outcome() };
    let object: AnyPrimitive = Arc::new(ball);
    for (round, places) in [1, 8].into_iter().enumerate() {
        let place = |_| {
            let matrix = DAffine3::from_mat3_translation(rotation(&mut random), translation(&mut random, 1.0));
            Transform::from_affine(matrix).ok()
        };
        let transforms: Vec<Transform> = (0..places).filter_map(place).collect();
        let chosen: Vec<usize> = (0..count).map(|_| random.below(places)).collect();
        let members = chosen.iter().map(|&i| TransformedPrimitive::new(Arc::clone(&object), transforms[i])).collect();
        let rays = rays_at(&mut random, run.effort.pick(10, 50));
        for hit in agree(&mut trials, &members, &rays).into_iter().flatten() {
            let first = chosen.iter().position(|&i| i == chosen[hit.primitive as usize]);
            trials.check(first == Some(hit.primitive as usize), || format!("{hit:?} is not the first of its kind"));
            trials.count("hits", 1);
        }
        (run.progress)(0.5 * (round + 1) as f64);
    }
    trials.outcome()
}

/// I17: the same instances in another order: the same hit on the same instance, to the bit.
pub(super) fn permuted(run: &Run) -> Outcome {
    in_parallel(run, 117, run.effort.pick(12, 100_000), |_, random, trials| {
        let Some(object) = bumpy(random, Vec3::ZERO, 0.5).and_then(|mesh| mesh_primitive(&mesh)) else { return };
        let place = |_| {
            let matrix = DAffine3::from_mat3_translation(rotation(random), translation(random, 1.5));
            Some(TransformedPrimitive::new(Arc::clone(&object), Transform::from_affine(matrix).ok()?))
        };
        let members: Instances = (0..24).filter_map(place).collect();
        let mut order: Vec<usize> = (0..members.len()).collect();
        for i in 0..order.len() {
            let j = random.below(order.len());
            order.swap(i, j);
        }
        let permuted: Instances = order.iter().map(|&i| members[i].clone()).collect();
        let rays = rays_at(random, 40);
        let (before, after) = (agree(trials, &members, &rays), agree(trials, &permuted, &rays));
        let count = object.primitive_count();
        for ((before, after), ray) in before.into_iter().zip(after).zip(&rays) {
            let back = after.map(|hit| {
                let instance = order[(hit.primitive / count) as usize] as u64;
                Hit { primitive: instance * count + hit.primitive % count, ..hit }
            });
            trials.count("hits", u64::from(before.is_some()));
            trials.check(before == back, || format!("{:?}: {before:?}, permuted {back:?}", ray.ray()));
        }
    })
}
