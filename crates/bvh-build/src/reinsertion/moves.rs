//! What a move gains in the tree as it is, and whether it may be made.

use super::topology::{ROOT, Topology};
use crate::depth::MAX_DEPTH;

/// By how much the areas of all interior nodes together get less when the subtree at `from` becomes the sibling of
/// `to`; `None` where that would be no tree, or one deeper than [`MAX_DEPTH`], or change nothing.
pub(super) fn gain(topology: &Topology, from: u32, to: u32) -> Option<f64> {
    let above = topology.parent(from);
    if from == ROOT || to == from || to == from ^ 1 || to == above {
        return None;
    }
    let (old, new) = (Path::to(topology, above), Path::to(topology, to));
    let (old, new) = (old.nodes(), new.nodes());
    if new.contains(&from) {
        return None;
    }
    // The new parent is as deep as `to` is now, or one less.
    if new.len() as u32 + topology.height(to).max(topology.height(from)) > MAX_DEPTH {
        return None;
    }
    let subject = topology.bounds(from);
    let area = |i: u32| topology.bounds(i).surface_area();
    let common = old.iter().zip(new).take_while(|(a, b)| a == b).count();
    let is_beside_ancestor = common == new.len();

    // The old parent goes, and those above it shrink, as far up as they are not above the new place too.
    let mut gain = area(above);
    let mut shrunk = topology.bounds(from ^ 1);
    let highest = if is_beside_ancestor { common - 1 } else { common };
    for i in (highest..old.len() - 1).rev() {
        shrunk = shrunk.union(&topology.bounds(old[i + 1] ^ 1));
        gain += area(old[i]) - shrunk.surface_area();
    }
    // The new parent comes, and those above it grow, as far up as they did not contain the subtree.
    if is_beside_ancestor {
        return Some(gain - area(to));
    }
    let grown = |i: u32| topology.bounds(i).union(&subject).surface_area();
    let growth: f64 = new[common..new.len() - 1].iter().map(|&i| grown(i) - area(i)).sum();
    Some(gain - grown(to) - growth)
}

/// The nodes from the root to another.
struct Path {
    /// At the end of the array; what is before `first` means nothing.
    nodes: [u32; MAX_DEPTH as usize],
    first: usize,
}

impl Path {
    fn to(topology: &Topology, mut node: u32) -> Self {
        let mut path = Self { nodes: [ROOT; MAX_DEPTH as usize], first: MAX_DEPTH as usize };
        loop {
            path.first -= 1;
            path.nodes[path.first] = node;
            if node == ROOT {
                return path;
            }
            node = topology.parent(node);
        }
    }

    /// The root first.
    fn nodes(&self) -> &[u32] {
        &self.nodes[self.first..]
    }
}
