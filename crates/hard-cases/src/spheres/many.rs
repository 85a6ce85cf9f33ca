//! Spheres that nearly or wholly coincide.

use std::ops::ControlFlow;

use bvh_flat::{BuildConfig, BvhAggregate, SplitMethod};
use geometry::glam::Vec3;
use geometry::{Hit, Interval, Ray, Sphere, TraversalRay};
use oracle::{Oracle, OracleList, SphereOracle};
use primitive::{GeometricPrimitive, HitKind, MaterialId, MediumInterface, Primitive, PrimitiveList, Surface};

use super::{Trials, exact_hits, in_parallel, ulps};
use crate::{Outcome, Random, Run};

pub(crate) type Ball = GeometricPrimitive<Sphere>;

/// The sphere with a material.
pub(crate) fn ball(sphere: Sphere) -> Option<Ball> {
    Some(GeometricPrimitive::new(sphere, Surface::of_material(MaterialId::from_index(0)?), MediumInterface::VACUUM))
}

/// P08: all hits on both shells in the exact order. Two whose t are one f32 come in the order of their numbers.
pub(super) fn shells(run: &Run) -> Outcome {
    in_parallel(run, 8, run.effort.pick(10_000, 100_000_000), |number, random, trials| {
        let radius = random.power_of_two(-10.0, 10.0);
        let gap = 10.0_f32.powf(3.0 * random.unit() - 7.0);
        let center = if number % 2 == 0 { Vec3::ZERO } else { radius * random.vector() };
        let radii = if number % 3 == 0 { [radius, radius * (1.0 + gap)] } else { [radius * (1.0 + gap), radius] };
        let spheres: Vec<Sphere> = radii.iter().filter_map(|&r| Sphere::new(center, r).ok()).collect();
        let list = PrimitiveList::new(spheres.iter().filter_map(|&s| ball(s)).collect());
        let exact =
            OracleList::new(spheres.iter().map(|s| Box::new(SphereOracle::new(s)) as Box<dyn Oracle>).collect());
        let origin = match random.below(3) {
            0 => center + radius * 3.0 * random.direction(),
            1 => center + radius * 0.9 * random.unit() * random.direction(),
            _ => center + radius * (1.0 + 0.5 * gap) * random.direction(),
        };
        // At the rim, where the ray cuts the outer shell alone, and anywhere.
        let target = center + radius * random.direction();
        let ray = Ray::new(origin, if random.below(4) == 0 { random.direction() } else { target - origin });
        judge(trials, &list, &exact, &ray);
    })
}

/// All hits, and the closest, of spheres against the oracle.
fn judge(trials: &mut Trials, list: &PrimitiveList<Ball>, exact: &OracleList, ray: &Ray) {
    let Some(traversal) = TraversalRay::new(ray) else { return };
    let mut hits = Vec::new();
    let _ = list.visit_hits(&traversal, Interval::FULL, HitKind::Material, &mut |hit: Hit| {
        hits.push(hit);
        ControlFlow::Continue(f32::INFINITY)
    });
    hits.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.primitive.cmp(&b.primitive)));
    let mut wanted = exact_hits(exact, ray);
    wanted.sort_by(|a, b| a.t.to_f32().total_cmp(&b.t.to_f32()).then(a.primitive.cmp(&b.primitive)));
    let worst = hits.iter().zip(&wanted).map(|(hit, exact)| ulps(hit.t, &exact.t)).fold(0.0, f64::max);
    let same = hits.len() == wanted.len() && hits.iter().zip(&wanted).all(|(h, w)| h.primitive == w.primitive);
    let closest = list.intersect(&traversal, Interval::FULL);
    trials.check(same && worst <= 1.0 && closest.as_ref() == hits.first(), || {
        let wanted: Vec<_> = wanted.iter().map(|hit| (hit.primitive, hit.t.to_f64())).collect();
        format!("{:?} {ray:?}: {hits:?} instead of {wanted:?}, the closest {closest:?}", list.members())
    });
    trials.largest("t error, ulp", worst);
}

/// P09: of spheres that coincide the first is hit, whatever the tree; every answer is the list's, to the bit. A few
/// others stand among them.
pub(super) fn identical(run: &Run) -> Outcome {
    let mut random = Random::new(run.seed, 9 << 32);
    let mut trials = Trials::default();
    let count = run.effort.pick(10_000, 1_000_000);
    let rays = run.effort.pick(20, 100);
    // All alike; and then each at one of eight places.
    for places in [1, 8] {
        let centers: Vec<Vec3> = (0..places).map(|_| random.vector()).collect();
        let members: Vec<Ball> =
            (0..count).filter_map(|_| Sphere::new(centers[random.below(places)], 0.5).ok().and_then(ball)).collect();
        let list = PrimitiveList::new(members.clone());
        let rays: Vec<TraversalRay> = (0..rays)
            .filter_map(|_| {
                let o = 4.0 * random.direction();
                TraversalRay::new(&Ray::new(o, random.vector() - o))
            })
            .collect();
        let wanted: Vec<Option<Hit>> = rays.iter().map(|ray| list.intersect(ray, Interval::FULL)).collect();
        let first = |hit: &Hit| {
            let center = members[hit.primitive as usize].shape().center();
            members.iter().position(|m| m.shape().center() == center) == Some(hit.primitive as usize)
        };
        trials.check(wanted.iter().flatten().all(first), || format!("not the first of its kind: {wanted:?}"));
        trials.count("hits", wanted.iter().flatten().count() as u64);
        for split_method in SplitMethod::ALL {
            for leaf in [1, 4, 64] {
                let config = BuildConfig::new(split_method).with_max_primitives_in_leaf(leaf);
                match BvhAggregate::build(members.clone(), &config) {
                    Ok(bvh) => {
                        for (ray, wanted) in rays.iter().zip(&wanted) {
                            let hit = bvh.intersect(ray, Interval::FULL);
                            trials
                                .check(hit == *wanted && bvh.intersect_p(ray, Interval::FULL) == hit.is_some(), || {
                                    format!("{config:?} {:?}: {hit:?} instead of {wanted:?}", ray.ray())
                                });
                        }
                    }
                    Err(error) => trials.check(false, || format!("{config:?}: {error}")),
                }
                (run.progress)(if places == 1 { 0.25 } else { 0.75 });
            }
        }
    }
    trials.outcome()
}
