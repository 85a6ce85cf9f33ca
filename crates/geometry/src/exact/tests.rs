//! The tiers against each other: what a cheaper one is certain of, the exact one confirms. (Against an independent
//! oracle the whole is tested where meshes are.)

use std::cmp::Ordering;

use glam::{DVec3, Vec3};

use super::enclosure::{Enclosure, cmp_plane};
use super::rational::Line;
use super::sheared::Frame;
use super::{ExactRay, Tier, TierCounts, TierObserver, are_coplanar, intersect_triangle_exact};
use crate::{Bounds3, Interval, Ray, TraversalRay};

/// A small generator: the crate has no random numbers.
struct Random(u64);

impl Random {
    fn below(&mut self, n: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % n
    }

    /// In [−1, 1), with all the bits of f64.
    fn signed(&mut self) -> f64 {
        (self.below(1 << 31) as f64 * 2.0_f64.powi(-31) + self.below(1 << 31) as f64) * 2.0_f64.powi(-30) - 1.0
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.signed(), self.signed(), self.signed())
    }

    /// Any exponent of the range.
    fn wild(&mut self, low: i32, high: i32) -> DVec3 {
        let mut power = || 2.0_f64.powi(low + self.below((high - low) as u64) as i32);
        let powers = DVec3::new(power(), power(), power());
        self.vector() * powers
    }

    /// A ray of f64 and a triangle that are hard on each other, of ten kinds.
    fn case(&mut self, i: usize) -> (TraversalRay, [Vec3; 3]) {
        let mut v = [self.vector(), self.vector(), self.vector()];
        let mut o = 3.0 * self.vector();
        let s = 0.5 + 0.5 * self.signed();
        let lattice = |p: DVec3| (p * 4.0).round();
        let mut target = match i % 10 {
            0 => v[0] + 0.3 * (v[1] - v[0]) + 0.5 * s * (v[2] - v[0]),
            1 => v[0].lerp(v[1], s),
            2 => v[2],
            3 => {
                (v, o) = (v.map(lattice), lattice(o));
                [v[0], v[0].midpoint(v[1]), lattice(self.vector())][self.below(3) as usize]
            }
            4 => {
                v[2] = v[1].lerp(v[0], s);
                v[2]
            }
            5 => {
                v = [0; 3].map(|_| self.wild(-149, 60));
                o = self.wild(-149, 60);
                self.wild(-149, 60)
            }
            6 => {
                v = [0; 3].map(|_| self.wild(-149, 60));
                o = self.wild(-1000, 127);
                o + self.wild(-1000, 127)
            }
            7 => {
                v = v.map(|p| p + DVec3::splat(1e6));
                v[0].lerp(v[1], s)
            }
            8 => {
                v[2] = v[1] + 1e-7 * v[2];
                v[0].lerp(v[1], s)
            }
            _ => {
                // A plane seen nearly edge-on.
                v = v.map(|p| p.with_z(1e-6 * p.z));
                o.z = 1e-7 * self.signed();
                v[0].lerp(v[1], s)
            }
        };
        let vertices = v.map(|p| p.as_vec3());
        if !i.is_multiple_of(20) {
            // As f32 has it, so that vertices are really met.
            target = target.as_vec3().as_dvec3();
        }
        // Times the last, f32 holds 0 to 4 units of each component.
        let scales = [1.0, 2.0_f64.powi(40), 2.0_f64.powi(-90), 2.0_f64.powi(-149)];
        let direction = (target - o) * scales[self.below(scales.len() as u64) as usize];
        let ray = TraversalRay::from_f64(o, direction, 0.0);
        let other = || TraversalRay::new(&Ray::new([0.25; 3], [1.0, 0.5, -1.0])).expect("valid");
        (ray.unwrap_or_else(other), vertices)
    }
}

/// `count` of them, each with its line.
fn cases(count: usize) -> impl Iterator<Item = (usize, TraversalRay, Line, [Vec3; 3])> {
    let mut random = Random(7);
    (0..count).map(move |i| {
        let (ray, vertices) = random.case(i);
        (i, ray, Line { origin: ray.origin64(), direction: ray.direction64() }, vertices)
    })
}

