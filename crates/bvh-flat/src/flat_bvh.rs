//! The flattened tree.

use geometry::Bounds3;

use crate::{InvalidBvh, LinearBvhNode, validate::validate};

/// The deepest tree there is, in nodes on a path: traversal stacks are sized by it.
pub const MAX_DEPTH: usize = 96;

/// A bounding volume hierarchy in one array: depth first, the first child next to its parent, and the order of the
/// primitives into which the leaves' ranges point.
///
/// Valid by construction (see [`from_parts`](Self::from_parts)), so traversal need not check. A tree without nodes is
/// met by no ray. Boxes are in the space of the primitives. (pbrt's third edition, section 4.3.4; fourth, 7.3.4.)
///
/// With the feature `serde` it can be kept in any codec; what comes out of one goes through
/// [`from_split_parts`](Self::from_split_parts).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(try_from = "Parts"))]
pub struct FlatBvh {
    nodes: Vec<LinearBvhNode>,
    order: Vec<u32>,
    primitive_count: u32,
    extra_references: u32,
}

/// What a codec has of a tree.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
struct Parts {
    nodes: Vec<LinearBvhNode>,
    order: Vec<u32>,
    primitive_count: u32,
    extra_references: u32,
}

#[cfg(feature = "serde")]
impl TryFrom<Parts> for FlatBvh {
    type Error = InvalidBvh;

    fn try_from(parts: Parts) -> Result<Self, InvalidBvh> {
        Self::from_split_parts(parts.nodes, parts.order, parts.primitive_count, parts.extra_references)
    }
}

impl FlatBvh {
    /// A tree from its arrays: the nodes, the primitive that stands at each place of the order, and how many primitives
    /// there are, counting those that no leaf has.
    ///
    /// # Errors
    /// [`InvalidBvh`], unless: each node but the first is the child of exactly one node before it, and all are reached;
    /// the leaves' ranges tile the order from front to back, none empty; the order names primitives below
    /// `primitive_count`, none twice; all boxes are [valid](Bounds3::is_valid) and lie in their parent's; no path is
    /// longer than [`MAX_DEPTH`]; axes are below 3 and padding is zero.
    pub fn from_parts(nodes: Vec<LinearBvhNode>, order: Vec<u32>, primitive_count: u32) -> Result<Self, InvalidBvh> {
        Self::from_split_parts(nodes, order, primitive_count, 0)
    }

    /// The same for a tree whose space may have been split, so that primitives stand in the order more than once: the
    /// places whose primitive stands before them already are `extra_references` at most.
    ///
    /// # Errors
    /// As [`from_parts`](Self::from_parts), but for that.
    pub fn from_split_parts(
        nodes: Vec<LinearBvhNode>,
        order: Vec<u32>,
        primitive_count: u32,
        extra_references: u32,
    ) -> Result<Self, InvalidBvh> {
        let extra_references = validate(&nodes, &order, primitive_count, extra_references)?;
        Ok(Self { nodes, order, primitive_count, extra_references })
    }

    /// A tree whose maker upholds what [`from_split_parts`](Self::from_split_parts) checks.
    #[cfg(feature = "build")]
    pub(crate) fn from_valid_parts(
        nodes: Vec<LinearBvhNode>,
        order: Vec<u32>,
        primitive_count: u32,
        extra_references: u32,
    ) -> Self {
        debug_assert_eq!(validate(&nodes, &order, primitive_count, extra_references), Ok(extra_references));
        Self { nodes, order, primitive_count, extra_references }
    }

    /// The nodes, whose boxes may change, and the order.
    pub(crate) fn parts_mut(&mut self) -> (&mut [LinearBvhNode], &[u32]) {
        (&mut self.nodes, &self.order)
    }

    /// The nodes, the root first.
    pub fn nodes(&self) -> &[LinearBvhNode] {
        &self.nodes
    }

    /// The primitive at each place of the order: what the [ranges](LinearBvhNode::range) of leaves point into.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// How many primitives the tree was built over, counting the inactive.
    pub fn primitive_count(&self) -> u32 {
        self.primitive_count
    }

    /// How many places of the order have a primitive that stands there before. If any, a leaf need not contain its
    /// primitives, but only the parts of them that are in no other leaf.
    pub fn extra_references(&self) -> u32 {
        self.extra_references
    }

    /// The box around everything; empty for an empty tree.
    pub fn bounds(&self) -> Bounds3 {
        self.nodes.first().map_or(Bounds3::EMPTY, LinearBvhNode::bounds)
    }

    /// The number of nodes on the longest path: 1 for a single leaf, 0 for an empty tree.
    pub fn depth(&self) -> usize {
        // The depths of the second children to come.
        let mut pending = Vec::new();
        let (mut next, mut deepest) = (Some(1), 0);
        for node in &self.nodes {
            let depth = next.unwrap_or_default();
            deepest = deepest.max(depth);
            next = if node.is_leaf() {
                pending.pop()
            } else {
                pending.push(depth + 1);
                Some(depth + 1)
            };
        }
        deepest
    }

    /// The memory of nodes and order, in bytes.
    pub fn memory(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.order.as_slice())
    }
}
