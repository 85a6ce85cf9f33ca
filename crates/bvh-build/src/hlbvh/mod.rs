//! Hierarchical linear bounding volume hierarchies (Pantaleoni and Luebke 2010; Garanzha et al. 2011; pbrt, chapter 4).

mod treelet;
mod upper_sah;

use crate::morton::MortonGrid;
use crate::observer::observed;
use crate::prim_info::{Extent, PrimInfo};
use crate::subtree::Subtree;
use crate::{BuildConfig, BuildObserver, Phase};

/// How many of a code's bits, from the highest, name the treelet.
const TREELET_BITS: u32 = 12;

/// The subtree of `prims`, which are put in Morton order.
pub(crate) fn build(prims: &mut Vec<PrimInfo>, config: &BuildConfig, observer: &dyn BuildObserver) -> Subtree {
    let (grid, mut coded) = observed(observer, Phase::MortonCodes, || {
        let grid = MortonGrid::new(prims, &Extent::of(prims), config.morton_bits);
        let coded: Vec<_> = (0_u32..).zip(prims.iter()).map(|(place, p)| Coded { code: grid.code(p), place }).collect();
        (grid, coded)
    });
    let codes = observed(observer, Phase::Sort, || {
        sort(&mut coded);
        *prims = coded.iter().map(|c| prims[c.place as usize]).collect();
        coded.iter().map(|c| c.code).collect::<Vec<_>>()
    });
    drop(coded);
    let treelets =
        observed(observer, Phase::Treelets, || treelet::build(&codes, grid.code_bits() - TREELET_BITS, prims, config));
    observed(observer, Phase::UpperTree, || upper_sah::build(treelets, config))
}

/// A primitive's code, and where it lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Coded {
    code: u64,
    place: u32,
}

/// Sorts by code; of equal codes the order stays.
fn sort(coded: &mut [Coded]) {
    radsort::sort_by_key(coded, |c| c.code);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sort_is_the_stable_one() {
        for (n, mask) in [(0, 1), (1, 1), (2, 0), (1000, 0), (1000, 7), (5000, 0x3fff_ffff), (5000, u64::MAX >> 1)] {
            let mut state = 7_u64;
            let coded: Vec<_> = (0..n)
                .map(|place| {
                    state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
                    Coded { code: (state >> 20 ^ state) & mask, place }
                })
                .collect();
            let (mut sorted, mut naive) = (coded.clone(), coded);
            sort(&mut sorted);
            naive.sort_by_key(|c| (c.code, c.place));
            assert_eq!(sorted, naive);
        }
    }
}
