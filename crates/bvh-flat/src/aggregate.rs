//! Primitives with a tree over them.

use std::ops::{ControlFlow, Range};

use geometry::{Bounds3, Hit, HitVisitor, Interval, MappedVisitor, TraversalRay, Visit, Work};
use primitive::{HitKind, Primitive, PrimitiveList, SurfaceInteraction};

use crate::simd::{Kernel, Lanes, SimdWidth};
use crate::wide::{
    Child, FullNode, LeafWriter, Line, MAX_LINES, NoWideTree, Query, Watch, WideTree, collapse, traverse,
    with_small_leaves,
};
#[cfg(feature = "build")]
use crate::{BuildConfig, BuildError, BuildObserver};
use crate::{FlatBvh, InvalidBvh};

/// Primitives with a tree over their bounds: pbrt's BVHAccel (third edition, section 4.3) or BVHAggregate (fourth,
/// 7.3), and a [`Primitive`] itself. With `P = Box<dyn Primitive>` it mixes anything; with an enum of a scene's own
/// kinds there is no dispatch. Every answer is the same, bit for bit, as that of the [`PrimitiveList`] alone, whatever
/// the tree.
///
/// Rays go through a wide tree, eight boxes at a time, that is collapsed from the flat one. Members do not move: the
/// next frame's aggregate is built over the next frame's members, which as `Arc<…>` share what is in them.
#[derive(Clone, Debug)]
pub struct BvhAggregate<P> {
    list: PrimitiveList<P>,
    bvh: FlatBvh,
    wide: WideTree,
    width: SimdWidth,
}

impl<P: Primitive> BvhAggregate<P> {
    /// Builds a tree over `members`; hits number their primitives one member after the other, in this order. A member
    /// whose bound is not [valid](Bounds3::is_valid) is never asked, and keeps its numbers. Space is not split,
    /// whatever the configuration says.
    ///
    /// # Errors
    /// [`BuildError`] for a configuration or a number of members that the builder refuses, or a tree of more than 16
    /// GiB.
    #[cfg(feature = "build")]
    pub fn build(members: Vec<P>, config: &BuildConfig) -> Result<Self, BuildError> {
        Self::build_observed(members, config, &())
    }

    /// Builds a tree over `members`; `observer` is told how far it has come, and may cancel it.
    ///
    /// # Errors
    /// As [`build`](Self::build); and [`BuildError::Cancelled`].
    #[cfg(feature = "build")]
    pub fn build_observed(
        members: Vec<P>,
        config: &BuildConfig,
        observer: &dyn BuildObserver,
    ) -> Result<Self, BuildError> {
        let bounds: Vec<Bounds3> = members.iter().map(Primitive::world_bound).collect();
        let bvh = FlatBvh::build(&bounds, config, observer)?;
        Self::assemble(members, bvh, &observer).map_err(|why| why.of(bounds.len()))
    }

    /// Joins primitives and a tree over their bounds.
    ///
    /// # Errors
    /// [`InvalidBvh::Geometry`] where the tree does not fit the members: not built over as many, a leaf that does not
    /// contain its members, an active member that no leaf has, or space that was split. [`InvalidBvh::TooLarge`] beyond
    /// 16 GiB.
    pub fn from_parts(members: Vec<P>, bvh: FlatBvh) -> Result<Self, InvalidBvh> {
        bvh.validate_against(members.len(), |i| members[i].world_bound())?;
        let primitive_count = members.len();
        Self::assemble(members, bvh, &()).map_err(|_| InvalidBvh::TooLarge { primitive_count })
    }

    fn assemble(members: Vec<P>, bvh: FlatBvh, watch: &impl Watch) -> Result<Self, NoWideTree> {
        if bvh.order().len() > MAX_LINES {
            return Err(NoWideTree::TooLarge);
        }
        let wide = collapse::<FullNode>(&*with_small_leaves(&bvh), bvh.extra_references() > 0, &Places, watch)?;
        Ok(Self { list: PrimitiveList::new(members), bvh, wide, width: SimdWidth::default() })
    }

    /// The same members and tree, traversed with another width; members keep their own.
    #[must_use]
    pub fn with_simd_width(self, width: SimdWidth) -> Self {
        Self { width, ..self }
    }

    /// The members, as the naive aggregate: [`member_of`](PrimitiveList::member_of) says whose a hit is.
    pub fn list(&self) -> &PrimitiveList<P> {
        &self.list
    }

    /// The tree.
    pub fn bvh(&self) -> &FlatBvh {
        &self.bvh
    }

    /// The memory of both forms of the tree, in bytes.
    pub fn memory(&self) -> usize {
        self.bvh.memory() + self.wide.arena.memory()
    }

