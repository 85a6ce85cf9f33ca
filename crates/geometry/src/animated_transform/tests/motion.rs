//! Transforms at a time, against a slerp written out.

use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::super::decompose::rotation_part;
use super::*;

/// pbrt's interpolation: translation, slerp of quaternions, stretch.
fn slerp(start: &Transform, end: &Transform, u: f64) -> DAffine3 {
    let [m0, m1] = [start.matrix(), end.matrix()];
    let [r0, r1] = [m0, m1].map(|m| rotation_part(&m.matrix3).expect("regular"));
    let stretch = r0.transpose() * m0.matrix3 * (1.0 - u) + r1.transpose() * m1.matrix3 * u;
    let [q0, mut q1] = [r0, r1].map(|r| DQuat::from_mat3(&r));
    if q0.dot(q1) < 0.0 {
        q1 = -q1;
    }
    let angle = q0.dot(q1).min(1.0).acos();
    let q = if angle < 1e-6 {
        (q0 * (1.0 - u) + q1 * u).normalize()
    } else {
        (q0 * ((1.0 - u) * angle).sin() + q1 * (u * angle).sin()) * (1.0 / angle.sin())
    };
    DAffine3::from_mat3_translation(DMat3::from_quat(q) * stretch, m0.translation * (1.0 - u) + m1.translation * u)
}

#[test]
fn a00_it_is_slerp() {
    let mut random = Random(10);
    for _ in 0..2000 {
        let t = random_animation(&mut random, 2);
        let [a, b] = [t.keyframes()[0], t.keyframes()[1]];
        let time = random.between(f64::from(a.time), f64::from(b.time)) as f32;
        let u = (f64::from(time) - f64::from(a.time)) / (f64::from(b.time) - f64::from(a.time));
        let expected = slerp(&a.transform, &b.transform, u);
        assert!(t.at(time).matrix().abs_diff_eq(expected, 1e-8), "{time} {t:?}\n{expected}");
    }
}

#[test]
fn a04_half_turns_and_antipodal_quaternions() {
    let b = bounds(DVec3::new(2.0, 0.0, 0.0), DVec3::splat(0.5));
    for axis in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(-1.0, 2.0, 0.5)] {
        for first in [0.0, 33.0, 179.0] {
            for by in [180.0, -180.0, 180.0 + 1.2e-6, 180.0 - 1.2e-6, 359.999_999, 360.0, 540.0] {
                let t = unit_time(rotation(axis, first), rotation(axis, first + by));
                let motion = t.motion_bounds(&b);
                for i in 0..=100 {
                    let at = t.at(i as f32 / 100.0);
                    assert!(at.matrix().is_finite());
                    assert!((at.matrix().matrix3.determinant() - 1.0).abs() < 1e-14);
                    assert!(b.corners().iter().all(|c| contains(&motion, at.point(c.as_dvec3()))), "{axis} {by}");
                }
                // The shorter way: 360° and nearly 360° do not go round.
                let furthest = (t.at(0.5).point(DVec3::ONE) - t.at(0.0).point(DVec3::ONE)).length();
                assert!(by.abs() < 359.0 || by > 361.0 || furthest < 1e-7, "{by} {furthest}");
            }
        }
    }
}

