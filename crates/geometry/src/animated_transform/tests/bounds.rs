//! Motion bounds, against sampled times and analytic extremes.

use glam::{DVec3, Vec3};

use super::*;

/// The box of the corners' positions at `n` + 1 equal times of each segment, not rounded: never larger than the
/// smallest.
fn sampled(t: &AnimatedTransform, b: &Bounds3, start: f32, end: f32, n: u32) -> (DVec3, DVec3) {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for pair in t.keyframes().windows(2) {
        let (from, to) = (pair[0].time.clamp(start, end), pair[1].time.clamp(start, end));
        for i in 0..=n {
            let m = t.at((from + (to - from) * (i as f32 / n as f32)).min(to));
            for c in b.corners() {
                let p = m.point(c.as_dvec3());
                (low, high) = (low.min(p), high.max(p));
            }
        }
    }
    (low, high)
}

/// Volume of the bounds relative to that of the sampled box, which lies within.
fn volume_ratio(b: &Bounds3, (low, high): (DVec3, DVec3)) -> f64 {
    assert!(contains(b, low) && contains(b, high), "{b:?} {low} {high}");
    let (all, taken) = (b.max.as_dvec3() - b.min.as_dvec3(), high - low);
    (all.x * all.y * all.z) / (taken.x * taken.y * taken.z)
}

#[test]
fn a01_translation_gives_the_union_of_the_ends() {
    let b = bounds(DVec3::new(0.3, -2.0, 5.0), DVec3::new(1.0, 0.1, 2.0));
    let fixed = chain(&[rotation(DVec3::ONE, 77.0), scale(1.0, -2.0, 3.3)]);
    let [start, end] = [translation(1.0, 2.0, -3.0), translation(-4.0, 2.0, 7.7)].map(|t| chain(&[t, fixed]));
    let t = unit_time(start, end);
    let (union, motion) = (start.bounds(&b).union(&end.bounds(&b)), t.motion_bounds(&b));
    for i in 0..3 {
        assert!((motion.min[i] - union.min[i]).abs() <= union.min[i].abs() * f32::EPSILON);
        assert!((motion.max[i] - union.max[i]).abs() <= union.max[i].abs() * f32::EPSILON);
    }
    // The linear part is the keyframes' own, to the bit.
    assert_eq!(t.at(0.3).matrix().matrix3, start.matrix().matrix3);
    assert!((t.at(0.5).matrix().translation - DVec3::new(-1.5, 2.0, 2.35)).length() < 1e-15);
}

/// The extreme x = r is met at half time exactly; pbrt's box ends at r cos(angle / 2).
#[test]
fn a02_small_rotations_at_large_radii() {
    for radius in [1.0_f32, 1e2, 1e4, 1e6] {
        for angle in [1e-6, 1e-3, 0.1, 0.5, 1.0, 2.0, 3.0, 3.6, 4.0, 30.0, 170.0] {
            let t = unit_time(rotation(DVec3::Z, -angle / 2.0), rotation(DVec3::Z, angle / 2.0));
            let point = Vec3::new(radius, 0.0, 1.0);
            let motion = t.motion_bounds(&Bounds3::from_points([point]));
            let (r, half) = (f64::from(radius), f64::to_radians(angle / 2.0));
            let (low, high) = (motion.min.as_dvec3(), motion.max.as_dvec3());
            assert!(contains(&motion, t.at(0.5).point(point.as_dvec3())) && high.x >= r);
            assert!(low.x <= r * half.cos() && low.y <= -r * half.sin() && high.y >= r * half.sin());
            // Beyond the arc by at most 1/256 of the sagitta and two f32 roundings.
            let allowed = r * (1.0 - half.cos()) / 256.0 + r * 1.3e-7;
            assert!(high.x - r <= allowed && r * half.cos() - low.x <= allowed, "{radius} {angle} {motion:?}");
            assert!(high.y - r * half.sin() <= allowed, "{radius} {angle} {motion:?}");
            // Nothing moves along the axis.
            assert!(high.z - low.z <= 2.5e-7 + r * 1e-12);
        }
    }
}

