//! The way through the lines of a wide tree, eight boxes or triangles at a time.

use std::marker::PhantomData;

use geometry::{Bounds3, TriangleMesh};

use super::InvalidWideTree;
use super::batch::{Batch, Leaf, See};
use crate::simd::{Kernel, LANES, Lanes};
use crate::wide::arena::{Arena, Child};
use crate::wide::collapse::WideTree;
use crate::wide::node::{CheckedNode, WideNode};
use crate::wide::traverse::MAX_WIDE_DEPTH;
use crate::wide::triangles::CheckedLayout;

/// Planes of quantised boxes lie within four times the domain: no box is more than twice as large as what is in it. The
/// box test does not overflow there.
const MAX_PLANE: f32 = (1_u64 << 62) as f32;

/// Lines are asked for so far ahead.
const AHEAD: usize = 64;

/// What a tree consists of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct WideCounts {
    pub(crate) nodes: u64,
    pub(crate) leaves: u64,
    pub(crate) references: u64,
    /// Of them those that are not the first to their primitive.
    pub(crate) repeats: u64,
    /// Nodes on the longest path, with the leaf.
    pub(crate) depth: usize,
}

#[cfg(feature = "parallel")]
impl WideCounts {
    pub(super) fn and(self, other: Self) -> Self {
        Self {
            nodes: self.nodes + other.nodes,
            leaves: self.leaves + other.leaves,
            references: self.references + other.references,
            repeats: self.repeats + other.repeats,
            depth: self.depth.max(other.depth),
        }
    }
}

/// A node or leaf, and where the lines of its subtree end.
#[derive(Clone, Copy)]
pub(super) struct Subtree {
    child: Child,
    end: usize,
    /// How many nodes are on the path to it, with itself.
    depth: usize,
    /// The planes between which everything in it must be: min x, max x, min y, ….
    within: [f32; 6],
}

impl Subtree {
    pub(super) fn root(child: Child, end: usize, bounds: &Bounds3) -> Self {
        let within = std::array::from_fn(|i| if i % 2 == 0 { bounds.min[i / 2] } else { bounds.max[i / 2] });
        Self { child, end, depth: 1, within }
    }
}

/// What subtrees are looked through with.
pub(super) struct Checker<'a, Y, S> {
    arena: &'a Arena,
    is_split: bool,
    mesh: Option<&'a TriangleMesh>,
    /// Is shown each primitive.
    see: &'a S,
    layout: PhantomData<fn() -> Y>,
}

impl<'a, Y: CheckedLayout, S: See> Checker<'a, Y, S> {
    pub(super) fn new(tree: &'a WideTree, mesh: Option<&'a TriangleMesh>, see: &'a S) -> Self {
        Self { arena: &tree.arena, is_split: tree.is_split, mesh, see, layout: PhantomData }
    }

    /// The line behind a leaf, whose triangles are looked at later, with many others.
    #[inline(always)]
    fn leaf<L: Lanes>(&self, leaf: &Subtree, batch: &mut Batch) -> Result<usize, InvalidWideTree> {
        let (place, count) = (leaf.child.place(), leaf.child.count());
        let behind = place + Y::word_count(count).div_ceil(16);
        let Some(stored) = self.arena.leaf(place).filter(|_| behind <= leaf.end) else {
            return Err(InvalidWideTree::OutOfRange { line: place, end: leaf.end });
        };
        self.arena.prefetch(place + AHEAD);
        batch.add(Leaf { place, count, within: leaf.within }, &Y::ids(stored, count));
        if batch.is_full() {
            self.check::<L>(batch)?;
        }
        Ok(behind)
    }

    #[inline(always)]
    fn check<L: Lanes>(&self, batch: &mut Batch) -> Result<(), InvalidWideTree> {
        batch.check::<L, Y>(self.arena, self.mesh, self.see, self.is_split)
    }

