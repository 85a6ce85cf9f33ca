//! Where to split one node.

pub(crate) mod equal_counts;
mod middle;
pub(crate) mod sah;

use geometry::Axis;

use crate::parallel::SEQUENTIAL;
use crate::prim_info::{Extent, PrimInfo};
use crate::recursive::Rules;
use crate::{Cancelled, ProgressReporter, SplitMethod};

/// A node's primitives in two parts, neither of them empty.
pub(crate) struct Split {
    /// The axis along which they were divided.
    pub(crate) axis: Axis,
    /// How many are in the first part.
    pub(crate) middle: usize,
    /// What the parts take up.
    pub(crate) extents: [Extent; 2],
}

impl Split {
    /// The split of `prims`, which are in order already, before `middle`.
    fn at(middle: usize, axis: Axis, prims: &[PrimInfo], progress: &ProgressReporter) -> Result<Self, Cancelled> {
        let (a, b) = prims.split_at(middle);
        Ok(Self { axis, middle, extents: [Extent::of_many(a, progress)?, Extent::of_many(b, progress)?] })
    }
}

/// Splits `prims`, whose extent is `extent`, and reorders them accordingly; `None` where they are a leaf. Where
/// `is_free` is false, a split is by halves.
pub(crate) fn split(
    prims: &mut [PrimInfo],
    extent: &Extent,
    rules: &Rules,
    is_free: bool,
) -> Result<Option<Split>, Cancelled> {
    let Rules { config, progress, .. } = rules;
    let fits_a_leaf = prims.len() <= config.max_primitives_in_leaf as usize;
    let interval = extent.centroid_interval().filter(|_| is_free);
    Ok(match (config.split_method, interval) {
        _ if prims.len() == 1 => None,
        // pbrt gives pairs to equal counts and never asks whether they would be better as a leaf. The buckets find the
        // same split, and do ask.
        (SplitMethod::Sah, Some(_)) if extent.bounds.surface_area() > 0.0 => {
            match sah::split(prims, extent, config, sah::leaf_cost(prims.len(), config), progress)? {
                // Only where the processor takes differences below 2⁻¹²⁶ for zero.
                None if !fits_a_leaf => Some(equal_counts::split(prims, extent, progress)?),
                split => split,
            }
        }
        _ if fits_a_leaf => None,
        (SplitMethod::Middle, Some(interval)) => Some(middle::split(prims, extent, interval, progress)?),
        _ => Some(equal_counts::split(prims, extent, progress)?),
    })
}

/// Moves all of `prims` that `is_first` before the others, and returns how many they are.
pub(crate) fn partition(
    prims: &mut [PrimInfo],
    mut is_first: impl FnMut(&PrimInfo) -> bool,
    progress: &ProgressReporter,
) -> Result<usize, Cancelled> {
    // Lomuto's scheme without a branch: half of all branches here would be mispredicted.
    let mut middle = 0;
    for begin in (0..prims.len()).step_by(SEQUENTIAL) {
        if begin > 0 {
            progress.check()?;
        }
        for i in begin..prims.len().min(begin + SEQUENTIAL) {
            let first = is_first(&prims[i]);
            prims.swap(i, middle);
            middle += usize::from(first);
        }
    }
    Ok(middle)
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Bounds3;

    #[test]
    fn a_partition_moves_all_that_are_first_to_the_front() {
        for n in 0..12_u32 {
            for wanted in 0..1_u32 << n {
                let mut prims: Vec<_> = (0..n).map(|i| PrimInfo::new(&Bounds3::default(), i)).collect();
                let middle = partition(&mut prims, |p| wanted >> p.index() & 1 == 1, &ProgressReporter::unobserved());
                let middle = middle.expect("nobody cancels");
                assert_eq!(middle as u32, wanted.count_ones());
                let front = prims[..middle].iter().fold(0, |set, p| set | 1 << p.index());
                let back = prims[middle..].iter().fold(0, |set, p| set | 1 << p.index());
                assert_eq!((front, back), (wanted, !wanted & ((1 << n) - 1)));
            }
        }
    }
}