    /// The members of a leaf, each with the number of its first primitive.
    #[inline]
    fn members(&self, leaf: Child) -> impl Iterator<Item = (&P, u64)> {
        let places = leaf.place()..leaf.place() + leaf.count();
        self.bvh.order().get(places).into_iter().flatten().map(|&index| {
            let index = index as usize;
            (&self.list.members()[index], self.list.first_primitive(index))
        })
    }

    fn run<Q: Query>(&self, ray: &TraversalRay, interval: Interval, query: &mut Q) {
        self.width.run(Traversal { tree: &self.wide, ray, interval, query });
    }
}

/// Leaves name their places in the order.
struct Places;

impl LeafWriter for Places {
    fn line_count(&self, _: Range<usize>) -> usize {
        0
    }

    fn write(&self, range: Range<usize>, _: usize, _: &mut [Line]) -> (usize, usize) {
        (range.start, range.len())
    }

    /// A member is asked on its own, and most have a tree of their own.
    fn cost(&self, count: usize) -> f64 {
        2.0 * count as f64
    }
}

/// A query on its way through a tree.
struct Traversal<'a, Q> {
    tree: &'a WideTree,
    ray: &'a TraversalRay,
    interval: Interval,
    query: &'a mut Q,
}

impl<Q: Query> Kernel for Traversal<'_, Q> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        traverse::<L, FullNode>(&self.tree.arena, self.tree.root, self.ray, self.interval, self.query);
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
        let visit = ControlFlow::Continue(interval.t_max());
        let mut query = AllQuery { aggregate: self, interval, kind, visitor, nodes: 0, visit };
        self.run(ray, interval, &mut query);
        let AllQuery { visitor, nodes, visit, .. } = query;
        visitor.work(Work { nodes, primitives: 0 });
        visit
    }

    fn intersect(&self, ray: &TraversalRay, interval: Interval) -> Option<Hit> {
        let mut query = ClosestQuery { aggregate: self, interval, closest: None };
        self.run(ray, interval, &mut query);
        query.closest
    }

    fn intersect_p(&self, ray: &TraversalRay, interval: Interval) -> bool {
        let mut query = AnyQuery { aggregate: self, interval, is_hit: false };
        self.run(ray, interval, &mut query);
        query.is_hit
    }

    fn interaction(&self, ray: &TraversalRay, hit: &Hit) -> SurfaceInteraction {
        self.list.interaction(ray, hit)
    }
}

struct ClosestQuery<'a, P> {
    aggregate: &'a BvhAggregate<P>,
    interval: Interval,
    closest: Option<Hit>,
}

impl<P: Primitive> Query for ClosestQuery<'_, P> {
    const ORDERED: bool = true;

    #[inline(always)]
    fn leaf<L: Lanes>(&mut self, ray: &TraversalRay, leaf: Child) -> ControlFlow<(), f32> {
        for (member, first) in self.aggregate.members(leaf) {
            if let Some(hit) = member.intersect(ray, self.interval).map(|hit| hit.offset_by(first))
                && self.closest.as_ref().is_none_or(|closest| hit.is_before(closest))
            {
                self.interval = self.interval.with_t_max(hit.t_max_for_ties());
                self.closest = Some(hit);
            }
        }
        ControlFlow::Continue(self.interval.t_max())
    }
}

struct AnyQuery<'a, P> {
    aggregate: &'a BvhAggregate<P>,
    interval: Interval,
    is_hit: bool,
}

impl<P: Primitive> Query for AnyQuery<'_, P> {
    const ORDERED: bool = false;

    #[inline(always)]
    fn leaf<L: Lanes>(&mut self, ray: &TraversalRay, leaf: Child) -> ControlFlow<(), f32> {
        self.is_hit = self.aggregate.members(leaf).any(|(member, _)| member.intersect_p(ray, self.interval));
        if self.is_hit { ControlFlow::Break(()) } else { ControlFlow::Continue(self.interval.t_max()) }
    }
}

struct AllQuery<'a, 'v, P> {
    aggregate: &'a BvhAggregate<P>,
    interval: Interval,
    kind: HitKind,
    visitor: &'v mut dyn HitVisitor,
    nodes: u64,
    visit: Visit,
}

impl<P: Primitive> Query for AllQuery<'_, '_, P> {
    const ORDERED: bool = true;

    #[inline(always)]
    fn leaf<L: Lanes>(&mut self, ray: &TraversalRay, leaf: Child) -> ControlFlow<(), f32> {
        for (member, first) in self.aggregate.members(leaf) {
            let ControlFlow::Continue(t_max) = self.visit else { break };
            let mut mapped = MappedVisitor::new(self.visitor, |hit| hit.offset_by(first));
            self.visit = member.visit_hits(ray, self.interval.with_t_max(t_max), self.kind, &mut mapped);
        }
        self.visit
    }

    #[inline(always)]
    fn node(&mut self) {
        self.nodes += 1;
    }
}