#[test]
fn a06_motions_through_a_singular_transform_are_refused() {
    let one = Transform::IDENTITY;
    for end in [scale(-1.0, -1.0, -1.0), scale(1.0, 1.0, -1.0), scale(1e-3, -1e3, 1.0)] {
        for (a, b) in [(one, end), (end, one)] {
            let t = animation(&[(0.0, a), (1.0, a), (3.0, b)]);
            assert_eq!(t, Err(AnimatedTransformError::Singular { index: 1, start: 1.0, end: 3.0 }), "{end:?}");
        }
    }
    assert!(Transform::scale(DVec3::ZERO).is_err(), "zero scale is no transform in the first place");
    // Two mirrored axes are a half turn; two mirrored ends never meet zero.
    assert!(animation(&[(0.0, one), (1.0, scale(-1.0, -1.0, 1.0))]).is_ok());
    let mirrored = unit_time(scale(-1.0, 2.0, 1.0), scale(1.0, 1.0, -3.0));
    assert!((0..=100).all(|i| mirrored.at(i as f32 / 100.0).swaps_handedness()));
    // What f64 cannot carry.
    let tiny = scale(1e-40, 1e-40, 1e-40);
    assert_eq!(animation(&[(0.0, one), (1.0, tiny)]), Err(AnimatedTransformError::OutOfRange { index: 1 }));
    assert_eq!(
        animation(&[(0.0, translation(1e39, 0.0, 0.0)), (1.0, one)]),
        Err(AnimatedTransformError::OutOfRange { index: 0 })
    );
    assert!(animation(&[(0.0, tiny), (1.0, tiny)]).is_ok());
}

#[test]
fn a07_times() {
    let (a, b) = (rotation(DVec3::ONE, 10.0), chain(&[translation(0.1, 0.2, 0.3), scale(0.7, 0.8, 0.9)]).inverse());
    let t = animation(&[(-1.5, a), (0.1, b), (1e30, a)]).expect("valid");
    for time in [-1.5, -1.500_001, -1e38, f32::NEG_INFINITY, f32::NAN, 1e30, 2e30, f32::INFINITY] {
        assert_eq!(t.at(time), a, "{time}");
    }
    assert_eq!(t.at(0.1), b);
    assert!(t.at(0.1_f32.next_down()) != b && t.at(0.0) != a);
    assert_eq!(animation(&[(3.0, b)]).expect("valid").at(-7.0), b);
    let extreme = animation(&[(-f32::MAX, a), (f32::MAX, b)]).expect("valid");
    assert!(extreme.at(0.0).matrix().abs_diff_eq(slerp(&a, &b, 0.5), 1e-14));

    assert_eq!(animation(&[]), Err(AnimatedTransformError::NoKeyframes));
    for (second, previous) in [(0.0, 0.0), (-1.0, 0.0), (-0.0, 0.0)] {
        let expected = AnimatedTransformError::TimeNotIncreasing { index: 1, time: second, previous };
        assert_eq!(animation(&[(previous, a), (second, b)]), Err(expected));
    }
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let t = animation(&[(0.0, a), (bad, b)]);
        assert!(matches!(t, Err(AnimatedTransformError::TimeNotFinite { index: 1, .. })), "{bad}");
        assert!(animation(&[(bad, a)]).is_err());
    }
}

#[test]
fn a10_what_stands_still_is_static() {
    let b = bounds(DVec3::new(0.3, -2.0, 5.0), DVec3::new(1.0, 0.1, 2.0));
    let m = chain(&[translation(0.1, 1e5, 0.3), rotation(DVec3::new(0.3, 1.0, 2.0), 25.0), scale(-0.7, 0.8, 1e-7)]);
    for t in [animation(&[(0.5, m)]), animation(&[(0.0, m), (0.3, m), (1.0, m)])].map(|t| t.expect("valid")) {
        assert!(t.is_static());
        assert!((-5..=15).all(|i| t.at(i as f32 / 10.0) == m));
        for (start, end) in [(f32::NEG_INFINITY, f32::INFINITY), (0.1, 0.2), (0.4, 0.7), (2.0, 3.0), (0.3, 0.3)] {
            assert_eq!(t.motion_bounds_between(&b, start, end), m.bounds(&b));
        }
    }
    let t = animation(&[(0.0, m), (1.0, m), (2.0, scale(-1.0, 1.0, 1.0))]).expect("valid");
    assert!(!t.is_static() && t.at(0.5) == m);
    assert_eq!(t.motion_bounds_between(&b, 0.2, 0.8), m.bounds(&b));
}
