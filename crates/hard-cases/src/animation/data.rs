//! What is a motion, and what it is at its ends.

use geometry::glam::{DMat3, DVec3, Vec3};
use geometry::{AnimatedTransform, AnimatedTransformError, Keyframe, Transform};

use super::motion::{any_box, any_linear, check_contained, motion, transform};
use crate::spheres::{Trials, in_parallel};
use crate::{Outcome, Run};

/// A06: exactly one end mirrored: on the way the scale goes through zero. Refused, with both times; mirrored at both
/// ends, and mirrored twice, is a motion.
pub(super) fn through_zero(run: &Run) -> Outcome {
    in_parallel(run, 206, run.effort.pick(2_000, 1_000_000), |_, random, trials| {
        let mirrors = [DVec3::new(-1.0, 1.0, 1.0), DVec3::new(1.0, 1.0, -1.0), DVec3::splat(-1.0)];
        let mirror = DMat3::from_diagonal(mirrors[random.below(3)]);
        let (first, last) = (any_linear(random), any_linear(random));
        let make = |first: DMat3, last: DMat3| {
            let keyframe = |time, linear| transform(linear, DVec3::ONE).map(|transform| Keyframe { time, transform });
            AnimatedTransform::new([keyframe(2.0, first), keyframe(3.0, last)].into_iter().flatten().collect())
        };
        for made in [make(first, last * mirror), make(first * mirror, last), make(mirror, DMat3::IDENTITY)] {
            let refused = AnimatedTransformError::Singular { index: 0, start: 2.0, end: 3.0 };
            trials.check(made == Err(refused), || format!("{first} {last} {mirror}: {made:?}"));
        }
        for made in [make(first, last), make(first * mirror, last * mirror)] {
            let Ok(made) = made else {
                trials.check(false, || format!("{first} {last} {mirror}: {made:?}"));
                continue;
            };
            let mirrored = made.keyframes()[0].transform.swaps_handedness();
            let same = (0..=20).all(|i| made.at(2.0 + 0.05 * i as f32).swaps_handedness() == mirrored);
            trials.check(same, || format!("{:?} changes its handedness", made.keyframes()));
        }
    })
}

/// A07: times that are none, and times outside: the transform before, at, after and at NaN is exactly a keyframe's.
pub(super) fn odd_times(run: &Run) -> Outcome {
    let mut trials = Trials::default();
    let mut random = crate::Random::new(run.seed, 207 << 32);
    let empty = AnimatedTransform::new(Vec::new());
    trials.check(empty == Err(AnimatedTransformError::NoKeyframes), || format!("no keyframes: {empty:?}"));
    for _ in 0..run.effort.pick(200, 20_000) {
        let mut any = || transform(any_linear(&mut random), DVec3::X);
        let (Some(first), Some(last)) = (any(), any()) else { continue };
        let make = |a: f32, b: f32| {
            let keyframes = [(a, first), (b, last)].map(|(time, transform)| Keyframe { time, transform });
            AnimatedTransform::new(keyframes.to_vec())
        };
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for (made, index) in [(make(bad, 1.0), 0), (make(0.0, bad), 1)] {
                let right = matches!(made, Err(AnimatedTransformError::TimeNotFinite { index: i, .. }) if i == index);
                trials.check(right, || format!("a keyframe at {bad}: {made:?}"));
            }
        }
        for (a, b) in [(1.0, 1.0), (2.0, 1.0), (0.0, -0.0), (f32::MAX, f32::MIN)] {
            let made = make(a, b);
            let refused = AnimatedTransformError::TimeNotIncreasing { index: 1, time: b, previous: a };
            trials.check(made == Err(refused), || format!("keyframes at {a} and {b}: {made:?}"));
        }
        for (a, b) in [(0.0, 1.0), (-1e-45, 1e-45), (f32::MIN, f32::MAX), (1.0, 1.0_f32.next_up()), (0.0, 1e-45)] {
            let Ok(motion) = make(a, b) else {
                trials.check(false, || format!("keyframes at {a} and {b} are refused"));
                continue;
            };
            for time in [f32::NEG_INFINITY, f32::MIN, a.next_down(), a, f32::NAN] {
                trials.check(motion.at(time) == first, || format!("{:?}: not the first at {time}", motion.keyframes()));
            }
            for time in [b, b.next_up(), f32::MAX, f32::INFINITY] {
                trials.check(motion.at(time) == last, || format!("{:?}: not the last at {time}", motion.keyframes()));
            }
            let between = motion.at(0.5 * a + 0.5 * b);
            trials.check(between.matrix().is_finite(), || format!("{:?}: {between:?}", motion.keyframes()));
        }
    }
    trials.outcome()
}

/// The largest error of a matrix put together again from its decomposition, in units of 2⁻⁵² of each column: far below
/// 2 ulp of f32.
const ENDS: f64 = 16.0;

/// A09: sheared, unevenly scaled and mirrored matrices, decomposed and put together again: a moment (10⁻⁴⁵) from the
/// keyframe the motion is where it is, and its box contains it.
pub(super) fn decomposed(run: &Run) -> Outcome {
    in_parallel(run, 209, run.effort.pick(3_000, 3_000_000), |number, random, trials| {
        let mirror = if number % 2 == 0 { DMat3::IDENTITY } else { DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0)) };
        let mut linear = || {
            let mut m = any_linear(random) * mirror;
            m.y_axis += m.x_axis * 10.0_f64.powf(3.0 * f64::from(random.signed()));
            m
        };
        let (first, last) = (linear(), linear());
        let (Some(first), Some(last)) = (transform(first, DVec3::X), transform(last, DVec3::Y)) else { return };
        let bounds = any_box(random, Vec3::ZERO, 1.0);
        // From a moment after 0, and to a moment before 0.
        for (keyframes, moment, wanted) in
            [([(0.0, first), (1.0, last)], 1e-45, first), ([(-1.0, first), (0.0, last)], -1e-45, last)]
        {
            let Some(motion) = motion(keyframes) else { continue };
            let (at, wanted) = (motion.at(moment).matrix().matrix3, wanted.matrix().matrix3);
            let worst = [0, 1, 2]
                .map(|i| (at.col(i) - wanted.col(i)).length() / wanted.col(i).length() / f64::EPSILON)
                .into_iter()
                .fold(0.0, f64::max);
            trials.largest("end error, ulp of f64", worst);
            trials.check(worst <= ENDS, || format!("{keyframes:?}: {at} at {moment}, {worst} ulp off"));
            check_contained(trials, &motion, &bounds, &motion.motion_bounds(&bounds), &[moment]);
        }
    })
}

/// Any place to stand at.
pub(super) fn still(random: &mut crate::Random) -> Option<Transform> {
    transform(any_linear(random), random.vector().as_dvec3())
}
