//! Boxes that contain a motion.

use geometry::glam::{DMat3, DVec3, Vec3};
use geometry::{Bounds3, Transform};

use super::motion::{any_box, any_linear, check_contained, extremes, motion, rotation, times, transform, volume_ratio};
use crate::spheres::{Trials, in_parallel};
use crate::{Outcome, Random, Run};

/// No box may be more than this part larger than the best one, in volume (M13).
const VOLUME: f64 = 1.05;

/// A01: where a thing only translates, the box is that of both ends, but for one float at each end.
pub(super) fn translation(run: &Run) -> Outcome {
    in_parallel(run, 201, run.effort.pick(2_000, 10_000_000), |_, random, trials| {
        let linear = any_linear(random);
        let mut end = || transform(linear, random.vector().as_dvec3() * 100.0);
        let (Some(first), Some(last)) = (end(), end()) else { return };
        let Some(motion) = motion([(0.0, first), (1.0, last)]) else {
            trials.check(false, || format!("{first:?} {last:?}: refused"));
            return;
        };
        let bounds = any_box(random, Vec3::ZERO, 10.0);
        let within = motion.motion_bounds(&bounds);
        check_contained(trials, &motion, &bounds, &within, &times(random, 0.0, 1.0, 20));
        let union = first.bounds(&bounds).union(&last.bounds(&bounds));
        let grown =
            Bounds3::new(union.min.map(|x| x.next_down().next_down()), union.max.map(|x| x.next_up().next_up()));
        trials.check(within.contains(&union) && grown.contains(&within), || {
            format!("{:?} {bounds:?}: {within:?}, both ends have {union:?}", motion.keyframes())
        });
    })
}

/// A turn by `degrees` of a box whose distance from the axis is about `distance`: contained at the extremes of every
/// corner's path, by the library's own motion and by the closed form.
fn turn(trials: &mut Trials, random: &mut Random, degrees: f64, distance: f32) {
    let axis = if random.below(4) == 0 { DVec3::AXES[random.below(3)] } else { random.direction().as_dvec3() };
    let Some(end) = Transform::rotate(degrees, axis).ok() else { return };
    let Some(motion) = motion([(0.0, Transform::IDENTITY), (1.0, end)]) else {
        trials.check(false, || format!("{degrees} degrees around {axis}: refused"));
        return;
    };
    let center = random.direction() * distance;
    let size = distance * random.power_of_two(-10.0, 0.0);
    let bounds = any_box(random, center, size);
    let within = motion.motion_bounds(&bounds);
    let mut all = times(random, 0.0, 1.0, 4);
    for corner in bounds.corners() {
        all.extend(extremes(degrees, axis, corner.as_dvec3()));
    }
    check_contained(trials, &motion, &bounds, &within, &all);
    // The closed form, which shares nothing with the library but the sine: right to 10⁻¹⁵ of the distance.
    let (min, max) = (within.min.as_dvec3(), within.max.as_dvec3());
    let slack = DVec3::splat(4e-15 * f64::from(distance + size));
    let a = axis.normalize();
    for corner in bounds.corners().map(Vec3::as_dvec3) {
        let outside = all.iter().find(|&&time| {
            let (sin, cos) = (f64::from(time) * degrees.to_radians()).sin_cos();
            let p = corner * cos + a.cross(corner) * sin + a * (a.dot(corner) * (1.0 - cos));
            !((p - min).cmpge(-slack).all() && (max - p).cmpge(-slack).all())
        });
        trials.check(outside.is_none(), || format!("{degrees} degrees around {axis}: {corner} leaves at {outside:?}"));
    }
    if random.below(16) == 0
        && let Some(ratio) = volume_ratio(&motion, &bounds, &within, [0.0, 1.0], 1000)
    {
        trials.largest("volume ratio", ratio);
        trials.check(ratio <= VOLUME, || {
            format!("{degrees} degrees around {axis}: {bounds:?} takes {ratio} of the best")
        });
    }
}

/// A02: turns by 0.1 to 3.6 degrees, which pbrt takes for none, 1 to 10⁶ from the axis.
pub(super) fn small_turns(run: &Run) -> Outcome {
    in_parallel(run, 202, run.effort.pick(500, 400_000), |_, random, trials| {
        let degrees = 0.1 * 36.0_f64.powf(f64::from(random.unit()));
        let distance = 10.0_f32.powf(6.0 * random.unit());
        turn(trials, random, degrees, distance);
    })
}

/// A03: turns by 4 to 179.9 degrees; and around an axis that does not pass through the origin.
pub(super) fn large_turns(run: &Run) -> Outcome {
    in_parallel(run, 203, run.effort.pick(500, 400_000), |number, random, trials| {
        let degrees = 4.0 + 175.9 * f64::from(random.unit());
        if number % 2 == 0 {
            let distance = random.power_of_two(-3.0, 10.0);
            turn(trials, random, degrees, distance);
        } else {
            let turn = rotation(degrees, random.direction().as_dvec3());
            let pivot = random.vector().as_dvec3() * 10.0;
            let start = any_linear(random);
            let ends = (transform(start, pivot), transform(turn * start, pivot - turn * pivot));
            judge_motion(trials, random, ends);
        }
    })
}

/// The motion between two transforms with positive determinants is made, and its boxes contain it, and are not much
/// larger; those of a part of the time too.
fn judge_motion(trials: &mut Trials, random: &mut Random, ends: (Option<Transform>, Option<Transform>)) {
    let (Some(first), Some(last)) = ends else { return };
    let Some(motion) = motion([(0.0, first), (1.0, last)]) else { return };
    let center = random.vector();
    let bounds = any_box(random, center, 1.0);
    let within = motion.motion_bounds(&bounds);
    check_contained(trials, &motion, &bounds, &within, &times(random, 0.0, 1.0, 100));
    if let Some(ratio) = volume_ratio(&motion, &bounds, &within, [0.0, 1.0], 300) {
        trials.largest("volume ratio", ratio);
        trials.check(ratio <= VOLUME, || format!("{:?} {bounds:?} takes {ratio} of the best", motion.keyframes()));
    }
}

