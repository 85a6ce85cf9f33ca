//! The exact answers about a sphere.

use geometry::glam::DVec3;
use geometry::{Interval, MAX_COORDINATE, Ray, Sphere};

use crate::bvh::Box64;
use crate::dyadic::Dyadic;
use crate::oracle::{ExactHit, Oracle, Tally};
use crate::real::ExactReal;
use crate::segment::Segment;
use crate::vector::{ExactTransform, difference, dot, scaled, vector};

/// Who knows the exact answer to every query about a sphere, at its own place or as an instance (then an ellipsoid).
///
/// The tier in f64 is a box around the sphere; within the box, every decision is taken in exact integers.
#[derive(Clone, Debug)]
pub struct SphereOracle {
    sphere: Sphere,
    /// From the sphere's space to that of the rays; `None` for the identity.
    object_to_world: Option<ExactTransform>,
    /// In the sphere's space.
    bounds: Box64,
}

impl SphereOracle {
    /// The oracle of a sphere at its own place.
    pub fn new(sphere: &Sphere) -> Self {
        let (c, r) = (sphere.center().as_dvec3(), DVec3::splat(sphere.radius().into()));
        let bounds = Box64::around(&[c - r, c + r]).grown();
        Self { sphere: *sphere, object_to_world: None, bounds }
    }

    /// The oracle of an instance of the sphere. A singular map makes it unhittable.
    pub fn instance(sphere: &Sphere, object_to_world: ExactTransform) -> Self {
        Self { object_to_world: Some(object_to_world), ..Self::new(sphere) }
    }

    fn is_active(&self) -> bool {
        // c ± r needs at most 61 − (−149) bits: not exact in f64, so it is asked exactly.
        let r = Dyadic::from_f64(self.sphere.radius().into());
        let limit = Dyadic::from_f64(MAX_COORDINATE.into());
        self.sphere.center().abs().to_array().iter().all(|&c| &Dyadic::from_f64(c.into()) + &r <= limit)
    }

    /// The parameters, ascending, at which the line of the ray meets the sphere: both roots of a t² + 2 b t + c = 0
    /// with f = o − center, a = d·d, b = f·d, c = f·f − r².
    ///
    /// For an instance the ray goes back into the sphere's space, with f, d and r multiplied by the determinant of the
    /// map, so that there is no division.
    fn roots(&self, ray: &Segment) -> Vec<ExactReal> {
        let (o, d) = (ray.exact_origin(), ray.exact_direction());
        let (scale, o, d) = match &self.object_to_world {
            Some(map) => map.scaled_inverse(&o, &d),
            None => (Dyadic::ONE, o, d),
        };
        if scale.is_zero() {
            return Vec::new();
        }
        let f = difference(&o, &scaled(&vector(self.sphere.center().as_dvec3()), &scale));
        let r = &Dyadic::from_f64(self.sphere.radius().into()) * &scale;
        let (a, b, c) = (dot(&d, &d), dot(&f, &d), &dot(&f, &f) - &r.square());
        let discriminant = &b.square() - &(&a * &c);
        let root = |sign: &Dyadic| ExactReal::quadratic(-&b, sign.clone(), discriminant.clone(), a.clone());
        match discriminant.signum() {
            1 => vec![root(&-&Dyadic::ONE), root(&Dyadic::ONE)],
            0 => vec![root(&Dyadic::ZERO)],
            _ => Vec::new(),
        }
    }
}

impl Oracle for SphereOracle {
    fn primitive_count(&self) -> u64 {
        1
    }

