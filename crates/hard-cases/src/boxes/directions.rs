//! S06, S07, S08, S12: directions with very small components, of any length, and from very far away.

use geometry::glam::{DVec3, Vec3};
use geometry::{Interval, Ray};

use super::judge::Judge;
use crate::build::meshes::{bumpy_sphere, cuboid, mesh_of};
use crate::{Aim, Outcome, Random, Run, Tries};

/// A number whose reciprocal overflows, or nearly: below 2⁻¹²⁶.
fn denormal_number(random: &mut Random) -> f32 {
    let magnitude = f32::from_bits(random.bits() >> (9 + random.below(23)));
    if random.below(2) == 0 { magnitude } else { -magnitude }
}

/// S06: some components of the direction, or all, are denormal: rays within closed boxes and spheres do not leak, and
/// hit what they should.
pub(super) fn denormal(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 106);
    // With all components denormal, t is not above the largest number only where the scene is small.
    let scenes = [
        (cuboid(Vec3::splat(-1.0), Vec3::ONE), 1.0, 6),
        (bumpy_sphere(2, 1.0, DVec3::ZERO, &mut random), 1.0, 6),
        (cuboid(Vec3::splat(-1e-4), Vec3::splat(1e-4)), 1e-4, 7),
        (bumpy_sphere(2, 1e-4, DVec3::ZERO, &mut random), 1e-4, 7),
    ];
    for (mesh, scale, subsets) in scenes {
        let Some(judge) = Judge::new(&mut tries, run, mesh) else { continue };
        let (mut inside, mut hits) = (0, 0);
        let count = run.effort.pick(2_000, 2_000_000);
        for i in 0..count {
            let subset = 1 + i % subsets;
            let mut direction = random.vector();
            for axis in 0..3 {
                if subset >> axis & 1 == 1 {
                    direction[axis] = denormal_number(&mut random);
                }
            }
            let mut origin = scale * 1.5 * random.vector();
            if i % 5 == 0 {
                // In the plane of a face of the cube.
                origin[random.below(3)] = scale;
            }
            let ray = Ray::new(origin, direction);
            hits += usize::from(judge.tolerant(&mut tries, &ray, Interval::FULL));
            inside += usize::from(judge.does_not_leak(&mut tries, &ray));
        }
        tries.check(inside > count / 20 && hits > count / 20, || format!("{inside} inside and {hits} hits"));
    }
    tries.outcome()
}

/// S07: components of 10⁻³⁰ to 10⁻⁷ beside one of 1, and walls so far away that they matter.
pub(super) fn small_components(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 107);
    let ten = std::f32::consts::LOG2_10;
    let mut hits = 0;
    let count = run.effort.pick(2_000, 500_000);
    for i in 0..count {
        let t = random.power_of_two(3.0 * ten, 12.0 * ten);
        let mut small = || random.power_of_two(-30.0 * ten, -7.0 * ten) * if random.below(2) == 0 { 1.0 } else { -1.0 };
        let (dx, dy) = (small(), small());
        let turned = |v: [f32; 3]| {
            let mut v = v;
            v.rotate_right(i % 3);
            Vec3::from_array(v)
        };
        // A narrow wall around where the ray is at t, and a wide one behind it.
        let wall = |t: f32, r: f32| {
            let (x, y) = (dx * t, dy * t);
            let corners = [[x - r, y - r, t], [x + r, y - r, t], [x + r, y + r, t], [x - r, y + r, t]].map(turned);
            [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]
        };
        let mesh = mesh_of(wall(t, 1e-4 * t).into_iter().chain(wall(2.0 * t, t)));
        let Some(judge) = Judge::new(&mut tries, run, mesh) else { continue };
        let ray = Ray::new(Vec3::ZERO, turned([dx, dy, 1.0]));
        hits += usize::from(judge.tolerant(&mut tries, &ray, Interval::FULL));
    }
    tries.check(hits == count, || format!("only {hits} of {count} rays can hit"));
    tries.outcome()
}

/// S08: a direction times 2ᵏ: t times 2⁻ᵏ, and not another bit changes.
pub(super) fn lengths(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 108);
    let mesh = bumpy_sphere(3, 1.0, DVec3::ZERO, &mut random);
    let Some(judge) = Judge::new(&mut tries, run, mesh) else { return tries.outcome() };
    let mut hits = 0;
    let count = run.effort.pick(200, 100_000);
    for i in 0..count {
        let origin = 2.0 * random.vector();
        let direction = Aim::ALL[i % 4].target(judge.mesh(), &mut random) - origin;
        let expected = judge.hit(&Ray::new(origin, direction), Interval::FULL);
        hits += usize::from(expected.is_some());
        for k in -100..=100 {
            let s = 2.0_f32.powi(k);
            let ray = Ray::new(origin, s * direction);
            let hit = judge.hit(&ray, Interval::FULL).map(|mut hit| {
                hit.t *= s;
                hit
            });
            tries.check(hit == expected, || format!("{ray:?}: {hit:?} times 2^{k}, at k = 0 {expected:?}"));
        }
    }
    tries.check(hits > count / 2, || format!("only {hits} of {count} rays hit"));
    tries.outcome()
}

/// S12: origins at up to 10³⁰. What is large enough to be seen from there is decided exactly; a ray along an axis, for
/// which all differences that matter are exact, hits what it should from anywhere.
pub(super) fn far_origins(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 112);
    for radius in [1.0, 1e6, 1e12, 1e17] {
        let mesh = bumpy_sphere(2, radius, DVec3::ZERO, &mut random);
        let Some(judge) = Judge::new(&mut tries, run, mesh) else { continue };
        let count = run.effort.pick(2_000, 1_000_000);
        let mut hits = 0;
        for i in 0..count {
            let away = random.power_of_two(0.0, [10.0, 20.0, 40.0][i % 3]);
            let origin = away * radius as f32 * random.direction();
            let target = radius as f32 * random.vector();
            let direction = if i % 2 == 0 { target - origin } else { (target - origin).normalize() };
            hits += usize::from(judge.tolerant(&mut tries, &Ray::new(origin, direction), Interval::FULL));
        }
        tries.check(hits > count / 4, || format!("radius {radius}: only {hits} of {count} rays can hit"));
    }
    let Some(judge) = Judge::new(&mut tries, run, cuboid(Vec3::splat(-1.0), Vec3::ONE)) else { return tries.outcome() };
    for k in 1..=100 {
        for axis in 0..3 {
            for sign in [1.0, -1.0] {
                let mut origin = Vec3::new(0.5, 0.25, -0.125);
                origin[axis] = sign * 2.0_f32.powi(k);
                let mut direction = Vec3::ZERO;
                direction[axis] = -sign;
                let ray = Ray::new(origin, direction);
                let (hit, exact) = (judge.hit(&ray, Interval::FULL), judge.closest(&ray, Interval::FULL));
                let expected = exact.map_or(f32::NAN, |exact| exact.t.to_f32());
                tries.check(hit.is_some_and(|hit| hit.t == expected), || format!("{ray:?}: {hit:?}, t is {expected}"));
            }
        }
    }
    tries.outcome()
}
