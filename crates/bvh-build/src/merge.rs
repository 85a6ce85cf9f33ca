//! Leaves of several primitives, where these cost less than a subtree.

use crate::binned::LEAST_DIVIDED;
use crate::subtree::{Block, SEQUENTIAL};
use crate::{BuildConfig, Cancelled, Node, NodeKind, ProgressReporter};

/// Up to so many primitives no leaf reaches beyond a block, but in [`SplitMethod::Hlbvh`](crate::SplitMethod), where a
/// few codes make a treelet: above blocks are nodes of more.
pub(crate) const MOST_WITHIN_BLOCKS: u32 = 256;

const _: () = assert!((MOST_WITHIN_BLOCKS as usize) < SEQUENTIAL);
const _: () = assert!((MOST_WITHIN_BLOCKS as usize) < LEAST_DIVIDED);

/// The tree with each subtree made a leaf whose primitives are cheaper to test at once, and fit a leaf: the largest such
/// subtrees, of equal costs the leaf. Costs are those of the surface area heuristic.
pub(crate) fn leaves(tree: &Block, config: &BuildConfig, progress: &ProgressReporter) -> Result<Block, Cancelled> {
    let rated = rate(&tree.nodes, config, progress)?;
    let mut merged = Block { nodes: Vec::new(), order: Vec::with_capacity(tree.order.len()) };
    // Interior nodes whose second child is to come, the next one last: where they were to find it, and where they are.
    let mut pending: Vec<(usize, usize)> = Vec::new();
    let mut next = 0;
    while next < tree.nodes.len() {
        progress.check_step(next)?;
        if let Some((_, parent)) = pending.pop_if(|&mut (second, _)| second == next) {
            merged.begin_second_child(parent);
        }
        let (node, rated) = (tree.nodes[next], &rated[next]);
        match node.kind {
            NodeKind::Interior { second_child, .. } if !rated.is_leaf => {
                pending.push((second_child as usize, merged.nodes.len()));
                next += 1;
                merged.nodes.push(node);
            }
            _ => {
                let below = &tree.nodes[next..][..rated.node_count as usize];
                next += below.len();
                let places = below.iter().flat_map(|node| node.kind.places());
                merged.push_leaf(node.bounds, places.map(|place| tree.order[place]));
            }
        }
    }
    Ok(merged)
}

/// What is below a node.
#[derive(Clone, Copy, Default)]
struct Subtree {
    node_count: u32,
    /// How many primitives it has.
    count: u32,
    /// Whether it becomes a leaf, or is one.
    is_leaf: bool,
    /// The least cost, times the node's area.
    cost: f64,
}

