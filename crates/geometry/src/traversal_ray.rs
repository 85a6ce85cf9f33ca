//! A valid ray with what box and triangle tests need of it, computed once.

use glam::{DVec3, DVec4, Vec3, Vec4};

use crate::{Bounds3, Interval, Ray};

/// A valid [`Ray`] prepared for traversal. Its existence proves that origin, direction and time are finite and that the
/// direction is not zero: whoever has one need not ask again, and an invalid ray visits no node.
///
/// Origin and direction are also kept in f64: a ray that went into an instance's object space was transformed in f64
/// and rounded to f32 once, for the f32 tests.
///
/// Vectors have a fourth component, so that any axis number below four is in range.
///
/// Kept in the order written, in which the two vectors of reciprocals are no neighbours: the compiler would read those
/// as one vector right after they were written as two, and such a load waits until they have left the store queue.
/// (Rejected: f64 only where it differs. The branch that hits then need costs random rays 3 %.)
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct TraversalRay {
    /// The fourth is the time.
    origin: Vec4,
    /// Of the direction, shrunk towards zero and finite: for the planes through which the ray enters.
    near_reciprocals: Vec4,
    direction: Vec4,
    /// Widened, and infinite for a zero component: for the planes through which the ray leaves.
    far_reciprocals: Vec4,
    shear: Shear,
    origin64: DVec4,
    direction64: DVec4,
    is_rounded: bool,
    is_regular: bool,
}

/// Woop, Benthin and Wald 2013, *Watertight Ray/Triangle Intersection*, JCGT 2(1): the axes kx, ky, kz with kz that of
/// the largest direction component, and the shear (Sx, Sy) that makes the ray the kz axis. kx and ky are not exchanged
/// for a negative direction, since both windings are hit.
///
/// The largest component is that of the f64 direction, and of the f32 one too, as rounding keeps the order. The other
/// way round would not do: of a direction near 2⁻¹⁴⁹ f32 may hold one number for components of which one is three times
/// the other.
#[derive(Clone, Copy, Debug)]
pub struct Shear {
    /// The axis that x is taken from.
    pub kx: usize,
    /// The axis that y is taken from.
    pub ky: usize,
    /// The axis of the largest component of the direction.
    pub kz: usize,
    /// d_kx / d_kz, rounded.
    pub sx: f32,
    /// d_ky / d_kz, rounded.
    pub sy: f32,
    /// 1 / d_kz, rounded; infinite where that is beyond f32.
    pub rdz: f32,
}

impl TraversalRay {
    /// How far the reciprocals of the box test are widened: 6 ulp, 6 · 2⁻²³ relative.
    ///
    /// The box test has at most 4 roundings a plane (subtraction, reciprocal, widening, product): 4 u with u = 2⁻²⁴. A
    /// sheared vertex of the triangle test is displaced sideways by at most about 5 u of its distance. 9 u < 12 u = 6
    /// ulp. The padding sits in the reciprocals, so it costs nothing per node (Ize 2013, *Robust BVH Ray Traversal*,
    /// JCGT 2(2)).
    pub const PADDING: f32 = 6.0 * f32::EPSILON;

    /// 2⁶⁰: what no number of a [regular](Self::is_regular) ray is beyond, nor a reciprocal of its direction.
    pub const LARGEST_OF_REGULAR: f32 = (1_u64 << 60) as f32;

    /// Prepares a ray; `None` where a component of origin or direction or the time is not finite, or the direction is
    /// zero.
    #[inline]
    pub fn new(ray: &Ray) -> Option<Self> {
        let (o, d) = (ray.origin.extend(ray.time), ray.direction.extend(1.0));
        let shear = Shear::new(d, largest_component(d.abs().to_array()));
        Self::prepare([o, d], [o.as_dvec4(), d.as_dvec4()], shear, false)
    }

    /// Prepares a ray that is known in f64, rounding it to f32 once; `None` as for [`new`](Self::new), with the rounded
    /// components.
    pub fn from_f64(origin64: DVec3, direction64: DVec3, time: f32) -> Option<Self> {
        let (o64, d64) = (origin64.extend(time.into()), direction64.extend(1.0));
        let (o, d) = (o64.as_vec4(), d64.as_vec4());
        let is_rounded = o64 != o.as_dvec4() || d64 != d.as_dvec4();
        let shear = Shear::new(d, largest_component(d64.abs().to_array()));
        Self::prepare([o, d], [o64, d64], shear, is_rounded)
    }

