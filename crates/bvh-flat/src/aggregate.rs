//! Primitives with a tree over them.

use std::ops::ControlFlow;

use geometry::{Bounds3, Hit, HitVisitor, Interval, MappedVisitor, TraversalRay, Visit, Watertight};
use primitive::{HitKind, Primitive, PrimitiveList, SurfaceInteraction};

#[cfg(feature = "build")]
use crate::{BuildConfig, BuildError, BuildObserver};
use crate::{FlatBvh, InvalidBvh};

/// Primitives with a tree over their bounds: pbrt's BVHAggregate, and a [`Primitive`] itself. With `P = Box<dyn
/// Primitive>` it mixes anything; with an enum of a scene's own kinds there is no dispatch. Every answer is the same, bit
/// for bit, as that of the [`PrimitiveList`] alone, whatever the tree.
#[derive(Clone, Debug)]
pub struct BvhAggregate<P> {
    list: PrimitiveList<P>,
    bvh: FlatBvh,
}

impl<P: Primitive> BvhAggregate<P> {
    /// Builds a tree over `members`; hits number their primitives one member after the other, in this order.
    ///
    /// # Errors
    /// [`BuildError`] for a configuration or a number of members that the builder refuses.
    #[cfg(feature = "build")]
    pub fn build(members: Vec<P>, config: &BuildConfig) -> Result<Self, BuildError> {
        Self::build_observed(members, config, &())
    }

    /// Builds a tree over `members`, telling `observer` of each phase.
    ///
    /// # Errors
    /// As [`build`](Self::build).
    #[cfg(feature = "build")]
    pub fn build_observed(
        members: Vec<P>,
        config: &BuildConfig,
        observer: &dyn BuildObserver,
    ) -> Result<Self, BuildError> {
        let bounds: Vec<Bounds3> = members.iter().map(Primitive::world_bound).collect();
        let bvh = FlatBvh::build(&bounds, config, observer)?;
        Ok(Self { list: PrimitiveList::new(members), bvh })
    }

    /// Joins primitives and a tree over their bounds.
    ///
    /// # Errors
    /// [`InvalidBvh::Geometry`] where the tree does not fit the members: not built over as many, a leaf that does not
    /// contain its members, or an active member that no leaf has.
    pub fn from_parts(members: Vec<P>, bvh: FlatBvh) -> Result<Self, InvalidBvh> {
        bvh.validate_against(members.len(), |i| members[i].world_bound())?;
        Ok(Self { list: PrimitiveList::new(members), bvh })
    }

    /// The members, as the naive aggregate.
    pub fn list(&self) -> &PrimitiveList<P> {
        &self.list
    }

    /// The tree.
    pub fn bvh(&self) -> &FlatBvh {
        &self.bvh
    }

    /// The member at a place of the order, and the number of its first primitive.
    #[inline]
    fn member(&self, place: usize) -> (&P, u64) {
        let index = self.bvh.order()[place] as usize;
        (&self.list.members()[index], self.list.first_primitive(index))
    }
}

impl<P: Primitive> Primitive for BvhAggregate<P> {
    fn world_bound(&self) -> Bounds3 {
        self.bvh.bounds()
    }

    fn primitive_count(&self) -> u64 {
        self.list.primitive_count()
    }

    fn visit_hits(&self, ray: &TraversalRay, interval: Interval, kind: HitKind, visitor: &mut dyn HitVisitor) -> Visit {
        self.bvh.visit_hits::<Watertight>(ray, interval, visitor, |range, mut interval, visitor| {
            for place in range {
                let (member, first) = self.member(place);
                let mut mapped = MappedVisitor::new(visitor, |hit| hit.offset_by(first));
                interval = interval.with_t_max(member.visit_hits(ray, interval, kind, &mut mapped)?);
            }
            ControlFlow::Continue(interval.t_max())
        })
    }

    fn intersect(&self, ray: &TraversalRay, interval: Interval) -> Option<Hit> {
        self.bvh.intersect::<Watertight>(ray, interval, |range, mut interval| {
            let mut closest: Option<Hit> = None;
            for place in range {
                let (member, first) = self.member(place);
                if let Some(hit) = member.intersect(ray, interval).map(|hit| hit.offset_by(first))
                    && closest.as_ref().is_none_or(|best| hit.is_before(best))
                {
                    interval = interval.with_t_max(hit.t_max_for_ties());
                    closest = Some(hit);
                }
            }
            closest
        })
    }

    fn intersect_p(&self, ray: &TraversalRay, interval: Interval) -> bool {
        self.bvh.intersect_p::<Watertight>(ray, interval, |mut range, interval| {
            range.any(|place| self.member(place).0.intersect_p(ray, interval))
        })
    }

    fn interaction(&self, ray: &TraversalRay, hit: &Hit) -> SurfaceInteraction {
        self.list.interaction(ray, hit)
    }
}
