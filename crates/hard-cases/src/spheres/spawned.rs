//! Rays that leave a sphere.

use geometry::glam::Vec3;
use geometry::{Interval, Ray, Sphere, TraversalRay};
use oracle::{Oracle, SphereOracle, Tally};
use primitive::Primitive;

use super::many::ball;
use super::rays::above_a_planet;
use super::{Trials, in_parallel};
use crate::{Outcome, Random, Run};

/// P10: a ray spawned outward never meets the sphere that it leaves, neither by the library's decision nor by the exact
/// one; one spawned inward meets it once, on the other side. Directions at any angle to the surface, down to 10⁻⁶.
pub(super) fn spawned(run: &Run) -> Outcome {
    in_parallel(run, 10, run.effort.pick(20_000, 100_000_000), |number, random, trials| {
        let sphere_and_ray = if number % 2 == 0 { far_away(random) } else { planet(random) };
        if let Some((sphere, ray)) = sphere_and_ray {
            spawn(trials, &sphere, &ray, random);
        }
    })
}

fn far_away(random: &mut Random) -> Option<(Sphere, Ray)> {
    let radius = random.power_of_two(-10.0, 10.0);
    let sphere = Sphere::new(radius * random.power_of_two(-3.0, 12.0) * random.vector(), radius).ok()?;
    let origin = sphere.center() + radius * 10.0_f32.powf(1.0 + 6.0 * random.unit()) * random.direction();
    let target = sphere.center() + radius * 0.8 * random.direction();
    Some((sphere, Ray::new(origin, target - origin)))
}

fn planet(random: &mut Random) -> Option<(Sphere, Ray)> {
    let (sphere, origin) = above_a_planet(random)?;
    Some((sphere, Ray::new(origin, Vec3::NEG_Y + 2.0 * random.vector())))
}

fn spawn(trials: &mut Trials, sphere: &Sphere, ray: &Ray, random: &mut Random) {
    let (Some(traversal), Some(ball)) = (TraversalRay::new(ray), ball(*sphere)) else { return };
    let Some(hit) = ball.intersect(&traversal, Interval::FULL) else { return };
    let at = ball.interaction(&traversal, &hit);
    let n = at.n();
    let along = n.cross(random.direction());
    let steepness = 10.0_f32.powf(-6.0 * random.unit());
    let outward = along + steepness * n;
    if n.dot(outward) < 1e-3 * steepness {
        return;
    }
    let oracle = SphereOracle::new(sphere);
    let spawned = at.spawn_ray(outward);
    let detour = (spawned.origin.as_dvec3() - at.point.p).length();
    let ulp = f64::from(at.p().abs().max_element().next_up() - at.p().abs().max_element());
    trials.largest("detachment, ulp", detour / ulp);
    let hit = TraversalRay::new(&spawned).and_then(|ray| ball.intersect(&ray, Interval::FULL));
    let exact = oracle.any(&spawned, Interval::FULL, &mut Tally::default());
    trials.check(hit.is_none() && !exact, || {
        format!("{sphere:?} {ray:?}: spawned outward {spawned:?} meets it: {hit:?}, exactly: {exact}")
    });
    // Where the chord is longer than a few ulp of the position: else the new origin may lie beyond its end.
    if 2.0 * steepness * sphere.radius() < 64.0 * ulp as f32 {
        return;
    }
    let spawned = at.spawn_ray(along - steepness * n);
    let hits = TraversalRay::new(&spawned).map_or(0, |ray| super::all_hits(sphere, &ray, Interval::FULL).len());
    trials.check(hits == 1, || format!("{sphere:?} {ray:?}: spawned inward {spawned:?} has {hits} hits, not 1"));
}
