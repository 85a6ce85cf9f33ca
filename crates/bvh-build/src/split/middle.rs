//! Splitting in the middle of the centroids.

use geometry::Axis;

use super::{Split, equal_counts, partition};
use crate::prim_info::{Extent, PrimInfo};
use crate::{Cancelled, ProgressReporter};

/// Splits `prims` at the midpoint of their centroids' interval `(axis, low, high)`; by equal counts where that
/// separates nothing, as when low and high are neighbouring numbers.
pub(crate) fn split(
    prims: &mut [PrimInfo],
    extent: &Extent,
    (axis, low, high): (Axis, f32, f32),
    progress: &ProgressReporter,
) -> Result<Split, Cancelled> {
    let midpoint = 0.5 * low + 0.5 * high;
    match partition(prims, |p| p.centroid2_on(axis) < midpoint, progress)? {
        middle if 0 < middle && middle < prims.len() => Split::at(middle, axis, prims, progress),
        _ => equal_counts::split(prims, extent, progress),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Bounds3;
    use geometry::glam::Vec3;

    fn points(x: &[f32]) -> Vec<PrimInfo> {
        (0..).zip(x).map(|(i, &x)| PrimInfo::new(&Bounds3::from_points([Vec3::new(x, 0.0, 0.0)]), i)).collect()
    }

    fn split_in_the_middle(prims: &mut [PrimInfo]) -> Split {
        let extent = Extent::of(prims);
        let interval = extent.centroid_interval().expect("spread");
        split(prims, &extent, interval, &ProgressReporter::unobserved()).expect("nobody cancels")
    }

    #[test]
    fn centroids_are_divided_at_their_midpoint() {
        let mut prims = points(&[9.0, 1.0, 0.0, 4.9, 5.1, 10.0]);
        let split = split_in_the_middle(&mut prims);
        assert_eq!((split.axis, split.middle), (Axis::X, 3));
        let mut first: Vec<_> = prims[..3].iter().map(|p| p.index()).collect();
        first.sort_unstable();
        assert_eq!(first, [1, 2, 3]);
        assert_eq!(split.extents, [Extent::of(&prims[..3]), Extent::of(&prims[3..])]);
    }

    #[test]
    fn neighbouring_numbers_are_split_by_count() {
        // The midpoint of an even number and the next above it rounds to the even one: nothing is below it.
        let mut prims = points(&[1.0, 1.0, 1.0, 1.0_f32.next_up()]);
        let split = split_in_the_middle(&mut prims);
        assert_eq!(split.middle, 2);
    }
}
