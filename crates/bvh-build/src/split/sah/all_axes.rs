//! Buckets along all three axes at once.

use geometry::Axis;
use geometry::glam::Vec3A;

use super::{Boundary, Limit};
use crate::BuildConfig;
use crate::parallel::join;
use crate::prim_info::{Bounds3A, Extent, PrimInfo};
use crate::split::{Split, partition};

/// Splits `prims` between two of the equal buckets over the interval of their centroids on one of the three axes: at
/// that of all boundaries where the cost is least, of equals at the first along the first axis. `None` where that is
/// not below `limit`. `CAPACITY` is a power of two, and no less than the number of buckets.
#[inline(never)] // Its arrays are large, and must not lie on the stack once for every level.
pub(super) fn split<const CAPACITY: usize>(
    prims: &mut [PrimInfo],
    extent: &Extent,
    config: &BuildConfig,
    limit: Limit,
) -> Option<Split> {
    let grid = Grid::<CAPACITY>::new(extent, config.buckets);
    let buckets = Buckets::of(prims, grid);
    let (axis, best) = buckets.cheapest_boundary(config.buckets as usize);
    limit.is_above(best.weight).then(|| {
        let middle = partition(prims, |p| grid.buckets(p)[axis.index()] < best.place);
        Split::at(middle, axis, prims)
    })
}

/// Assigns primitives to buckets by their centroids, on each axis.
#[derive(Clone, Copy)]
pub(super) struct Grid<const CAPACITY: usize> {
    low: Vec3A,
    scale: Vec3A,
    last: Vec3A,
}

impl<const CAPACITY: usize> Grid<CAPACITY> {
    pub(super) fn new(extent: &Extent, count: u32) -> Self {
        let low = extent.centroids2.min;
        let scale = Vec3A::splat(count as f32) / (extent.centroids2.max - low);
        Self { low, scale, last: Vec3A::splat((count - 1) as f32) }
    }

    /// The bucket on each axis, never one that is not there: the half-open parts of the interval [0, count), as whole
    /// numbers are nearest to them when half is taken off. On an axis without an interval, 0 · ∞ is NaN, of which the
    /// maximum with 0 is 0. Adding 2²³ rounds to the nearest whole number and leaves it in the lowest bits, since
    /// conversion with all its cases is slow.
    #[inline]
    pub(super) fn buckets(self, p: &PrimInfo) -> [usize; 3] {
        let b = p.bounds();
        let place = (b.min + b.max - self.low) * self.scale - Vec3A::splat(0.5);
        let rounded = place.max(Vec3A::ZERO).min(self.last) + Vec3A::splat(8_388_608.0);
        rounded.to_array().map(|c| c.to_bits() as usize % CAPACITY)
    }
}

/// How many primitives have their centroids in each bucket, and their bounds.
struct Buckets<const CAPACITY: usize> {
    counts: [[u32; CAPACITY]; 3],
    bounds: [[Bounds3A; CAPACITY]; 3],
}

impl<const CAPACITY: usize> Buckets<CAPACITY> {
    fn of(prims: &[PrimInfo], grid: Grid<CAPACITY>) -> Self {
        let mut buckets = Self { counts: [[0; CAPACITY]; 3], bounds: [[Bounds3A::EMPTY; CAPACITY]; 3] };
        buckets.add(prims, grid);
        buckets
    }

    fn add(&mut self, prims: &[PrimInfo], grid: Grid<CAPACITY>) {
        /// Above this, a second thread is worth waking.
        const SEQUENTIAL: usize = 1 << 16;
        if prims.len() > SEQUENTIAL {
            let (a, b) = prims.split_at(prims.len() / 2);
            let ((), b) = join(|| self.add(a, grid), || Self::of(b, grid));
            for axis in 0..3 {
                for i in 0..CAPACITY {
                    self.counts[axis][i] += b.counts[axis][i];
                    self.bounds[axis][i] = self.bounds[axis][i].union(&b.bounds[axis][i]);
                }
            }
            return;
        }
        for p in prims {
            let bounds = p.bounds();
            for (axis, bucket) in grid.buckets(p).into_iter().enumerate() {
                self.counts[axis][bucket] += 1;
                self.bounds[axis][bucket] = self.bounds[axis][bucket].union(&bounds);
            }
        }
    }

    /// The boundary of least weight between the first `count` buckets of any axis; [`Boundary::place`] counts buckets.
    fn cheapest_boundary(&self, count: usize) -> (Axis, Boundary) {
        let mut best = (Axis::X, Boundary::NONE);
        for ((axis, counts), bounds) in Axis::ALL.into_iter().zip(&self.counts).zip(&self.bounds) {
            // The weight of all from each bucket on in one sweep back, and of all before it in another one forth.
            let mut behind = [0.0; CAPACITY];
            let (mut n, mut side) = (0, Bounds3A::EMPTY);
            for i in (1..count).rev() {
                n += counts[i];
                side = side.union(&bounds[i]);
                behind[i] = if n == 0 { f64::INFINITY } else { f64::from(n) * side.surface_area() };
            }
            let (mut n, mut side) = (0, Bounds3A::EMPTY);
            for place in 1..count {
                n += counts[place - 1];
                side = side.union(&bounds[place - 1]);
                let weight = f64::from(n) * side.surface_area() + behind[place];
                if n > 0 && weight < best.1.weight {
                    best = (axis, Boundary { place, weight });
                }
            }
        }
        best
    }
}
