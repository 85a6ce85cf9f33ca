//! Buckets along all three axes at once.

use geometry::Axis;
use geometry::glam::Vec3A;

use super::{Boundary, Limit};
use crate::parallel;
use crate::prim_info::{Bounds3A, Extent, PrimInfo};
use crate::split::{Split, partition};
use crate::{BuildConfig, Cancelled, ProgressReporter};

/// Splits `prims` between two of the equal buckets over the interval of their centroids on one of the three axes: at
/// that of all boundaries where the cost is least, of equals at the first along the first axis. `None` where that is
/// not below `limit`.
pub(super) fn split(
    prims: &mut [PrimInfo],
    extent: &Extent,
    config: &BuildConfig,
    limit: Limit,
    progress: &ProgressReporter,
) -> Result<Option<Split>, Cancelled> {
    let Some(plane) = cheapest_plane(prims, extent, config, limit, progress)? else { return Ok(None) };
    let mut centroids2 = [Bounds3A::EMPTY; 2];
    let is_first = |p: &PrimInfo| {
        let centroid2 = p.centroid2();
        let is_behind = plane.is_behind(centroid2);
        let side = &mut centroids2[usize::from(is_behind)];
        *side = side.union_point(centroid2);
        !is_behind
    };
    let middle = partition(prims, is_first, progress)?;
    let extents = [0, 1].map(|side| Extent { bounds: plane.bounds[side], centroids2: centroids2[side] });
    Ok(Some(Split { axis: plane.axis, middle, extents }))
}

/// Where primitives are divided.
#[derive(Clone, Copy)]
pub(crate) struct Plane {
    pub(crate) axis: Axis,
    /// How many primitives are before it.
    pub(crate) middle: usize,
    /// The bounds of those before it, and of those behind.
    pub(crate) bounds: [Bounds3A; 2],
    grid: Grid,
    /// The number of the first bucket behind it, and on the other axes infinity.
    first_behind: Vec3A,
}

impl Plane {
    /// Whether the bucket of a primitive with this centroid, doubled, is behind the plane.
    #[inline]
    pub(crate) fn is_behind(&self, centroid2: Vec3A) -> bool {
        self.grid.rounded(centroid2).cmpge(self.first_behind).any()
    }
}

/// As [`split`], without moving anything.
pub(crate) fn cheapest_plane(
    prims: &[PrimInfo],
    extent: &Extent,
    config: &BuildConfig,
    limit: Limit,
    progress: &ProgressReporter,
) -> Result<Option<Plane>, Cancelled> {
    let count = config.buckets_of(prims.len());
    match count {
        ..=8 => cheapest_of::<8>(prims, extent, count, limit, progress),
        9..=16 => cheapest_of::<16>(prims, extent, count, limit, progress),
        17..=32 => cheapest_of::<32>(prims, extent, count, limit, progress),
        _ => cheapest_of::<64>(prims, extent, count, limit, progress),
    }
}

/// The same of `count` buckets, at most `CAPACITY`, which is a power of two.
#[inline(never)] // Its arrays are large, and must not lie on the stack once for every level.
fn cheapest_of<const CAPACITY: usize>(
    prims: &[PrimInfo],
    extent: &Extent,
    count: u32,
    limit: Limit,
    progress: &ProgressReporter,
) -> Result<Option<Plane>, Cancelled> {
    let grid = Grid::new(extent, count);
    let mut buckets = Buckets::<CAPACITY>::EMPTY;
    buckets.add(prims, grid, progress)?;
    let (axis, boundary) = buckets.cheapest_boundary(count as usize);
    Ok(limit.is_above(boundary.weight).then(|| {
        let (counts, bounds) = (&buckets.counts[axis.index()], &buckets.bounds[axis.index()]);
        let (a, b) = bounds.split_at(boundary.place);
        let mut first_behind = Vec3A::INFINITY;
        first_behind[axis.index()] = ROUNDING + boundary.place as f32;
        Plane {
            axis,
            middle: counts[..boundary.place].iter().sum::<u32>() as usize,
            bounds: [a, b].map(|side| side.iter().fold(Bounds3A::EMPTY, |all, b| all.union(b))),
            grid,
            first_behind,
        }
    }))
}

/// Adding 2²³ rounds to the nearest whole number and leaves it in the lowest bits: conversion with all its cases is
/// slow.
const ROUNDING: f32 = 8_388_608.0;

/// Assigns primitives to buckets by their centroids, on each axis.
#[derive(Clone, Copy)]
pub(super) struct Grid {
    low: Vec3A,
    scale: Vec3A,
    last: Vec3A,
}

impl Grid {
    pub(super) fn new(extent: &Extent, count: u32) -> Self {
        let low = extent.centroids2.min;
        let scale = Vec3A::splat(count as f32) / (extent.centroids2.max - low);
        Self { low, scale, last: Vec3A::splat((count - 1) as f32) }
    }

    /// The bucket on each axis, never one that is not there: the half-open parts of the interval [0, count), as whole
    /// numbers are nearest to them when half is taken off. On an axis without an interval, 0 · ∞ is NaN, of which the
    /// maximum with 0 is 0.
    #[inline]
    pub(super) fn buckets<const CAPACITY: usize>(self, centroid2: Vec3A) -> [usize; 3] {
        self.rounded(centroid2).to_array().map(|c| c.to_bits() as usize % CAPACITY)
    }

    /// The same with 2²³ added.
    #[inline]
    fn rounded(self, centroid2: Vec3A) -> Vec3A {
        let place = (centroid2 - self.low) * self.scale - Vec3A::splat(0.5);
        place.max(Vec3A::ZERO).min(self.last) + Vec3A::splat(ROUNDING)
    }
}

/// How many primitives have their centroids in each bucket, and their bounds.
struct Buckets<const CAPACITY: usize> {
    counts: [[u32; CAPACITY]; 3],
    bounds: [[Bounds3A; CAPACITY]; 3],
}

impl<const CAPACITY: usize> Buckets<CAPACITY> {
    const EMPTY: Self = Self { counts: [[0; CAPACITY]; 3], bounds: [[Bounds3A::EMPTY; CAPACITY]; 3] };

    fn add(&mut self, prims: &[PrimInfo], grid: Grid, progress: &ProgressReporter) -> Result<(), Cancelled> {
        if prims.len() > parallel::SEQUENTIAL {
            let (a, b) = prims.split_at(prims.len() / 2);
            progress.check()?;
            let mut other = Self::EMPTY;
            parallel::try_join(|| self.add(a, grid, progress), || other.add(b, grid, progress))?;
            self.unite(&other);
            return Ok(());
        }
        for p in prims {
            let bounds = p.bounds();
            let [x, y, z] = grid.buckets::<CAPACITY>(bounds.min + bounds.max);
            // All is read before anything is written: the processor need not find out that the axes are apart.
            let old = [self.bounds[0][x], self.bounds[1][y], self.bounds[2][z]];
            let [a, b, c] = old.map(|old| old.union(&bounds));
            (self.bounds[0][x], self.bounds[1][y], self.bounds[2][z]) = (a, b, c);
            self.counts[0][x] += 1;
            self.counts[1][y] += 1;
            self.counts[2][z] += 1;
        }
        Ok(())
    }

    fn unite(&mut self, other: &Self) {
        for axis in 0..3 {
            for i in 0..CAPACITY {
                self.counts[axis][i] += other.counts[axis][i];
                self.bounds[axis][i] = self.bounds[axis][i].union(&other.bounds[axis][i]);
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