#[test]
fn triangles_that_are_passed_by_are_not_met() {
    let mut counts = [0; 2];
    for (i, ray, line, vertices) in cases(60_000) {
        let is_passed_by = Frame::new(&ray).shear(&vertices).is_passed_by();
        assert!(!is_passed_by || !line.meets(&vertices), "{i} {ray:?} {vertices:?}");
        counts[usize::from(is_passed_by)] += 1;
    }
    assert!(counts.into_iter().all(|count| count > 5_000), "{counts:?}");
    // From far away everything else is in doubt.
    let mut random = Random(9);
    let mut tiers = TierCounts::default();
    for exponent in [30, 60, 90, 120] {
        for _ in 0..1_000 {
            let [v0, v1, v2] = [0; 3].map(|_| random.vector().as_vec3());
            let origin = (random.vector() * 2.0_f64.powi(exponent)).as_vec3();
            let Some(ray) = TraversalRay::new(&Ray::new(origin, random.vector().as_vec3())) else { continue };
            let hit = ExactRay::unfiltered(&ray).intersect_triangle(&[v0, v1, v2], Interval::FULL, &mut tiers);
            assert!(hit.is_none());
        }
    }
    assert_eq!((tiers.filter, tiers.exact), (0, 0), "{tiers:?}");
}

#[test]
fn edge_functions_are_within_their_bounds() {
    let mut certain = [0; 2];
    for (i, ray, line, vertices) in cases(60_000) {
        let frame = Frame::new(&ray);
        let sheared = frame.shear(&vertices);
        let [low, high] = sheared.edge_range();
        let of_ray = frame.edge_error(&Bounds3::from_points(vertices));
        let of_triangle = sheared.edge_error();
        for (tier, error) in [of_ray, of_triangle].into_iter().enumerate() {
            let is_hit = if low < -error && high > error {
                false
            } else if low > error || high < -error {
                true
            } else {
                continue;
            };
            certain[tier] += 1;
            assert_eq!(line.meets(&vertices), is_hit, "{i}: {line:?} {vertices:?}");
        }
    }
    assert!(certain[0] > 10_000 && certain[1] > certain[0] + 2_000, "{certain:?}");
}

/// Also for a `t` an f32 away from where the plane is met.
#[test]
fn planes_are_met_where_they_are_said_to_be() {
    let mut certain = [0, 0];
    for (i, ray, line, vertices) in cases(60_000) {
        if !line.meets(&vertices) {
            continue;
        }
        let near = Enclosure::exactly(&line, &vertices).low as f32;
        for t in [0.0, near.next_down(), near, near.next_up(), 2.0 * near].into_iter().filter(|t| t.is_finite()) {
            if let Some(order) = cmp_plane(&ray, &vertices, t) {
                assert_eq!(line.cmp_t(&vertices, t.into()), order, "{i}: {line:?} {vertices:?} {t}");
                certain[usize::from(order.is_gt())] += 1;
            }
        }
    }
    assert!(certain.iter().all(|&certain| certain > 10_000), "{certain:?}");
}

#[test]
fn enclosures_enclose_and_agree() {
    let (mut certain, mut width) = (0, 0.0_f64);
    for (i, _, line, vertices) in cases(60_000) {
        if !line.meets(&vertices) {
            continue;
        }
        let exactly = Enclosure::exactly(&line, &vertices);
        for enclosure in [Enclosure::of_plane(&line, &vertices), Some(exactly)].into_iter().flatten() {
            let is_in = |e: &Enclosure| {
                (e.low.is_infinite() || line.cmp_t(&vertices, e.low).is_ge())
                    && (e.high.is_infinite() || line.cmp_t(&vertices, e.high).is_le())
            };
            assert!(is_in(&enclosure), "{i}: {line:?} {vertices:?} {enclosure:?}");
            certain += 1;
        }
        if exactly.high.is_finite() && exactly.low > 1e-290 {
            width = width.max((exactly.high - exactly.low) / exactly.low);
        }
        // Half of it is not around it any more: t* is not.
        if let Some(e) = Enclosure::of_plane(&line, &vertices).filter(|e| e.low > 0.0 && e.high.is_finite()) {
            assert_eq!(line.cmp_t(&vertices, 0.5 * e.low), Ordering::Greater);
            assert_eq!(line.cmp_t(&vertices, 2.0 * e.high), Ordering::Less);
        }
    }
    assert!(certain > 20_000 && width < 5e-15, "{certain} {width}");
}

/// u and v within 2⁻²³, t the nearest f32.
#[test]
fn values_are_close() {
    let (mut exact, mut count) = ([0; 10], [0; 10]);
    for (i, ray, line, vertices) in cases(60_000) {
        let Some(hit) = intersect_triangle_exact(&ray, &vertices, Interval::FULL) else { continue };
        let b = line.approximate(&vertices).b;
        for (value, b) in [hit.u, hit.v].into_iter().zip(b) {
            assert!((f64::from(value) - b).abs() <= 2.0_f64.powi(-23), "{i}: {hit:?} {b:?}");
            assert!((0.0..=1.0).contains(&value) && value.is_sign_positive());
        }
        let middle = |x: f32, y: f32| 0.5 * (f64::from(x) + f64::from(y));
        let (below, above) = (middle(hit.t.next_down(), hit.t), middle(hit.t, hit.t.next_up().min(f32::MAX)));
        assert!(line.cmp_t(&vertices, below).is_ge(), "{i}: {ray:?} {vertices:?}");
        assert!(line.cmp_t(&vertices, above).is_le() || hit.t == f32::MAX, "{i}: {ray:?} {vertices:?}");
        let mut counts = TierCounts::default();
        let exact_ray = ExactRay::new(&ray, &Bounds3::from_points(vertices));
        let enclosure = exact_ray.intersect_triangle(&vertices, Interval::FULL, &mut ()).expect("it was hit");
        let _ = exact_ray.values(&vertices, &enclosure, &mut counts);
        exact[i % 10] += counts.exact;
        count[i % 10] += 1;
    }
    assert!(count.iter().all(|&n| n > 300) && exact[..4] == [0; 4] && exact[7] < count[7] / 2, "{count:?} {exact:?}");
}

