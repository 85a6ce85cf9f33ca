//! Trees over geometry that has moved.

use std::ops::Range;

use geometry::Bounds3;
use thiserror::Error;

use crate::parallel::join;
use crate::{FlatBvh, LinearBvhNode};

/// Why a tree cannot be adapted to what moved. It is as it was before.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum RefitError {
    /// There are more primitives than before, or fewer.
    #[error("the tree was built over {expected} primitives, not over {found}; build a tree anew")]
    Count {
        /// How many the tree was built over.
        expected: usize,
        /// How many there are.
        found: usize,
    },
    /// Leaves have parts of primitives, as the builder cut them: those of others are not known.
    #[error("space was split: build a tree anew, or without spatial splits")]
    Split,
    /// A primitive became active (its bounds were not [valid](Bounds3::is_valid), and are now), and no leaf has it; or
    /// it became inactive, and a leaf has it.
    #[error("primitive {primitive} became active or inactive: build a tree anew")]
    Activity {
        /// The first such primitive.
        primitive: usize,
    },
}

impl FlatBvh {
    /// Adapts the boxes to primitives that moved; the tree stays the same otherwise. Linear in the number of nodes, in
    /// place, on all threads of the current rayon pool with the feature `parallel`, and with the same result on any
    /// number.
    ///
    /// The result is the cost of the new tree by the surface area heuristic as a part of that of the one it was adapted
    /// from, with costs of 1/2 for a node and 1 for a primitive: where the product since the build gets large (2, say),
    /// rays would gain by a new build. 1 where either tree has no area.
    ///
    /// Bounds that are not [valid](Bounds3::is_valid) are those of inactive primitives, which must have been so before.
    ///
    /// # Errors
    /// [`RefitError`], and the tree is as it was: for another number of bounds, with spatial splits, and where a
    /// primitive became active or inactive.
    pub fn refit(&mut self, bounds: &[Bounds3]) -> Result<f64, RefitError> {
        let expected = self.primitive_count() as usize;
        if bounds.len() != expected {
            return Err(RefitError::Count { expected, found: bounds.len() });
        }
        if self.extra_references() > 0 {
            return Err(RefitError::Split);
        }
        let mut is_active = vec![false; expected];
        self.order().iter().for_each(|&i| is_active[i as usize] = true);
        if let Some(primitive) = (0..expected).find(|&i| is_active[i] != bounds[i].is_valid()) {
            return Err(RefitError::Activity { primitive });
        }
        let old_area = self.bounds().surface_area();
        let (nodes, order) = self.parts_mut();
        let leaf =
            |range: Range<usize>| order[range].iter().fold(Bounds3::EMPTY, |all, &i| all.union(&bounds[i as usize]));
        let [old, new] = if nodes.is_empty() { [0.0; 2] } else { subtree(nodes, 0, &leaf) };
        Ok(ratio([old / old_area, new / self.bounds().surface_area()]))
    }
}

/// Adapts the subtree of `nodes`, which begin at `first` in the tree, where `leaf` has the bounds of a leaf's range:
/// the costs before and after, times the area of the root.
fn subtree(nodes: &mut [LinearBvhNode], first: usize, leaf: &(impl Fn(Range<usize>) -> Bounds3 + Sync)) -> [f64; 2] {
    /// Up to so many nodes are adapted by one thread.
    const SEQUENTIAL: usize = 1 << 13;
    if nodes.len() <= SEQUENTIAL {
        // Children lie behind their parents, so from the back every child is ready before its parent.
        return (0..nodes.len()).rev().fold([0.0; 2], |costs, i| {
            let bounds = if nodes[i].is_leaf() {
                leaf(nodes[i].range())
            } else {
                nodes[i + 1].bounds().union(&nodes[nodes[i].second_child() - first].bounds())
            };
            sum(costs, adapt(&mut nodes[i], bounds))
        });
    }
    let middle = nodes[0].second_child() - first;
    let (root, below) = nodes.split_at_mut(1);
    let (a, b) = below.split_at_mut(middle - 1);
    let (a_costs, b_costs) = join(|| subtree(a, first + 1, leaf), || subtree(b, first + middle, leaf));
    let bounds = a[0].bounds().union(&b[0].bounds());
    sum(sum(a_costs, b_costs), adapt(&mut root[0], bounds))
}

/// Gives a node other bounds: its own costs before and after, times the area of the root.
fn adapt(node: &mut LinearBvhNode, bounds: Bounds3) -> [f64; 2] {
    let cost = if node.is_leaf() { f64::from(node.count) } else { 0.5 };
    let costs = [node.bounds(), bounds].map(|bounds| cost * bounds.surface_area());
    // A zero loses its sign, as where a tree is built.
    (node.min, node.max) = ((bounds.min + 0.0).to_array(), (bounds.max + 0.0).to_array());
    costs
}

/// The sums of two pairs.
pub(crate) fn sum(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

/// How the second of two costs is to the first.
pub(crate) fn ratio([old, new]: [f64; 2]) -> f64 {
    let ratio = new / old;
    if ratio.is_finite() && ratio > 0.0 { ratio } else { 1.0 }
}