    #[inline]
    fn prepare(
        [origin, direction]: [Vec4; 2],
        [origin64, direction64]: [DVec4; 2],
        shear: Shear,
        is_rounded: bool,
    ) -> Option<Self> {
        let reciprocal = direction.recip();
        let mut near_reciprocals = reciprocal * (1.0 - Self::PADDING);
        let far_reciprocals = reciprocal * (1.0 + Self::PADDING);
        let is_below = |v: Vec4| v.abs().cmple(Vec4::splat(Self::LARGEST_OF_REGULAR));
        let is_regular = (is_below(origin) & is_below(direction) & is_below(far_reciprocals)).all();
        if !is_regular {
            if !is_valid(origin, direction) {
                return None;
            }
            // The near reciprocal of a zero (or denormal) component must stay finite: it then never over-estimates the
            // entry, where an infinite one would turn an origin in the plane into NaN.
            near_reciprocals = near_reciprocals.min(Vec4::splat(f32::MAX)).max(Vec4::splat(-f32::MAX));
        }
        Some(Self {
            origin,
            near_reciprocals,
            direction,
            far_reciprocals,
            shear,
            origin64,
            direction64,
            is_rounded,
            is_regular,
        })
    }

    /// The ray in f32.
    #[inline]
    pub fn ray(&self) -> Ray {
        Ray { origin: self.origin.truncate(), direction: self.direction.truncate(), time: self.origin.w }
    }

    /// The origin in f64; exactly the f32 origin unless the ray was transformed.
    #[inline]
    pub fn origin64(&self) -> DVec3 {
        self.origin64.truncate()
    }

    /// The direction in f64; exactly the f32 direction unless the ray was transformed.
    #[inline]
    pub fn direction64(&self) -> DVec3 {
        self.direction64.truncate()
    }

    /// The time of the ray.
    #[inline]
    pub fn time(&self) -> f32 {
        self.origin.w
    }

    /// The origin, and the time.
    #[inline]
    pub fn origin_and_time(&self) -> Vec4 {
        self.origin
    }

    /// The direction, and 1.
    #[inline]
    pub fn direction_and_one(&self) -> Vec4 {
        self.direction
    }

    /// Whether the f32 ray is not exactly the f64 one: it was transformed.
    #[inline]
    pub fn is_rounded(&self) -> bool {
        self.is_rounded
    }

    /// Whether no component of the direction is zero, denormal or enormous, and neither the origin nor the time is far
    /// outside of the domain: products of any two of its numbers, and of one with a coordinate, are far from the ends of
    /// f32.
    #[inline]
    pub fn is_regular(&self) -> bool {
        self.is_regular
    }

    /// The reciprocals of the direction, and then a number near 1, twice: for the planes through which the ray enters a
    /// box, smaller in size by 6 ulp and finite; for those through which it leaves, larger by 6 ulp, and infinite for a
    /// component of zero.
    #[inline]
    pub fn reciprocals(&self) -> [Vec4; 2] {
        [self.near_reciprocals, self.far_reciprocals]
    }

    /// The shear that makes the ray an axis.
    #[inline]
    pub fn shear(&self) -> &Shear {
        &self.shear
    }

    /// Origin and direction in f64 in the order of the shear: kx, ky, kz.
    #[inline(always)]
    pub(crate) fn permuted64(&self) -> [[f64; 3]; 2] {
        let Shear { kx, ky, kz, .. } = self.shear;
        let (o, d): (&[f64; 4], &[f64; 4]) = (self.origin64.as_ref(), self.direction64.as_ref());
        [[o[kx & 3], o[ky & 3], o[kz & 3]], [d[kx & 3], d[ky & 3], d[kz & 3]]]
    }

    /// The reciprocals of the direction, without padding: for the naive kernels only.
    pub(crate) fn reciprocal(&self) -> Vec3 {
        self.direction.truncate().recip()
    }

    /// For each axis, whether the ray runs towards smaller coordinates: the sign bit of the direction, so that −0.0 is
    /// as consistent as any other value.
    #[inline]
    pub fn direction_is_negative(&self) -> [bool; 3] {
        let signs = self.direction.is_negative_bitmask();
        [signs & 1 != 0, signs & 2 != 0, signs & 4 != 0]
    }

    /// Where the ray enters `bounds` within `interval`, or `None` where it passes by.
    ///
    /// Never `None` for a box that the exact ray meets within the closed interval, and never a larger entry for a box
    /// than for one inside of it: rounding is monotone, and both widen in the same way. The entry is at least `t_min`
    /// and at most the exact one, that of the f64 ray where it [is rounded](Self::is_rounded). Zero, −0.0 and denormal
    /// components need no case of their own: a plane that gives NaN (0 · ∞: the origin lies in the plane, the ray runs
    /// along it) does not bound the ray.
    #[inline]
    pub fn enter(&self, bounds: &Bounds3, interval: Interval) -> Option<f32> {
        if self.is_rounded { self.enter_f32(&self.grown(bounds), interval) } else { self.enter_f32(bounds, interval) }
    }

