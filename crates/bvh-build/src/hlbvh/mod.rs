//! Hierarchical linear bounding volume hierarchies (Pantaleoni and Luebke 2010; Garanzha et al. 2011; pbrt, 4.3.3).

mod coded;
mod sort;
mod treelet;
mod upper_sah;

use crate::morton::MortonGrid;
use crate::parallel;
use crate::prim_info::{Extent, PrimInfo};
use crate::room::Room;
use crate::{BuildConfig, BuildObserver, Cancelled, Node, Phase, ProgressReporter};
use coded::Coded;

/// How many of a code's bits, from the highest, name the treelet.
const TREELET_BITS: u32 = 12;

/// The nodes and the order of the tree over `prims`, of which there is one at least.
pub(crate) fn build(
    prims: &[PrimInfo],
    config: &BuildConfig,
    observer: &dyn BuildObserver,
) -> Result<(Vec<Node>, Vec<u32>), Cancelled> {
    let codes = ProgressReporter::observe(observer, Phase::MortonCodes, prims.len(), |progress| {
        let extent = Extent::of_many(prims, progress)?;
        let grid = MortonGrid::new(prims, &extent, config.morton_bits, progress)?;
        let low_bits = grid.code_bits() - TREELET_BITS;
        Ok(if grid.code_bits() <= <u64 as Coded>::CODE_BITS {
            Codes::Short(coded(prims, &grid, progress)?, low_bits)
        } else {
            Codes::Long(coded(prims, &grid, progress)?, low_bits)
        })
    })?;
    match codes {
        Codes::Short(coded, low_bits) => build_coded(coded, low_bits, prims, config, observer),
        Codes::Long(coded, low_bits) => build_coded(coded, low_bits, prims, config, observer),
    }
}

/// The codes of all primitives, and how many of their bits do not name the treelet.
enum Codes {
    Short(Room<u64>, u32),
    Long(Room<u128>, u32),
}

fn coded<C: Coded>(prims: &[PrimInfo], grid: &MortonGrid, progress: &ProgressReporter) -> Result<Room<C>, Cancelled> {
    let mut coded = Room::zeroed(prims.len());
    parallel::fill(&mut coded, progress, |place| C::new(grid.code(&prims[place]), place as u32))?;
    Ok(coded)
}

fn build_coded<C: Coded>(
    mut coded: Room<C>,
    low_bits: u32,
    prims: &[PrimInfo],
    config: &BuildConfig,
    observer: &dyn BuildObserver,
) -> Result<(Vec<Node>, Vec<u32>), Cancelled> {
    let n = prims.len();
    ProgressReporter::observe(observer, Phase::Sort, n, |progress| sort::sort(&mut coded, progress))?;
    let treelets = ProgressReporter::observe(observer, Phase::Treelets, n, |progress| {
        treelet::build(&mut coded, low_bits, prims, config, progress)
    })?;
    let root = ProgressReporter::observe(observer, Phase::UpperTree, treelets.len(), |progress| {
        upper_sah::build(treelets, config, progress)
    })?;
    // The treelets have left the primitives' indices there.
    ProgressReporter::observe(observer, Phase::Assembly, root.node_count(), |progress| {
        root.assemble(n, |place| coded[place].number(), None, progress)
    })
}
