//! A ray and an interval as the oracle computes with them.

use geometry::glam::{DVec3, Vec3};
use geometry::{Interval, Ray};

use crate::real::ExactReal;
use crate::vector::{Vector, vector};

/// A valid ray with the part of it that is asked about: f32 data, widened exactly.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment {
    pub(crate) origin: DVec3,
    pub(crate) direction: DVec3,
    pub(crate) t_min: f64,
    pub(crate) t_max: f64,
}

impl Segment {
    /// `None` where nothing can be hit: a component or the time is not finite, the direction is zero, or the interval
    /// is empty.
    pub(crate) fn new(ray: &Ray, interval: Interval) -> Option<Self> {
        let valid =
            ray.origin.is_finite() && ray.direction.is_finite() && ray.direction != Vec3::ZERO && ray.time.is_finite();
        (valid && !interval.is_empty()).then(|| Self {
            origin: ray.origin.as_dvec3(),
            direction: ray.direction.as_dvec3(),
            t_min: interval.t_min().into(),
            t_max: interval.t_max().into(),
        })
    }

    pub(crate) fn exact_origin(&self) -> Vector {
        vector(self.origin)
    }

    pub(crate) fn exact_direction(&self) -> Vector {
        vector(self.direction)
    }

    /// Whether `t` lies in the open interval.
    pub(crate) fn contains(&self, t: &ExactReal) -> bool {
        t.cmp_f64(self.t_min).is_gt() && t.cmp_f64(self.t_max).is_lt()
    }

    /// Whether every number of the closed range does.
    pub(crate) fn contains_all(&self, [low, high]: [f64; 2]) -> bool {
        low > self.t_min && high < self.t_max
    }

    /// Whether no number of the closed range does.
    pub(crate) fn contains_none(&self, [low, high]: [f64; 2]) -> bool {
        high <= self.t_min || low >= self.t_max
    }
}
