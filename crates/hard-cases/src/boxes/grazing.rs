//! S04: rays through the very corners and edges of boxes.

use geometry::glam::Vec3;
use geometry::{Bounds3, Interval, Kernels, Ray, TraversalRay, Watertight};

use super::judge::Judge;
use crate::build::meshes::cuboid;
use crate::{Outcome, Random, Run, Tries};

/// S04: no box test and no closed box loses a ray. Three ways to graze: boxes alone, against integers; closed boxes
/// from within, at their corners and edges; and closed boxes with long edges, where the ray passes close to an edge
/// whose ends are far away.
pub(super) fn corners_and_edges(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    boxes_alone(&mut tries, run);
    closed_boxes(&mut tries, run);
    long_edges(&mut tries, run);
    tries.outcome()
}

fn boxes_alone(tries: &mut Tries, run: &Run) {
    let mut random = Random::new(run.seed, 104);
    let count = run.effort.pick(200_000, 200_000_000);
    let mut false_entries = 0_u64;
    for _ in 0..count {
        let bounds = Bounds3::from_points([4.0 * random.vector(), 4.0 * random.vector()]);
        let mut target = bounds.corners()[random.below(8)];
        if random.below(2) == 0 {
            let axis = random.below(3);
            target[axis] = bounds.min[axis] + random.unit() * (bounds.max[axis] - bounds.min[axis]);
        }
        let origin = nudged(4.0 * random.vector(), &mut random);
        let ray = Ray::new(origin, nudged(target - origin, &mut random));
        // The integers cannot hold what is smaller than this.
        let is_small = |x: f32| x != 0.0 && x.abs() < 2.0_f32.powi(-24);
        if [ray.origin, ray.direction, bounds.min, bounds.max].iter().any(|v| v.to_array().into_iter().any(is_small)) {
            continue;
        }
        let Some(traversal) = TraversalRay::new(&ray) else { continue };
        let entry = Watertight::enter(&traversal, &bounds, Interval::FULL);
        let meets = exactly_meets(&ray, &bounds);
        tries.check(entry.is_some() || !meets, || format!("{ray:?} does not enter {bounds:?}"));
        false_entries += u64::from(entry.is_some() && !meets);
    }
    tries.figure("rate of false entries at corners and edges", false_entries as f64 / f64::from(count));
}

/// Up to three ulps beside, in any component.
fn nudged(v: Vec3, random: &mut Random) -> Vec3 {
    Vec3::from_array(v.to_array().map(|x| {
        let steps = random.below(7) as i32 - 3;
        (0..steps.abs()).fold(x, |x, _| if steps > 0 { x.next_up() } else { x.next_down() })
    }))
}

/// Whether the ray meets the closed box at t >= 0, in integers: all numbers are multiples of 2⁻⁵⁰ and below 2⁴, so that
/// products of their differences fit 128 bits.
fn exactly_meets(ray: &Ray, bounds: &Bounds3) -> bool {
    let integer = |x: f32| (f64::from(x) * 2.0_f64.powi(50)) as i128;
    // Entries and exits as fractions with a positive denominator.
    let (mut entries, mut exits) = (vec![(0, 1)], Vec::new());
    for i in 0..3 {
        let (o, d) = (integer(ray.origin[i]), integer(ray.direction[i]));
        let (min, max) = (integer(bounds.min[i]) - o, integer(bounds.max[i]) - o);
        match d.signum() {
            0 if min > 0 || max < 0 => return false,
            0 => {}
            1 => {
                entries.push((min, d));
                exits.push((max, d));
            }
            _ => {
                entries.push((-max, -d));
                exits.push((-min, -d));
            }
        }
    }
    entries.iter().all(|entry| exits.iter().all(|exit| entry.0 * exit.1 <= exit.0 * entry.1))
}

fn closed_boxes(tries: &mut Tries, run: &Run) {
    let mut random = Random::new(run.seed, 204);
    let mut inside = 0;
    for _ in 0..run.effort.pick(200, 20_000) {
        let bounds = Bounds3::from_points([4.0 * random.vector(), 4.0 * random.vector()]);
        let Some(judge) = Judge::new(tries, run, cuboid(bounds.min, bounds.max)) else { continue };
        for _ in 0..50 {
            let mut target = bounds.corners()[random.below(8)];
            if random.below(2) == 0 {
                let axis = random.below(3);
                target[axis] = bounds.min[axis] + random.unit() * (bounds.max[axis] - bounds.min[axis]);
            }
            let origin = random.point_in(&bounds);
            let ray = Ray::new(origin, nudged(target - origin, &mut random));
            inside += usize::from(judge.does_not_leak(tries, &ray));
            judge.tolerant(tries, &ray, Interval::FULL);
        }
    }
    tries.check(inside > 1_000, || format!("only {inside} origins are inside"));
}

/// A corridor with the viewer near one of its long edges: what a vertex is displaced by in the triangle test grows with
/// its own distance, while a box is padded by the distance at which the ray passes.
fn long_edges(tries: &mut Tries, run: &Run) {
    let mut random = Random::new(run.seed, 304);
    let mut inside = 0;
    for exponent in 0..run.effort.pick(7, 17) {
        let length = 10.0_f32.powi(exponent);
        for axis in 0..3 {
            let turned = |v: [f32; 3]| {
                let mut v = v;
                v.rotate_right(axis);
                Vec3::from_array(v)
            };
            let mesh = cuboid(turned([-length, -4.0, -4.0]), turned([length, 0.0, 0.0]));
            let Some(judge) = Judge::new(tries, run, mesh) else { continue };
            for _ in 0..run.effort.pick(500, 100_000) {
                let origin = [random.signed(), -0.2 - random.unit(), -0.2 - random.unit()];
                // Off the edge by about as much as a rounding at the distance of its ends, in f32 or in f64.
                let rounding = [f32::EPSILON, f64::EPSILON as f32][random.below(2)];
                let beside = (length * rounding * random.power_of_two(-6.0, 2.0)).min(0.1);
                let along = origin[0] + random.signed() * random.power_of_two(0.0, 4.0).min(length);
                let target = turned([along, beside * random.signed(), beside * random.signed()]);
                let ray = Ray::new(turned(origin), target - turned(origin));
                inside += usize::from(judge.does_not_leak(tries, &ray));
            }
        }
    }
    tries.check(inside > 1_000, || format!("only {inside} origins are inside"));
}
