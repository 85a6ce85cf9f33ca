//! Spheres.

mod expansion;
mod quadratic;

use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

use glam::{DVec3, Vec2, Vec3};
use thiserror::Error;

use expansion::two_sum;
use quadratic::{Point, Quadratic};

use crate::{Bounds3, Hit, HitVisitor, Interval, Shape, SurfacePoint, TraversalRay, Visit, Work, round_down, round_up};

/// A whole sphere: all points at distance `radius` from `center`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    center: Vec3,
    radius: f32,
}

/// Why there is no such sphere.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SphereError {
    /// The radius is not a positive, finite number.
    #[error("a sphere's radius must be positive and finite, not {0}")]
    Radius(f32),
    /// A coordinate of the center is not finite.
    #[error("a sphere's center must be finite, not {0}")]
    Center(Vec3),
}

impl Sphere {
    /// The sphere around `center`.
    ///
    /// # Errors
    /// [`SphereError`] where the radius is not positive and finite, or the center not finite.
    pub fn new(center: impl Into<Vec3>, radius: f32) -> Result<Self, SphereError> {
        let center = center.into();
        if !(radius > 0.0 && radius.is_finite()) {
            return Err(SphereError::Radius(radius));
        }
        if !center.is_finite() {
            return Err(SphereError::Center(center));
        }
        Ok(Self { center, radius })
    }

    /// The middle.
    pub fn center(&self) -> Vec3 {
        self.center
    }

    /// The distance of the surface from the center.
    pub fn radius(&self) -> f32 {
        self.radius
    }
}

impl Shape for Sphere {
    /// center ± radius, rounded outward once, from the exact sum.
    fn object_bound(&self) -> Bounds3 {
        let r = f64::from(self.radius);
        let end = |c: f32, r: f64| two_sum(c.into(), r);
        let low = |c: f32| match end(c, -r) {
            (sum, tail) if tail < 0.0 => round_down(sum.next_down()),
            (sum, _) => round_down(sum),
        };
        let high = |c: f32| match end(c, r) {
            (sum, tail) if tail > 0.0 => round_up(sum.next_up()),
            (sum, _) => round_up(sum),
        };
        let c = self.center.to_array();
        Bounds3::new(Vec3::from_array(c.map(low)), Vec3::from_array(c.map(high)))
    }

    /// Decides as real arithmetic does on the f64 ray: whether, how often and in which order the ray meets the sphere.
    /// A tangent counts once. `t` is within 0.57 ulp of the exact value.
    fn visit_hits(&self, ray: &TraversalRay, mut interval: Interval, visitor: &mut dyn HitVisitor) -> Visit {
        visitor.work(Work { nodes: 0, primitives: 1 });
        let Some([t0, t1]) = Quadratic::parameters(self, ray) else { return ControlFlow::Continue(interval.t_max()) };
        let bounds = self.object_bound();
        if bounds.is_valid() {
            let roots = [t0, t1];
            for &root in &roots[..if t0 == t1 { 1 } else { 2 }] {
                let t = root as f32;
                if !interval.contains(t) {
                    continue;
                }
                let Some(entry) = ray.enter(&bounds, interval) else { break };
                let t = t.max(entry);
                if interval.contains(t) {
                    interval = interval.with_t_max(visitor.hit(Hit { t, u: 0.0, v: 0.0, primitive: 0 })?);
                }
            }
        }
        ControlFlow::Continue(interval.t_max())
    }

    /// The first point with the hit's `t`, or the one nearest to it. Its error does not depend on how far away the ray
    /// began: see `Quadratic::point`.
    fn surface_point(&self, ray: &TraversalRay, hit: &Hit) -> SurfacePoint {
        let t = f64::from(hit.t);
        let second = Quadratic::parameters(self, ray)
            .is_some_and(|[t0, t1]| t0 as f32 != hit.t && (t - t1).abs() < (t - t0).abs());
        let Point { p, error, from_center } = Quadratic::point(self, ray, second);
        let n = (from_center / f64::from(self.radius)).normalize_or(-ray.direction64().normalize());
        let phi = libm::atan2(n.y, n.x);
        let phi = if phi < 0.0 { phi + TAU } else { phi };
        let theta = libm::acos(n.z.clamp(-1.0, 1.0));
        SurfacePoint {
            p,
            p_error: DVec3::splat(error) + p.abs() * f64::EPSILON,
            n,
            uv: Vec2::new((phi / TAU) as f32, (theta / PI) as f32),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Ray;

    fn ray(o: [f32; 3], d: [f32; 3]) -> TraversalRay {
        TraversalRay::new(&Ray::new(o, d)).expect("valid")
    }

    #[test]
    fn both_hits_in_order_and_the_inside() {
        let s = Sphere::new(Vec3::new(0.0, 0.0, 5.0), 1.0).expect("valid");
        let mut ts = Vec::new();
        let _ = s.visit_hits(&ray([0.0; 3], [0.0, 0.0, 1.0]), Interval::FULL, &mut |h: Hit| {
            ts.push(h.t);
            ControlFlow::Continue(f32::INFINITY)
        });
        assert_eq!(ts, [4.0, 6.0]);
        assert_eq!(s.intersect(&ray([0.0, 0.0, 5.0], [0.0, 0.0, 2.0]), Interval::FULL).expect("inside").t, 0.5);
        assert!(s.intersect(&ray([0.0; 3], [0.0, 0.0, -1.0]), Interval::FULL).is_none());
        assert!(s.intersect(&ray([0.0, 1.01, 0.0], [0.0, 0.0, 1.0]), Interval::FULL).is_none());
    }

    #[test]
    fn a_small_sphere_far_away_is_hit() {
        let s = Sphere::new(Vec3::new(1e6, 0.0, 0.0), 1.0).expect("valid");
        assert_eq!(s.intersect(&ray([0.0; 3], [1.0, 0.0, 0.0]), Interval::FULL).expect("ahead").t, 999_999.0);
        assert!(s.intersect(&ray([0.0; 3], [1.0, 2e-6, 0.0]), Interval::FULL).is_none());
    }

    #[test]
    fn what_is_no_sphere_is_refused() {
        for r in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert!(Sphere::new(Vec3::ZERO, r).is_err());
        }
        assert!(Sphere::new(Vec3::NAN, 1.0).is_err());
    }

    #[test]
    fn surface_point_is_on_the_sphere() {
        let s = Sphere::new(Vec3::new(1.0, 2.0, 3.0), 0.5).expect("valid");
        let r = ray([0.0; 3], [1.0, 2.1, 3.0]);
        let hit = s.intersect(&r, Interval::FULL).expect("ahead");
        let at = s.surface_point(&r, &hit);
        assert!(((at.p - s.center().as_dvec3()).length() - 0.5).abs() < 1e-14);
        assert!(at.n.dot(r.direction64()) < 0.0 && (at.n.length() - 1.0).abs() < 1e-14);
    }
}
