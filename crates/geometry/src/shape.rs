//! What every shape can be asked.

use glam::{DVec3, Vec2};

use crate::{Bounds3, ClosestHit, FirstHit, Hit, HitVisitor, Interval, Transform, TraversalRay, Visit};

/// Something with a surface that a ray can meet: pbrt's Shape. It may consist of many primitives, as a mesh does.
///
/// Everything is in the shape's object space. Which hits a shape reports must be a function of the ray alone; the
/// interval only selects among them. And no hit has a `t` below the entry of the ray into
/// [`object_bound`](Self::object_bound), as [`TraversalRay::enter`] computes it, which a shape of your own keeps to by
/// `t.max(entry)`. Then the closest of many depends neither on the order of testing nor on a tree.
///
/// Shapes are shared by threads: what a query wants to remember belongs into its visitor.
pub trait Shape: Send + Sync {
    /// A box around the shape in object space; [`Bounds3::EMPTY`] where there is nothing to hit.
    fn object_bound(&self) -> Bounds3;

    /// A box around the shape after `object_to_world`.
    fn world_bound(&self, object_to_world: &Transform) -> Bounds3 {
        object_to_world.bounds(&self.object_bound())
    }

    /// How many primitives it consists of: hits name them `0 .. count`.
    fn primitive_count(&self) -> u64 {
        1
    }

    /// Tells `visitor` of every hit with `t_min < t < t_max`, in no particular order; of none where the interval is
    /// empty. The `t` of hits are never NaN, and count in lengths of the ray's direction. The visitor's answer lowers
    /// `t_max` for the rest, or ends the visit; the last answer is returned, `Continue(t_max)` if there was none.
    fn visit_hits(&self, ray: &TraversalRay, interval: Interval, visitor: &mut dyn HitVisitor) -> Visit;

    /// The closest hit: the smallest `t`, of equal `t` the smallest primitive. To leave hits out, visit with
    /// [`ClosestHit::among`].
    fn intersect(&self, ray: &TraversalRay, interval: Interval) -> Option<Hit> {
        let mut closest = ClosestHit::new(interval);
        let _ = self.visit_hits(ray, interval, &mut closest);
        closest.hit()
    }

    /// Whether there is any hit: pbrt's IntersectP, for shadow rays. To leave hits out, visit with
    /// [`FirstHit::among`].
    fn intersect_p(&self, ray: &TraversalRay, interval: Interval) -> bool {
        self.visit_hits(ray, interval, &mut FirstHit::default()).is_break()
    }

    /// The surface at a hit that this shape reported for this very ray. Of any other hit nothing is promised: a
    /// `primitive` that does not exist may end in a panic.
    fn surface_point(&self, ray: &TraversalRay, hit: &Hit) -> SurfacePoint;
}

/// A point on a surface, in f64: it is rounded to f32 once, when it is an interaction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The position.
    pub p: DVec3,
    /// For each axis a bound on the distance of `p` from the exact intersection of the exact ray with the surface.
    pub p_error: DVec3,
    /// The geometric normal: of unit length, outward for a closed surface (for a triangle, the side from which its
    /// vertices run counter-clockwise).
    pub n: DVec3,
    /// The surface's own parameters: a mesh's interpolated texture coordinates (its barycentrics where it has none), a
    /// sphere's longitude and latitude over [0, 1]².
    pub uv: Vec2,
}

macro_rules! shape_by_reference {
    ($($pointer:ty),*) => {$(
        impl<S: Shape + ?Sized> Shape for $pointer {
            fn object_bound(&self) -> Bounds3 {
                (**self).object_bound()
            }
            fn world_bound(&self, object_to_world: &Transform) -> Bounds3 {
                (**self).world_bound(object_to_world)
            }
            fn primitive_count(&self) -> u64 {
                (**self).primitive_count()
            }
            fn visit_hits(&self, ray: &TraversalRay, interval: Interval, visitor: &mut dyn HitVisitor) -> Visit {
                (**self).visit_hits(ray, interval, visitor)
            }
            fn intersect(&self, ray: &TraversalRay, interval: Interval) -> Option<Hit> {
                (**self).intersect(ray, interval)
            }
            fn intersect_p(&self, ray: &TraversalRay, interval: Interval) -> bool {
                (**self).intersect_p(ray, interval)
            }
            fn surface_point(&self, ray: &TraversalRay, hit: &Hit) -> SurfacePoint {
                (**self).surface_point(ray, hit)
            }
        }
    )*};
}

shape_by_reference!(&S, Box<S>, std::sync::Arc<S>);
