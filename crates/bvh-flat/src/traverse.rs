//! The way of a ray through the tree.

use std::ops::{ControlFlow, Range};

use geometry::{Hit, HitVisitor, Interval, Kernels, TraversalRay, Visit, Work};

use crate::FlatBvh;
use crate::stack::Stack;

/// The three queries, for whoever stores the primitives: `leaf` is given a range of the primitive order and does with
/// its primitives what the query says. A node is passed by only where the ray enters its box beyond `t_max`, so that a
/// hit at exactly the `t` of the closest so far is still found, and the smaller primitive wins whatever the tree. The
/// box test is that of `K`: [`Watertight`](geometry::Watertight), unless the loss of another is to be shown.
///
/// For that, no hit may have a `t` below the entry into its primitive's box, nor NaN. The order of primitives is
/// [`order`](Self::order). An empty interval is met by nothing. (pbrt's third edition, section 4.3.5; fourth, 7.3.5.)
impl FlatBvh {
    /// The closest hit. `leaf` answers with the closest of its range in the interval, which ends just above the `t` of
    /// the closest so far; of equal `t` with the smallest primitive.
    #[inline]
    pub fn intersect<K: Kernels>(
        &self,
        ray: &TraversalRay,
        interval: Interval,
        mut leaf: impl FnMut(Range<usize>, Interval) -> Option<Hit>,
    ) -> Option<Hit> {
        let mut closest: Option<Hit> = None;
        let mut t_max = interval.t_max();
        let _ = self.traverse::<K>(ray, interval, &mut (), |range, interval| {
            if let Some(hit) = leaf(range, interval)
                && closest.as_ref().is_none_or(|best| hit.is_before(best))
            {
                t_max = hit.t_max_for_ties();
                closest = Some(hit);
            }
            ControlFlow::Continue(t_max)
        });
        closest
    }

    /// Whether `leaf` answers yes for any range that the ray comes to.
    #[inline]
    pub fn intersect_p<K: Kernels>(
        &self,
        ray: &TraversalRay,
        interval: Interval,
        mut leaf: impl FnMut(Range<usize>, Interval) -> bool,
    ) -> bool {
        self.traverse::<K>(ray, interval, &mut (), |range, interval| {
            if leaf(range, interval) { ControlFlow::Break(()) } else { ControlFlow::Continue(interval.t_max()) }
        })
        .is_break()
    }

    /// Has `leaf` tell `visitor` of all hits of each range that the ray comes to, nearest first as far as the boxes
    /// tell, and then tells it what that cost.
    pub fn visit_hits<K: Kernels>(
        &self,
        ray: &TraversalRay,
        interval: Interval,
        visitor: &mut dyn HitVisitor,
        mut leaf: impl FnMut(Range<usize>, Interval, &mut dyn HitVisitor) -> Visit,
    ) -> Visit {
        let mut nodes = 0_u64;
        let visit = self.traverse::<K>(ray, interval, &mut nodes, |range, interval| leaf(range, interval, visitor));
        visitor.work(Work { nodes, primitives: 0 });
        visit
    }

    /// Near child first, by the sign of the direction on the axis of the split; both children's boxes are tested at
    /// their parent, and the far one again against the closest hit when its turn comes.
    #[inline]
    fn traverse<K: Kernels>(
        &self,
        ray: &TraversalRay,
        mut interval: Interval,
        nodes_visited: &mut impl NodeCounter,
        mut leaf: impl FnMut(Range<usize>, Interval) -> Visit,
    ) -> Visit {
        let nodes = self.nodes();
        if interval.is_empty() || nodes.is_empty() || K::enter(ray, &nodes[0].bounds(), interval).is_none() {
            return ControlFlow::Continue(interval.t_max());
        }
        let negative = ray.direction_is_negative();
        let mut stack = Stack::new();
        let mut index = 0;
        loop {
            nodes_visited.count();
            let node = &nodes[index];
            if node.is_leaf() {
                interval = interval.with_t_max(leaf(node.range(), interval)?);
            } else {
                let children = (index + 1, node.second_child());
                let (near, far) = if negative[node.axis()] { (children.1, children.0) } else { children };
                let near_entry = K::enter(ray, &nodes[near].bounds(), interval);
                let far_entry = K::enter(ray, &nodes[far].bounds(), interval);
                match (near_entry, far_entry) {
                    (Some(_), Some(entry)) => {
                        stack.push(far, entry);
                        index = near;
                        continue;
                    }
                    (Some(_), None) => {
                        index = near;
                        continue;
                    }
                    (None, Some(_)) => {
                        index = far;
                        continue;
                    }
                    (None, None) => {}
                }
            }
            match stack.pop(interval.t_max()) {
                Some(next) => index = next,
                None => return ControlFlow::Continue(interval.t_max()),
            }
        }
    }
}

/// Counts nodes on request: `()` counts nothing and costs nothing.
trait NodeCounter {
    fn count(&mut self);
}

impl NodeCounter for () {
    #[inline]
    fn count(&mut self) {}
}

impl NodeCounter for u64 {
    #[inline]
    fn count(&mut self) {
        *self += 1;
    }
}
