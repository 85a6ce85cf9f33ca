//! Where a subtree would be best.

use super::topology::{ROOT, Topology};
use crate::prim_info::Bounds3A;

/// No search looks below more nodes. In scenes hardly any does: it is 3 on average in sponza, 7 in hairball-procedural.
/// Of long thin triangles in all directions, nearly all of which overlap, it would be 540, for a gain larger by 2 %.
const MOST_OPENED: u32 = 64;

/// A place for a subtree, better than that where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Move {
    /// The slot of the subtree's root.
    pub(super) from: u32,
    /// The slot of the node whose sibling it should be.
    pub(super) to: u32,
    /// By how much the areas of all interior nodes together get less.
    pub(super) gain: f64,
}

/// Interior nodes whose children are to be looked at, each with what is saved if the subtree goes anywhere below, apart
/// from the area of its new parent.
pub(super) type Pending = Vec<(f64, u32)>;

/// The best place found for the subtree at `from`, which is not the root; `None` where none gains more than
/// `least_gain`.
///
/// Taking it out saves the area of its parent, and of each node further above what that shrinks by. Putting it back
/// costs the area of its new parent, and of each node above that what it grows by. The search goes from the old parent
/// up to the root; at each node it goes down on the other side, wherever the savings less the area of the subtree,
/// which the new parent has at least, are more than those of the best place so far (Meister and Bittner 2018,
/// algorithm 1), and it has looked below fewer than [`MOST_OPENED`].
pub(super) fn best_place(topology: &Topology, from: u32, least_gain: f64, pending: &mut Pending) -> Option<Move> {
    let subject = topology.bounds(from);
    let mut search = Search {
        topology,
        subject,
        subject_area: subject.surface_area(),
        best: Move { from, to: from, gain: least_gain },
        opened: 0,
        pending,
    };
    let mut pivot = topology.parent(from);
    let mut side = from ^ 1;
    // What is saved anywhere but below the pivot, and what the pivot shrinks to.
    let mut saved = topology.bounds(pivot).surface_area();
    let mut shrunk = topology.bounds(side);
    search.go_down(side, saved);
    while pivot != ROOT {
        side = pivot ^ 1;
        pivot = topology.parent(pivot);
        search.go_down(side, saved);
        shrunk = shrunk.union(&topology.bounds(side));
        let pivot_area = topology.bounds(pivot).surface_area();
        saved += pivot_area - shrunk.surface_area();
        // Beside all that is left of the pivot. The new parent has the bounds that the pivot had.
        search.consider(pivot, saved - pivot_area);
    }
    (search.best.to != from).then_some(search.best)
}

struct Search<'a> {
    topology: &'a Topology,
    subject: Bounds3A,
    subject_area: f64,
    best: Move,
    /// Below how many nodes it has looked.
    opened: u32,
    pending: &'a mut Pending,
}

impl Search<'_> {
    fn consider(&mut self, to: u32, gain: f64) {
        if gain > self.best.gain {
            self.best = Move { to, gain, ..self.best };
        }
    }

    /// Considers `node` and all below it, with what is `saved` if the subtree goes there.
    fn go_down(&mut self, node: u32, saved: f64) {
        self.look_at(node, saved);
        while let Some((saved, node)) = self.pending.pop() {
            if self.opened < MOST_OPENED
                && self.is_worth_it(saved)
                && let Some([a, b]) = self.topology.children(node)
            {
                self.opened += 1;
                self.look_at(a, saved);
                self.look_at(b, saved);
            }
        }
    }

    /// Considers `node`, and leaves what is below for later.
    fn look_at(&mut self, node: u32, saved: f64) {
        let bounds = self.topology.bounds(node);
        let new_parent = bounds.union(&self.subject).surface_area();
        self.consider(node, saved - new_parent);
        let saved = saved - (new_parent - bounds.surface_area());
        if self.is_worth_it(saved) && self.topology.children(node).is_some() {
            self.pending.push((saved, node));
        }
    }

    fn is_worth_it(&self, saved: f64) -> bool {
        saved - self.subject_area > self.best.gain
    }
}
