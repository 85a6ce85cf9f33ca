//! A ray, as its caller writes it.

use glam::Vec3;

/// The half-line `origin + t · direction`, at a time.
///
/// Plain data: any bits may stand in it. The direction need not be of unit length; `t` counts in multiples of it. Which
/// part of the ray a query looks at is the query's argument ([`Interval`](crate::Interval)), and a query never writes
/// into a ray. Queries take a [`TraversalRay`](crate::TraversalRay), which exists for valid rays only.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ray {
    /// Where `t = 0`.
    pub origin: Vec3,
    /// The step of `t = 1`; any length but zero.
    pub direction: Vec3,
    /// The moment at which moving things are seen, in the unit of the animation's keyframes.
    pub time: f32,
}

impl Ray {
    /// The ray from `origin` along `direction` at time 0.
    pub fn new(origin: impl Into<Vec3>, direction: impl Into<Vec3>) -> Self {
        Self { origin: origin.into(), direction: direction.into(), time: 0.0 }
    }

    /// The same ray at another time.
    #[must_use]
    pub fn at_time(self, time: f32) -> Self {
        Self { time, ..self }
    }

    /// The point `origin + t · direction`, computed in f32; a hit's position comes more exactly from its
    /// [`Shape`](crate::Shape). With two roundings a coordinate; not finite where that overflows or anything is not.
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + t * self.direction
    }
}
