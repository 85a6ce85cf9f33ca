//! What is a sphere, and what is its box.

use geometry::glam::{DVec3, Vec3};
use geometry::{Bounds3, Interval, MAX_COORDINATE, Ray, Shape, Sphere, SphereError, Transform, TraversalRay};
use oracle::ExactReal;

use super::{Trials, in_parallel, judge};
use crate::{Outcome, Random, Run};

/// P05: what is no sphere is refused with its reason; the smallest of all is a sphere; one outside of the domain is
/// never hit.
pub(super) fn refused(_: &Run) -> Outcome {
    let mut trials = Trials::default();
    for radius in [0.0, -0.0, -1.0, -1e-45, f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let sphere = Sphere::new(Vec3::ZERO, radius);
        trials.check(matches!(sphere, Err(SphereError::Radius(_))), || format!("radius {radius}: {sphere:?}"));
    }
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in Vec3::AXES {
            let center = Vec3::ONE + axis * bad;
            let sphere = Sphere::new(center, 1.0);
            trials.check(matches!(sphere, Err(SphereError::Center(_))), || format!("center {center}: {sphere:?}"));
        }
    }
    for radius in [1e-45, 1e-40, f32::MIN_POSITIVE, 1e-20, 1e17, MAX_COORDINATE] {
        let Ok(sphere) = Sphere::new(Vec3::ZERO, radius) else {
            trials.check(false, || format!("radius {radius} is refused"));
            continue;
        };
        for direction in [Vec3::X, Vec3::NEG_Y, Vec3::new(1.0, 2.0, -3.0)] {
            judge(&mut trials, &sphere, &Ray::new(-direction, direction));
            judge(&mut trials, &sphere, &Ray::new(-direction * radius.min(1e10) * 4.0, direction));
            judge(&mut trials, &sphere, &Ray::new(Vec3::new(0.0, 0.0, radius), direction));
        }
    }
    for (center, radius) in
        [(Vec3::X, MAX_COORDINATE.next_up()), (Vec3::Y * MAX_COORDINATE, 1e15), (Vec3::ZERO, f32::MAX)]
    {
        let Ok(sphere) = Sphere::new(center, radius) else { continue };
        let ray = TraversalRay::new(&Ray::new(center, Vec3::X));
        let hit = ray.and_then(|ray| sphere.intersect(&ray, Interval::FULL));
        trials.check(hit.is_none(), || format!("{sphere:?} is outside of the domain, but hit: {hit:?}"));
    }
    trials.outcome()
}

/// P06: the box contains center ± radius, exactly, and is at most one float larger at each end; the box of an instance
/// contains the ends of the sphere's diameters.
pub(super) fn bounds(run: &Run) -> Outcome {
    in_parallel(run, 6, run.effort.pick(50_000, 100_000_000), |_, random, trials| {
        let radius = random.power_of_two(-149.0, 59.0);
        let center = Vec3::from_array([0; 3].map(|_| center_coordinate(random, radius)));
        let Ok(sphere) = Sphere::new(center, radius) else { return };
        let bounds = sphere.object_bound();
        trials.check(holds(&sphere, &bounds), || format!("{sphere:?}: {bounds:?}"));
        let axis = random.direction().as_dvec3();
        let Ok(placement) = Transform::rotate(f64::from(random.unit()) * 360.0, axis) else { return };
        let world = sphere.world_bound(&placement);
        // Within 10⁻¹⁵ of the farthest point of the sphere along each axis of the world.
        let (c, r) = (placement.point(center.as_dvec3()), f64::from(radius));
        let inside = (r - 1e-15 * (r + 2.0 * center.abs().as_dvec3().max_element())).max(0.0);
        let contains = (c - inside).cmpge(world.min.as_dvec3()).all() && (c + inside).cmple(world.max.as_dvec3()).all();
        trials.check(contains, || format!("{sphere:?} {placement:?}: {world:?}"));
        let ulp = f64::from(f32::EPSILON) * DVec3::max_element(c.abs() + r);
        trials.largest("growth under rotation / radius", (world.max.x - world.min.x) as f64 / (2.0 * r + 4.0 * ulp));
    })
}

/// Of the radius' size, of any other size, or such that c ± r needs more digits than f64 has.
fn center_coordinate(random: &mut Random, radius: f32) -> f32 {
    random.signed()
        * match random.below(4) {
            0 => radius,
            1 => random.power_of_two(-149.0, 59.0),
            2 => (radius * random.power_of_two(20.0, 60.0)).min(MAX_COORDINATE),
            _ => 0.0,
        }
}

fn holds(sphere: &Sphere, bounds: &Bounds3) -> bool {
    (0..3).all(|i| {
        let radius = ExactReal::from_f64(sphere.radius().into());
        let center = f64::from(sphere.center()[i]);
        let (low, high) = (radius.along(center, -1.0), radius.along(center, 1.0));
        let (min, max) = (bounds.min[i], bounds.max[i]);
        let contains = low.cmp_f64(min.into()).is_ge() && high.cmp_f64(max.into()).is_le();
        let is_tight = low.cmp_f64(min.next_up().into()).is_le() && high.cmp_f64(max.next_down().into()).is_ge();
        contains && is_tight
    })
}
