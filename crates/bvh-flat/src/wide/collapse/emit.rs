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
use crate::wide::progress::Update;

/// Up to so many lines are written by one thread.
const SEQUENTIAL: usize = 1 << 13;

/// Writes subtrees, each into lines of its own: a node, its leaves, and then the subtrees below it.
pub(super) struct Emitter<'a, N, T: ?Sized, W> {
    tree: &'a T,
    plans: &'a [Plan],
    writer: &'a W,
    update: &'a Update<'a>,
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

/// The wide nodes below another.
#[derive(Default)]
struct Below {
    places: [Place; LANES],
    count: usize,
}

impl Below {
    fn places(&self) -> &[Place] {
        &self.places[..self.count]
    }
}

/// The binary nodes that a wide one has for children.
#[derive(Default)]
struct Children {
    nodes: [usize; LANES],
    count: usize,
}

impl<'a, N: WideNode, T: BinaryTree + ?Sized, W: LeafWriter> Emitter<'a, N, T, W> {
    pub(super) fn new(tree: &'a T, plans: &'a [Plan], writer: &'a W, update: &'a Update) -> Self {
        Self { tree, plans, writer, update, node: PhantomData }
    }

    /// Writes the whole tree, and says where its root is, if there is one. `None` where it is broken off.
    pub(super) fn root(&self, lines: &mut [Line]) -> Option<Option<Child>> {
        if self.plans.is_empty() {
            return Some(None);
        }
        if self.plans[0].is_leaf() {
            (self.update)(lines.len())?;
            return Some(Some(self.leaf(0, 0, lines)));
        }
        self.subtree(Place::default(), lines)?;
        Some(Some(Child::node(0)))
    }

    /// Writes a wide node and everything below it.
    fn subtree(&self, place: Place, lines: &mut [Line]) -> Option<()> {
        let count = lines.len();
        if count <= SEQUENTIAL {
            (self.update)(count)?;
            self.block(place, lines);
            return Some(());
        }
        let (below, rest) = self.node(place, lines);
        (self.update)(count - rest.len())?;
        self.subtrees(below.places(), rest)
    }

    /// Writes some subtrees, one behind the other.
    fn subtrees(&self, places: &[Place], lines: &mut [Line]) -> Option<()> {
        match places {
            [] => Some(()),
            [place] => self.subtree(*place, lines),
            _ => {
                let (first, second) = places.split_at(places.len() / 2);
                let (a, b) = lines.split_at_mut(second[0].at - first[0].at);
                let (a, b) = join(|| self.subtrees(first, a), || self.subtrees(second, b));
                a.and(b)
            }
        }
    }

    /// As [`subtree`](Self::subtree), by one thread.
    fn block(&self, place: Place, lines: &mut [Line]) {
        let (below, mut rest) = self.node(place, lines);
        for &place in below.places() {
            let (lines, behind) = rest.split_at_mut(self.plans[place.node].line_count());
            self.block(place, lines);
            rest = behind;
        }
    }

    /// Writes a wide node and its leaves: the wide nodes below it, and the lines for these.
    fn node<'l>(&self, Place { node, at }: Place, lines: &'l mut [Line]) -> (Below, &'l mut [Line]) {
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
        let mut below = Below::default();
        for (lane, &i) in nodes.iter().enumerate() {
            if !self.plans[i].is_leaf() {
                references[lane] = Some(Child::node(next));
                below.places[below.count] = Place { node: i, at: next };
                below.count += 1;
                next += self.plans[i].line_count();
            }
        }
        N::write(&bounds[..nodes.len()], &references[..nodes.len()], own);
        (below, rest)
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