/// Arcs around any axis through any pivot: along e the path c + r (u cos φ + v sin φ) is extreme where tan φ = v·e /
/// u·e.
#[test]
fn a03_the_analytic_extremes_of_arcs_are_contained() {
    let mut random = Random(11);
    for _ in 0..3000 {
        let (axis, angle) = (random.vector().normalize(), random.between(4.0, 179.9));
        let x = (random.vector() * 10.0_f64.powf(random.between(-2.0, 5.0))).as_vec3();
        let t = unit_time(Transform::IDENTITY, rotation(axis, angle));
        let motion = t.motion_bounds(&Bounds3::from_points([x]));
        let x = x.as_dvec3();
        let center = axis * axis.dot(x);
        let (u, v) = (x - center, axis.cross(x));
        for e in DVec3::AXES {
            for half_turn in [0.0, std::f64::consts::PI] {
                let phi = v.dot(e).atan2(u.dot(e)) + half_turn;
                if (0.0..=angle.to_radians()).contains(&phi) {
                    let extreme = center + u * phi.cos() + v * phi.sin();
                    // The test's own rounding stays within 1e-14 |x|, the motion's box is rounded to 2⁻²⁴.
                    assert!(contains(&motion, extreme - (extreme * 1e-13)), "{axis} {angle} {extreme} {motion:?}");
                }
            }
        }
        let (low, high) = sampled(&t, &Bounds3::from_points([x.as_vec3()]), 0.0, 1.0, 64);
        assert!(contains(&motion, low) && contains(&motion, high));
    }
}

/// A05 and the rest: 10⁵ random (keyframes, box, time), all of it moving.
#[test]
fn a05_every_point_is_contained_at_every_time() {
    let mut random = Random(12);
    let mut samples = 0;
    while samples < 100_000 {
        let n = 2 + random.below(15);
        let t = random_animation(&mut random, n);
        let [first, last] = [t.keyframes()[0].time, t.keyframes()[n as usize - 1].time].map(f64::from);
        for _ in 0..4 {
            let center = random.vector() * 10.0_f64.powf(random.between(-1.0, 3.0));
            let half = random.vector().abs() * 10.0_f64.powf(random.between(-6.0, 2.0));
            let b = bounds(center, half);
            let motion = t.motion_bounds(&b);
            assert!(motion.is_valid());
            for i in 0..125 {
                let joint = t.keyframes()[random.below(n) as usize].time;
                let time = match i % 8 {
                    0 => joint,
                    1 => joint.next_up(),
                    2 => joint.next_down(),
                    _ => random.between(first - 1.0, last + 1.0) as f32,
                };
                let (min, max) = (b.min.as_dvec3(), b.max.as_dvec3());
                let x = if i % 2 == 0 {
                    b.corners()[random.below(8) as usize].as_dvec3()
                } else {
                    (min + (max - min) * (0.5 + 0.5 * random.vector())).min(max)
                };
                assert!(contains(&motion, t.at(time).point(x)), "{time} {x} {b:?} {motion:?} {t:?}");
                samples += 1;
            }
        }
    }
}

#[test]
fn a08_nested_motions_are_contained() {
    let mut random = Random(13);
    for _ in 0..200 {
        let levels = [0; 3].map(|_| random_animation(&mut random, 3));
        let b = bounds(random.vector(), random.vector().abs());
        let world = levels.iter().fold(b, |b, t| t.motion_bounds(&b));
        for _ in 0..50 {
            let (time, corner) = (random.between(-11.0, 30.0) as f32, b.corners()[random.below(8) as usize]);
            let p = levels.iter().fold(corner.as_dvec3(), |p, t| t.at(time).point(p));
            assert!(contains(&world, p));
        }
    }
}

