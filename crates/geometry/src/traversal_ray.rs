//! A valid ray with what box and triangle tests need of it, computed once.

use glam::{DVec3, Vec3, Vec4};

use crate::{Bounds3, Interval, Ray};

/// How far the reciprocals of the box test are widened: 6 ulp, 6 · 2⁻²³ relative.
///
/// The box test has at most 4 roundings a plane (subtraction, reciprocal, widening, product): 4 u with u = 2⁻²⁴. A
/// sheared vertex of the triangle test is displaced sideways by at most about 5 u of its distance. 9 u < 12 u = 6 ulp.
/// The padding sits in the reciprocals, so it costs nothing per node (Ize 2013, *Robust BVH Ray Traversal*, JCGT 2(2)).
const PADDING: f32 = 6.0 * f32::EPSILON;

/// A valid [`Ray`] prepared for traversal. Its existence proves that origin, direction and time are finite and that the
/// direction is not zero: whoever has one need not ask again, and an invalid ray visits no node.
///
/// Origin and direction are also kept in f64: a ray that went into an instance's object space was transformed in f64
/// and rounded to f32 once, for the f32 tests.
#[derive(Clone, Copy, Debug)]
pub struct TraversalRay {
    ray: Ray,
    origin64: DVec3,
    direction64: DVec3,
    /// Reciprocals of the direction, shrunk towards zero and finite: for the planes through which the ray enters.
    reciprocal_near: Vec4,
    /// Reciprocals of the direction, widened; infinite for a zero component: for the planes through which it leaves.
    reciprocal_far: Vec4,
    pub(crate) shear: Shear,
    is_rounded: bool,
}

/// Woop, Benthin and Wald 2013, *Watertight Ray/Triangle Intersection*, JCGT 2(1): the axes kx, ky, kz with kz that of the
/// largest direction component, and the shear (Sx, Sy) that makes the ray the kz axis. kx and ky are not exchanged for a
/// negative direction, since both windings are hit.
#[derive(Clone, Copy, Debug)]
pub struct Shear {
    /// The axis that x is taken from.
    pub kx: usize,
    /// The axis that y is taken from.
    pub ky: usize,
    /// The axis of the largest component of the direction.
    pub kz: usize,
    /// d[kx] / d[kz], rounded.
    pub sx: f32,
    /// d[ky] / d[kz], rounded.
    pub sy: f32,
}

impl TraversalRay {
    /// Prepares a ray; `None` where a component of origin or direction or the time is not finite, or the direction is
    /// zero.
    #[inline]
    pub fn new(ray: &Ray) -> Option<Self> {
        is_valid(ray).then(|| Self::prepare(*ray, ray.origin.as_dvec3(), ray.direction.as_dvec3(), false))
    }

    /// Prepares a ray that is known in f64, rounding it to f32 once; `None` as for [`new`](Self::new), with the rounded
    /// components.
    pub fn from_f64(origin64: DVec3, direction64: DVec3, time: f32) -> Option<Self> {
        let ray = Ray { origin: origin64.as_vec3(), direction: direction64.as_vec3(), time };
        let is_rounded = origin64 != ray.origin.as_dvec3() || direction64 != ray.direction.as_dvec3();
        is_valid(&ray).then(|| Self::prepare(ray, origin64, direction64, is_rounded))
    }

    #[inline]
    fn prepare(ray: Ray, origin64: DVec3, direction64: DVec3, is_rounded: bool) -> Self {
        let reciprocal = ray.direction.extend(1.0).recip();
        // The near reciprocal of a zero (or denormal) component must stay finite: it then never over-estimates the
        // entry, where an infinite one would turn an origin in the plane into NaN.
        let near = (reciprocal * (1.0 - PADDING)).min(Vec4::splat(f32::MAX)).max(Vec4::splat(-f32::MAX));
        Self {
            ray,
            origin64,
            direction64,
            reciprocal_near: near,
            reciprocal_far: reciprocal * (1.0 + PADDING),
            shear: Shear::new(ray.direction),
            is_rounded,
        }
    }

