//! From moved subtrees back to nodes in depth-first order.

use geometry::glam::Vec3;
use geometry::{Axis, Bounds3};

use super::topology::{ROOT, Topology};
use crate::subtree::Block;
use crate::{Cancelled, Node, NodeKind, ProgressReporter};

/// The tree of `topology`. Its leaves are those of `old`. The children of a node are divided along the axis on which
/// their centroids are furthest apart, the lower one first.
pub(super) fn emit(topology: &Topology, old: &Block, progress: &ProgressReporter) -> Result<Block, Cancelled> {
    let leaves: Vec<(Bounds3, u32, u32)> = old
        .nodes
        .iter()
        .filter_map(|node| match node.kind {
            NodeKind::Leaf { first, count } => Some((node.bounds, first, count)),
            NodeKind::Interior { .. } => None,
        })
        .collect();
    let mut tree = Block { nodes: Vec::with_capacity(old.nodes.len()), order: Vec::with_capacity(old.order.len()) };
    let mut pending = vec![(ROOT, None)];
    while let Some((slot, parent)) = pending.pop() {
        progress.check_step(tree.nodes.len())?;
        if let Some(parent) = parent {
            tree.begin_second_child(parent);
        }
        if let Some(children) = topology.children(slot) {
            let (axis, [a, b]) = in_order(topology, children);
            pending.push((b, Some(tree.nodes.len())));
            pending.push((a, None));
            tree.push_interior(axis);
        } else if let Some(number) = topology.leaf(slot) {
            let (bounds, first, count) = leaves[number as usize];
            tree.nodes.push(Node { bounds, kind: NodeKind::Leaf { first: tree.order.len() as u32, count } });
            tree.order.extend_from_slice(&old.order[first as usize..][..count as usize]);
        }
    }
    tree.enclose(progress)?;
    Ok(tree)
}

/// The axis on which the centroids of two nodes are furthest apart, and the nodes, the lower one first; of equals the
/// first.
fn in_order(topology: &Topology, [a, b]: [u32; 2]) -> (Axis, [u32; 2]) {
    let [a_centroid2, b_centroid2] = [a, b].map(|i| {
        let bounds = topology.bounds(i);
        bounds.min + bounds.max
    });
    let distance = b_centroid2 - a_centroid2;
    let axis = Bounds3::new(Vec3::ZERO, distance.abs()).dominant_axis();
    (axis, if distance[axis.index()] < 0.0 { [b, a] } else { [a, b] })
}
