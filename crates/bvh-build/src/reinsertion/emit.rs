//! From moved subtrees back to nodes in depth-first order.

use geometry::glam::Vec3;
use geometry::{Axis, Bounds3};

use super::topology::{ROOT, Topology};
use crate::subtree::interior;
use crate::{Cancelled, Node, NodeKind, ProgressReporter};

/// The nodes of `topology`, depth first, and the order of the primitives. Leaves are those of `old_nodes`, with their
/// ranges of `old_order`. The children of a node are divided along the axis on which their centroids are furthest
/// apart, the lower one first.
pub(super) fn emit(
    topology: &Topology,
    old_nodes: &[Node],
    old_order: &[u32],
    progress: &ProgressReporter,
) -> Result<(Vec<Node>, Vec<u32>), Cancelled> {
    let leaves: Vec<(Bounds3, u32, u32)> = old_nodes
        .iter()
        .filter_map(|node| match node.kind {
            NodeKind::Leaf { first, count } => Some((node.bounds, first, count)),
            NodeKind::Interior { .. } => None,
        })
        .collect();
    let mut nodes: Vec<Node> = Vec::with_capacity(old_nodes.len());
    let mut order = Vec::with_capacity(old_order.len());
    let mut pending = vec![(ROOT, None)];
    while let Some((slot, parent)) = pending.pop() {
        progress.check_step(nodes.len())?;
        if let Some((parent, axis)) = parent {
            let second_child = nodes.len() as u32;
            let parent: &mut Node = &mut nodes[parent];
            parent.kind = NodeKind::Interior { axis, second_child };
        }
        if let Some(children) = topology.children(slot) {
            let (axis, [a, b]) = in_order(topology, children);
            pending.push((b, Some((nodes.len(), axis))));
            pending.push((a, None));
            nodes.push(interior(Bounds3::EMPTY, axis));
        } else if let Some(number) = topology.leaf(slot) {
            let (bounds, first, count) = leaves[number as usize];
            nodes.push(Node { bounds, kind: NodeKind::Leaf { first: order.len() as u32, count } });
            order.extend_from_slice(&old_order[first as usize..][..count as usize]);
        }
    }
    // Children lie behind their parents, so from the back every child is ready before its parent.
    for i in (0..nodes.len()).rev() {
        progress.check_step(i)?;
        if let NodeKind::Interior { second_child, .. } = nodes[i].kind {
            nodes[i].bounds = nodes[i + 1].bounds.union(&nodes[second_child as usize].bounds);
        }
    }
    Ok((nodes, order))
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
