//! The way of a ray through a wide tree.

use std::ops::ControlFlow;

use geometry::{Interval, TraversalRay};

use super::arena::{Arena, Child};
use super::box_ray::{BoxLanes, is_regular};
use crate::MAX_DEPTH;
use crate::simd::{Lanes, Stack};

/// A wide tree is no deeper than the binary one that it was made of, whose large leaves may have been divided, by 13
/// levels at most; each level leaves seven children on the stack, and eight are written at once.
const STACK: usize = 7 * (MAX_DEPTH + 13) + 16;

/// What is asked of the primitives on the ray's way.
pub(crate) trait Query {
    /// Whether near children are to be visited first.
    const ORDERED: bool;

    /// Takes a leaf: `Continue(t_max)` to be shown others up to there, `Break` to stop.
    fn leaf<L: Lanes>(&mut self, leaf: Child) -> ControlFlow<(), f32>;

    /// Is told of each node.
    #[inline(always)]
    fn node(&mut self) {}
}

/// A tree and a ray's way through it.
pub(crate) struct Traversal<'a> {
    pub(crate) arena: &'a Arena,
    pub(crate) root: Option<Child>,
    pub(crate) ray: &'a TraversalRay,
    pub(crate) interval: Interval,
}

impl Traversal<'_> {
    /// Shows `query` the leaves that the ray comes to.
    #[inline(always)]
    pub(crate) fn run<L: Lanes>(&self, query: &mut impl Query) {
        if is_regular(self.ray) { self.traverse::<L, true, _>(query) } else { self.traverse::<L, false, _>(query) }
    }

    #[inline(always)]
    fn traverse<L: Lanes, const REGULAR: bool, Q: Query>(&self, query: &mut Q) {
        let &Self { arena, root: Some(root), ray, interval } = self else { return };
        if interval.is_empty() {
            return;
        }
        let mut t_max = interval.t_max();
        let mut lanes = BoxLanes::<L>::new::<REGULAR>(ray, interval.t_min(), t_max);
        let shift = 3 * lanes.octant();
        let mut stack: Stack<STACK> = Stack::new();
        let mut next = root;
        loop {
            if next.is_leaf() {
                match query.leaf::<L>(next) {
                    ControlFlow::Break(()) => return,
                    ControlFlow::Continue(bound) => {
                        if Q::ORDERED && bound < t_max {
                            t_max = bound;
                            lanes.set_t_max(bound);
                        }
                    }
                }
            } else {
                query.node();
                let Some(node) = arena.node(next.line()) else { return };
                let slabs = lanes.slabs::<REGULAR>(node);
                let met = slabs.met::<REGULAR>();
                // One child or none, most often.
                if met & met.wrapping_sub(1) == 0 {
                    if met != 0 {
                        next = Child(node.children()[met.trailing_zeros() as usize & 7]);
                        continue;
                    }
                } else {
                    let mut others = met;
                    while others != 0 {
                        arena.prefetch(Child(node.children()[others.trailing_zeros() as usize & 7]).place());
                        others &= others - 1;
                    }
                    let children = L::load_u32(node.children());
                    let has_room = if Q::ORDERED {
                        let rest = met & (met - 1);
                        if rest & (rest - 1) == 0 {
                            let nearest = L::least_met(slabs.entry, slabs.exit, met);
                            let has_room = stack.push::<L>(children, slabs.entry, met & !(1 << nearest));
                            next = Child(node.children()[nearest & 7]);
                            if has_room {
                                continue;
                            }
                            return;
                        }
                        let nearest = L::least_met(slabs.entry, slabs.exit, met);
                        next = Child(node.children()[nearest & 7]);
                        let orders = L::load_u32(node.orders());
                        let entry = L::permute(slabs.entry, orders, shift);
                        let exit = L::permute(slabs.exit, orders, shift);
                        let permuted = L::permute_u32(children, orders, shift);
                        let met = if REGULAR { L::le_or_negative(entry, exit) } else { L::le(entry, exit) };
                        let met = met & !L::eq_u32(permuted, L::splat_u32(next.0));
                        if stack.push::<L>(permuted, entry, met) { continue; } 
                        false
                    } else {
                        stack.push::<L>(children, slabs.entry, met)
                    };
                    debug_assert!(has_room);
                    if !has_room {
                        return;
                    }
                }
            }
            match stack.pop(t_max) {
                Some(child) => next = Child(child),
                None => return,
            }
        }
    }
}
