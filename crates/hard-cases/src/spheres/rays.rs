//! Rays at the places where a sphere's quadratic equation loses its digits.

use geometry::glam::{DVec3, Vec3};
use geometry::{Ray, Sphere};

use super::{in_parallel, judge};
use crate::{Outcome, Random, Run};

/// A sphere of any size around a point of about that size.
fn any_sphere(random: &mut Random) -> Option<Sphere> {
    let scale = random.power_of_two(-20.0, 20.0);
    let radius = scale * (0.5 + random.unit());
    let center = match random.below(3) {
        0 => Vec3::ZERO,
        1 => scale * random.vector(),
        _ => scale * random.power_of_two(0.0, 12.0) * random.vector(),
    };
    Sphere::new(center, radius).ok()
}

/// A unit vector and one perpendicular to it, as f64 has them.
fn perpendicular(random: &mut Random) -> (DVec3, DVec3) {
    if random.below(3) == 0 {
        let axis = random.below(3);
        return (DVec3::AXES[axis], if random.bits() & 1 == 0 { 1.0 } else { -1.0 } * DVec3::AXES[(axis + 1) % 3]);
    }
    let d = random.direction().as_dvec3().normalize();
    (d, d.cross(random.direction().as_dvec3()).try_normalize().unwrap_or_else(|| d.any_orthonormal_vector()))
}

/// P01: rays that pass the center at r (1 + k 2⁻²⁴) for k from −64 to 64, from before, beside and behind the point of
/// contact. The inputs are rounded to f32 and the exact answer is about the rounded ones.
pub(super) fn tangent(run: &Run) -> Outcome {
    in_parallel(run, 1, run.effort.pick(8_000, 100_000_000), |number, random, trials| {
        let Some(sphere) = any_sphere(random) else { return };
        let (d, n) = perpendicular(random);
        let (c, r) = (sphere.center().as_dvec3(), f64::from(sphere.radius()));
        let k = (number % 129) as f64 - 64.0;
        let b = r * (1.0 + k * 2.0_f64.powi(-24));
        let before = r * f64::from([0.0, 1.0, random.power_of_two(-20.0, 20.0), -0.5][random.below(4)]);
        let length = f64::from(random.power_of_two(-10.0, 10.0));
        judge(trials, &sphere, &Ray::new((c + b * n - before * d).as_vec3(), (length * d).as_vec3()));
    })
}

/// P02: rays from 10 to 10⁷ radii away at the disc that the sphere is seen as, its rim above all.
pub(super) fn far_away(run: &Run) -> Outcome {
    in_parallel(run, 2, run.effort.pick(8_000, 100_000_000), |number, random, trials| {
        let Some(sphere) = any_sphere(random) else { return };
        let (d, n) = perpendicular(random);
        let (c, r) = (sphere.center().as_dvec3(), f64::from(sphere.radius()));
        let distance = 10.0_f64.powf(1.0 + 6.0 * f64::from(random.unit()));
        let off =
            if number % 2 == 0 { f64::from(random.unit()) * 1.2 } else { 1.0 + 1e-3 * f64::from(random.signed()) };
        let o = (c - distance * r * d).as_vec3();
        let target = c + off * r * n;
        let towards = (target - o.as_dvec3()) * f64::from(random.power_of_two(-30.0, 0.0));
        judge(trials, &sphere, &Ray::new(o, towards.as_vec3()));
    })
}

/// A planet of radius 6.4 · 10⁶ that touches the origin of coordinates from below, and a point above the surface by
/// 10⁻³ to 10³.
pub(super) fn above_a_planet(random: &mut Random) -> Option<(Sphere, Vec3)> {
    let radius = 6.4e6;
    let sphere = Sphere::new(Vec3::new(0.0, -radius, 0.0), radius).ok()?;
    let height = 10.0_f64.powf(6.0 * f64::from(random.unit()) - 3.0);
    let side = 10.0_f64.powf(5.0 * f64::from(random.unit()) - 1.0);
    let [x, z] = [0, 1].map(|_| side * f64::from(random.signed()));
    let ground = -(x * x + z * z) / (f64::from(radius) + (f64::from(radius).powi(2) - x * x - z * z).sqrt());
    Some((sphere, DVec3::new(x, ground + height, z).as_vec3()))
}

/// P03: rays down, at the horizon and just below or above it.
pub(super) fn planet(run: &Run) -> Outcome {
    in_parallel(run, 3, run.effort.pick(8_000, 100_000_000), |number, random, trials| {
        let Some((sphere, o)) = above_a_planet(random) else { return };
        let (up, r) = (o.as_dvec3() - sphere.center().as_dvec3(), f64::from(sphere.radius()));
        let across = up.cross(random.direction().as_dvec3()).normalize_or(DVec3::X);
        let height = up.length() - r;
        // The horizon lies below the horizontal by about √(2h/r).
        let dip = (2.0 * height.max(0.0) / r).sqrt();
        let slope = match number % 3 {
            0 => 10.0_f64.powf(4.0 * f64::from(random.unit()) - 3.0),
            1 => dip * (1.0 + 1e-3 * f64::from(random.signed())),
            _ => dip * (1.0 + f64::from(random.unit())),
        };
        judge(trials, &sphere, &Ray::new(o, (across - slope * up.normalize()).as_vec3()));
    })
}

/// P04: origins in the center; inside; on the surface, exactly; and 1 ulp beside it. Directions any, along the surface,
/// and along a diagonal of whole numbers.
pub(super) fn on_the_surface(run: &Run) -> Outcome {
    in_parallel(run, 4, run.effort.pick(8_000, 100_000_000), |number, random, trials| {
        // 2² + 3² + 6² = 7² and all its kin: points with coordinates that f32 has.
        let scale = random.power_of_two(-20.0, 20.0).log2().round().exp2();
        let (spot, radius) =
            [([2.0, 3.0, 6.0], 7.0), ([1.0, 4.0, 8.0], 9.0), ([0.0, 3.0, 4.0], 5.0), ([0.0, 0.0, 1.0], 1.0)]
                [random.below(4)];
        let mut spot = Vec3::from(spot);
        for i in 0..3 {
            let j = random.below(3);
            (spot[i], spot[j]) = (spot[j], spot[i]);
            spot[i] *= if random.bits() & 1 == 0 { 1.0 } else { -1.0 };
        }
        let center = if random.below(2) == 0 { Vec3::ZERO } else { (1000.0 * random.vector()).round() };
        let Ok(sphere) = Sphere::new(center * scale, radius * scale) else { return };
        let mut o = match number % 8 {
            0 => center,
            1 => center + 0.5 * spot,
            2 => center + radius * random.direction() * random.unit(),
            _ => center + spot,
        } * scale;
        if number % 8 >= 6 {
            let i = random.below(3);
            o[i] = if random.bits() & 1 == 0 { o[i].next_up() } else { o[i].next_down() };
        }
        let direction = match random.below(5) {
            0 => random.direction(),
            1 => -spot,
            2 => spot.cross(Vec3::new(1.0, 2.0, -5.0)),
            3 => spot.any_orthogonal_vector() + 1e-6 * random.vector(),
            _ => (8.0 * random.vector()).round(),
        };
        judge(trials, &sphere, &Ray::new(o, direction));
    })
}