/// t* is halfway between two f32: the even one is t.
#[test]
fn ties_round_to_even() {
    for (height, t) in [(16_777_216.0, 16_777_216.0), (16_777_218.0, 16_777_220.0)] {
        let triangle = [Vec3::new(0.0, 0.0, -1.0), Vec3::new(4.0, 0.0, -1.0), Vec3::new(0.0, 4.0, -1.0)];
        for (direction, scale) in [(-1.0, 1.0), (-0.125, 8.0)] {
            let ray = TraversalRay::new(&Ray::new([0.5, 1.5, height], [0.0, 0.0, direction])).expect("valid");
            let hit = intersect_triangle_exact(&ray, &triangle, Interval::FULL).expect("it is below");
            assert_eq!((hit.t, hit.u, hit.v), (scale * t, 0.125, 0.375));
        }
    }
}

/// The order of two hits, by all tiers, is that of their t* against whatever separates them.
#[test]
fn hits_are_ordered() {
    let mut random = Random(3);
    let mut counts = TierCounts::default();
    let mut orders = [0; 3];
    for i in 0..20_000 {
        let (ray, a) = random.case(10 * i + i % 4);
        let ulp = |x: f32, random: &mut Random| [x, x.next_up(), x.next_down()][random.below(3) as usize];
        let b = a.map(|p| Vec3::new(ulp(p.x, &mut random), ulp(p.y, &mut random), ulp(p.z, &mut random)));
        let exact = ExactRay::new(&ray, &Bounds3::from_points(a.into_iter().chain(b)));
        let hit = |v| exact.intersect_triangle(v, Interval::FULL, &mut ());
        let (Some(x), Some(y)) = (hit(&a), hit(&b)) else { continue };
        let order = exact.compare((&x, &a), (&y, &b), &mut counts);
        orders[(order as i8 + 1) as usize] += 1;
        assert_eq!(exact.compare((&y, &b), (&x, &a), &mut ()), order.reverse());
        assert_eq!(exact.line().cmp_hits(&a, &b), order);
        assert_eq!(exact.compare((&x, &a), (&x, &a), &mut ()), Ordering::Equal);
        let (t, s) = (exact.values(&a, &x, &mut ()).t, exact.values(&b, &y, &mut ()).t);
        assert!(t.total_cmp(&s) == order || t == s);
    }
    assert!(orders.iter().all(|&n| n > 50), "{orders:?}");
    assert!(counts.certificate > 1_000 && counts.exact > 100, "{counts:?}");
}

/// Powers of two change no sign and no order, though they change which integers are used.
#[test]
fn the_largest_integers_decide_as_the_smallest_do() {
    let mut random = Random(5);
    let (mut hits, mut misses) = (0, 0);
    for i in 0..600 {
        let (ray, vertices) = random.case(10 * i + 3);
        let line = Line { origin: ray.origin64(), direction: ray.direction64() };
        let hit = line.meets(&vertices);
        for (place, direction) in [(30, 0), (-100, 60), (-140, -900), (50, 120)] {
            let (p, d) = (2.0_f64.powi(place), 2.0_f64.powi(direction) / 2.0_f64.powi(20));
            // A component far below the others makes the grid as fine as can be.
            let mut fine = Line { origin: line.origin * p, direction: line.direction * d };
            let scaled = vertices.map(|v| (v.as_dvec3() * p).as_vec3());
            assert_eq!(fine.meets(&scaled), hit);
            if hit {
                let t = p / d;
                hits += 1;
                for x in [0.5, 1.0, 1.5] {
                    assert_eq!(fine.cmp_t(&scaled, x * t), line.cmp_t(&vertices, x));
                }
                assert_eq!(fine.cmp_hits(&scaled, &scaled), Ordering::Equal);
                // Strictly inside, and not at a decision: nothing changes by next to nothing.
                let inside = line.approximate(&vertices).b.into_iter().all(|b| b > 0.01 && b < 0.49);
                if inside && fine.origin.x == 0.0 {
                    fine.origin.x = f64::from_bits(1);
                    assert!(fine.meets(&scaled));
                    assert_eq!(fine.cmp_hits(&scaled, &scaled), Ordering::Equal);
                    assert_eq!(fine.cmp_t(&scaled, 0.0), line.cmp_t(&vertices, 0.0));
                }
            } else {
                misses += 1;
            }
        }
    }
    assert!(hits > 100 && misses > 100, "{hits} {misses}");
}