    /// The box with room for what was rounded off a ray of f64.
    ///
    /// It grows by more than the origin moved. The direction is wrong by one rounding, u relatively, and the padding of
    /// 12 u has room for it beside its own 4 u. Near 2¹²⁷ its own are 10 u, since reciprocals are denormal; near 2⁻¹²⁷
    /// the direction is, and wrong by 4 u. Smaller components have no finite reciprocal: f32::MAX, which is less,
    /// stands for it where the ray enters, and nothing bounds it where it leaves.
    fn grown(&self, bounds: &Bounds3) -> Bounds3 {
        let o = self.origin.truncate();
        // u |o| is how far the origin moved, u (|b| + w) how far the new plane is rounded: 4u and more are for each. An
        // empty box, whose planes are infinite, stays one.
        let width = |b: Vec3| {
            let width = (o.abs() + b.abs()) * (2.0 * f32::EPSILON) + Vec3::splat(f32::MIN_POSITIVE);
            width.min(Vec3::splat(f32::MAX))
        };
        Bounds3::new(bounds.min - width(bounds.min), bounds.max + width(bounds.max))
    }

    #[inline(always)]
    fn enter_f32(&self, bounds: &Bounds3, interval: Interval) -> Option<f32> {
        let mut entry = interval.t_min();
        let mut exit = interval.t_max().min(f32::MAX);
        for i in 0..3 {
            let (near_plane, far_plane) = if self.direction[i].is_sign_negative() {
                (bounds.max[i], bounds.min[i])
            } else {
                (bounds.min[i], bounds.max[i])
            };
            let near = (near_plane - self.origin[i]) * self.near_reciprocals[i];
            let far = (far_plane - self.origin[i]) * self.far_reciprocals[i];
            // The comparison fails for NaN, which then bounds nothing.
            entry = if near > entry { near } else { entry };
            exit = if far < exit { far } else { exit };
        }
        (entry <= exit).then_some(entry)
    }
}

/// Whether everything is finite and the direction, of which the fourth component is 1, is not zero.
#[inline]
fn is_valid(origin: Vec4, direction: Vec4) -> bool {
    origin.is_finite() && direction.is_finite() && direction != Vec4::W
}

/// The axis of the largest of the first three numbers. Without branches, which random directions would make the
/// processor guess wrong.
#[inline]
fn largest_component<T: PartialOrd>([x, y, z, _]: [T; 4]) -> usize {
    let of_xy = if y > x { (y, 1) } else { (x, 0) };
    if z > of_xy.0 { 2 } else { of_xy.1 }
}

impl Shear {
    #[inline]
    fn new(direction: Vec4, kz: usize) -> Self {
        // The axes after kz, two bits for each kz.
        let (kx, ky) = (0b00_10_01 >> (2 * kz) & 3, 0b01_00_10 >> (2 * kz) & 3);
        let d = direction.to_array();
        Self { kx, ky, kz, sx: d[kx] / d[kz], sy: d[ky] / d[kz], rdz: 1.0 / d[kz] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(o: [f32; 3], d: [f32; 3]) -> TraversalRay {
        TraversalRay::new(&Ray::new(o, d)).expect("valid")
    }

    #[test]
    fn invalid_rays_do_not_exist() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for i in 0..7 {
                let mut c = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
                c[i] = bad;
                let r = Ray::new([c[0], c[1], c[2]], [c[3], c[4], c[5]]).at_time(c[6]);
                assert!(TraversalRay::new(&r).is_none(), "{r:?}");
            }
        }
        for zero in [0.0, -0.0] {
            assert!(TraversalRay::new(&Ray::new([0.0; 3], [zero; 3])).is_none());
        }
        assert!(TraversalRay::new(&Ray::new([0.0; 3], [1e-45, 0.0, 0.0])).is_some());
    }

    #[test]
    fn regular_rays_have_numbers_between_the_limits() {
        let limit = TraversalRay::LARGEST_OF_REGULAR;
        let is_regular = |x: f32, time: f32| {
            let prepare = |o, d| TraversalRay::new(&Ray::new(o, d).at_time(time)).expect("valid").is_regular();
            [prepare([0.0, x, 0.0], [1.0; 3]), prepare([0.0; 3], [1.0, 1.0, x])]
        };
        assert_eq!(is_regular(-limit, 0.0), [true; 2]);
        assert_eq!(is_regular(limit.next_up(), 0.0), [false; 2]);
        // The reciprocal of the second is widened beyond the limit.
        assert_eq!(is_regular(1.0 / limit * (1.0 + 2.0 * TraversalRay::PADDING), limit), [true; 2]);
        assert_eq!(is_regular(1.0 / limit, limit), [true, false]);
        for zero in [0.0, -0.0, f32::from_bits(1)] {
            assert_eq!(is_regular(zero, 0.0), [true, false]);
        }
        assert_eq!(is_regular(1.0, limit.next_up()), [false; 2]);
    }

