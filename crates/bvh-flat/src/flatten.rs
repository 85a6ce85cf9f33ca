//! From a built tree to the flat one.

use bvh_build::{Cancelled, Node, NodeKind, Phase, ProgressReporter, Tree};
use geometry::Bounds3;

use crate::{BuildConfig, BuildError, BuildObserver, FlatBvh, LinearBvhNode};

// Traversal's stack is as deep as trees are built.
const _: () = assert!(bvh_build::MAX_DEPTH as usize <= crate::MAX_DEPTH);

impl FlatBvh {
    /// Builds and flattens a tree over `bounds`, as [`bvh_build::build_observed`] does. A primitive whose box is not
    /// [valid](Bounds3::is_valid) is inactive: it keeps its number, and no leaf has it. Space is not split, whatever
    /// the configuration says; for that, [flatten](Self::from_tree) what [`bvh_build::build_split`] builds.
    ///
    /// # Errors
    /// [`BuildError`] for a configuration or a number of primitives that the builder refuses, and where `observer`
    /// cancels.
    pub fn build(bounds: &[Bounds3], config: &BuildConfig, observer: &dyn BuildObserver) -> Result<Self, BuildError> {
        let tree = bvh_build::build_observed(bounds, config, observer)?;
        let nodes = tree.nodes();
        let nodes = observed_collect(observer, Phase::Emission, nodes.len(), |i| linear_node(&nodes[i]))?;
        Ok(Self::with_nodes(nodes, tree))
    }

    /// Flattens a built tree, whose nodes stand depth first already: only their form changes.
    pub fn from_tree(tree: Tree) -> Self {
        Self::with_nodes(tree.nodes().iter().map(linear_node).collect(), tree)
    }

    /// `tree`, whose nodes have this other form.
    fn with_nodes(nodes: Vec<LinearBvhNode>, tree: Tree) -> Self {
        let statistics = tree.statistics();
        let primitive_count = statistics.active_count + statistics.inactive_count;
        let extra_references = statistics.reference_count - statistics.active_count;
        Self::from_valid_parts(nodes, tree.into_order(), primitive_count, extra_references)
    }
}

/// The result for each number below `count`, as `phase`, whose items these are.
pub(crate) fn observed_collect<T>(
    observer: &dyn BuildObserver,
    phase: Phase,
    count: usize,
    f: impl Fn(usize) -> T,
) -> Result<Vec<T>, Cancelled> {
    const PART: usize = 1 << 13;
    ProgressReporter::observe(observer, phase, count, |progress| {
        let mut all = Vec::with_capacity(count);
        for begin in (0..count).step_by(PART) {
            let end = count.min(begin + PART);
            all.extend((begin..end).map(&f));
            progress.update(end - begin)?;
        }
        Ok(all)
    })
}

fn linear_node(node: &Node) -> LinearBvhNode {
    match node.kind {
        NodeKind::Interior { axis, second_child } => LinearBvhNode::interior(node.bounds, axis, second_child),
        // A configuration allows at most 65535 primitives in a leaf.
        NodeKind::Leaf { first, count } => LinearBvhNode::leaf(node.bounds, first, count as u16),
    }
}
