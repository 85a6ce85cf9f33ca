//! The way through the lines of a wide tree, eight boxes or triangles at a time.

use std::marker::PhantomData;

use geometry::{Bounds3, TriangleMesh};

use super::InvalidWideTree;
use crate::simd::{Kernel, LANES, LEAF_NUMBERS, Lanes, prefetch};
use crate::wide::arena::{Arena, Child};
use crate::wide::collapse::WideTree;
use crate::wide::node::{CheckedNode, WideNode};
use crate::wide::traverse::MAX_WIDE_DEPTH;
use crate::wide::triangles::{CheckedLayout, Scratch};

/// Planes of quantised boxes lie within four times the domain: no box is more than twice as large as what is in it. The
/// box test does not overflow there.
const MAX_PLANE: f32 = (1_u64 << 62) as f32;

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

/// The vertices of a mesh come from anywhere in memory: a leaf's triangles are asked for when it is met, their vertices
/// when as many others as half of these have been, and they are looked at when all have been. Without it a third of the
/// time is spent waiting.
const AWAITED: usize = 32;

/// Leaves whose triangles are still to be looked at.
struct Awaited {
    leaves: [Subtree; AWAITED],
    /// How many leaves have been met.
    met: usize,
}

/// What subtrees are looked through with.
pub(super) struct Checker<'a, Y, S> {
    arena: &'a Arena,
    is_split: bool,
    mesh: Option<&'a TriangleMesh>,
    /// Is shown each primitive; whether there is such a one, and it was not seen before.
    see: &'a S,
    layout: PhantomData<fn() -> Y>,
}

impl<'a, Y: CheckedLayout, S: Fn(u32) -> bool> Checker<'a, Y, S> {
    pub(super) fn new(tree: &'a WideTree, mesh: Option<&'a TriangleMesh>, see: &'a S) -> Self {
        Self { arena: &tree.arena, is_split: tree.is_split, mesh, see, layout: PhantomData }
    }

    /// The line behind a leaf, whose triangles are looked at when they have come from memory.
    #[inline(always)]
    fn leaf<L: Lanes>(&self, leaf: &Subtree, awaited: &mut Awaited) -> Result<usize, InvalidWideTree> {
        let (place, count) = (leaf.child.place(), leaf.child.count());
        let words = Y::word_count(count);
        let behind = place + words.div_ceil(16);
        let stored = self.arena.leaf(place).filter(|_| behind <= leaf.end);
        let Some(stored) = stored else {
            return Err(InvalidWideTree::OutOfRange { line: place, end: leaf.end });
        };
        for primitive in (0..count).map(|i| Y::id(stored, count, i)) {
            if !(self.see)(primitive) {
                return Err(InvalidWideTree::Primitive { leaf: place, primitive });
            }
            if let Some(triangle) = self.mesh.and_then(|mesh| mesh.triangles().get(primitive as usize)) {
                prefetch(triangle);
            }
        }
        let padding = stored[words.min(LEAF_NUMBERS)..].iter().take(16 * words.div_ceil(16) - words);
        if padding.fold(0, |all, x| all | x.to_bits()) != 0 {
            return Err(InvalidWideTree::Leaf { leaf: place });
        }
        awaited.met += 1;
        awaited.leaves[awaited.met % AWAITED] = *leaf;
        if awaited.met > AWAITED / 2 {
            self.prefetch_vertices(&awaited.leaves[(awaited.met - AWAITED / 2) % AWAITED]);
        }
        // The one whose place the next will take.
        if awaited.met >= AWAITED {
            self.triangles::<L>(&awaited.leaves[(awaited.met + 1) % AWAITED])?;
        }
        Ok(behind)
    }

    /// Asks for the vertices of a leaf's triangles, which are there by now.
    #[inline(always)]
    fn prefetch_vertices(&self, leaf: &Subtree) {
        let (Some(mesh), count) = (self.mesh, leaf.child.count()) else { return };
        let Some(stored) = self.arena.leaf(leaf.child.place()) else { return };
        for id in (0..count).map(|i| Y::id(stored, count, i)) {
            let triangle = mesh.triangles().get(id as usize).copied().unwrap_or_default();
            triangle.into_iter().filter_map(|i| mesh.positions().get(i as usize)).for_each(prefetch);
        }
    }