    /// Looks at a node and its leaves, and puts the subtrees below it on the stack, the first on top.
    #[inline(always)]
    fn node<L: Lanes>(
        &self,
        at: &Subtree,
        pending: &mut Vec<Subtree>,
        counts: &mut WideCounts,
        batch: &mut Batch,
    ) -> Result<(), InvalidWideTree> {
        let line = at.child.line();
        let begin = line + Y::Node::LINES;
        let node = self.arena.lines(line).filter(|_| begin <= at.end).and_then(Y::Node::read);
        let Some(node) = node else { return Err(InvalidWideTree::OutOfRange { line, end: at.end }) };
        let count = node.children().iter().position(|&child| child == 0).unwrap_or(LANES);
        if count < 2 || !node.is_canonical::<L>(count) {
            return Err(InvalidWideTree::Node { node: line });
        }
        if at.depth >= MAX_WIDE_DEPTH {
            return Err(InvalidWideTree::TooDeep { node: line });
        }
        let Some(boxes) = boxes_within::<L, Y::Node>(node, count, &at.within) else {
            return Err(InvalidWideTree::Bounds { node: line });
        };
        let child = |lane: usize| Subtree {
            child: node.child(lane as u32),
            depth: at.depth + 1,
            within: std::array::from_fn(|i| boxes[i][lane & 7]),
            ..*at
        };
        let mut next = begin;
        for leaf in (0..count).map(child).filter(|child| child.child.is_leaf()) {
            if leaf.child.place() != next {
                return Err(misplaced(line, leaf.child.place(), next, at.end));
            }
            next = self.leaf::<L>(&leaf, batch)?;
            counts.leaves += 1;
            counts.references += leaf.child.count() as u64;
        }
        let first = pending.len();
        for subtree in (0..count).map(child).filter(|child| !child.child.is_leaf()) {
            let begins = subtree.child.line();
            // The first one begins behind the leaves; the others somewhere behind the node of the one before, which
            // must then end there.
            let is_first = pending.len() == first;
            if begins < next || begins >= at.end || (is_first && begins != next) {
                return Err(misplaced(line, begins, next, at.end));
            }
            if let Some(before) = pending[first..].last_mut() {
                before.end = begins;
            }
            pending.push(subtree);
            next = begins + Y::Node::LINES;
        }
        if pending.len() == first && next != at.end {
            return Err(misplaced(line, at.end, next, at.end));
        }
        pending[first..].reverse();
        counts.nodes += 1;
        counts.depth = counts.depth.max(at.depth + 1);
        Ok(())
    }
}

/// What is wrong with a reference from a node to `line`, where `next` was to come.
#[cold]
fn misplaced(node: usize, line: usize, next: usize, end: usize) -> InvalidWideTree {
    match line {
        _ if line <= node => InvalidWideTree::Cycle { node, line },
        _ if line < next => InvalidWideTree::Overlap { node, line, next },
        _ if line <= end => InvalidWideTree::Gap { node, line, next },
        _ => InvalidWideTree::OutOfRange { line, end },
    }
}

/// The boxes of a node's children, cut to what is above; `None` where one is not valid, or not inside of that where it
/// should be.
#[inline(always)]
fn boxes_within<L: Lanes, N: CheckedNode>(node: &N, count: usize, within: &[f32; 6]) -> Option<[[f32; LANES]; 6]> {
    let mut boxes = [[0.0; LANES]; 6];
    let mut valid = (1 << count) - 1;
    for axis in 0..3 {
        let [min, max] = [0, 1].map(|side| node.planes::<L>(16 * axis + 8 * side));
        let [low, high] = [0, 1].map(|side| L::splat(within[2 * axis + side]));
        valid &= L::le(min, max);
        let (min, max) = if N::IS_NESTED {
            valid &= L::le(low, min) & L::le(max, high);
            (min, max)
        } else {
            valid &= L::le(L::splat(-MAX_PLANE), min) & L::le(max, L::splat(MAX_PLANE));
            (L::max(low, min), L::min(high, max))
        };
        boxes[2 * axis] = L::to_array(min);
        boxes[2 * axis + 1] = L::to_array(max);
    }
    (valid == (1 << count) - 1).then_some(boxes)
}

/// Goes through subtrees, but not those of fewer than `leave` lines: they come out.
pub(super) struct Walk<'a, Y, S> {
    pub(super) checker: &'a Checker<'a, Y, S>,
    pub(super) pending: Vec<Subtree>,
    pub(super) leave: usize,
}

impl<Y: CheckedLayout, S: See> Kernel for Walk<'_, Y, S> {
    type Output = Result<(WideCounts, Vec<Subtree>), InvalidWideTree>;

    #[inline(always)]
    fn run<L: Lanes>(mut self) -> Self::Output {
        let mut batch = Batch::new();
        let walked = self.walk::<L>(&mut batch);
        // Leaves that were met before a fault come before it.
        self.checker.check::<L>(&mut batch)?;
        walked
    }
}

impl<Y: CheckedLayout, S: See> Walk<'_, Y, S> {
    #[inline(always)]
    fn walk<L: Lanes>(&mut self, batch: &mut Batch) -> Result<(WideCounts, Vec<Subtree>), InvalidWideTree> {
        let mut counts = WideCounts::default();
        let mut left = Vec::new();
        while let Some(subtree) = self.pending.pop() {
            if subtree.child.is_leaf() {
                // Only the root comes here.
                let behind = if subtree.child.place() == 0 { self.checker.leaf::<L>(&subtree, batch)? } else { 0 };
                if behind != subtree.end {
                    return Err(misplaced(0, subtree.child.place(), behind, subtree.end));
                }
                let references = subtree.child.count() as u64;
                counts = WideCounts { nodes: 0, leaves: 1, references, repeats: 0, depth: 1 };
            } else if subtree.end - subtree.child.line() < self.leave {
                left.push(subtree);
            } else {
                self.checker.node::<L>(&subtree, &mut self.pending, &mut counts, batch)?;
            }
        }
        Ok((counts, left))
    }
}
