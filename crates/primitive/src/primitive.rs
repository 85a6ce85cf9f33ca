//! What every primitive can be asked.

use geometry::{Bounds3, ClosestHit, FirstHit, Hit, HitVisitor, Interval, TraversalRay, Visit};

use crate::SurfaceInteraction;

/// Which hits a visit tells of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HitKind {
    /// Those on surfaces with a material.
    Material,
    /// Those where the medium changes, with a material or without.
    MediumTransition,
}

/// Something that a ray can hit and a renderer can shade: pbrt's Primitive (third edition, section 4.1; fourth, 7.1).
/// Aggregates of primitives are primitives.
///
/// A primitive's space is that of whoever asks ("world"). Which hits exist is a function of the ray alone, and no hit
/// has a `t` below the entry of the ray into [`world_bound`](Self::world_bound) as [`TraversalRay::enter`] computes it:
/// with these two, an aggregate's answer does not depend on its tree. All primitives of this workspace keep both; a
/// primitive of your own keeps the second by `t.max(entry)`.
///
/// Primitives are shared by threads, so `Box<dyn Primitive>` is all that a scene of many kinds needs.
pub trait Primitive: Send + Sync {
    /// A box around the primitive, at every time; not [valid](Bounds3::is_valid) where there is nothing to hit. The
    /// same whenever it is asked: an aggregate is built by it.
    fn world_bound(&self) -> Bounds3;

    /// How many primitives it counts for in the numbering of hits, which is from 0; an instance counts like a copy.
    fn primitive_count(&self) -> u64 {
        1
    }

    /// Tells `visitor` of every hit of this `kind` with `t_min < t < t_max`, in no particular order; of none where the
    /// interval is empty. The `t` of hits are never NaN, and count in lengths of the ray's direction. The visitor's
    /// answer lowers `t_max` for the rest, or ends the visit; the last answer is returned, `Continue(t_max)` if there
    /// was none.
    fn visit_hits(&self, ray: &TraversalRay, interval: Interval, kind: HitKind, visitor: &mut dyn HitVisitor) -> Visit;

    /// The closest hit on a surface with a material: the smallest `t`, of equal `t` the smallest primitive. To leave
    /// hits out (alpha masks, ray masks), visit with [`ClosestHit::among`]; to learn what it cost, with [`ClosestHit`].
    fn intersect(&self, ray: &TraversalRay, interval: Interval) -> Option<Hit> {
        let mut closest = ClosestHit::new(interval);
        let _ = self.visit_hits(ray, interval, HitKind::Material, &mut closest);
        closest.hit()
    }

    /// Whether there is any hit on a surface with a material: pbrt's IntersectP, for shadow rays. To leave hits out,
    /// visit with [`FirstHit::among`]; to learn which hit it was or what it cost, with [`FirstHit`].
    fn intersect_p(&self, ray: &TraversalRay, interval: Interval) -> bool {
        self.visit_hits(ray, interval, HitKind::Material, &mut FirstHit::default()).is_break()
    }

    /// Describes a hit that this primitive reported for this very ray. Of any other hit nothing is promised: a
    /// `primitive` that does not exist may end in a panic.
    fn interaction(&self, ray: &TraversalRay, hit: &Hit) -> SurfaceInteraction;
}

macro_rules! primitive_by_reference {
    ($($pointer:ty),*) => {$(
        impl<P: Primitive + ?Sized> Primitive for $pointer {
            fn world_bound(&self) -> Bounds3 {
                (**self).world_bound()
            }
            fn primitive_count(&self) -> u64 {
                (**self).primitive_count()
            }
            fn visit_hits(
                &self,
                ray: &TraversalRay,
                interval: Interval,
                kind: HitKind,
                visitor: &mut dyn HitVisitor,
            ) -> Visit {
                (**self).visit_hits(ray, interval, kind, visitor)
            }
            fn intersect(&self, ray: &TraversalRay, interval: Interval) -> Option<Hit> {
                (**self).intersect(ray, interval)
            }
            fn intersect_p(&self, ray: &TraversalRay, interval: Interval) -> bool {
                (**self).intersect_p(ray, interval)
            }
            fn interaction(&self, ray: &TraversalRay, hit: &Hit) -> SurfaceInteraction {
                (**self).interaction(ray, hit)
            }
        }
    )*};
}

primitive_by_reference!(&P, Box<P>, std::sync::Arc<P>);
