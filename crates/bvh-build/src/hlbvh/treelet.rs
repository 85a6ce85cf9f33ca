//! Treelets: subtrees over primitives whose codes begin with the same bits, split along the remaining ones.

use geometry::Bounds3;

use super::TREELET_BITS;
use crate::depth::MAX_DEPTH;
use crate::morton::axis_of_bit;
use crate::parallel;
use crate::prim_info::{Bounds3A, PrimInfo};
use crate::recursive::{Group, Rules};
use crate::subtree::{Part, Step, Subtree};
use crate::{BuildConfig, Node, SplitMethod};

/// The height that no treelet exceeds: above it there must be room for a balanced tree over all treelets.
///
/// Treelets keep to it: each split along a bit uses up one of at most 51, so the last of these nodes is at depth 52 or
/// above, and a group that begins there is within its limit: 52 + ⌈log₂ 2³¹⌉ ≤ 84 (see [`crate::depth`]).
const MAX_HEIGHT: u32 = MAX_DEPTH - TREELET_BITS;

/// The treelets of `prims`, which are sorted by their `codes`: one for all whose codes agree above `low_bits`.
pub(super) fn build(codes: &[u64], low_bits: u32, prims: &mut [PrimInfo], config: &BuildConfig) -> Vec<Subtree> {
    let rules = Rules::new(config, MAX_HEIGHT).with_split_method(SplitMethod::Sah);
    let mut parts = Vec::new();
    let mut rest = prims;
    for codes in codes.chunk_by(|a, b| a >> low_bits == b >> low_bits) {
        let (prims, behind) = rest.split_at_mut(codes.len());
        let first = parts.last().map_or(0, |p: &TreeletPart| p.first() + p.len());
        parts.push(TreeletPart::Coded { codes, prims, first, rules: &rules });
        rest = behind;
    }
    parallel::map(parts, |part| Subtree::grow(part, 1))
}

/// A part of a treelet.
enum TreeletPart<'a> {
    /// Primitives in the order of their codes.
    Coded { codes: &'a [u64], prims: &'a mut [PrimInfo], first: usize, rules: &'a Rules },
    /// Primitives of one cell, which only their bounds can tell apart. pbrt makes them a leaf, however many they are;
    /// where a few far primitives stretch the grid, that can be nearly all of a scene.
    Cell(Group<'a>),
}

impl Part for TreeletPart<'_> {
    fn len(&self) -> usize {
        match self {
            Self::Coded { codes, .. } => codes.len(),
            Self::Cell(group) => group.len(),
        }
    }

    fn first(&self) -> usize {
        match self {
            Self::Coded { first, .. } => *first,
            Self::Cell(group) => group.first(),
        }
    }

    fn split(self, depth: u32) -> Step<Self> {
        let (codes, prims, first, rules) = match self {
            Self::Coded { codes, prims, first, rules } => (codes, prims, first, rules),
            Self::Cell(group) => return split_cell(group, depth),
        };
        if codes.len() <= rules.config.max_primitives_in_leaf as usize {
            return Step::Leaf(bounds_of(prims));
        }
        // The codes are sorted: the first and the last differ in the highest bit in which any two do. pbrt asks bit
        // after bit.
        let differing = codes.first().zip(codes.last()).map_or(0, |(a, b)| a ^ b);
        let Some(bit) = differing.checked_ilog2() else {
            return split_cell(Group::new(prims, first, rules), depth);
        };
        let middle = codes.partition_point(|code| code >> bit & 1 == 0);
        let (a_codes, b_codes) = codes.split_at(middle);
        let (a, b) = prims.split_at_mut(middle);
        Step::Interior(
            axis_of_bit(bit),
            Self::Coded { codes: a_codes, prims: a, first, rules },
            Self::Coded { codes: b_codes, prims: b, first: first + middle, rules },
        )
    }

    fn finish(&mut self, depth: u32, nodes: &mut Vec<Node>) -> Option<u32> {
        match self {
            Self::Coded { .. } => None,
            Self::Cell(group) => group.finish(depth, nodes),
        }
    }
}

fn split_cell<'a>(group: Group<'a>, depth: u32) -> Step<TreeletPart<'a>> {
    match group.split(depth) {
        Step::Leaf(bounds) => Step::Leaf(bounds),
        Step::Interior(axis, a, b) => Step::Interior(axis, TreeletPart::Cell(a), TreeletPart::Cell(b)),
    }
}

fn bounds_of(prims: &[PrimInfo]) -> Bounds3 {
    prims.iter().fold(Bounds3A::EMPTY, |all, p| all.union(&p.bounds())).to_bounds()
}
