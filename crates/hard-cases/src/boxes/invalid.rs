//! S11, S15: rays that are none, and boxes that contain nothing.

use geometry::glam::{DVec3, Vec3};
use geometry::{Bounds3, Interval, Kernels, Ray, TraversalRay, Watertight};

use super::judge::Judge;
use crate::build::meshes::{mesh_of, triangle_at};
use crate::{Outcome, Random, Run, Tries};

/// S11: every choice of components that are NaN or infinite, and zero directions of all signs. Such a ray cannot be
/// prepared for traversal, so it visits nothing.
pub(super) fn rays(_: &Run) -> Outcome {
    let mut tries = Tries::new();
    for bad in [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::from_bits(0x7f80_0001)] {
        for pattern in 0..128 {
            let component = |i: usize| if pattern >> i & 1 == 1 { bad } else { 0.5 };
            let [o, d] = [0, 3].map(|i| Vec3::new(component(i), component(i + 1), component(i + 2)));
            let ray = Ray::new(o, d).at_time(component(6));
            let prepared = TraversalRay::new(&ray);
            tries.check(prepared.is_some() == (pattern == 0), || format!("{ray:?}: {prepared:?}"));
        }
    }
    for signs in 0..8 {
        let zero = Vec3::from_array([0, 1, 2].map(|i| if signs >> i & 1 == 1 { -0.0 } else { 0.0 }));
        let ray = TraversalRay::new(&Ray::new(Vec3::ONE, zero));
        tries.check(ray.is_none(), || format!("{ray:?}"));
    }
    // What is a number in f64 and none in f32, or zero there.
    for (o, d) in [(1e300, 1.0), (1.0, -1e300), (1.0, 1e-300), (f64::NAN, 1.0), (0.0, f64::INFINITY)] {
        let ray = TraversalRay::from_f64(DVec3::splat(o), DVec3::splat(d), 0.0);
        tries.check(ray.is_none(), || format!("{o} and {d}: {ray:?}"));
    }
    tries.outcome()
}

/// S15: the empty box, which stands for every child that is not there, is entered by no ray, however far it reaches;
/// and a scene of inactive triangles is hit by none.
pub(super) fn empty_boxes(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 115);
    let inactive = mesh_of([[Vec3::splat(f32::MAX); 3], triangle_at(Vec3::splat(1e30), 1e30), [Vec3::NAN; 3]]);
    let judge = Judge::new(&mut tries, run, inactive);
    let extremes = [0.0, -0.0, 1.0, -1.0, 1e30, -1e30, f32::MAX, f32::MIN, f32::MIN_POSITIVE, 1e-45, -1e-45];
    for _ in 0..run.effort.pick(50_000, 10_000_000) {
        let mut component = || extremes[random.below(extremes.len())];
        let origin = Vec3::new(component(), component(), component());
        let ray = Ray::new(origin, Vec3::new(component(), component(), component()));
        let t_max = [f32::INFINITY, f32::MAX, 1e38][random.below(3)];
        let interval = Interval::new([0.0, 1e30, f32::MAX][random.below(3)], t_max);
        let Some(traversal) = TraversalRay::new(&ray) else { continue };
        let entry = Watertight::enter(&traversal, &Bounds3::EMPTY, interval);
        tries.check(entry.is_none(), || format!("{ray:?} {interval:?} enters nothing at {entry:?}"));
        let hit = judge.as_ref().and_then(|judge| judge.hit(&ray, interval));
        tries.check(hit.is_none(), || format!("{ray:?} {interval:?}: {hit:?}"));
    }
    tries.outcome()
}