    /// The ray in f32.
    pub fn ray(&self) -> &Ray {
        &self.ray
    }

    /// The origin in f64; exactly the f32 origin unless the ray was transformed.
    pub fn origin64(&self) -> DVec3 {
        self.origin64
    }

    /// The direction in f64; exactly the f32 direction unless the ray was transformed.
    pub fn direction64(&self) -> DVec3 {
        self.direction64
    }

    /// Whether the f32 ray is not exactly the f64 one: it was transformed.
    #[inline]
    pub fn is_rounded(&self) -> bool {
        self.is_rounded
    }

    /// The reciprocals of the direction for the planes through which the ray enters a box: smaller in size by 6 ulp, and
    /// finite.
    #[inline]
    pub fn reciprocal_near(&self) -> Vec3 {
        self.reciprocal_near.truncate()
    }

    /// The reciprocals of the direction for the planes through which the ray leaves a box: larger in size by 6 ulp, and
    /// infinite for a component of zero.
    #[inline]
    pub fn reciprocal_far(&self) -> Vec3 {
        self.reciprocal_far.truncate()
    }

    /// The shear that makes the ray an axis.
    #[inline]
    pub fn shear(&self) -> Shear {
        self.shear
    }

    /// The time of the ray.
    pub fn time(&self) -> f32 {
        self.ray.time
    }

    /// The reciprocals of the direction, without padding: for the naive kernels only.
    pub(crate) fn reciprocal(&self) -> Vec3 {
        self.ray.direction.recip()
    }

    /// For each axis, whether the ray runs towards smaller coordinates: the sign bit of the direction, so that −0.0 is
    /// as consistent as any other value.
    pub fn direction_is_negative(&self) -> [bool; 3] {
        self.ray.direction.to_array().map(f32::is_sign_negative)
    }

    /// Where the ray enters `bounds` within `interval`, or `None` where it passes by.
    ///
    /// Never `None` for a box that the exact ray meets within the closed interval, and never a larger entry for a box
    /// than for one inside of it: rounding is monotone, and both widen in the same way. The entry is at least `t_min`
    /// and at most the exact one. Zero, −0.0 and denormal components need no case of their own: a plane that gives NaN
    /// (0 · ∞: the origin lies in the plane, the ray runs along it) does not bound the ray.
    #[inline]
    pub fn enter(&self, bounds: &Bounds3, interval: Interval) -> Option<f32> {
        let mut entry = interval.t_min();
        let mut exit = interval.t_max().min(f32::MAX);
        for i in 0..3 {
            let (near_plane, far_plane) = if self.ray.direction[i].is_sign_negative() {
                (bounds.max[i], bounds.min[i])
            } else {
                (bounds.min[i], bounds.max[i])
            };
            let near = (near_plane - self.ray.origin[i]) * self.reciprocal_near[i];
            let far = (far_plane - self.ray.origin[i]) * self.reciprocal_far[i];
            // The comparison fails for NaN, which then bounds nothing.
            entry = if near > entry { near } else { entry };
            exit = if far < exit { far } else { exit };
        }
        (entry <= exit).then_some(entry)
    }
}

/// Whether everything is finite and the direction is not zero.
#[inline]
fn is_valid(ray: &Ray) -> bool {
    let (o, d) = (ray.origin.extend(ray.time), ray.direction.extend(0.0));
    o.is_finite() && d.is_finite() && d != Vec4::ZERO
}

impl Shear {
    /// Without branches, which random directions would make the processor guess wrong.
    #[inline]
    fn new(direction: Vec3) -> Self {
        let d = direction.abs();
        let of_xy = if d.y > d.x { (d.y, 1) } else { (d.x, 0) };
        let kz = if d.z > of_xy.0 { 2 } else { of_xy.1 };
        // The axes after kz, two bits for each kz.
        let (kx, ky) = (0b00_10_01 >> (2 * kz) & 3, 0b01_00_10 >> (2 * kz) & 3);
        let d = direction.extend(1.0).to_array();
        Self { kx, ky, kz, sx: d[kx] / d[kz], sy: d[ky] / d[kz] }
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
        }
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
