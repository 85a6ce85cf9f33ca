//! Subtrees over a few primitives, by sweeps along all axes.

use geometry::{Axis, Bounds3};

use crate::prim_info::PrimInfo;
use crate::recursive::Rules;
use crate::split::sah::{Limit, MAX_SWEPT, Sorted};
use crate::subtree::Block;

/// A part that is still to be split: a range of the sorted primitives.
#[derive(Clone, Copy, Default)]
struct Range {
    begin: usize,
    end: usize,
    depth: u32,
    /// The node whose second child it is.
    parent: Option<usize>,
}

/// Appends the subtree of `prims`, at most [`MAX_SWEPT`], to `block`. Its root is at `depth`; the result is the depth of
/// the deepest node. The tree is that of one sweep for each node, and the sorting is done once for all.
#[inline(never)] // Its arrays are large.
pub(crate) fn grow(prims: &[PrimInfo], rules: &Rules, depth: u32, block: &mut Block) -> u32 {
    let mut sorted = Sorted::new(prims);
    // A part of n primitives leaves at most one part pending for each level, and there are fewer than n levels.
    let mut pending = [Range::default(); MAX_SWEPT];
    let mut deepest = depth;
    let mut count = 1;
    pending[0] = Range { begin: 0, end: prims.len(), depth, parent: None };
    while count > 0 {
        count -= 1;
        let Range { begin, end, depth, parent } = pending[count];
        deepest = deepest.max(depth);
        if let Some(parent) = parent {
            block.begin_second_child(parent);
        }
        match choose(&mut sorted, prims, begin, end, rules, depth) {
            Choice::Leaf(bounds) => block.push_leaf(bounds, sorted.indices(prims, begin, end)),
            Choice::Split(axis, middle) => {
                sorted.part(axis, begin, middle, end);
                let here = block.nodes.len();
                block.push_interior(axis);
                pending[count] = Range { begin: middle, end, depth: depth + 1, parent: Some(here) };
                pending[count + 1] = Range { begin, end: middle, depth: depth + 1, parent: None };
                count += 2;
            }
        }
    }
    deepest
}

enum Choice {
    Leaf(Bounds3),
    Split(Axis, usize),
}

/// What becomes of the sorted primitives from `begin` to `end`, by the same rules as [`crate::split::split`].
fn choose(sorted: &mut Sorted, prims: &[PrimInfo], begin: usize, end: usize, rules: &Rules, depth: u32) -> Choice {
    let (count, config) = (end - begin, &rules.config);
    let extent = sorted.extent(prims, begin, end);
    let fits_a_leaf = count <= config.max_primitives_in_leaf as usize;
    let is_free = rules.limit.allows_any_split(depth, count);
    if count == 1 {
        return Choice::Leaf(extent.bounds.to_bounds());
    }
    let is_weighed = is_free && extent.centroid_interval().is_some() && extent.bounds.surface_area() > 0.0;
    if is_weighed {
        let limit = Limit::of(count, &extent, config);
        if limit.is_any()
            && let Some((axis, middle)) = sorted.cheapest_boundary(prims, begin, end, limit)
        {
            return Choice::Split(axis, middle);
        }
    }
    if fits_a_leaf {
        return Choice::Leaf(extent.bounds.to_bounds());
    }
    let axis = extent.centroids2.to_bounds().dominant_axis();
    sorted.break_ties(axis, prims, begin, end);
    Choice::Split(axis, begin + count / 2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::depth::MAX_DEPTH;
    use crate::recursive::Group;
    use crate::subtree::{Part, Step};
    use crate::{BuildConfig, ProgressReporter, SplitAxes};
    use geometry::glam::Vec3;

    /// The same subtree with a sweep, and a sort, for each node.
    fn naive(part: impl Part, depth: u32, block: &mut Block) -> u32 {
        match part.split(depth).expect("nobody cancels") {
            Step::Leaf(bounds, part) => {
                block.push_leaf(bounds, part.prims().iter().map(PrimInfo::index));
                depth
            }
            Step::Interior(axis, a, b) => {
                let here = block.nodes.len();
                block.push_interior(axis);
                let deepest = naive(a, depth + 1, block);
                block.begin_second_child(here);
                deepest.max(naive(b, depth + 1, block))
            }
        }
    }

    /// Boxes with many equal coordinates, on a line, in a plane or in space, some without any extent.
    fn boxes(n: usize, seed: u64) -> Vec<PrimInfo> {
        let mut state = seed;
        let mut random = |values: u64| {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
            ((state >> 33) % values) as f32
        };
        let mask = Vec3::new(1.0, (seed % 2) as f32, (seed / 2 % 2) as f32);
        let places = [1, 3, 10, 1000][seed as usize % 4];
        let size = (seed / 4 % 3) as f32;
        (0..n as u32)
            .map(|i| {
                let min = mask * Vec3::new(random(places), random(places), random(places));
                let extent = size * Vec3::new(random(3), random(3), random(3));
                PrimInfo::new(&Bounds3::new(min, min + extent), i)
            })
            .collect()
    }

    #[test]
    fn the_subtree_is_that_of_a_sweep_for_each_node() {
        let mut splits = 0;
        for seed in 0..24 {
            for n in (1..=20).chain([31, 32, 33, 63, 64]) {
                for (leaf, limit) in [(1, MAX_DEPTH), (4, MAX_DEPTH), (1, 8), (2, 10)] {
                    let config = BuildConfig::default()
                        .with_max_primitives_in_leaf(leaf)
                        .with_axes(SplitAxes::All)
                        .with_full_sweep(MAX_SWEPT as u32);
                    let progress = ProgressReporter::unobserved();
                    let rules = Rules::new(&config, limit, &progress);
                    let (fast, mut slow) = (boxes(n, seed), boxes(n, seed));
                    let [mut block, mut expected] = [Block::default(), Block::default()];
                    let deepest = grow(&fast, &rules, 2, &mut block);
                    let what = format!("{n} {seed} {leaf} {limit}");
                    let group = Group::new(&mut slow, &rules).expect("nobody cancels");
                    assert_eq!(deepest, naive(group, 2, &mut expected), "{what}");
                    let kinds = |block: &Block| block.nodes.iter().map(|node| node.kind).collect::<Vec<_>>();
                    assert_eq!((kinds(&block), block.order), (kinds(&expected), expected.order), "{what}");
                    splits += block.nodes.len() - 1;
                }
            }
        }
        assert!(splits > 10_000, "{splits}");
    }
}