fn rate(nodes: &[Node], config: &BuildConfig, progress: &ProgressReporter) -> Result<Vec<Subtree>, Cancelled> {
    let t_trav = f64::from(config.traversal_cost);
    let mut subtrees = vec![Subtree::default(); nodes.len()];
    for (i, node) in nodes.iter().enumerate().rev() {
        progress.check_step(i)?;
        let area = node.bounds.surface_area();
        let as_leaf = |count: u32| area * config.cost_of_leaf(count);
        subtrees[i] = match node.kind {
            NodeKind::Leaf { count, .. } => Subtree { node_count: 1, count, is_leaf: true, cost: as_leaf(count) },
            NodeKind::Interior { second_child, .. } => {
                let [a, b] = [subtrees[i + 1], subtrees[second_child as usize]];
                let count = a.count + b.count;
                let split = area * t_trav + a.cost + b.cost;
                let is_leaf = count <= config.max_primitives_in_leaf && as_leaf(count) <= split;
                let cost = if is_leaf { as_leaf(count) } else { split };
                Subtree { node_count: 1 + a.node_count + b.node_count, count, is_leaf, cost }
            }
        };
    }
    Ok(subtrees)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Reinsertion, SplitMethod, build};
    use geometry::Bounds3;
    use geometry::glam::Vec3;

    /// The least cost of a tree whose leaves are subtrees of this one, times the area, and how many leaves it has.
    fn naive(nodes: &[Node], i: usize, config: &BuildConfig) -> (f64, u32, u32) {
        let [t_trav, t_isect, t_leaf] =
            [config.traversal_cost, config.intersection_cost, config.leaf_cost].map(f64::from);
        let area = nodes[i].bounds.surface_area();
        match nodes[i].kind {
            NodeKind::Leaf { count, .. } => (area * (f64::from(count) * t_isect + t_leaf), count, 1),
            NodeKind::Interior { second_child, .. } => {
                let [a, b] = [i + 1, second_child as usize].map(|child| naive(nodes, child, config));
                let count = a.1 + b.1;
                let [split, leaf] = [area * t_trav + a.0 + b.0, area * (f64::from(count) * t_isect + t_leaf)];
                if count <= config.max_primitives_in_leaf && leaf <= split {
                    (leaf, count, 1)
                } else {
                    (split, count, a.2 + b.2)
                }
            }
        }
    }

    /// Numbers in [0, 1).
    fn random(seed: u64) -> impl FnMut() -> f32 {
        let mut state = seed;
        move || {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
            (state >> 40) as f32 / (1 << 24) as f32
        }
    }

    #[test]
    fn the_leaves_are_those_of_least_cost() {
        let mut random = random(1);
        let (mut merged, progress) = (0, ProgressReporter::unobserved());
        for n in [0, 1, 2, 3, 10, 500] {
            let mut point = || Vec3::new(random(), random(), random());
            let bounds: Vec<_> = (0..n).map(|_| Bounds3::from_points([point(), point()])).collect();
            let fine = build(&bounds, &BuildConfig::default().with_max_primitives_in_leaf(1)).expect("valid");
            for leaf in [1, 2, 4, 100] {
                for (t_trav, t_isect, t_leaf) in [(0.5, 1.0, 0.0), (2.0, 1.0, 0.0), (0.0, 1.0, 0.0), (0.3, 0.1, 1.5)] {
                    let config = BuildConfig::default().with_max_primitives_in_leaf(leaf);
                    let config = config.with_costs(t_trav, t_isect).with_leaf_cost(t_leaf);
                    let fine_block = Block { nodes: fine.nodes().to_vec(), order: fine.order().to_vec() };
                    let Block { nodes, order } = leaves(&fine_block, &config, &progress).expect("nobody cancels");
                    let coarse = crate::Tree::new(nodes, order, [n as usize; 2], &config, &progress);
                    let coarse = coarse.expect("nobody cancels");
                    let statistics = coarse.statistics();
                    if n > 0 {
                        let (cost, count, leaf_count) = naive(fine.nodes(), 0, &config);
                        let cost = cost / coarse.bounds().surface_area();
                        assert!((statistics.sah_cost - cost).abs() <= 1e-12 * cost, "{n} {config:?}");
                        assert_eq!((statistics.leaf_count, count), (leaf_count, n));
                        assert!(statistics.largest_leaf <= leaf);
                    }
                    merged += fine.nodes().len() - coarse.nodes().len();
                }
            }
        }
        assert!(merged > 500, "{merged}");
    }

    /// Where the builder merges them block by block.
    #[test]
    fn leaves_of_blocks_are_those_of_the_whole() {
        let mut random = random(3);
        let mut point = |scale: f32| scale * Vec3::new(random(), random(), random());
        let bounds: Vec<_> = (0..9_000)
            .map(|_| {
                let p = point(1.0);
                Bounds3::new(p, p + point(0.02))
            })
            .collect();
        let progress = ProgressReporter::unobserved();
        for config in [
            BuildConfig::balanced(),
            BuildConfig::new(SplitMethod::Sah),
            BuildConfig::new(SplitMethod::Middle),
            BuildConfig::new(SplitMethod::EqualCounts),
            BuildConfig::fastest(),
        ] {
            for leaf in [4, 256, 600] {
                let config = config.with_costs(1.0, 0.02).with_leaf_cost(0.5);
                let fine = build(&bounds, &config.with_max_primitives_in_leaf(1)).expect("valid");
                let config = config.with_max_primitives_in_leaf(leaf);
                let fine = Block { nodes: fine.nodes().to_vec(), order: fine.order().to_vec() };
                let Block { nodes, order } = leaves(&fine, &config, &progress).expect("nobody cancels");
                let merged = build(&bounds, &config.with_reinsertion(Some(Reinsertion::new(0, 1.0)))).expect("valid");
                assert!(merged.nodes() == nodes && merged.order() == order, "{config:?}");
                let largest = merged.statistics().largest_leaf;
                assert!(largest > 100.min(leaf / 2), "{largest} {config:?}");
            }
        }
    }
}
