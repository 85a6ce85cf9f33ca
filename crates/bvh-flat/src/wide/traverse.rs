//! The way of a ray through a wide tree.

use std::ops::ControlFlow;

use geometry::{Interval, TraversalRay};

use super::arena::{Arena, Child};
use super::box_ray::{BoxLanes, Slabs};
use super::node::WideNode;
use crate::MAX_DEPTH;
use crate::simd::{Lanes, Stack};

/// The most nodes on a path of a wide tree, with the leaf: it is no deeper than the binary one that it was made of,
/// whose large leaves may have been divided, by 13 levels at most.
pub(crate) const MAX_WIDE_DEPTH: usize = MAX_DEPTH + 13;

/// Each level leaves seven children on the stack, and eight are written at once.
const STACK: usize = 7 * MAX_WIDE_DEPTH + 16;

/// What is asked of the primitives on a ray's way.
pub(crate) trait Query {
    /// Whether all children are to be visited in their order, and not only the nearest first.
    const ORDERED: bool;

    /// Takes a leaf that `ray` comes to: `Continue(t_max)` to be shown others up to there, `Break` to stop.
    fn leaf<L: Lanes>(&mut self, ray: &TraversalRay, leaf: Child) -> ControlFlow<(), f32>;

    /// Is told of each node.
    #[inline(always)]
    fn node(&mut self) {}
}

/// Where a ray comes to next.
pub(crate) enum Next {
    /// To a child of the node that it is at.
    Down(Child),
    /// Back to one that it has met before, whose lines were asked for then.
    Back(Child),
}

impl Next {
    #[inline(always)]
    fn child(self) -> Child {
        match self {
            Self::Down(child) | Self::Back(child) => child,
        }
    }
}

/// A ray on its way through a tree: where it goes next is kept by whoever makes the steps.
pub(crate) struct Way<L: Lanes> {
    lanes: BoxLanes<L>,
    shift: u32,
    t_max: f32,
}

/// What a ray still has to visit. Not part of a [`Way`], all of which would then be kept in memory.
pub(crate) type WayStack = Stack<STACK>;

impl<L: Lanes> Way<L> {
    #[inline(always)]
    pub(crate) fn new<const REGULAR: bool>(ray: &TraversalRay, interval: Interval) -> Self {
        let lanes = BoxLanes::<L>::new::<REGULAR>(ray, interval.t_min(), interval.t_max());
        Self { shift: 3 * lanes.octant(), lanes, t_max: interval.t_max() }
    }

