//! Boxes of instances.

use geometry::glam::{DAffine3, DMat3, DVec3, Vec3};
use geometry::{Bounds3, Transform};

use super::single::{rotation, translation};
use crate::spheres::in_parallel;
use crate::{Outcome, Random, Run};

/// Any map that I01 to I09 place things by.
fn any_map(random: &mut Random) -> DAffine3 {
    let power = |random: &mut Random, decades: f64| 10.0_f64.powf(decades * f64::from(random.signed()));
    let linear = match random.below(6) {
        0 => DMat3::IDENTITY,
        1 => rotation(random),
        2 => rotation(random) * power(random, 6.0),
        3 => DMat3::from_diagonal(DVec3::from_array([0; 3].map(|_| -power(random, 3.0)))),
        4 => DMat3::from_cols(random.vector().as_dvec3(), random.vector().as_dvec3(), random.vector().as_dvec3()),
        _ => rotation(random) * DMat3::from_diagonal(DVec3::new(1.0, power(random, 8.0), 1.0)) * rotation(random),
    };
    let distance = power(random, 7.0);
    DAffine3::from_mat3_translation(linear, translation(random, distance))
}

/// I11: the box of an instance contains the exact image of each corner of the box inside, hence, level by level, every
/// vertex; and it is larger than the box in f64 by no more than the rounding to f32.
pub(super) fn contain(run: &Run) -> Outcome {
    in_parallel(run, 111, run.effort.pick(20_000, 100_000_000), |number, random, trials| {
        let Ok(transform) = Transform::from_affine(any_map(random)) else { return };
        let size = random.power_of_two(-20.0, 20.0);
        let center = size * random.vector() * if number % 2 == 0 { 1.0 } else { random.power_of_two(0.0, 20.0) };
        let corner = |random: &mut Random| center + size * random.vector();
        let bounds = Bounds3::from_points([corner(random), corner(random)]);
        let world = transform.bounds(&bounds);
        trials.check(contains(&world, &transform, &bounds), || format!("{transform:?} {bounds:?}: {world:?}"));
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for corner in bounds.corners() {
            let p = transform.point(corner.as_dvec3());
            (low, high) = (low.min(p), high.max(p));
        }
        let ulp = |x: f64| f64::from(x.abs() as f32) * f64::from(f32::EPSILON) + 1e-44;
        for i in 0..3 {
            trials.largest("low end, ulp", (low[i] - f64::from(world.min[i])) / ulp(low[i]));
            trials.largest("high end, ulp", (f64::from(world.max[i]) - high[i]) / ulp(high[i]));
        }
    })
}

/// Whether the exact image of every corner lies in the box.
fn contains(world: &Bounds3, transform: &Transform, bounds: &Bounds3) -> bool {
    let m = transform.matrix();
    bounds.corners().into_iter().map(Vec3::as_dvec3).all(|p| {
        (0..3).all(|i| {
            let beyond = |end: f32| {
                let products = [0, 1, 2].map(|j| product(m.matrix3.col(j)[i], p[j]));
                let [[a, b], [c, d], [e, f]] = products;
                sign_of_sum([a, b, c, d, e, f, m.translation[i], -f64::from(end)])
            };
            beyond(world.min[i]) >= 0 && beyond(world.max[i]) <= 0
        })
    })
}

/// A product as a sum of two floats, exactly.
fn product(x: f64, y: f64) -> [f64; 2] {
    let product = x * y;
    [product, x.mul_add(y, -product)]
}

/// The sign of a sum, exactly: Shewchuk's partial sums, which do not overlap.
fn sign_of_sum(terms: [f64; 8]) -> i32 {
    let mut partial: Vec<f64> = Vec::new();
    for term in terms {
        let mut carry = term;
        partial.retain_mut(|x| {
            let sum = carry + *x;
            let part = sum - carry;
            let tail = (carry - (sum - part)) + (*x - part);
            (carry, *x) = (sum, tail);
            tail != 0.0
        });
        partial.push(carry);
    }
    partial.iter().rev().find(|x| **x != 0.0).map_or(0, |x| if *x > 0.0 { 1 } else { -1 })
}
