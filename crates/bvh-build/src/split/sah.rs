//! The surface area heuristic over buckets.

mod buckets;
mod few;

use geometry::Axis;

use super::{Split, partition};
use crate::BuildConfig;
use crate::prim_info::{Extent, PrimInfo};
use buckets::Buckets;

/// Into how many buckets the interval of the centroids is divided, as in pbrt.
const BUCKET_COUNT: usize = 12;

/// Splits `prims` between two of 12 equal buckets over the interval `(axis, low, high)` of their centroids: at that of
/// the 11 boundaries where the expected cost of a ray that meets the node is least, of equals at the first. `None`
/// where no split costs less than `leaf_cost`.
///
/// The cost is t_trav + p_A n_A t_isect + p_B n_B t_isect. A random ray that meets the node's bounds C meets bounds A
/// inside of them with the probability p_A = s_A / s_C, s being the surface area (pbrt, chapter 4). Requires that
/// low < high and s_C > 0.
#[inline(never)] // Its arrays are large, and must not lie on the stack once for every level.
pub(crate) fn split(
    prims: &mut [PrimInfo],
    extent: &Extent,
    (axis, low, high): (Axis, f32, f32),
    config: &BuildConfig,
    leaf_cost: f64,
) -> Option<Split> {
    let projection = Projection::new(axis, low, high);
    let [t_trav, t_isect] = [config.traversal_cost, config.intersection_cost].map(f64::from);
    let is_worth_it = |weight: f64| t_trav + t_isect * weight / extent.bounds.surface_area() < leaf_cost;
    // With no more primitives than buckets, most buckets would be empty. With them for all nodes, a build of a million
    // boxes took 455 ms instead of 345 (one thread, CPU time).
    if prims.len() <= BUCKET_COUNT {
        let best = few::cheapest_boundary(prims, projection);
        return is_worth_it(best.weight).then(|| Split::at(best.place, axis, prims));
    }
    let buckets = Buckets::of(prims, projection);
    let best = buckets.cheapest_boundary();
    is_worth_it(best.weight).then(|| {
        let middle = partition(prims, |p| projection.bucket(p) < best.place);
        Split { axis, middle, extents: buckets.extents(best.place) }
    })
}

/// A boundary with primitives on both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Boundary {
    /// How many buckets, or primitives in order of their buckets, lie before it.
    place: usize,
    /// Count times area of what lies before it and of what lies behind: n_A s_A + n_B s_B.
    weight: f64,
}

impl Boundary {
    const NONE: Self = Self { place: 0, weight: f64::INFINITY };
}

/// Assigns primitives to buckets by their centroids.
#[derive(Clone, Copy)]
struct Projection {
    axis: Axis,
    low: f32,
    scale: f32,
}

impl Projection {
    fn new(axis: Axis, low: f32, high: f32) -> Self {
        Self { axis, low, scale: BUCKET_COUNT as f32 / (high - low) }
    }

    /// The bucket, never one that is not there. The lowest centroid is in the first bucket: 0 · scale is 0, or NaN
    /// where scale overflows to infinity, and both convert to 0. The highest is in the last: scale is rounded from
    /// 12 / (high − low), and its product with the same difference is more than 11.
    #[inline]
    fn bucket(self, p: &PrimInfo) -> usize {
        (((p.centroid2_on(self.axis) - self.low) * self.scale) as i32).min(BUCKET_COUNT as i32 - 1) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Bounds3;
    use geometry::glam::Vec3;

    /// Boxes of many sizes; every third is flat, and every fifth is at one of few places.
    fn boxes(n: u32, seed: u32) -> Vec<PrimInfo> {
        let mut state = u64::from(seed);
        let mut random = || {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
            (state >> 40) as f32 / (1 << 24) as f32
        };
        (0..n)
            .map(|i| {
                let mut min = Vec3::new(random(), random(), random()) * Vec3::new(1.0, 3.0, 2.0);
                if i % 5 == 0 {
                    min = (min * 2.0).floor();
                }
                let mut size = Vec3::splat(random() * random() * 0.3);
                if i % 3 == 0 {
                    size.y = 0.0;
                }
                PrimInfo::new(&Bounds3::new(min, min + size), i)
            })
            .collect()
    }

    /// The 11 boundaries, each evaluated from the primitives: the indices before the cheapest, and its cost.
    fn brute_force(prims: &[PrimInfo], config: &BuildConfig) -> (Vec<u32>, f64) {
        let extent = Extent::of(prims);
        let (axis, low, high) = extent.centroid_interval().expect("spread");
        let side = |first: bool, place: usize| -> Vec<&PrimInfo> {
            let bucket =
                |p: &PrimInfo| (12.0 / (high - low) * (p.centroid2_on(axis) - low)).floor().clamp(0.0, 11.0) as usize;
            prims.iter().filter(|p| (bucket(p) < place) == first).collect()
        };
        let area = |side: &[&PrimInfo]| {
            side.iter().fold(Bounds3::EMPTY, |all, p| all.union(&p.bounds().to_bounds())).surface_area()
        };
        let mut best = (Vec::new(), f64::INFINITY);
        for place in 1..12 {
            let [a, b] = [side(true, place), side(false, place)];
            if !a.is_empty() && !b.is_empty() {
                let weight = a.len() as f64 * area(&a) + b.len() as f64 * area(&b);
                let cost = f64::from(config.traversal_cost)
                    + f64::from(config.intersection_cost) * weight / extent.bounds.surface_area();
                if cost < best.1 {
                    best = (a.iter().map(|p| p.index).collect(), cost);
                }
            }
        }
        best
    }

    #[test]
    fn the_split_is_the_cheapest_of_all_boundaries() {
        let config = BuildConfig::default();
        for n in (2..=40).chain([100, 1000, 70_000]) {
            for seed in 0..if n < 100 { 20 } else { 2 } {
                let mut prims = boxes(n, seed);
                let extent = Extent::of(&prims);
                let interval = extent.centroid_interval().expect("spread");
                let (expected, cost) = brute_force(&prims, &config);

                assert!(split(&mut prims, &extent, interval, &config, cost).is_none(), "a leaf is as cheap: {n}");
                let found = split(&mut prims, &extent, interval, &config, cost.next_up()).expect("a split is cheaper");
                let mut before: Vec<_> = prims[..found.middle].iter().map(|p| p.index).collect();
                before.sort_unstable();
                assert_eq!(before, expected, "{n} {seed}");
                assert_eq!(found.axis, interval.0);
                assert_eq!(found.extents, [Extent::of(&prims[..found.middle]), Extent::of(&prims[found.middle..])]);
            }
        }
    }

    #[test]
    fn the_ends_of_every_interval_are_in_the_outer_buckets() {
        let ends = [0.0, 1e-45, 1e-38, 1.0, 1.0_f32.next_up(), 3.0, 1e18, -1e-45, -1.0, -7.3, -1e18];
        for low in ends {
            for high in ends.into_iter().filter(|&high| low < high) {
                let at = |x: f32| PrimInfo::new(&Bounds3::new(Vec3::splat(0.0), Vec3::new(x, 0.0, 0.0)), 0);
                let projection = Projection::new(Axis::X, low, high);
                assert_eq!([projection.bucket(&at(low)), projection.bucket(&at(high))], [0, 11], "{low} {high}");
            }
        }
    }
}