    /// One hit or two.
    fn all_hits(&self, ray: &Ray, interval: Interval, tally: &mut Tally) -> Vec<ExactHit> {
        let Some(ray) = Segment::new(ray, interval) else { return Vec::new() };
        if self.object_to_world.is_none() && self.bounds.enter(&ray, ray.t_max).is_none() {
            tally.filtered += 1;
            return Vec::new();
        }
        if !self.is_active() {
            return Vec::new();
        }
        tally.exact += 1;
        let roots = self.roots(&ray).into_iter().filter(|t| ray.contains(t));
        roots.map(|t| ExactHit { t, primitive: 0 }).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::glam::{DAffine3, Vec3};

    fn hits(oracle: &SphereOracle, o: [f32; 3], d: [f32; 3]) -> Vec<ExactHit> {
        oracle.all_hits(&Ray::new(o, d), Interval::FULL, &mut Tally::default())
    }

    fn sphere(c: [f32; 3], r: f32) -> Sphere {
        Sphere::new(c, r).expect("valid")
    }

    #[test]
    fn two_hits_one_or_none() {
        let oracle = SphereOracle::new(&sphere([0.0, 0.0, 5.0], 1.0));
        let t = |o, d| hits(&oracle, o, d).iter().map(|hit| hit.t.to_f32()).collect::<Vec<_>>();
        assert_eq!(t([0.0; 3], [0.0, 0.0, 1.0]), [4.0, 6.0]);
        assert_eq!(t([0.0, 0.0, 5.0], [0.0, 0.0, 2.0]), [0.5]);
        assert_eq!(t([1.0, 0.0, 0.0], [0.0, 0.0, 2.5]), [2.0], "tangent");
        assert_eq!(t([1.0_f32.next_up(), 0.0, 0.0], [0.0, 0.0, 2.5]), [] as [f32; 0]);
        assert_eq!(t([1.0_f32.next_down(), 0.0, 0.0], [0.0, 0.0, 2.5]).len(), 2);
        assert_eq!(t([0.0, 0.0, 6.0], [0.0, 0.0, 1.0]), [] as [f32; 0], "t = 0 is excluded");
        assert_eq!(t([0.0, 0.0, 6.0], [0.0, 0.0, -1.0]), [2.0]);
        assert_eq!(t([f32::NAN, 0.0, 0.0], [0.0, 0.0, 1.0]), [] as [f32; 0]);
    }

    /// A sphere and a plane at the same t, which is irrational for neither: the root is exact.
    #[test]
    fn roots_compare_with_ratios() {
        let oracle = SphereOracle::new(&sphere([0.0, 0.0, 5.0], 3.0));
        let all = hits(&oracle, [1.0, 2.0, 0.0], [0.0, 0.0, 3.0]);
        assert_eq!(all[0].t, ExactReal::ratio(Dyadic::ONE, Dyadic::ONE));
        let all = hits(&oracle, [1.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        assert_eq!(all[0].t.to_f64(), 5.0 - 7.0_f64.sqrt());
    }

    /// Power-of-two scales and mirrors give the sphere that they say.
    #[test]
    fn instances_are_ellipsoids() {
        let map = |scale: [f64; 3], t: [f64; 3]| {
            ExactTransform::new(&DAffine3::from_scale_rotation_translation(
                scale.into(),
                geometry::glam::DQuat::IDENTITY,
                t.into(),
            ))
            .expect("finite")
        };
        let unit = sphere([0.0; 3], 1.0);
        let moved = SphereOracle::instance(&unit, map([-4.0, 4.0, 4.0], [8.0, 0.0, 0.0]));
        let plain = SphereOracle::new(&sphere([8.0, 0.0, 0.0], 4.0));
        for i in 0..100 {
            let o = [0.1 * i as f32, -20.0, 0.05 * i as f32];
            assert_eq!(hits(&moved, o, [0.02, 1.0, 0.01]), hits(&plain, o, [0.02, 1.0, 0.01]));
        }
        let ellipsoid = SphereOracle::instance(&unit, map([1.0, 2.0, 3.0], [0.0; 3]));
        let t = hits(&ellipsoid, [0.0, 0.0, 9.0], [0.0, 0.0, -1.0]);
        assert_eq!(t.iter().map(|hit| hit.t.to_f32()).collect::<Vec<_>>(), [6.0, 12.0]);
        let flat = SphereOracle::instance(&unit, map([1.0, 0.0, 1.0], [0.0; 3]));
        assert!(hits(&flat, [0.0, 0.0, 9.0], [0.0, 0.0, -1.0]).is_empty());
    }

    #[test]
    fn spheres_outside_of_the_domain_are_inactive() {
        for (c, r, active) in [(0.0, MAX_COORDINATE, true), (1.0, MAX_COORDINATE, false), (0.0, f32::MAX, false)] {
            let oracle = SphereOracle::new(&sphere([c, 0.0, 0.0], r));
            assert_eq!(!hits(&oracle, [0.0; 3], [1.0, 0.0, 0.0]).is_empty(), active);
        }
        assert!(!hits(&SphereOracle::new(&sphere([Vec3::ONE.x; 3], 1e-45)), [1.0; 3], [1.0, 0.0, 0.0]).is_empty());
    }
}
