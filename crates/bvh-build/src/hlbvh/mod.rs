//! Hierarchical linear bounding volume hierarchies (Pantaleoni and Luebke 2010; Garanzha et al. 2011; pbrt, 4.3.3).

mod coded;
mod sort;
mod treelet;
mod upper_sah;

use crate::morton::MortonGrid;
use crate::parallel;
use crate::prim_info::{Extent, PrimInfo};
use crate::room::Room;
use crate::subtree::Subtree;
use crate::{BuildConfig, BuildObserver, Cancelled, Phase, ProgressReporter};
use coded::{Coded, Packed};

/// How many of a code's bits, from the highest, name the treelet.
const TREELET_BITS: u32 = 12;

/// The tree over `prims`, of which there is one at least, and whose extent is `extent`.
pub(crate) fn grow(
    prims: &[PrimInfo],
    extent: &Extent,
    config: &BuildConfig,
    observer: &dyn BuildObserver,
) -> Result<Subtree, Cancelled> {
    let codes = ProgressReporter::observe(observer, Phase::MortonCodes, prims.len(), |progress| {
        let grid = MortonGrid::new(prims, extent, config.morton_bits, progress)?;
        let low_bits = grid.code_bits() - TREELET_BITS;
        Ok(if fits::<Short>(&grid, prims) {
            Codes::Short(coded(prims, &grid, progress)?, low_bits)
        } else if fits::<Middle>(&grid, prims) {
            Codes::Middle(coded(prims, &grid, progress)?, low_bits)
        } else {
            Codes::Long(coded(prims, &grid, progress)?, low_bits)
        })
    })?;
    match codes {
        Codes::Short(coded, low_bits) => grow_coded(coded, low_bits, prims, config, observer),
        Codes::Middle(coded, low_bits) => grow_coded(coded, low_bits, prims, config, observer),
        Codes::Long(coded, low_bits) => grow_coded(coded, low_bits, prims, config, observer),
    }
}

/// Codes of 32 bits, of as many primitives as there may be.
type Short = Packed<32>;

/// Codes of 42 bits, of up to four million primitives: in 8 bytes each instead of 16, which makes kitchen's fastest
/// build (1.4 million) take 0.94 of the time, and black-forest's 0.91.
type Middle = Packed<22>;

/// The codes of all primitives, and how many of their bits do not name the treelet.
enum Codes {
    Short(Room<Short>, u32),
    Middle(Room<Middle>, u32),
    Long(Room<u128>, u32),
}

fn fits<C: Coded>(grid: &MortonGrid, prims: &[PrimInfo]) -> bool {
    grid.code_bits() <= C::CODE_BITS && prims.len() as u64 <= 1 << C::NUMBER_BITS
}

fn coded<C: Coded>(prims: &[PrimInfo], grid: &MortonGrid, progress: &ProgressReporter) -> Result<Room<C>, Cancelled> {
    let mut coded = Room::zeroed(prims.len());
    let part = |part: &mut [C], begin: usize| {
        for ((coded, place), p) in part.iter_mut().zip(begin..).zip(&prims[begin..]) {
            *coded = C::new(grid.code(p), place as u32);
        }
    };
    parallel::fold_mut(&mut coded, 0, progress, &part, &|(), ()| ())?;
    Ok(coded)
}

fn grow_coded<C: Coded>(
    mut coded: Room<C>,
    low_bits: u32,
    prims: &[PrimInfo],
    config: &BuildConfig,
    observer: &dyn BuildObserver,
) -> Result<Subtree, Cancelled> {
    let n = prims.len();
    ProgressReporter::observe(observer, Phase::Sort, n, |progress| sort::sort(&mut coded, progress))?;
    let treelets = ProgressReporter::observe(observer, Phase::Treelets, n, |progress| {
        treelet::build(&coded, low_bits, prims, config, progress)
    })?;
    drop(coded);
    ProgressReporter::observe(observer, Phase::UpperTree, treelets.len(), |progress| {
        upper_sah::build(treelets, config, progress)
    })
}
