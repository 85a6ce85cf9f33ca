//! One copy in memory, many places.

use std::ops::ControlFlow;

use geometry::glam::DVec3;
use geometry::{
    AnimatedTransform, Bounds3, Hit, HitVisitor, Interval, MappedVisitor, SurfacePoint, Transform, TraversalRay, Visit,
};

use crate::interaction::outgoing_direction;
use crate::{HitKind, Primitive, SurfaceInteraction};

/// Where a primitive stands.
#[derive(Clone, Debug, PartialEq)]
pub enum Placement {
    /// At one place, at all times.
    Static(Transform),
    /// At a place that depends on the ray's time. Boxed, since moving instances are the few.
    Animated(Box<AnimatedTransform>),
}

impl From<Transform> for Placement {
    fn from(transform: Transform) -> Self {
        Self::Static(transform)
    }
}

impl From<AnimatedTransform> for Placement {
    fn from(transform: AnimatedTransform) -> Self {
        Self::Animated(Box::new(transform))
    }
}

impl Placement {
    /// The transform from the primitive's space to the surrounding one at `time`; for what time means and NaN does, see
    /// [`AnimatedTransform::at`].
    pub fn at(&self, time: f32) -> Transform {
        match self {
            Self::Static(transform) => *transform,
            Self::Animated(transform) => transform.at(time),
        }
    }

    /// A box that contains the image of `bounds` at every time: [`Transform::bounds`] or
    /// [`AnimatedTransform::motion_bounds`].
    pub fn bounds(&self, bounds: &Bounds3) -> Bounds3 {
        match self {
            Self::Static(transform) => transform.bounds(bounds),
            Self::Animated(transform) => transform.motion_bounds(bounds),
        }
    }

    fn ray_to_object(&self, ray: &TraversalRay) -> Option<TraversalRay> {
        match self {
            Self::Static(transform) => transform.ray_to_object(ray),
            Self::Animated(transform) => transform.at(ray.time()).ray_to_object(ray),
        }
    }
}

/// A primitive at another place: pbrt's TransformedPrimitive, and AnimatedPrimitive (third edition, section 4.1.2;
/// fourth, 7.1.2). With `P = Arc<…>` many of them share one copy, and since it is a primitive itself, it nests to any
/// depth.
///
/// The ray is transformed in f64 and its direction is not normalised, so `t` and the interval mean the same inside. A
/// ray that misses the instance's own world bound misses the instance, and no `t` lies below the entry into it. A ray
/// whose image is not finite, or has no direction, hits nothing inside.
///
/// The error of an interaction takes in what the transforms of ray and point add, to first order: up to `f32::MAX`
/// where the ray only touches the surface.
#[derive(Clone, Debug)]
pub struct TransformedPrimitive<P> {
    primitive: P,
    placement: Placement,
    world_bound: Bounds3,
}

impl<P: Primitive> TransformedPrimitive<P> {
    /// `primitive`, seen through `placement`, which carries its space into the surrounding one. Its world bound, which
    /// is computed here, is empty where that of `primitive` is not [valid](Bounds3::is_valid).
    pub fn new(primitive: P, placement: impl Into<Placement>) -> Self {
        let placement = placement.into();
        let object_bound = primitive.world_bound();
        let world_bound = if object_bound.is_valid() { placement.bounds(&object_bound) } else { Bounds3::EMPTY };
        Self { primitive, placement, world_bound }
    }

    /// The primitive in its own space.
    pub fn primitive(&self) -> &P {
        &self.primitive
    }

    /// Where it stands.
    pub fn placement(&self) -> &Placement {
        &self.placement
    }

    /// The entry into the world bound and the ray inside; `None` where every hit is ruled out.
    fn enter(&self, ray: &TraversalRay, interval: Interval) -> Option<(f32, TraversalRay)> {
        let entry = ray.enter(&self.world_bound, interval)?;
        if entry < interval.t_max() { Some((entry, self.placement.ray_to_object(ray)?)) } else { None }
    }
}

impl<P: Primitive> Primitive for TransformedPrimitive<P> {
    fn world_bound(&self) -> Bounds3 {
        self.world_bound
    }

    fn primitive_count(&self) -> u64 {
        self.primitive.primitive_count()
    }

    fn visit_hits(&self, ray: &TraversalRay, interval: Interval, kind: HitKind, visitor: &mut dyn HitVisitor) -> Visit {
        let Some((entry, ray)) = self.enter(ray, interval) else { return ControlFlow::Continue(interval.t_max()) };
        self.primitive.visit_hits(
            &ray,
            interval,
            kind,
            &mut MappedVisitor::new(visitor, |hit| Hit { t: hit.t.max(entry), ..hit }),
        )
    }

    fn intersect(&self, ray: &TraversalRay, interval: Interval) -> Option<Hit> {
        let (entry, ray) = self.enter(ray, interval)?;
        let hit = self.primitive.intersect(&ray, interval)?;
        Some(Hit { t: hit.t.max(entry), ..hit })
    }

    fn intersect_p(&self, ray: &TraversalRay, interval: Interval) -> bool {
        self.enter(ray, interval).is_some_and(|(_, ray)| self.primitive.intersect_p(&ray, interval))
    }

    fn interaction(&self, ray: &TraversalRay, hit: &Hit) -> SurfaceInteraction {
        let object_to_world = self.placement.at(ray.time());
        // The hit was found by this ray, so it has an image inside.
        let inner_ray = object_to_world.ray_to_object(ray).unwrap_or(*ray);
        let inner = self.primitive.interaction(&inner_ray, hit);
        let mut point = object_to_world.surface_point(&inner.point);
        point.p_error += displacement(&object_to_world.ray_deviation(ray, f64::from(hit.t)), &point, ray);
        SurfaceInteraction { point, wo: outgoing_direction(ray), ..inner }
    }
}

/// How far the intersection moves, for each axis, when the ray moves by at most `deviation`: by as much sideways, and
/// along the ray until it meets the surface again, |δ| |dᵢ| / |n · d| to first order. At most f32::MAX, which is
/// reached where the ray only touches.
fn displacement(deviation: &DVec3, point: &SurfacePoint, ray: &TraversalRay) -> DVec3 {
    let d = ray.direction64();
    let along = d.abs() * (deviation.length() / point.n.dot(d).abs());
    let limit = DVec3::splat(f64::from(f32::MAX));
    // The minimum with the limit on the right also takes the place of NaN (0 / 0).
    DVec3::from_array([0, 1, 2].map(|i| (deviation[i] + along[i]).min(limit[i])))
}
