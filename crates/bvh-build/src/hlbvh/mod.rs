//! Hierarchical linear bounding volume hierarchies (Pantaleoni and Luebke 2010; Garanzha et al. 2011; pbrt, chapter 4).

mod coded;
mod sort;
mod treelet;
mod upper_sah;

use crate::morton::MortonGrid;
use crate::observer::observed;
use crate::parallel;
use crate::prim_info::{Extent, PrimInfo};
use crate::{BuildConfig, BuildObserver, Node, Phase};
use coded::Coded;

/// How many of a code's bits, from the highest, name the treelet.
const TREELET_BITS: u32 = 12;

/// The nodes and the order of the tree over `prims`, of which there is one at least.
pub(crate) fn build(prims: &[PrimInfo], config: &BuildConfig, observer: &dyn BuildObserver) -> (Vec<Node>, Vec<u32>) {
    observer.begin(Phase::MortonCodes);
    let grid = MortonGrid::new(prims, &Extent::of(prims), config.morton_bits);
    if grid.code_bits() <= <u64 as Coded>::CODE_BITS {
        build_coded::<u64>(&grid, prims, config, observer)
    } else {
        build_coded::<u128>(&grid, prims, config, observer)
    }
}

/// The same with codes of the length of `C`; the first phase has begun.
fn build_coded<C: Coded>(
    grid: &MortonGrid,
    prims: &[PrimInfo],
    config: &BuildConfig,
    observer: &dyn BuildObserver,
) -> (Vec<Node>, Vec<u32>) {
    let mut coded = parallel::collect(prims.len(), |place| C::new(grid.code(&prims[place]), place as u32));
    observer.end(Phase::MortonCodes);
    observed(observer, Phase::Sort, || sort::sort(&mut coded));
    let low_bits = grid.code_bits() - TREELET_BITS;
    let treelets = observed(observer, Phase::Treelets, || treelet::build(&mut coded, low_bits, prims, config));
    let root = observed(observer, Phase::UpperTree, || upper_sah::build(treelets, config));
    // The treelets have left the primitives' indices there.
    observed(observer, Phase::Assembly, || root.assemble(coded.len(), |place| coded[place].number()))
}