    #[test]
    fn the_largest_component_is_that_of_the_f64_direction() {
        let unit = f64::from(f32::from_bits(1));
        let direction = DVec3::new(-0.6, 1.4, 1.2) * unit;
        let ray = TraversalRay::from_f64(DVec3::ZERO, direction, 0.0).expect("rounds to (−1, 1, 1) units");
        assert!(ray.is_rounded() && ray.ray().direction.abs() == Vec3::splat(unit as f32));
        let &Shear { kx, ky, kz, sx, sy, .. } = ray.shear();
        assert_eq!((kx, ky, kz, sx, sy), (2, 0, 1, 1.0, -1.0));
    }

    /// Origin on every face, edge and corner, zero components of either sign (S01, S02): the closed box is met.
    #[test]
    fn rays_in_the_faces_meet_the_closed_box() {
        let unit = Bounds3::new(Vec3::ZERO, Vec3::ONE);
        let values = [0.0_f32, 0.5, 1.0];
        for axis in 0..3 {
            for a in values {
                for b in values {
                    for zero in [0.0_f32, -0.0] {
                        for sign in [1.0_f32, -1.0] {
                            let mut o = [a, b, 0.0];
                            let mut d = [zero, zero, sign];
                            o[2] = if sign > 0.0 { -2.0 } else { 3.0 };
                            o.rotate_right(axis);
                            d.rotate_right(axis);
                            let entry = ray(o, d).enter(&unit, Interval::FULL).expect("meets the box");
                            assert!((entry - 2.0).abs() < 1e-5);
                            o[axis] = 1.5;
                            assert!(ray(o, d).enter(&unit, Interval::FULL).is_none(), "{o:?} {d:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn empty_boxes_are_never_entered() {
        for d in [[1.0, 0.0, 0.0], [0.3, -0.4, 0.5], [-0.0, 0.0, -1.0]] {
            assert!(ray([0.0; 3], d).enter(&Bounds3::EMPTY, Interval::FULL).is_none());
            let direction = Vec3::from(d).as_dvec3();
            let rounded = TraversalRay::from_f64(DVec3::splat(0.1), direction, 0.0).expect("a valid ray");
            assert!(rounded.is_rounded() && rounded.enter(&Bounds3::EMPTY, Interval::FULL).is_none());
        }
    }

    /// The smallest boxes around points of a ray of f64, near its origin and far: all are met, and not too late.
    #[test]
    fn what_was_rounded_off_a_ray_loses_no_box() {
        let mut lost_in_f32 = 0;
        for i in 1..2000 {
            let number = |k: i32| (f64::from(i) * 0.618_033_988_75 * f64::from(k)).fract() - 0.5;
            let origin = DVec3::new(number(1), number(3), number(7)) * 40.0;
            let direction = DVec3::new(number(2), number(5), number(11)) * 3.0;
            let ray = TraversalRay::from_f64(origin, direction, 0.0).expect("a valid ray");
            for t in [0.0, 1e-6, 1e-3, 0.1, 10.0] {
                let p = origin + t * direction;
                let low = Vec3::from_array(p.to_array().map(crate::round_down));
                let high = Vec3::from_array(p.to_array().map(crate::round_up));
                let point = Bounds3::new(low, high);
                let entry = ray.enter(&point, Interval::FULL);
                assert!(entry.is_some_and(|entry| f64::from(entry) <= t), "{entry:?} {t} {ray:?}");
                lost_in_f32 += usize::from(ray.enter_f32(&point, Interval::FULL).is_none_or(|e| f64::from(e) > t));
            }
        }
        assert!(lost_in_f32 > 1000, "{lost_in_f32}");
    }

    #[test]
    fn a_box_behind_or_beyond_is_not_entered() {
        let b = Bounds3::new(Vec3::new(2.0, -1.0, -1.0), Vec3::new(3.0, 1.0, 1.0));
        assert!(ray([0.0; 3], [1.0, 0.1, 0.0]).enter(&b, Interval::FULL).is_some());
        assert!(ray([0.0; 3], [-1.0, 0.1, 0.0]).enter(&b, Interval::FULL).is_none());
        assert!(ray([0.0; 3], [1.0, 0.1, 0.0]).enter(&b, Interval::up_to(1.9)).is_none());
        assert!(ray([0.0; 3], [1.0, 0.1, 0.0]).enter(&b, Interval::new(3.5, 9.0)).is_none());
    }
}