#[test]
fn a11_a_shutter_sees_its_own_part() {
    let mut random = Random(14);
    let mut whole = 0.0;
    for _ in 0..500 {
        let t = random_animation(&mut random, 4);
        let b = bounds(random.vector() * 5.0, random.vector().abs() + 0.1);
        let [first, last] = [t.keyframes()[0].time, t.keyframes()[3].time];
        let [start, end] = [0; 2].map(|_| random.between(f64::from(first), f64::from(last)) as f32);
        let (start, end) = (start.min(end), start.max(end));
        let motion = t.motion_bounds_between(&b, start, end);
        assert_eq!(motion, t.motion_bounds_between(&b, end, start));
        for _ in 0..100 {
            let time = random.between(f64::from(start), f64::from(end)) as f32;
            assert!(b.corners().iter().all(|c| contains(&motion, t.at(time).point(c.as_dvec3()))));
        }
        let ratio = volume_ratio(&motion, sampled(&t, &b, start, end, 400));
        assert!(ratio <= 1.05, "{ratio} {start} {end} {t:?}");
        whole += volume_ratio(&t.motion_bounds(&b), sampled(&t, &b, start, end, 100)).ln() / 500.0;
        // At one time it is that transform's box.
        let (at, alone) = (t.motion_bounds_between(&b, start, start), t.at(start).bounds(&b));
        assert!((at.min - alone.min).abs().max((at.max - alone.max).abs()).max_element() < 1e-4);
        assert_eq!(t.motion_bounds_between(&b, f32::NAN, start), t.motion_bounds(&b));
        let before = t.motion_bounds_between(&b, first - 2.0, first - 1.0);
        assert_eq!(before, t.keyframes()[0].transform.bounds(&b));
    }
    assert!(whole.exp() > 1.5, "the whole range is larger: {}", whole.exp());
}

#[test]
fn volumes_are_near_the_smallest() {
    let mut random = Random(15);
    let mut worst = 1.0_f64;
    for i in 0..600 {
        let b = bounds(random.vector() * 10.0_f64.powf(random.between(-1.0, 2.0)), random.vector().abs() + 0.05);
        let axis = random.vector();
        let by = |degrees: f64| rotation(axis, degrees);
        let t = match i % 6 {
            0 => unit_time(by(0.0), by(random.between(0.01, 4.0))),
            1 => unit_time(by(10.0), by(random.between(10.0, 190.0))),
            2 => unit_time(by(0.0), chain(&[translation(1.0, 2.0, 3.0), by(30.0)])),
            3 => unit_time(by(0.0), chain(&[by(60.0), scale(1.0, 2.0, 0.5)])),
            4 => unit_time(scale(1.0, 1.0, 1.0), scale(0.1, 5.0, 2.0)),
            _ => random_animation(&mut random, 3),
        };
        let [first, last] = [t.keyframes()[0].time, t.keyframes()[t.keyframes().len() - 1].time];
        worst = worst.max(volume_ratio(&t.motion_bounds(&b), sampled(&t, &b, first, last, 500)));
    }
    assert!(worst <= 1.02, "{worst}");
}

#[test]
fn boxes_without_a_finite_extent() {
    let t = unit_time(rotation(DVec3::X, 1.0), rotation(DVec3::X, 50.0));
    assert!(t.motion_bounds(&Bounds3::EMPTY).is_empty());
    assert!(t.motion_bounds(&Bounds3::new(Vec3::NAN, Vec3::ONE)).is_empty());
    let half_space = Bounds3::new(Vec3::ZERO, Vec3::INFINITY);
    assert_eq!(t.motion_bounds(&half_space), Bounds3::new(Vec3::NEG_INFINITY, Vec3::INFINITY));
    let huge = Bounds3::new(Vec3::splat(-f32::MAX), Vec3::splat(f32::MAX));
    assert!(t.motion_bounds(&huge).contains(&huge));
}
