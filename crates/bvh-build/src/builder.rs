//! From bounds to a tree.

use geometry::Bounds3;

use crate::depth::{MAX_DEPTH, MAX_PRIMITIVES};
use crate::observer::observed;
use crate::prim_info::PrimInfo;
use crate::recursive::{Group, Rules};
use crate::subtree::Subtree;
use crate::{BuildConfig, BuildError, BuildObserver, Phase, SplitMethod, Tree, hlbvh};

/// The tree over `bounds`; see [`build_observed`].
///
/// # Errors
/// As [`build_observed`].
pub fn build(bounds: &[Bounds3], config: &BuildConfig) -> Result<Tree, BuildError> {
    build_observed(bounds, config, &())
}

/// The tree over `bounds`, one for each primitive, while `observer` is told of its phases.
///
/// Primitives whose bounds are not [valid](Bounds3::is_valid) are inactive: they keep their index and are in no leaf.
/// Where none is active, the tree is empty. The same bounds and configuration make the same tree, bit for bit, on any
/// number of threads and without the feature `parallel`. Time is linear in n for each level of the tree.
///
/// # Errors
/// [`BuildError::InvalidConfig`], and [`BuildError::TooManyPrimitives`] beyond 2³¹ bounds.
pub fn build_observed(
    bounds: &[Bounds3],
    config: &BuildConfig,
    observer: &dyn BuildObserver,
) -> Result<Tree, BuildError> {
    config.validate()?;
    check_count(bounds.len())?;
    let mut prims = observed(observer, Phase::Bounds, || PrimInfo::active(bounds));
    let root = match config.split_method {
        _ if prims.is_empty() => Subtree::default(),
        SplitMethod::Hlbvh => hlbvh::build(&mut prims, config, observer),
        SplitMethod::Sah | SplitMethod::Middle | SplitMethod::EqualCounts => {
            observed(observer, Phase::Recursion, || {
                Subtree::grow(Group::new(&mut prims, 0, &Rules::new(config, MAX_DEPTH)), 1)
            })
        }
    };
    let (nodes, order) = observed(observer, Phase::Assembly, || root.assemble(&prims));
    let inactive = bounds.len() - prims.len();
    let tree = observed(observer, Phase::Statistics, || Tree::new(nodes, order, inactive, config));
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
