//! From a built tree to the flat one.

use bvh_build::{Node, NodeKind, Tree};
use geometry::Bounds3;

use crate::{BuildConfig, BuildError, BuildObserver, FlatBvh, LinearBvhNode};

// Traversal's stack is as deep as trees are built.
const _: () = assert!(bvh_build::MAX_DEPTH as usize <= crate::MAX_DEPTH);

impl FlatBvh {
    /// Builds and flattens a tree over `bounds`. A primitive whose box is not [valid](Bounds3::is_valid) is inactive: it
    /// keeps its number, and no leaf has it.
    ///
    /// # Errors
    /// [`BuildError`] for a configuration or a number of primitives that the builder refuses.
    pub fn build(bounds: &[Bounds3], config: &BuildConfig, observer: &dyn BuildObserver) -> Result<Self, BuildError> {
        Ok(Self::from_tree(bvh_build::build_observed(bounds, config, observer)?))
    }

    /// Flattens a built tree, whose nodes stand depth first already: only their form changes.
    pub fn from_tree(tree: Tree) -> Self {
        let nodes = tree.nodes().iter().map(linear_node).collect();
        let statistics = tree.statistics();
        let primitive_count = statistics.active_count + statistics.inactive_count;
        let extra_references = statistics.reference_count - statistics.active_count;
        Self::from_valid_parts(nodes, tree.into_order(), primitive_count, extra_references)
    }
}

fn linear_node(node: &Node) -> LinearBvhNode {
    match node.kind {
        NodeKind::Interior { axis, second_child } => LinearBvhNode::interior(node.bounds, axis, second_child),
        // A configuration allows at most 65535 primitives in a leaf.
        NodeKind::Leaf { first, count } => LinearBvhNode::leaf(node.bounds, first, count as u16),
    }
}
