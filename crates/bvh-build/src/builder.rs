//! From bounds to a tree.

use geometry::Bounds3;

use crate::depth::{MAX_DEPTH, MAX_PRIMITIVES};
use crate::prim_info::ActivePrims;
use crate::recursive::{Group, Rules};
use crate::subtree::{Block, Subtree};
use crate::{
    BuildConfig, BuildError, BuildObserver, Cancelled, ClippedBounds, Phase, ProgressReporter, SpatialSplits,
    SplitMethod, Tree, TreeStatistics, binned, hlbvh, merge, reinsertion, spatial, tiny,
};

/// The tree over `bounds`; see [`build_observed`].
///
/// # Errors
/// As [`build_observed`].
pub fn build(bounds: &[Bounds3], config: &BuildConfig) -> Result<Tree, BuildError> {
    build_observed(bounds, config, &())
}

/// The tree over `bounds`, one for each primitive, while `observer` is told how far it has come, and may cancel it.
///
/// All bounds are in one space, in any unit. Primitives whose bounds are not [valid](Bounds3::is_valid) (empty, NaN,
/// infinite or beyond 2⁶⁰) are inactive: they keep their index and are in no leaf. Where none is active, the tree is
/// empty. The same bounds and configuration make the same tree, bit for bit, on any number of threads and without the
/// feature `parallel`. Time is linear in n for each level of the tree. Space is not split, whatever the configuration
/// says: a box does not tell the parts of what is in it.
///
/// The calling thread needs a stack of 64 KiB. The threads of a rayon pool need 512 KiB, which is less than they have by
/// default: while one waits for a half of a node it works on others, on the same stack.
///
/// # Errors
/// [`BuildError::InvalidConfig`], [`BuildError::TooManyPrimitives`] beyond 2³¹ bounds, and [`BuildError::Cancelled`]
/// where the observer wants it.
pub fn build_observed(
    bounds: &[Bounds3],
    config: &BuildConfig,
    observer: &dyn BuildObserver,
) -> Result<Tree, BuildError> {
    build_clipped(bounds.len(), |i| bounds[i as usize], None, config, observer)
}

/// As [`build_observed`], of `count` primitives that are asked for their bounds, and can be asked for those of their
/// parts: so space can be split, where the configuration [says so](BuildConfig::spatial_splits). `bounds` is asked for
/// each index below `count`, from any thread, and must answer the same question in the same way.
///
/// # Errors
/// As [`build_observed`]; the references for which there is [room](SpatialSplits::budget) count towards the 2³¹.
pub fn build_split(
    count: usize,
    bounds: impl Fn(u32) -> Bounds3 + Sync,
    clipped: &ClippedBounds,
    config: &BuildConfig,
    observer: &dyn BuildObserver,
) -> Result<Tree, BuildError> {
    build_clipped(count, bounds, Some(clipped), config, observer)
}

fn build_clipped(
    count: usize,
    bounds: impl Fn(u32) -> Bounds3 + Sync,
    clipped: Option<&ClippedBounds>,
    config: &BuildConfig,
    observer: &dyn BuildObserver,
) -> Result<Tree, BuildError> {
    config.validate()?;
    check_count(count)?;
    let splits = config.spatial_splits.filter(|_| config.split_method == SplitMethod::Sah).zip(clipped);
    let most = splits.map_or(0, |(splits, _)| splits.room(count));
    check_count(count.saturating_add(most))?;
    let mut active = ProgressReporter::observe(observer, Phase::Bounds, count, |progress| {
        ActivePrims::new(count, most, bounds, progress)
    })?;
    let active_count = active.count;
    let is_tiny = tiny::scale(&mut active);
    // Which primitives a leaf should have is known better from below.
    let is_merged = config.reinsertion.is_some_and(|options| options.merged_leaves);
    let growth = if is_merged { config.with_max_primitives_in_leaf(1) } else { *config };
    let may_merge = is_merged && config.max_primitives_in_leaf > 1;
    // Block by block, so that there is never room for all small ones.
    let is_within_blocks =
        config.split_method != SplitMethod::Hlbvh && config.max_primitives_in_leaf <= merge::MOST_WITHIN_BLOCKS;
    let merging = (may_merge && is_within_blocks).then_some(config);
    let mut tree = match splits {
        Some((splits, clipped)) if active_count > 0 => {
            active.room.truncate(active_count + splits.room(active_count));
            let of_tiny = |index: u32, to: &Bounds3| tiny::clipped(clipped, index, to);
            let clipped = if is_tiny { &of_tiny } else { clipped };
            grow_split(active, &splits, clipped, &growth, merging, observer)?
        }
        _ => grow(active, &growth, merging, observer)?,
    };
    if let Some(options) = &config.reinsertion {
        let most = reinsertion::rated_slots(tree.nodes.len(), options);
        tree = ProgressReporter::observe(observer, Phase::Reinsertion, most, |progress| {
            // Before and not after: the trees cost the same, and a third of the build's time is saved.
            if may_merge && merging.is_none() {
                tree = merge::leaves(&tree, config, progress)?;
                progress.update(most - reinsertion::rated_slots(tree.nodes.len(), options))?;
            }
            reinsertion::optimize(tree, options, observer, progress)
        })?;
    }
    if is_tiny {
        tiny::scale_back(&mut tree.nodes);
    }
    Ok(finish(tree, [active_count, count], config, observer)?)
}

