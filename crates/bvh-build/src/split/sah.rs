//! The surface area heuristic: over buckets, or over all boundaries where primitives are few.

mod all_axes;
mod buckets;
mod few;
mod sweep;

use geometry::Axis;

use super::{Split, partition};
use crate::config::MAX_BUCKETS;
use crate::prim_info::{Bounds3A, Extent, PrimInfo};
use crate::{BuildConfig, Cancelled, ProgressReporter, SplitAxes};
pub(crate) use all_axes::{Buckets, Grid, Plane, cheapest_plane};
pub(crate) use sweep::{MAX_SWEPT, Sorted};

/// Splits `prims` where the expected cost of a ray that meets the node is least, by the axes and buckets of `config`.
/// `None` where no split costs less than `leaf_cost`, or no boundary separates anything.
///
/// The cost is t_trav + p_A n_A t_isect + p_B n_B t_isect. A random ray that meets the node's bounds C meets bounds A
/// inside of them with the probability p_A = s_A / s_C, s being the surface area (pbrt, 4.3.2). Requires that the
/// centroids are not all one point, and s_C > 0.
pub(crate) fn split(
    prims: &mut [PrimInfo],
    extent: &Extent,
    config: &BuildConfig,
    leaf_cost: f64,
    progress: &ProgressReporter,
) -> Result<Option<Split>, Cancelled> {
    let limit = Limit::new(extent, config, leaf_cost);
    if !limit.is_any() {
        return Ok(None);
    }
    match (config.axes, config.buckets) {
        (SplitAxes::Dominant, ..=12) => one_axis::<12>(prims, extent, config, limit, progress),
        (SplitAxes::Dominant, ..=32) => one_axis::<32>(prims, extent, config, limit, progress),
        (SplitAxes::Dominant, _) => one_axis::<MAX_BUCKETS>(prims, extent, config, limit, progress),
        (SplitAxes::All, _) if prims.len() <= config.full_sweep as usize => sweep::split(prims, limit, progress),
        (SplitAxes::All, _) => all_axes::split(prims, extent, config, limit, progress),
    }
}

/// Splits `prims` between two of the equal buckets over the interval of their centroids on the dominant axis: at that
/// of the boundaries where the cost is least, of equals at the first.
#[inline(never)] // Its arrays are large, and must not lie on the stack once for every level.
fn one_axis<const CAPACITY: usize>(
    prims: &mut [PrimInfo],
    extent: &Extent,
    config: &BuildConfig,
    limit: Limit,
    progress: &ProgressReporter,
) -> Result<Option<Split>, Cancelled> {
    let Some((axis, low, high)) = extent.centroid_interval() else { return Ok(None) };
    let projection = Projection::new(axis, low, high, config.buckets);
    // With no more primitives than buckets, most buckets would be empty. With them for all nodes, a build of a million
    // boxes took 455 ms instead of 345 (one thread, CPU time).
    if prims.len() <= config.buckets as usize {
        let best = few::cheapest_boundary::<CAPACITY>(prims, projection);
        return limit.is_above(best.weight).then(|| Split::at(best.place, axis, prims, progress)).transpose();
    }
    let mut buckets = buckets::Buckets::<CAPACITY>::EMPTY;
    buckets.add(prims, projection, progress)?;
    let best = buckets.cheapest_boundary();
    if !limit.is_above(best.weight) {
        return Ok(None);
    }
    let middle = partition(prims, |p| projection.bucket(p) < best.place as i32, progress)?;
    Ok(Some(Split { axis, middle, extents: buckets.extents(best.place) }))
}

/// What a split must cost less than, to be made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limit {
    t_trav: f64,
    t_isect: f64,
    bounds: Bounds3A,
    leaf_cost: f64,
}

impl Limit {
    /// The limit `leaf_cost` for a node that takes up `extent`, which has some area.
    pub(crate) fn new(extent: &Extent, config: &BuildConfig, leaf_cost: f64) -> Self {
        let [t_trav, t_isect] = [config.traversal_cost, config.intersection_cost].map(f64::from);
        Self { t_trav, t_isect, bounds: extent.bounds, leaf_cost }
    }