    /// Whether the triangles of a leaf are in its boxes, as large as it says, and those of the mesh.
    #[inline(always)]
    fn triangles<L: Lanes>(&self, leaf: &Subtree) -> Result<(), InvalidWideTree> {
        let (place, count) = (leaf.child.place(), leaf.child.count());
        let Some(stored) = self.arena.leaf(place) else {
            return Err(InvalidWideTree::OutOfRange { line: place, end: leaf.end });
        };
        let mut scratch = Y::Scratch::new();
        let block = Y::block(stored, count, self.mesh, &mut scratch);
        if block.is_some_and(|block| !is_within::<L>(block, count, &leaf.within, self.is_split)) {
            return Err(InvalidWideTree::Leaf { leaf: place });
        }
        match self.mesh {
            Some(mesh) if !Y::equals_mesh(stored, count, mesh) => Err(InvalidWideTree::Vertices { leaf: place }),
            _ => Ok(()),
        }
    }

    /// Looks at those that are still awaited.
    #[inline(always)]
    fn rest<L: Lanes>(&self, awaited: &Awaited) -> Result<(), InvalidWideTree> {
        let first = (awaited.met + 2).saturating_sub(AWAITED).max(1);
        (first..=awaited.met).try_for_each(|i| self.triangles::<L>(&awaited.leaves[i % AWAITED]))
    }

    /// Looks at a node and its leaves, and puts the subtrees below it on the stack, the first on top.
    #[inline(always)]
    fn node<L: Lanes>(
        &self,
        at: &Subtree,
        pending: &mut Vec<Subtree>,
        counts: &mut WideCounts,
        awaited: &mut Awaited,
    ) -> Result<(), InvalidWideTree> {
        let line = at.child.line();
        let begin = line + Y::Node::LINES;
        let node = self.arena.lines(line).filter(|_| begin <= at.end).and_then(Y::Node::read);
        let Some(node) = node else { return Err(InvalidWideTree::OutOfRange { line, end: at.end }) };
        let count = node.children().iter().position(|&child| child == 0).unwrap_or(LANES);
        if count < 2 || !node.is_canonical(count) {
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
            next = self.leaf::<L>(&leaf, awaited)?;
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

/// Whether the vertices of a leaf's triangles are between planes, or with spatial splits on both sides at most; and its
/// first number is one ulp more than the largest extent of any of them.
#[inline(always)]
fn is_within<L: Lanes>(block: &[f32; LEAF_NUMBERS], count: usize, within: &[f32; 6], is_split: bool) -> bool {
    let all = (1 << count) - 1;
    let mut valid = all;
    let mut extent = L::splat(0.0);
    for axis in 0..3 {
        let [low, high] = [0, 1].map(|side| L::splat(within[2 * axis + side]));
        let [a, b, c] = L::load_vertices(block, count, axis);
        let (min, max) = (L::min(L::min(a, b), c), L::max(L::max(a, b), c));
        // NaN is not equal to itself, and min and max do not keep it.
        valid &= L::le(a, a) & L::le(b, b) & L::le(c, c);
        valid &= if is_split { L::le(low, max) & L::le(min, high) } else { L::le(low, min) & L::le(max, high) };
        extent = L::max(extent, L::sub(max, min));
    }
    let largest = L::splat(block[0].next_down());
    valid & L::le(extent, largest) & all == all && L::le(largest, extent) & all != 0
}

/// Goes through subtrees, but not those of fewer than `leave` lines: they come out.
pub(super) struct Walk<'a, Y, S> {
    pub(super) checker: &'a Checker<'a, Y, S>,
    pub(super) pending: Vec<Subtree>,
    pub(super) leave: usize,
}

impl<Y: CheckedLayout, S: Fn(u32) -> bool> Kernel for Walk<'_, Y, S> {
    type Output = Result<(WideCounts, Vec<Subtree>), InvalidWideTree>;

    #[inline(always)]
    fn run<L: Lanes>(mut self) -> Self::Output {
        let mut counts = WideCounts::default();
        let mut left = Vec::new();
        let Some(&first) = self.pending.first() else { return Ok((counts, left)) };
        let mut awaited = Awaited { leaves: [first; AWAITED], met: 0 };
        while let Some(subtree) = self.pending.pop() {
            if subtree.child.is_leaf() {
                // Only the root comes here.
                let behind =
                    if subtree.child.place() == 0 { self.checker.leaf::<L>(&subtree, &mut awaited)? } else { 0 };
                if behind != subtree.end {
                    return Err(misplaced(0, subtree.child.place(), behind, subtree.end));
                }
                let references = subtree.child.count() as u64;
                counts = WideCounts { nodes: 0, leaves: 1, references, repeats: 0, depth: 1 };
            } else if subtree.end - subtree.child.line() < self.leave {
                left.push(subtree);
            } else {
                self.checker.node::<L>(&subtree, &mut self.pending, &mut counts, &mut awaited)?;
            }
        }
        self.checker.rest::<L>(&awaited)?;
        Ok((counts, left))
    }
}
