//! Trees.

use std::ops::Range;

use geometry::{Axis, Bounds3};

use crate::{BuildConfig, Cancelled, ProgressReporter, parallel};

/// A bounding volume hierarchy over the active ones of the bounds it was built from.
///
/// Every node's bounds contain those of its children, and a leaf's bounds contain those of its primitives, exactly;
/// they are the smallest that do. Every active primitive is in one leaf. No path has more than
/// [`MAX_DEPTH`](crate::MAX_DEPTH) nodes, and n primitives make at most 2n − 1 of them.
///
/// Where space was [split](crate::SpatialSplits), a primitive may be in several leaves, in none of them twice: each has
/// the part of it that is within its bounds, and together all of it. Then n counts these references.
#[derive(Clone, Debug, PartialEq)]
pub struct Tree {
    nodes: Vec<Node>,
    order: Vec<u32>,
    statistics: TreeStatistics,
}

/// A node with its bounds, before it is packed (`LinearBvhNode` of `bvh-flat`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// The bounds of everything below, in the space of the bounds that the tree was built over; always
    /// [valid](Bounds3::is_valid).
    pub bounds: Bounds3,
    /// What is below.
    pub kind: NodeKind,
}

/// What is below a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeKind {
    /// Two children: the first directly behind this node, the second further on.
    Interior {
        /// The axis along which the children were divided: the first one is the lower. So a ray whose direction is
        /// negative on it meets the second one first, as a rule.
        axis: Axis,
        /// The index of the second child in [`Tree::nodes`], behind all that is below the first.
        second_child: u32,
    },
    /// Primitives.
    Leaf {
        /// Where they begin in [`Tree::order`].
        first: u32,
        /// How many they are; at least one.
        count: u32,
    },
}

impl NodeKind {
    /// The places of a leaf's primitives in the order.
    #[inline]
    pub(crate) fn places(&self) -> Range<usize> {
        match *self {
            Self::Leaf { first, count } => first as usize..first as usize + count as usize,
            Self::Interior { .. } => 0..0,
        }
    }
}

/// What a tree is like, as it was built.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct TreeStatistics {
    /// How many nodes it has.
    pub node_count: u32,
    /// How many of them are leaves.
    pub leaf_count: u32,
    /// The number of nodes on the longest path: 1 for a single leaf, 0 for the empty tree.
    pub depth: u32,
    /// The number of primitives in the largest leaf.
    pub largest_leaf: u32,
    /// How many primitives are in the tree.
    pub active_count: u32,
    /// How many references to them the leaves have: more than primitives where [space was
    /// split](crate::SpatialSplits).
    pub reference_count: u32,
    /// How many primitives are not in the tree: their bounds are empty, NaN or outside of the domain
    /// ([`Bounds3::is_valid`]).
    pub inactive_count: u32,
    /// The expected cost of a random ray that meets the tree's bounds, by the surface area heuristic and with the
    /// costs of the configuration: the sum of p · t_trav over the interior nodes and of p · (t_leaf + n · t_isect) over
    /// the leaves, where p is a node's area as a part of the root's. Where the root has no area, p is 1. Always finite.
    pub sah_cost: f64,
}

impl Tree {
    /// With the statistics; `active_count` of `primitive_count` primitives are in it.
    pub(crate) fn new(
        nodes: Vec<Node>,
        order: Vec<u32>,
        [active_count, primitive_count]: [usize; 2],
        config: &BuildConfig,
        progress: &ProgressReporter,
    ) -> Result<Self, Cancelled> {
        let statistics = TreeStatistics {
            active_count: active_count as u32,
            inactive_count: (primitive_count - active_count) as u32,
            reference_count: order.len() as u32,
            ..TreeStatistics::of(&nodes, config, progress)?
        };
        Ok(Self { nodes, order, statistics })
    }

    /// All nodes in depth-first order: the root first, every first child directly behind its parent. None where there
    /// are no active primitives.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The indices of the active primitives, leaf by leaf in the order of the nodes, each as often as it is in a leaf.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// The same indices, taken out of the tree.
    pub fn into_order(self) -> Vec<u32> {
        self.order
    }

    pub(crate) fn into_parts(self) -> (Vec<Node>, Vec<u32>) {
        (self.nodes, self.order)
    }

    /// What the tree is like.
    pub fn statistics(&self) -> &TreeStatistics {
        &self.statistics
    }

    /// The bounds of all active primitives; empty where there are none.
    pub fn bounds(&self) -> Bounds3 {
        self.nodes.first().map_or(Bounds3::EMPTY, |root| root.bounds)
    }
}

impl TreeStatistics {
    /// The statistics of `nodes`, without those of primitives.
    fn of(nodes: &[Node], config: &BuildConfig, progress: &ProgressReporter) -> Result<Self, Cancelled> {
        let Some(root) = nodes.first() else { return Ok(Self::default()) };
        let area = root.bounds.surface_area();
        // Without any extent every ray that meets the root meets all.
        let probability = |bounds: &Bounds3| if area > 0.0 { bounds.surface_area() / area } else { 1.0 };
        let add = |all: Self, node: &Node| {
            let (leaf_count, in_leaf, cost) = match node.kind {
                NodeKind::Interior { .. } => (0, 0, f64::from(config.traversal_cost)),
                NodeKind::Leaf { count, .. } => (1, count, config.cost_of_leaf(count)),
            };
            Self {
                leaf_count: all.leaf_count + leaf_count,
                largest_leaf: all.largest_leaf.max(in_leaf),
                sah_cost: all.sah_cost + probability(&node.bounds) * cost,
                ..all
            }
        };
        let part = |nodes: &[Node]| nodes.iter().fold(Self::default(), add);
        let unite = |a: Self, b: Self| Self {
            leaf_count: a.leaf_count + b.leaf_count,
            largest_leaf: a.largest_leaf.max(b.largest_leaf),
            sah_cost: a.sah_cost + b.sah_cost,
            ..a
        };
        let (statistics, depth) =
            parallel::try_join(|| parallel::fold(nodes, progress, &part, &unite), || depth(nodes, progress))?;
        Ok(Self { node_count: nodes.len() as u32, depth, ..statistics })
    }
}

/// The number of nodes on the longest path.
fn depth(nodes: &[Node], progress: &ProgressReporter) -> Result<u32, Cancelled> {
    // The second children to come, the next one last, with their depths.
    let mut pending: Vec<(usize, u32)> = Vec::new();
    let (mut depth, mut deepest) = (0, 0);
    for (i, node) in nodes.iter().enumerate() {
        progress.step(i)?;
        depth = pending.pop_if(|&mut (next, _)| next == i).map_or(depth + 1, |(_, depth)| depth);
        deepest = deepest.max(depth);
        if let NodeKind::Interior { second_child, .. } = node.kind {
            pending.push((second_child as usize, depth + 1));
        }
    }
    Ok(deepest)
}