impl Tree {
    /// The tree after reinsertion, by the [options](BuildConfig::reinsertion) of `config` or the default ones, while
    /// `observer` is told of it and may say that it is enough (see [`BuildObserver::reinserted`]).
    ///
    /// Leaves are the same, in another order; the cost is not larger; the tree is the same, bit for bit, on any number
    /// of threads. A tree of small leaves gains most. The statistics are by the costs of `config`, of which nothing
    /// else counts. See [`BuildConfig::reinsertion`] for the way to build such a tree at once.
    ///
    /// # Errors
    /// [`BuildError::InvalidConfig`]; and [`BuildError::Cancelled`], with which the tree is lost: an observer that
    /// wants to keep it as it is then breaks off in [`reinserted`](BuildObserver::reinserted) instead.
    pub fn optimized(self, config: &BuildConfig, observer: &dyn BuildObserver) -> Result<Self, BuildError> {
        config.validate()?;
        let TreeStatistics { active_count, inactive_count, .. } = *self.statistics();
        let (nodes, order) = self.into_parts();
        let options = config.reinsertion.unwrap_or_default();
        let most = reinsertion::rated_slots(nodes.len(), &options);
        let tree = ProgressReporter::observe(observer, Phase::Reinsertion, most, |progress| {
            reinsertion::optimize(Block { nodes, order }, &options, observer, progress)
        })?;
        let counts = [active_count, active_count + inactive_count].map(|count| count as usize);
        Ok(finish(tree, counts, config, observer)?)
    }
}

/// Those of the tree over `active` primitives, with leaves merged, if so.
fn grow(
    mut active: ActivePrims,
    config: &BuildConfig,
    merging: Option<&BuildConfig>,
    observer: &dyn BuildObserver,
) -> Result<Block, Cancelled> {
    let extent = active.extent;
    let prims = active.prims();
    if prims.is_empty() {
        return Ok(Block::default());
    }
    let root = if config.split_method == SplitMethod::Hlbvh {
        hlbvh::grow(prims, &extent, config, observer)?
    } else {
        recursion(observer, prims.len(), |progress| {
            let rules = Rules { merging, ..Rules::new(config, MAX_DEPTH, progress) };
            if binned::is_for(config) {
                return binned::grow(prims, extent, &rules);
            }
            Subtree::grow(Group::with_extent(prims, extent, &rules), 1, &rules)
        })?
    };
    drop(active);
    assemble(root, observer)
}

/// As [`grow`], where space may be split: behind the primitives there is room for more references to them.
fn grow_split(
    active: ActivePrims,
    splits: &SpatialSplits,
    clipped: &ClippedBounds,
    config: &BuildConfig,
    merging: Option<&BuildConfig>,
    observer: &dyn BuildObserver,
) -> Result<Block, Cancelled> {
    let ActivePrims { mut room, count, extent } = active;
    let root = recursion(observer, room.len(), |progress| {
        let rules = Rules { merging, ..Rules::new(config, MAX_DEPTH, progress) };
        let setting = spatial::Setting::new(&rules, splits, clipped, &extent);
        Subtree::grow(spatial::Group::new(&mut room, count, extent, &setting), 1, &rules)
    })?;
    drop(room);
    assemble(root, observer)
}

fn assemble(root: Subtree, observer: &dyn BuildObserver) -> Result<Block, Cancelled> {
    ProgressReporter::observe(observer, Phase::Assembly, root.node_count(), |progress| root.assemble(progress))
}

fn recursion<T>(
    observer: &dyn BuildObserver,
    count: usize,
    grow: impl FnOnce(&ProgressReporter) -> Result<T, Cancelled>,
) -> Result<T, Cancelled> {
    ProgressReporter::observe(observer, Phase::Recursion, count, grow)
}

/// `tree` with its statistics, as the observer is told; `counts` are those of active primitives and of all.
fn finish(
    Block { nodes, order }: Block,
    counts: [usize; 2],
    config: &BuildConfig,
    observer: &dyn BuildObserver,
) -> Result<Tree, Cancelled> {
    let tree = ProgressReporter::observe(observer, Phase::Statistics, nodes.len(), |progress| {
        Tree::new(nodes, order, counts, config, progress)
    })?;
    observer.built(tree.statistics());
    Ok(tree)
}

fn check_count(count: usize) -> Result<(), BuildError> {
    if count > MAX_PRIMITIVES {
        return Err(BuildError::TooManyPrimitives { count, limit: MAX_PRIMITIVES });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_beyond_32_bit_nodes_are_refused() {
        assert_eq!(check_count(1 << 31), Ok(()));
        for count in [(1 << 31) + 1, 1 << 32, usize::MAX] {
            assert_eq!(check_count(count), Err(BuildError::TooManyPrimitives { count, limit: 1 << 31 }));
        }
    }
}
