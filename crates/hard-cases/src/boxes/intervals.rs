//! S09, S10, S16: intervals with extreme ends, with none, and with ends at the hits.

use geometry::glam::Vec3;
use geometry::{Hit, Interval, Ray, TraversalRay, Visit, Work};

use super::judge::Judge;
use crate::build::meshes::cuboid;
use crate::build::sweep::counted;
use crate::{Outcome, Run, Tries};

/// Rays at the cube from 1 to 2 on all axes whose t are exact: from 1/4 before it along z, from within, and with
/// directions so long or so short that t is near the ends of the numbers.
fn rays() -> Vec<Ray> {
    let mut rays = Vec::new();
    for k in [-125, -60, -1, 0, 3, 60, 126] {
        let d = 2.0_f32.powi(k);
        for z in [0.75, 1.0, 1.5, 2.0, 2.25] {
            rays.push(Ray::new([1.25, 1.5, z], [0.0, 0.0, d]));
            rays.push(Ray::new([1.25, 1.5, z], [0.0, 0.0, -d]));
            rays.push(Ray::new([z, 1.375, 1.25], [d, 0.0, 0.0]));
        }
    }
    rays
}

/// S09: intervals that begin or end at zeros, at the smallest and at the largest numbers.
pub(super) fn extreme_ends(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let Some(judge) = Judge::new(&mut tries, run, cuboid(Vec3::ONE, Vec3::splat(2.0))) else { return tries.outcome() };
    let ends = [0.0, -0.0, 1e-45, 1e-39, f32::MIN_POSITIVE, 0.25, 1.0, 1e38, f32::MAX, f32::INFINITY];
    for ray in rays() {
        for t_min in ends {
            for t_max in ends {
                judge.strict(&mut tries, &ray, Interval::new(t_min, t_max));
            }
        }
    }
    tries.outcome()
}

/// S10: ends in the wrong order, equal, negative or NaN: nothing is hit, and nothing visited.
pub(super) fn no_intervals(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let Some(judge) = Judge::new(&mut tries, run, cuboid(Vec3::ONE, Vec3::splat(2.0))) else { return tries.outcome() };
    let values =
        [-1.0, -1e-45, -f32::INFINITY, f32::NAN, 0.0, -0.0, 1e-45, 1.0, 2.0, f32::MAX, f32::INFINITY, -f32::NAN];
    for (t_min, t_max) in values.iter().flat_map(|&a| values.iter().map(move |&b| (a, b))) {
        if t_min >= 0.0 && t_min < t_max {
            continue;
        }
        let interval = Interval::new(t_min, t_max);
        tries.check(interval.is_empty(), || format!("{t_min} to {t_max} is not empty"));
        for ray in rays().iter().filter_map(TraversalRay::new) {
            let (hit, work) = counted(judge.shape(), &ray, interval);
            let is_nothing = hit.is_none() && work == Work::default();
            let queries = (judge.shape().intersect(&ray, interval), judge.shape().intersect_p(&ray, interval));
            tries.check(is_nothing && queries == (None, false), || {
                format!("{:?} from {t_min} to {t_max}: {hit:?}, {queries:?} after {work:?}", ray.ray())
            });
        }
    }
    tries.outcome()
}

/// S16: both ends are excluded, exactly, by all queries alike.
pub(super) fn at_the_ends(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let Some(judge) = Judge::new(&mut tries, run, cuboid(Vec3::ONE, Vec3::splat(2.0))) else { return tries.outcome() };
    for ray in rays() {
        let Some(traversal) = TraversalRay::new(&ray) else { continue };
        // The ends: where the ray meets the two faces, and the numbers beside.
        let mut ends = vec![0.0, f32::INFINITY];
        let d = ray.direction.max_element() + ray.direction.min_element();
        for face in [1.0, 2.0] {
            let t = (face - if ray.direction.x != 0.0 { ray.origin.x } else { ray.origin.z }) / d;
            if t > 0.0 && t.is_finite() {
                ends.extend([t, t.next_down(), t.next_up()]);
            }
        }
        for (&t_min, &t_max) in ends.iter().flat_map(|a| ends.iter().map(move |b| (a, b))) {
            let interval = Interval::new(t_min, t_max);
            judge.strict(&mut tries, &ray, interval);
            let mut outside = None;
            let _ = judge.shape().visit_hits(&traversal, interval, &mut |hit: Hit| {
                if !interval.contains(hit.t) {
                    outside = Some(hit);
                }
                Visit::Continue(interval.t_max())
            });
            tries.check(outside.is_none(), || format!("{ray:?} {interval:?}: {outside:?}"));
        }
    }
    tries.outcome()
}
