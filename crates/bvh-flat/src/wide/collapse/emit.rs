//! Writing nodes and leaves as planned.

use std::marker::PhantomData;
use std::ops::Range;

use geometry::Bounds3;

use super::plan::Plan;
use super::{BinaryTree, LeafWriter, Line};
use crate::parallel::join;
use crate::simd::LANES;
use crate::wide::arena::Child;
use crate::wide::node::WideNode;

/// Up to so many lines are written by one thread.
const SEQUENTIAL: usize = 1 << 13;

/// Writes subtrees, each into lines of its own: a node, its leaves, and then the subtrees below it.
pub(super) struct Emitter<'a, N, T: ?Sized, W> {
    tree: &'a T,
    plans: &'a [Plan],
    writer: &'a W,
    node: PhantomData<fn() -> N>,
}

/// A wide node in lines of the arena.
#[derive(Clone, Copy, Default)]
struct Place {
    /// The binary node that it is made of.
    node: usize,
    /// Its first line.
    at: usize,
}

/// The binary nodes that a wide one has for children.
#[derive(Default)]
struct Children {
    nodes: [usize; LANES],
    count: usize,
}

impl<'a, N: WideNode, T: BinaryTree + ?Sized, W: LeafWriter> Emitter<'a, N, T, W> {
    pub(super) fn new(tree: &'a T, plans: &'a [Plan], writer: &'a W) -> Self {
        Self { tree, plans, writer, node: PhantomData }
    }

    /// Writes the whole tree.
    pub(super) fn root(&self, lines: &mut [Line]) -> Child {
        if self.plans[0].is_leaf() {
            return self.leaf(0, 0, lines);
        }
        self.subtree(Place::default(), lines);
        Child::node(0)
    }

    /// Writes a wide node and everything below it.
    fn subtree(&self, Place { node, at }: Place, lines: &mut [Line]) {
        let mut children = Children::default();
        self.gather(node, LANES, &mut children);
        let nodes = &children.nodes[..children.count];
        let (own, mut rest) = lines.split_at_mut(N::LINES);
        let mut next = at + N::LINES;
        let mut bounds = [Bounds3::EMPTY; LANES];
        let mut references = [None; LANES];
        for (lane, &i) in nodes.iter().enumerate() {
            bounds[lane] = self.tree.bounds(i);
            if self.plans[i].is_leaf() {
                let (leaf, behind) = rest.split_at_mut(self.plans[i].line_count());
                references[lane] = Some(self.leaf(i, next, leaf));
                (next, rest) = (next + leaf.len(), behind);
            }
        }
        let mut below = [Place::default(); LANES];
        let mut count = 0;
        let begin = next;
        for (lane, &i) in nodes.iter().enumerate() {
            if !self.plans[i].is_leaf() {
                references[lane] = Some(Child::node(next));
                below[count] = Place { node: i, at: next };
                (next, count) = (next + self.plans[i].line_count(), count + 1);
            }
        }
        N::write(&bounds[..nodes.len()], &references[..nodes.len()], own);
        self.subtrees(&below[..count], begin, rest);
    }

    /// Writes some subtrees, one behind the other from line `begin` on.
    fn subtrees(&self, places: &[Place], begin: usize, lines: &mut [Line]) {
        match places {
            [] => {}
            [place] => self.subtree(*place, lines),
            _ => {
                let (first, second) = places.split_at(places.len() / 2);
                let middle = second[0].at;
                let (a, b) = lines.split_at_mut(middle - begin);
                if a.len() + b.len() <= SEQUENTIAL {
                    self.subtrees(first, begin, a);
                    self.subtrees(second, middle, b);
                } else {
                    join(|| self.subtrees(first, begin, a), || self.subtrees(second, middle, b));
                }
            }
        }
    }

    fn leaf(&self, node: usize, at: usize, lines: &mut [Line]) -> Child {
        let (place, count) = self.writer.write(self.range(node), at, lines);
        Child::leaf(place, count)
    }

    /// The places of all primitives below a node that becomes a leaf.
    fn range(&self, node: usize) -> Range<usize> {
        let mut first = node;
        while self.tree.second_child(first).is_some() {
            first += 1;
        }
        let begin = self.tree.range(first).start;
        begin..begin + self.plans[node].count()
    }

    /// The children as which a node is put under a wide one; as eight, those of a wide one of its own.
    fn gather(&self, node: usize, parts: usize, children: &mut Children) {
        if parts == 1 {
            children.nodes[children.count] = node;
            children.count += 1;
            return;
        }
        match (self.tree.second_child(node), self.plans[node].left_of(parts)) {
            // A leaf has no other plan.
            (None, _) => self.gather(node, 1, children),
            (Some(_), 0) => self.gather(node, parts - 1, children),
            (Some(second), left) => {
                self.gather(node + 1, left, children);
                self.gather(second, parts - left, children);
            }
        }
    }
}
