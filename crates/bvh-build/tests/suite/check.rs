//! Everything that a tree must be, recomputed from the bounds it was built from.

use bvh_build::geometry::{Axis, Bounds3};
use bvh_build::{BuildConfig, MAX_DEPTH, NodeKind, Tree};

/// Panics with `what` where `tree` is not a valid tree over `bounds`.
pub(crate) fn check(tree: &Tree, bounds: &[Bounds3], config: &BuildConfig, what: &str) {
    let active: Vec<u32> = (0..).zip(bounds).filter(|(_, b)| b.is_valid()).map(|(i, _)| i).collect();
    let statistics = tree.statistics();
    assert_eq!(statistics.active_count as usize, active.len(), "{what}");
    assert_eq!(statistics.inactive_count as usize, bounds.len() - active.len(), "{what}");
    assert_eq!(statistics.node_count as usize, tree.nodes().len(), "{what}");
    assert!(statistics.sah_cost.is_finite() && statistics.sah_cost >= 0.0, "{what}: {statistics:?}");

    let mut order = tree.order().to_vec();
    order.sort_unstable();
    assert_eq!(order, active, "{what}: each active primitive is in the order once");

    if active.is_empty() {
        assert!(tree.nodes().is_empty() && tree.bounds().is_empty(), "{what}");
        return;
    }
    assert!(tree.nodes().len() < 2 * active.len(), "{what}: {statistics:?}");
    let mut walk = Walk { tree, bounds, config, what, next_node: 0, next_place: 0, leaves: 0, largest_leaf: 0 };
    let depth = walk.subtree();
    assert_eq!(walk.next_node, tree.nodes().len(), "{what}: all nodes are reached");
    assert_eq!(walk.next_place, active.len(), "{what}: leaves tile the order");
    assert!(depth <= MAX_DEPTH, "{what}: depth {depth}");
    assert_eq!(
        (statistics.depth, statistics.leaf_count, statistics.largest_leaf),
        (depth, walk.leaves, walk.largest_leaf)
    );
    assert!(close(statistics.sah_cost, walk.sah_cost()), "{what}: {} {}", statistics.sah_cost, walk.sah_cost());
}

struct Walk<'a> {
    tree: &'a Tree,
    bounds: &'a [Bounds3],
    config: &'a BuildConfig,
    what: &'a str,
    next_node: usize,
    next_place: usize,
    leaves: u32,
    largest_leaf: u32,
}

impl Walk<'_> {
    /// Checks the subtree at `next_node`, and returns its depth.
    fn subtree(&mut self) -> u32 {
        let what = self.what;
        let (here, node) = (self.next_node, self.tree.nodes()[self.next_node]);
        self.next_node += 1;
        match node.kind {
            NodeKind::Leaf { first, count } => {
                assert_eq!(first as usize, self.next_place, "{what}: leaves lie in order");
                assert!(0 < count && count <= self.config.max_primitives_in_leaf, "{what}: a leaf of {count}");
                self.next_place += count as usize;
                self.leaves += 1;
                self.largest_leaf = self.largest_leaf.max(count);
                let prims = &self.tree.order()[first as usize..self.next_place];
                assert!(prims.is_sorted(), "{what}: {prims:?}");
                let all = prims.iter().fold(Bounds3::EMPTY, |all, &i| all.union(&self.bounds[i as usize]));
                assert_eq!(node.bounds, all, "{what}: the smallest bounds");
                1
            }
            NodeKind::Interior { axis, second_child } => {
                assert!(Axis::ALL.contains(&axis));
                let a = self.subtree();
                assert_eq!(self.next_node, second_child as usize, "{what}: children in depth-first order");
                let b = self.subtree();
                let [a_bounds, b_bounds] = [here + 1, second_child as usize].map(|i| self.tree.nodes()[i].bounds);
                assert!(node.bounds.contains(&a_bounds) && node.bounds.contains(&b_bounds), "{what}");
                assert_eq!(node.bounds, a_bounds.union(&b_bounds), "{what}: the smallest bounds");
                1 + a.max(b)
            }
        }
    }

    fn sah_cost(&self) -> f64 {
        let area = self.tree.bounds().surface_area();
        let costs = self.tree.nodes().iter().map(|node| {
            let p = if area == 0.0 { 1.0 } else { node.bounds.surface_area() / area };
            assert!((0.0..=1.0).contains(&p), "{}: {p}", self.what);
            p * match node.kind {
                NodeKind::Interior { .. } => f64::from(self.config.traversal_cost),
                NodeKind::Leaf { count, .. } => f64::from(count) * f64::from(self.config.intersection_cost),
            }
        });
        costs.sum()
    }
}

/// Sums of at most 2²⁰ positive terms, each with a relative error of a few 2⁻⁵³.
fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs()
}
