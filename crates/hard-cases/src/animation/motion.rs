//! Motions, and whether a box contains them.

use geometry::glam::{DAffine3, DMat3, DVec3, Vec3};
use geometry::{AnimatedTransform, Bounds3, Keyframe, Transform};

use crate::Random;
use crate::spheres::Trials;

/// The map of a linear part and a translation.
pub(super) fn transform(linear: DMat3, translation: DVec3) -> Option<Transform> {
    Transform::from_affine(DAffine3::from_mat3_translation(linear, translation)).ok()
}

/// The rotation by `degrees` around a unit vector.
pub(super) fn rotation(degrees: f64, axis: DVec3) -> DMat3 {
    Transform::rotate(degrees, axis).map_or(DMat3::IDENTITY, |t| t.matrix().matrix3)
}

/// Any rotation, with any positive scale and some shear.
pub(super) fn any_linear(random: &mut Random) -> DMat3 {
    let turn = rotation(f64::from(random.unit()) * 360.0, random.direction().as_dvec3());
    let scale = DVec3::from_array([0; 3].map(|_| f64::from(random.power_of_two(-2.0, 2.0))));
    let mut shear = DMat3::IDENTITY;
    shear.y_axis.x = random.signed().into();
    shear.z_axis.y = random.signed().into();
    turn * shear * DMat3::from_diagonal(scale)
}

/// A motion through `keyframes`.
pub(super) fn motion(keyframes: impl IntoIterator<Item = (f32, Transform)>) -> Option<AnimatedTransform> {
    AnimatedTransform::new(keyframes.into_iter().map(|(time, transform)| Keyframe { time, transform }).collect()).ok()
}

/// A box anywhere near `center`, of about `size`; every eighth is a point.
pub(super) fn any_box(random: &mut Random, center: Vec3, size: f32) -> Bounds3 {
    let corner = center + size * random.vector();
    let other = if random.below(8) == 0 { corner } else { center + size * random.vector() };
    Bounds3::from_points([corner, other])
}

/// Times of a motion from `start` to `end`: both, their neighbours, and `count` between.
pub(super) fn times(random: &mut Random, start: f32, end: f32, count: usize) -> Vec<f32> {
    let mut times = vec![start, end, start.next_up(), end.next_down(), 0.5 * (start + end)];
    times.extend((0..count).map(|_| (start + (end - start) * random.unit()).clamp(start, end)));
    times
}

/// The times, from 0 to 1, at which a coordinate of `x` is extreme while it turns by `degrees` around `axis` through
/// the origin.
pub(super) fn extremes(degrees: f64, axis: DVec3, x: DVec3) -> Vec<f32> {
    let a = axis.normalize();
    let (cos, sin) = (x - a * a.dot(x), a.cross(x));
    let angle = degrees.to_radians();
    let mut times = Vec::new();
    for i in 0..3 {
        let first = sin[i].atan2(cos[i]);
        for turn in -2..=2 {
            let u = ((first + f64::from(turn) * std::f64::consts::PI) / angle) as f32;
            times.extend([u.next_down(), u, u.next_up()].into_iter().filter(|u| (0.0..=1.0).contains(u)));
        }
    }
    times
}

/// Checks that the box of the motion contains what the motion maps the corners of `bounds` to at each time.
pub(super) fn check_contained(
    trials: &mut Trials,
    motion: &AnimatedTransform,
    bounds: &Bounds3,
    within: &Bounds3,
    times: &[f32],
) {
    let (min, max) = (within.min.as_dvec3(), within.max.as_dvec3());
    for &time in times {
        let at = motion.at(time);
        let outside = bounds.corners().into_iter().find(|corner| {
            let p = at.point(corner.as_dvec3());
            !(p.cmpge(min).all() && p.cmple(max).all())
        });
        trials.check(outside.is_none(), || {
            format!("{:?}: {outside:?} of {bounds:?} leaves {within:?} at {time}", motion.keyframes())
        });
    }
}

/// How much larger than the box of the motion as it is seen at `samples` times a box is, in volume; of boxes with an
/// extent in f32.
pub(super) fn volume_ratio(
    motion: &AnimatedTransform,
    bounds: &Bounds3,
    within: &Bounds3,
    [start, end]: [f32; 2],
    samples: u16,
) -> Option<f64> {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for i in 0..=samples {
        let at = motion.at(start + (end - start) * (f32::from(i) / f32::from(samples)));
        for corner in bounds.corners() {
            let p = at.point(corner.as_dvec3());
            (low, high) = (low.min(p), high.max(p));
        }
    }
    let extent = high - low;
    let ulp = f64::from(f32::EPSILON) * low.abs().max(high.abs());
    extent.cmpgt(ulp * 1e4).all().then(|| {
        let d = within.max.as_dvec3() - within.min.as_dvec3();
        (d.x * d.y * d.z) / (extent.x * extent.y * extent.z)
    })
}