#[test]
fn each_tier_is_asked_in_turn() {
    let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let tier = |x: f32, y: f32, bounds: f32| {
        struct Last(Option<Tier>);
        impl TierObserver for Last {
            fn decided(&mut self, tier: Tier) {
                assert!(self.0.replace(tier).is_none(), "told once");
            }
        }
        let ray = TraversalRay::new(&Ray::new([x, y, 1.0], [0.25, 0.125, -1.0])).expect("valid");
        let exact = ExactRay::new(&ray, &Bounds3::new(Vec3::splat(-bounds), Vec3::splat(bounds)));
        let mut last = Last(None);
        let hit = exact.intersect_triangle(&triangle, Interval::FULL, &mut last);
        (hit.is_some(), last.0.expect("told"))
    };
    assert_eq!(tier(3.0, 3.0, 1.0), (false, Tier::Filter));
    assert_eq!(tier(3.0, 3.0, 1e12), (false, Tier::Certificate));
    assert_eq!(tier(0.0, 0.0, 1.0), (true, Tier::Certificate));
    assert_eq!(tier(-0.25, -0.125, 1.0), (true, Tier::Exact));
    assert!(!tier((-0.25_f32).next_down(), -0.125, 1.0).0);
}

#[test]
fn what_is_no_triangle_is_not_hit() {
    let ray = TraversalRay::new(&Ray::new([0.25, 0.25, 1.0], [0.0, 0.0, -1.0])).expect("valid");
    let hit = |v: [Vec3; 3]| intersect_triangle_exact(&ray, &v, Interval::FULL);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX] {
        assert!(hit([Vec3::ZERO, Vec3::X, Vec3::new(0.0, bad, 0.0)]).is_none());
    }
    assert!(hit([Vec3::ZERO, Vec3::ONE, Vec3::ONE]).is_none());
    assert!(hit([Vec3::new(0.25, 0.0, -1.0), Vec3::new(0.25, 0.0, 1.0), Vec3::new(0.25, 1.0, 0.0)]).is_none());
    assert!(hit([Vec3::ZERO, Vec3::X, Vec3::Y]).is_some());
    let t = |interval| intersect_triangle_exact(&ray, &[Vec3::ZERO, Vec3::X, Vec3::Y], interval).map(|h| h.t);
    assert_eq!([t(Interval::up_to(1.0)), t(Interval::new(1.0, 2.0)), t(Interval::EMPTY)], [None; 3]);
    assert_eq!(t(Interval::new(1.0_f32.next_down(), 1.0_f32.next_up())), Some(1.0));
}

/// Ties that are seen without arithmetic are those that exact numbers find, and nearly equal ones are not taken for
/// ties.
#[test]
fn coplanar_triangles_are_hit_at_the_same_parameter() {
    let floor = [Vec3::new(-1.0, 0.25, -1.0), Vec3::new(2.0, 0.25, -1.0), Vec3::new(-1.0, 0.25, 2.0)];
    let tile = [Vec3::new(-0.5, 0.25, -0.7), Vec3::new(0.9, 0.25, -0.5), Vec3::new(-0.3, 0.25, 1.1)];
    let slanted = [Vec3::new(-1.0, 0.3, -1.0), Vec3::new(2.0, 0.1, -1.0), Vec3::new(-1.0, 0.2, 2.0)];
    let turned = [slanted[2], slanted[0], slanted[1]];
    let mut above = tile;
    above[1].y = above[1].y.next_up();
    let ray = TraversalRay::new(&Ray::new([0.03, 3.0, 0.01], [0.013, -1.0, 0.007])).unwrap();
    let exact = ExactRay::new(&ray, &Bounds3::from_points([floor, tile, slanted, above].concat()));
    let hit = |v: &[Vec3; 3]| exact.intersect_triangle(v, Interval::FULL, &mut ()).unwrap();
    for (a, b, is_coplanar) in
        [(floor, tile, true), (slanted, turned, true), (slanted, floor, false), (floor, above, false)]
    {
        assert_eq!(are_coplanar(&a, &b), is_coplanar);
        assert_eq!(are_coplanar(&b, &a), is_coplanar);
        let order = exact.compare((&hit(&a), &a), (&hit(&b), &b), &mut ());
        assert_eq!(order, exact.line().cmp_hits(&a, &b), "{a:?} {b:?}");
        assert_eq!(order.is_eq(), is_coplanar);
    }
}