    /// Visits a node or a leaf: where the ray comes to next, or `None` at the end of its way.
    ///
    /// The nearest of the children that are met is next; of three and more the others follow in the order of the ray's
    /// octant. Rejected: two in scalar numbers, without a branch (sponza and kitchen 1 % faster, bunny and dragon as
    /// much slower); the order of the octant for all, with which kitchen's primary rays visit 8.7 nodes and test 8.8
    /// triangles instead of 8.3 and 6.8; and the others in no order, with which sponza's diffuse rays visit 12.3 and
    /// test 11.1 instead of 11.8 and 10.1.
    ///
    /// Any hit is found sooner by way of the nearest too (8 % less time for bunny's and the hairball's shadow rays, 4 %
    /// for black-forest's, 4 % more for terrain-rainier's), but the order of the others does not pay. Rejected: first
    /// the child of whose box the ray has most before it, with which all scenes take longer.
    #[inline(always)]
    pub(crate) fn step<const REGULAR: bool, N: WideNode, Q: Query>(
        &mut self,
        arena: &Arena,
        ray: &TraversalRay,
        at: Child,
        query: &mut Q,
        stack: &mut WayStack,
    ) -> Option<Next> {
        if at.is_leaf() {
            let ControlFlow::Continue(bound) = query.leaf::<L>(ray, at) else { return None };
            if Q::ORDERED && bound < self.t_max {
                self.t_max = bound;
                self.lanes.set_t_max(bound);
            }
            return self.back::<Q>(stack);
        }
        query.node();
        let node = N::read_from(arena, at.line())?;
        let slabs = self.lanes.slabs::<REGULAR>(node);
        let children = L::load_u32(node.children());
        let met = boxes_met::<L, REGULAR, N>(&slabs, children);
        // One child or none, most often.
        let others = met & met.wrapping_sub(1);
        if others == 0 {
            return match met {
                0 => self.back::<Q>(stack),
                _ => Some(Next::Down(node.child(met.trailing_zeros()))),
            };
        }
        // Before the nearest is known, and two without a branch, since most often it is two. Rejected, in geometric
        // mean over sponza, kitchen, bunny, dragon and terrain-rainier: none (5 % more speed for sponza's primary rays,
        // as much less where memory is slow, on dragon); the last of the stack alone (1 % less), and the next one with
        // each that is taken from it (2 %); all but the nearest (3 %); two lines of each instead of four (1 %).
        arena.prefetch(node.child(met.trailing_zeros()).place());
        arena.prefetch(node.child(others.trailing_zeros()).place());
        let more = others & (others - 1);
        if more != 0 {
            arena.prefetch(node.child(more.trailing_zeros()).place());
            arena.prefetch(node.child(more.leading_zeros() ^ 31).place());
        }
        let nearest = L::least_met(slabs.entry, met) as u32;
        let next = node.child(nearest);
        if !Q::ORDERED || more == 0 {
            stack.push::<L>(children, slabs.entry, met & !(1 << nearest))?;
        } else {
            let orders = L::load_u32(node.orders());
            let entry = L::permute(slabs.entry, orders, self.shift);
            let exit = L::permute(slabs.exit, orders, self.shift);
            let children = L::permute_u32(children, orders, self.shift);
            let met = boxes_met::<L, REGULAR, N>(&Slabs { entry, exit }, children)
                & !L::eq_u32(children, L::splat_u32(next.0));
            stack.push::<L>(children, entry, met)?;
        }
        Some(Next::Down(next))
    }

    /// To what is left, if anything is.
    #[inline(always)]
    fn back<Q: Query>(&self, stack: &mut WayStack) -> Option<Next> {
        let child = if Q::ORDERED { stack.pop_before(self.t_max) } else { stack.pop() };
        child.map(Next::Back)
    }
}

/// The lanes with a child whose box is met.
#[inline(always)]
pub(super) fn boxes_met<L: Lanes, const REGULAR: bool, N: WideNode>(slabs: &Slabs<L>, children: L::U32) -> u32 {
    let met = slabs.met::<REGULAR>();
    if N::HAS_EMPTY_BOXES { met } else { met & !L::eq_u32(children, L::splat_u32(0)) }
}

/// Shows `query` the leaves that a ray comes to.
#[inline(always)]
pub(crate) fn traverse<L: Lanes, N: WideNode>(
    arena: &Arena,
    root: Option<Child>,
    ray: &TraversalRay,
    interval: Interval,
    query: &mut impl Query,
) {
    let Some(root) = root.filter(|_| !interval.is_empty()) else { return };
    if ray.is_regular() {
        traverse_as::<L, true, N>(arena, root, ray, interval, query);
    } else {
        traverse_as::<L, false, N>(arena, root, ray, interval, query);
    }
}

#[inline(always)]
fn traverse_as<L: Lanes, const REGULAR: bool, N: WideNode>(
    arena: &Arena,
    root: Child,
    ray: &TraversalRay,
    interval: Interval,
    query: &mut impl Query,
) {
    let mut way = Way::<L>::new::<REGULAR>(ray, interval);
    let mut stack = WayStack::new();
    let mut next = Some(root);
    while let Some(at) = next {
        next = way.step::<REGULAR, N, _>(arena, ray, at, query, &mut stack).map(Next::child);
    }
}