    /// The limit for a set of `count` primitives: what they cost as a leaf, if they fit one.
    pub(crate) fn of(count: usize, extent: &Extent, config: &BuildConfig) -> Self {
        Self::new(extent, config, leaf_cost(count, config))
    }

    /// Whether `count` primitives as a leaf cost no more than any split of them can.
    pub(crate) fn is_cheap(count: usize, config: &BuildConfig) -> bool {
        leaf_cost(count, config) <= f64::from(config.traversal_cost)
    }

    /// Whether any split can cost less.
    pub(crate) fn is_any(&self) -> bool {
        self.t_trav < self.leaf_cost
    }

    /// Whether a boundary of this weight costs less. No boundary has the weight infinity, and costs less than nothing.
    fn is_above(&self, weight: f64) -> bool {
        weight < f64::INFINITY
            && (self.leaf_cost == f64::INFINITY
                || self.t_trav + self.t_isect * weight / self.bounds.surface_area() < self.leaf_cost)
    }
}

/// What `count` primitives cost as a leaf, if they fit one.
pub(crate) fn leaf_cost(count: usize, config: &BuildConfig) -> f64 {
    let fits_a_leaf = count <= config.max_primitives_in_leaf as usize;
    if fits_a_leaf { f64::from(config.intersection_cost) * count as f64 } else { f64::INFINITY }
}

/// A boundary with primitives on both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Boundary {
    /// How many buckets, or primitives in order of their buckets, lie before it.
    pub(crate) place: usize,
    /// Count times area of what lies before it and of what lies behind: n_A s_A + n_B s_B.
    pub(crate) weight: f64,
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
    last: i32,
}

impl Projection {
    /// To `count` buckets over the interval from `low` to `high`.
    fn new(axis: Axis, low: f32, high: f32, count: u32) -> Self {
        Self { axis, low, scale: count as f32 / (high - low), last: count as i32 - 1 }
    }

    /// The bucket, never one that is not there. The lowest centroid is in the first bucket: 0 · scale is 0, or NaN
    /// where scale overflows to infinity, and both convert to 0. The highest is in the last: scale is rounded from
    /// count / (high − low), and its product with the same difference is more than count − 1.
    #[inline]
    fn bucket(self, p: &PrimInfo) -> i32 {
        (((p.centroid2_on(self.axis) - self.low) * self.scale) as i32).min(self.last)
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

    /// The primitives' indices in the first part, in order, and the cost of the split.
    type Found = (Vec<u32>, f64);

    /// The cheaper one of `best` and the split into those with a key below some key, and the others; every one of them
    /// evaluated from the primitives.
    fn brute_force(prims: &[PrimInfo], config: &BuildConfig, key: impl Fn(&PrimInfo) -> f32, best: &mut Found) {
        let extent = Extent::of(prims);
        let area = |side: &[&PrimInfo]| {
            side.iter().fold(Bounds3::EMPTY, |all, p| all.union(&p.bounds().to_bounds())).surface_area()
        };
        let mut keys: Vec<_> = prims.iter().map(&key).collect();
        keys.sort_by(f32::total_cmp);
        keys.dedup();
        for &middle in &keys[1..] {
            let (a, b): (Vec<&PrimInfo>, Vec<&PrimInfo>) = prims.iter().partition(|p| key(p) < middle);
            let weight = a.len() as f64 * area(&a) + b.len() as f64 * area(&b);
            let cost = f64::from(config.traversal_cost)
                + f64::from(config.intersection_cost) * weight / extent.bounds.surface_area();
            if cost < best.1 {
                *best = (indices(a.into_iter()), cost);
            }
        }
    }

    fn indices<'a>(prims: impl Iterator<Item = &'a PrimInfo>) -> Vec<u32> {
        let mut indices: Vec<_> = prims.map(|p| p.index()).collect();
        indices.sort_unstable();
        indices
    }

