//! Treelets: subtrees over primitives whose codes begin with the same bits, split along the remaining ones.

use geometry::Bounds3;

use super::TREELET_BITS;
use super::coded::Coded;
use crate::depth::MAX_DEPTH;
use crate::morton::axis_of_bit;
use crate::parallel;
use crate::prim_info::{Bounds3A, PrimInfo};
use crate::recursive::{Group, Rules};
use crate::subtree::{Block, Part, Step, Subtree};
use crate::{BuildConfig, Cancelled, ProgressReporter, SplitMethod};

/// The height that no treelet exceeds: above it there must be room for a balanced tree over all treelets.
///
/// Treelets keep to it: each split along a bit uses up one of at most 51, so the last of these nodes is at depth 52 or
/// above, and a group that begins there is within its limit: 52 + ⌈log₂ 2³¹⌉ ≤ 84 (see [`crate::depth`]).
const MAX_HEIGHT: u32 = MAX_DEPTH - TREELET_BITS;

/// The treelets of `prims`, at the places that sorted `coded` has: one for all whose codes agree above
/// `low_bits`.
pub(super) fn build<C: Coded>(
    coded: &[C],
    low_bits: u32,
    prims: &[PrimInfo],
    config: &BuildConfig,
    progress: &ProgressReporter,
) -> Result<Vec<Subtree>, Cancelled> {
    let rules = Rules::new(config, MAX_HEIGHT, progress).with_split_method(SplitMethod::Sah);
    let treelets = coded.chunk_by(|a, b| a.code() >> low_bits == b.code() >> low_bits).collect();
    parallel::map(treelets, |coded: &[C]| {
        let mut own = gathered(prims, coded, progress)?;
        Subtree::grow(TreeletPart::Coded { coded, prims: &mut own, rules: &rules }, 1, &rules)
    })
}

/// The primitives at the places that `coded` has, in its order.
fn gathered<C: Coded>(
    prims: &[PrimInfo],
    coded: &[C],
    progress: &ProgressReporter,
) -> Result<Vec<PrimInfo>, Cancelled> {
    let mut gathered = Vec::with_capacity(coded.len());
    for part in coded.chunks(parallel::SEQUENTIAL) {
        progress.check()?;
        gathered.extend(part.iter().map(|c| prims[c.number() as usize]));
    }
    Ok(gathered)
}

/// A part of a treelet.
enum TreeletPart<'a, C> {
    /// Primitives in the order of their codes.
    Coded { coded: &'a [C], prims: &'a mut [PrimInfo], rules: &'a Rules<'a> },
    /// Primitives of one cell, which only their bounds can tell apart. pbrt makes them a leaf, however many they are;
    /// where a few far primitives stretch the grid, that can be nearly all of a scene.
    Cell(Group<'a>),
}

impl<C: Coded> Part for TreeletPart<'_, C> {
    fn prims(&self) -> &[PrimInfo] {
        match self {
            Self::Coded { prims, .. } => prims,
            Self::Cell(group) => group.prims(),
        }
    }

    fn split(self, depth: u32) -> Result<Step<Self>, Cancelled> {
        let (coded, prims, rules) = match self {
            Self::Coded { coded, prims, rules } => (coded, prims, rules),
            Self::Cell(group) => return split_cell(group, depth),
        };
        if coded.len() <= rules.config.max_primitives_in_leaf as usize {
            return Ok(Step::Leaf(bounds_of(prims), Self::Coded { coded, prims, rules }));
        }
        // The codes are sorted: the first and the last differ in the highest bit in which any two do. pbrt asks bit
        // after bit.
        let differing = coded.first().zip(coded.last()).map_or(0, |(a, b)| a.code() ^ b.code());
        let Some(bit) = differing.checked_ilog2() else {
            return split_cell(Group::new(prims, rules)?, depth);
        };
        let middle = coded.partition_point(|c| c.code() >> bit & 1 == 0);
        let (a_coded, b_coded) = coded.split_at(middle);
        let (a, b) = prims.split_at_mut(middle);
        Ok(Step::Interior(
            axis_of_bit(bit),
            Self::Coded { coded: a_coded, prims: a, rules },
            Self::Coded { coded: b_coded, prims: b, rules },
        ))
    }

    fn finish(&mut self, depth: u32, block: &mut Block) -> Result<Option<u32>, Cancelled> {
        match self {
            Self::Coded { .. } => Ok(None),
            Self::Cell(group) => group.finish(depth, block),
        }
    }
}

fn split_cell<C>(group: Group, depth: u32) -> Result<Step<TreeletPart<C>>, Cancelled> {
    Ok(match group.split(depth)? {
        Step::Leaf(bounds, group) => Step::Leaf(bounds, TreeletPart::Cell(group)),
        Step::Interior(axis, a, b) => Step::Interior(axis, TreeletPart::Cell(a), TreeletPart::Cell(b)),
    })
}

fn bounds_of(prims: &[PrimInfo]) -> Bounds3 {
    prims.iter().fold(Bounds3A::EMPTY, |all, p| all.union(&p.bounds())).to_bounds()
}
