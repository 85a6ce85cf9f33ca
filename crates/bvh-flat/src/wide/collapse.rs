//! From a binary tree to a wide one, by cost.

mod emit;
mod plan;

use std::borrow::Cow;
use std::ops::Range;

use geometry::Bounds3;

use super::arena::{Arena, Child, LEAF_LINES, Line, MAX_LINES};
use super::node::WideNode;
use super::progress::{NoWideTree, Stage, Watch};
use crate::simd::LANES;
use crate::{FlatBvh, LinearBvhNode};
use emit::Emitter;
use plan::{Plan, plan};

/// A tree of nodes with up to eight children, and leaves with up to eight primitives.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WideTree {
    pub(crate) arena: Arena,
    /// `None` where there is nothing to hit.
    pub(crate) root: Option<Child>,
    pub(crate) bounds: Bounds3,
    /// Whether a primitive may be in several leaves.
    pub(crate) is_split: bool,
    /// How many steps, to nodes and leaves, a random ray through the bounds is expected to make: the cost of the
    /// surface area heuristic.
    pub(crate) expected_steps: f64,
}

/// Puts the primitives at a range of the order, at most eight, where a leaf of them finds them.
pub(crate) trait LeafWriter: Sync {
    /// How many lines such a leaf takes.
    fn line_count(&self, range: Range<usize>) -> usize;

    /// Writes so many lines, which are zero and begin at line `at` of the arena: the place by which a leaf finds the
    /// primitives, and how many they are, each once.
    fn write(&self, range: Range<usize>, at: usize, lines: &mut [Line]) -> (usize, usize);

    /// What testing `count` primitives of a leaf costs, where testing the eight boxes of a node costs 1.
    fn cost(&self, count: usize) -> f64;
}

/// A binary tree, depth first: the first child of a node is the next one.
pub(crate) trait BinaryTree: Sync {
    /// How many nodes it has.
    fn len(&self) -> usize;

    /// The bounds of a node.
    fn bounds(&self, node: usize) -> Bounds3;

    /// The second child of a node; `None` for a leaf.
    fn second_child(&self, node: usize) -> Option<usize>;

    /// The places of a leaf's primitives in the order, at most eight.
    fn range(&self, leaf: usize) -> Range<usize>;
}

impl BinaryTree for [LinearBvhNode] {
    fn len(&self) -> usize {
        self.len()
    }

    fn bounds(&self, node: usize) -> Bounds3 {
        self[node].bounds()
    }

    fn second_child(&self, node: usize) -> Option<usize> {
        (!self[node].is_leaf()).then(|| self[node].second_child())
    }

    fn range(&self, leaf: usize) -> Range<usize> {
        self[leaf].range()
    }
}

#[cfg(feature = "build")]
impl BinaryTree for [bvh_build::Node] {
    fn len(&self) -> usize {
        self.len()
    }

    fn bounds(&self, node: usize) -> Bounds3 {
        self[node].bounds
    }

    fn second_child(&self, node: usize) -> Option<usize> {
        match self[node].kind {
            bvh_build::NodeKind::Interior { second_child, .. } => Some(second_child as usize),
            bvh_build::NodeKind::Leaf { .. } => None,
        }
    }

    fn range(&self, leaf: usize) -> Range<usize> {
        match self[leaf].kind {
            bvh_build::NodeKind::Interior { .. } => 0..0,
            bvh_build::NodeKind::Leaf { first, count } => first as usize..first as usize + count as usize,
        }
    }
}

/// Which binary nodes become wide nodes and leaves is decided by dynamic programming, after Ylitie, Karras and Laine
/// 2017, *Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs*, section 4: the least sum of area
/// times cost over all nodes and leaves.
///
/// The plan says how many lines each subtree takes, so that all are written in parallel into memory of the right size.
///
/// `is_split` says whether a primitive may be in several leaves.
pub(crate) fn collapse<N: WideNode>(
    tree: &(impl BinaryTree + ?Sized),
    is_split: bool,
    writer: &impl LeafWriter,
    watch: &impl Watch,
) -> Result<WideTree, NoWideTree> {
    let mut plans = bytemuck::zeroed_vec(tree.len());
    let cost = watch.observe(Stage::Plan, tree.len(), |update| plan::<N>(tree, &mut plans, writer, update));
    let cost = cost.ok_or(NoWideTree::Cancelled)?;
    let count = plans.first().map_or(0, Plan::line_count);
    if count > MAX_LINES {
        return Err(NoWideTree::TooLarge);
    }
    let written = watch.observe(Stage::Emission, count, |update| {
        let emitter = Emitter::<N, _, _>::new(tree, &plans, writer, update);
        let (arena, root) = Arena::written(count + LEAF_LINES, |lines| emitter.root(&mut lines[..count]));
        Some((arena, root?))
    });
    let (arena, root) = written.ok_or(NoWideTree::Cancelled)?;
    let bounds = root.map_or(Bounds3::EMPTY, |_| tree.bounds(0));
    let area = bounds.surface_area();
    let expected_steps = if area > 0.0 { cost / area } else { 0.0 };
    Ok(WideTree { arena, root, bounds, is_split, expected_steps })
}

/// The same tree with leaves of at most eight primitives.
pub(crate) fn with_small_leaves(bvh: &FlatBvh) -> Cow<'_, [LinearBvhNode]> {
    let nodes = bvh.nodes();
    if nodes.iter().all(|node| usize::from(node.count) <= LANES) {
        return Cow::Borrowed(nodes);
    }
    let mut small: Vec<LinearBvhNode> = Vec::with_capacity(2 * nodes.len());
    // Where each node went.
    let moved: Vec<u32> = nodes
        .iter()
        .map(|node| {
            let at = small.len();
            if node.is_leaf() {
                divide(node, node.range(), &mut small);
            } else {
                small.push(*node);
            }
            at as u32
        })
        .collect();
    for (node, &at) in nodes.iter().zip(&moved).filter(|(node, _)| !node.is_leaf()) {
        small[at as usize].offset = moved[node.second_child()];
    }
    Cow::Owned(small)
}

/// Appends a part of a leaf as leaves of at most eight primitives, and nodes above them.
fn divide(leaf: &LinearBvhNode, range: Range<usize>, nodes: &mut Vec<LinearBvhNode>) {
    let at = nodes.len();
    nodes.push(LinearBvhNode { offset: range.start as u32, count: range.len() as u16, ..*leaf });
    if range.len() > LANES {
        // The first half in whole leaves.
        let middle = range.start + (range.len() / 2).next_multiple_of(LANES);
        divide(leaf, range.start..middle, nodes);
        nodes[at] = LinearBvhNode { offset: nodes.len() as u32, count: 0, ..*leaf };
        divide(leaf, middle..range.end, nodes);
    }
}