    /// The cheapest split that `config` allows.
    fn cheapest(prims: &[PrimInfo], config: &BuildConfig) -> Found {
        let extent = Extent::of(prims);
        let mut best = (Vec::new(), f64::INFINITY);
        let count = match config.axes {
            SplitAxes::Dominant => config.buckets,
            SplitAxes::All => config.buckets_of(prims.len()),
        } as f32;
        for axis in Axis::ALL {
            let [low, high] = [extent.centroids2.min, extent.centroids2.max].map(|c| c[axis.index()]);
            let place = |p: &PrimInfo| count / (high - low) * (p.centroid2_on(axis) - low);
            if low < high {
                match config.axes {
                    SplitAxes::Dominant if extent.centroids2.to_bounds().dominant_axis() != axis => {}
                    SplitAxes::Dominant => {
                        brute_force(prims, config, |p| place(p).floor().clamp(0.0, count - 1.0), &mut best);
                    }
                    SplitAxes::All if prims.len() <= config.full_sweep as usize => {
                        brute_force(prims, config, |p| p.centroid2_on(axis), &mut best);
                    }
                    SplitAxes::All => {
                        let bucket = |p: &PrimInfo| (place(p) - 0.5).round_ties_even().clamp(0.0, count - 1.0);
                        brute_force(prims, config, bucket, &mut best);
                    }
                }
            }
        }
        best
    }

    #[test]
    fn the_split_is_the_cheapest_of_all_boundaries() {
        let configs = [2, 3, 12, 13, 16, 32, 33, 64].into_iter().flat_map(|buckets| {
            SplitAxes::ALL
                .map(|axes| BuildConfig::default().with_buckets(buckets).with_axes(axes).with_full_sweep(buckets / 2))
        });
        for config in configs {
            for n in (2..=40).chain([63, 64, 65, 100, 1000, 70_000]) {
                for seed in 0..if n < 100 { 5 } else { 1 } {
                    let mut prims = boxes(n, seed);
                    let extent = Extent::of(&prims);
                    let (expected, cost) = cheapest(&prims, &config);
                    let what = format!("{n} {seed} {config:?}");

                    let mut split = |leaf_cost| {
                        let progress = ProgressReporter::unobserved();
                        split(&mut prims, &extent, &config, leaf_cost, &progress).expect("nobody cancels")
                    };
                    // On all axes costs are compared in f32.
                    let is_rounded = config.axes == SplitAxes::All && n > config.full_sweep;
                    let error = if is_rounded { 1e-6 * cost } else { 0.0 };
                    assert!(split(cost - error).is_none(), "a leaf is as cheap: {what}");
                    let found = split((cost + error).next_up()).expect("a split is cheaper");
                    let (a, b) = prims.split_at(found.middle);
                    let weight = |side: &[PrimInfo]| side.len() as f64 * Extent::of(side).bounds.surface_area();
                    let part = (weight(a) + weight(b)) / extent.bounds.surface_area();
                    let found_cost = f64::from(config.traversal_cost) + f64::from(config.intersection_cost) * part;
                    assert!(found_cost <= cost + error, "{what}: {found_cost} {cost}");
                    assert!(is_rounded || indices(a.iter()) == expected, "{what}");
                    let on_axis = |p: &PrimInfo| p.centroid2_on(found.axis);
                    let last = a.iter().map(on_axis).fold(f32::NEG_INFINITY, f32::max);
                    assert!(b.iter().all(|p| last < on_axis(p)), "{what}");
                    assert_eq!(found.extents, [Extent::of(a), Extent::of(b)], "{what}");
                }
            }
        }
    }

    #[test]
    fn the_ends_of_every_interval_are_in_the_outer_buckets() {
        let ends = [0.0, 1e-45, 1e-38, 1.0, 1.0_f32.next_up(), 3.0, 1e18, -1e-45, -1.0, -7.3, -1e18];
        for low in ends {
            for high in ends.into_iter().filter(|&high| low < high) {
                let at = |x: f32| PrimInfo::new(&Bounds3::new(Vec3::splat(0.0), Vec3::new(x, 0.0, 0.0)), 0);
                for count in [2, 3, 12, 31, 32, 64] {
                    let projection = Projection::new(Axis::X, low, high, count);
                    let ends = [at(low), at(high)];
                    let last = count as i32 - 1;
                    assert_eq!(ends.each_ref().map(|p| projection.bucket(p)), [0, last], "{low} {high} {count}");
                    let grid = all_axes::Grid::new(&Extent::of(&ends), count);
                    let buckets = ends.each_ref().map(|p| grid.buckets::<64>(p.centroid2()));
                    assert_eq!(buckets, [[0, 0, 0], [last as usize, 0, 0]], "{low} {high} {count}");
                }
            }
        }
    }
}