/// A04: half turns and quaternions that are opposite or nearly so: the shorter way round, finite, contained.
pub(super) fn half_turns(run: &Run) -> Outcome {
    in_parallel(run, 204, run.effort.pick(1_000, 1_000_000), |number, random, trials| {
        let near = [0.0, 1e-8_f64.to_degrees() * 2.0, -1e-8_f64.to_degrees() * 2.0, 1e-3, -1e-3];
        let degrees = [180.0, 360.0, 540.0, 0.0][(number % 4) as usize] + near[random.below(5)];
        let axis = if random.below(2) == 0 { DVec3::AXES[random.below(3)] } else { random.direction().as_dvec3() };
        let start = if random.below(2) == 0 { DMat3::IDENTITY } else { any_linear(random) };
        let turned = rotation(degrees, axis);
        let ends = (transform(start, DVec3::ZERO), transform(turned * start, DVec3::ZERO));
        if let (Some(first), Some(last)) = ends {
            let made = motion([(0.0, first), (1.0, last)]);
            trials.check(made.is_some(), || format!("{degrees} degrees around {axis} from {start}: refused"));
            if let Some(motion) = made {
                let half = motion.at(0.5).matrix().matrix3 * start.inverse();
                // The angle of a rotation from its trace.
                let angle = ((half.x_axis.x + half.y_axis.y + half.z_axis.z - 1.0) / 2.0).clamp(-1.0, 1.0).acos();
                let shortest = ((degrees + 180.0).rem_euclid(360.0) - 180.0).abs().to_radians();
                trials.check(half.is_finite() && (angle - shortest / 2.0).abs() < 1e-7, || {
                    format!("{degrees} degrees around {axis}: at half of the time it has turned by {angle}")
                });
            }
        }
        judge_motion(trials, random, ends);
    })
}

/// A05: 2 to 16 keyframes at uneven times: contained at and around every joint; each keyframe exact at its time.
pub(super) fn many_keyframes(run: &Run) -> Outcome {
    in_parallel(run, 205, run.effort.pick(200, 1_000_000), |_, random, trials| {
        let count = 2 + random.below(15);
        let mut time = 10.0 * random.signed();
        let mut keyframes = Vec::new();
        for _ in 0..count {
            let same = random.below(6) == 0 && !keyframes.is_empty();
            let next = if same {
                keyframes.last().map(|&(_, t)| t)
            } else {
                transform(any_linear(random), random.vector().as_dvec3())
            };
            keyframes.extend(next.map(|next| (time, next)));
            time += random.power_of_two(-16.0, 3.0);
        }
        let Some(motion) = motion(keyframes.clone()) else { return };
        let center = random.vector();
        let bounds = any_box(random, center, 1.0);
        let within = motion.motion_bounds(&bounds);
        let mut all = Vec::new();
        for pair in keyframes.windows(2) {
            all.extend(times(random, pair[0].0, pair[1].0, 20));
        }
        check_contained(trials, &motion, &bounds, &within, &all);
        for (time, keyframe) in keyframes {
            trials.check(motion.at(time) == keyframe, || format!("{:?} is not itself at {time}", motion.keyframes()));
        }
    })
}

/// A11: a part of the time has a box of its own: it contains that part, lies in the whole box, is not much larger than
/// the best, and does not depend on which end is named first.
pub(super) fn shutter(run: &Run) -> Outcome {
    in_parallel(run, 211, run.effort.pick(300, 1_000_000), |_, random, trials| {
        let mut end = || transform(any_linear(random), random.vector().as_dvec3() * 3.0);
        let (Some(first), Some(middle), Some(last)) = (end(), end(), end()) else { return };
        let Some(motion) = motion([(0.0, first), (0.3, middle), (1.0, last)]) else { return };
        let center = random.vector();
        let bounds = any_box(random, center, 1.0);
        let [mut start, mut end] = [random.unit(), random.unit()];
        if start > end {
            (start, end) = (end, start);
        }
        let within = motion.motion_bounds_between(&bounds, start, end);
        check_contained(trials, &motion, &bounds, &within, &times(random, start, end, 60));
        let whole = motion.motion_bounds(&bounds);
        // Each may be 1/128 of its extent larger than it must.
        let slack = (whole.max - whole.min) / 64.0 + whole.max.abs().max(whole.min.abs()) * 1e-6;
        let grown = Bounds3::new(whole.min - slack, whole.max + slack);
        let same = motion.motion_bounds_between(&bounds, end, start) == within;
        let unknown = motion.motion_bounds_between(&bounds, f32::NAN, end) == whole;
        trials.check(grown.contains(&within) && same && unknown, || {
            format!("{:?} {bounds:?}: {within:?} from {start} to {end}, {whole:?} at all times", motion.keyframes())
        });
        if let Some(ratio) = volume_ratio(&motion, &bounds, &within, [start, end], 300) {
            trials.largest("volume ratio", ratio);
            trials.check(ratio <= VOLUME, || format!("{:?} {bounds:?} takes {ratio} of the best", motion.keyframes()));
        }
        let part = |b: &Bounds3| (b.max - b.min).as_dvec3().element_product();
        trials.largest("least part of the whole volume saved", 1.0 - part(&within) / part(&whole));
    })
}
