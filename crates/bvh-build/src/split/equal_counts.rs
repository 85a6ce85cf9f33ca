//! Splitting into halves.

use super::Split;
use crate::prim_info::{Extent, PrimInfo};
use crate::{Cancelled, ProgressReporter};

/// Splits `prims`, two or more, into two parts whose sizes differ by at most one, the second being the larger: by their
/// centroids along the axis where these are spread most, of equal centroids by index.
pub(crate) fn split(prims: &mut [PrimInfo], extent: &Extent, progress: &ProgressReporter) -> Result<Split, Cancelled> {
    let middle = prims.len() / 2;
    let axis = extent.centroids2.to_bounds().dominant_axis();
    prims.select_nth_unstable_by(middle, |a, b| {
        a.centroid2_on(axis).total_cmp(&b.centroid2_on(axis)).then(a.index().cmp(&b.index()))
    });
    Split::at(middle, axis, prims, progress)
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Bounds3;
    use geometry::glam::Vec3;

    #[test]
    fn the_lower_half_comes_first_as_a_sort_would_have_it() {
        for n in 2..40_u32 {
            // Many equal centroids, so that indices decide.
            let mut prims: Vec<_> = (0..n)
                .map(|i| PrimInfo::new(&Bounds3::from_points([Vec3::new(0.0, (i * 7 % 5) as f32, 0.0)]), i))
                .collect();
            let mut sorted: Vec<_> = (0..n).collect();
            sorted.sort_by_key(|&i| (i * 7 % 5, i));
            let extent = Extent::of(&prims);
            let split = split(&mut prims, &extent, &ProgressReporter::unobserved()).expect("nobody cancels");
            assert_eq!(split.middle, n as usize / 2);
            let mut first: Vec<_> = prims[..split.middle].iter().map(|p| p.index()).collect();
            first.sort_by_key(|&i| (i * 7 % 5, i));
            assert_eq!(first, sorted[..split.middle]);
        }
    }

    #[test]
    fn one_point_is_halved_by_index() {
        let mut prims: Vec<_> = (0..7).rev().map(|i| PrimInfo::new(&Bounds3::from_points([Vec3::ONE]), i)).collect();
        let extent = Extent::of(&prims);
        let split = split(&mut prims, &extent, &ProgressReporter::unobserved()).expect("nobody cancels");
        assert_eq!(split.middle, 3);
        assert!(prims[..3].iter().all(|p| p.index() < 3));
    }
}
