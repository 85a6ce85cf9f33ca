//! Buckets along all three axes at once.

use geometry::Axis;
use geometry::glam::{BVec3A, Mat3A, Vec3A};

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
    Ok(Some(Split { axis: plane.axis, middle, extents: plane.extents(centroids2) }))
}

/// Where primitives are divided.
#[derive(Clone, Copy)]
pub(crate) struct Plane {
    pub(crate) axis: Axis,
    /// How many primitives are before it.
    pub(crate) middle: usize,
    /// The bounds of those before it, and of those behind.
    pub(crate) bounds: [Bounds3A; 2],
    /// The grid on this axis.
    low: f32,
    scale: f32,
    /// The number of the first bucket behind it, with 2²³ added.
    first_behind: f32,
}

impl Plane {
    /// Whether the bucket of a primitive with this centroid, doubled, is behind the plane.
    #[inline]
    pub(crate) fn is_behind(&self, centroid2: Vec3A) -> bool {
        // To bring the bucket into the interval would change nothing.
        (centroid2[self.axis.index()] - self.low) * self.scale - 0.5 + ROUNDING >= self.first_behind
    }

    /// What the sides take up, with these bounds of the centroids, doubled.
    pub(crate) fn extents(&self, centroids2: [Bounds3A; 2]) -> [Extent; 2] {
        [0, 1].map(|side| Extent { bounds: self.bounds[side], centroids2: centroids2[side] })
    }

    /// The same question, where the plane is on this axis.
    pub(crate) fn sides<const AXIS: usize>(&self) -> Sides<AXIS> {
        let [low, scale, first_behind] = [self.low, self.scale, self.first_behind].map(Vec3A::splat);
        Sides { low, scale, first_behind }
    }
}

/// Which side of a plane on one axis primitives are on.
#[derive(Clone, Copy)]
pub(crate) struct Sides<const AXIS: usize> {
    low: Vec3A,
    scale: Vec3A,
    first_behind: Vec3A,
}

impl<const AXIS: usize> Sides<AXIS> {
    /// As [`Plane::is_behind`], in all lanes.
    #[inline(always)]
    pub(crate) fn is_behind(self, centroid2: Vec3A) -> BVec3A {
        let place = (Vec3A::splat(centroid2.to_array()[AXIS]) - self.low) * self.scale - Vec3A::splat(0.5);
        (place + Vec3A::splat(ROUNDING)).cmpge(self.first_behind)
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
    let (axis, boundary) = buckets.cheapest_boundary(count as usize, &extent.bounds);
    Ok(limit.is_above(boundary.weight).then(|| {
        let (a, b) = buckets.bounds[axis.index()][..count as usize].split_at(boundary.place);
        Plane {
            axis,
            middle: buckets.counts[..boundary.place].iter().map(|counts| counts[axis.index()]).sum::<u32>() as usize,
            bounds: [a, b].map(|side| side.iter().fold(Bounds3A::EMPTY, |all, b| all.union(b))),
            low: grid.low[axis.index()],
            scale: grid.scale[axis.index()],
            first_behind: ROUNDING + boundary.place as f32,
        }
    }))
}

/// The power of two that brings the largest component into [1, 2), or as far towards it as one power can.
fn unit_scale(extent: Vec3A) -> f32 {
    let exponent = extent.max_element().to_bits() >> 23;
    f32::from_bits((254 - exponent.clamp(1, 253)) << 23)
}

/// Adding 2²³ rounds to the nearest whole number and leaves it in the lowest bits: conversion with all its cases is
/// slow.
const ROUNDING: f32 = 8_388_608.0;

/// Assigns primitives to buckets by their centroids, on each axis.
#[derive(Clone, Copy)]
pub(crate) struct Grid {
    low: Vec3A,
    scale: Vec3A,
    last: Vec3A,
}

impl Grid {
    pub(crate) fn new(extent: &Extent, count: u32) -> Self {
        let Bounds3A { min, max } = extent.centroids2;
        let size = max - min;
        // A product below the normal numbers, or of one, takes some processors a hundred times as long, and those of
        // places near the lowest may be such. So they are counted from a little below it: the least that is normal,
        // or 2⁻¹²⁰ of the size, which moves no others unless the size is below 2⁻⁹⁰.
        let below = size.max(Vec3A::splat(2_f32.powi(-6))) * 2_f32.powi(-120);
        let below = Vec3A::select(size.cmpgt(Vec3A::splat(2_f32.powi(-100))), below, Vec3A::ZERO);
        let scale = Vec3A::splat(count as f32) / size;
        Self { low: min - below, scale, last: Vec3A::splat((count - 1) as f32) }
    }

    /// The bucket on each axis, never one that is not there: the half-open parts of the interval [0, count), as whole
    /// numbers are nearest to them when half is taken off. On an axis without an interval, 0 · ∞ is NaN, of which the
    /// maximum with 0 is 0.
    #[inline]
    pub(crate) fn buckets<const CAPACITY: usize>(self, centroid2: Vec3A) -> [usize; 3] {
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
pub(crate) struct Buckets<const CAPACITY: usize> {
    /// Of the buckets with one number those on each axis.
    counts: [[u32; 4]; CAPACITY],
    bounds: [[Bounds3A; CAPACITY]; 3],
}

impl<const CAPACITY: usize> Buckets<CAPACITY> {
    pub(crate) const EMPTY: Self = Self { counts: [[0; 4]; CAPACITY], bounds: [[Bounds3A::EMPTY; CAPACITY]; 3] };

    fn add(&mut self, prims: &[PrimInfo], grid: Grid, progress: &ProgressReporter) -> Result<(), Cancelled> {
        let (a, b) = prims.split_at(prims.len() / 2);
        if prims.len() > parallel::SEQUENTIAL {
            progress.check()?;
            let mut other = Self::EMPTY;
            parallel::try_join(|| self.add(a, grid, progress), || other.add(b, grid, progress))?;
            self.unite(&other);
            return Ok(());
        }
        // Rejected: the halves in turns, or each in buckets of its own, so that no primitive waits for its neighbour in
        // the same bucket. Neither is faster; nor is AVX2 (x86-64-v3) by more than 0.04 of the build.
        prims.iter().for_each(|p| self.add_one(p, grid));
        Ok(())
    }

    #[inline(always)]
    fn add_one(&mut self, p: &PrimInfo, grid: Grid) {
        let bounds = p.bounds();
        let [x, y, z] = grid.buckets::<CAPACITY>(bounds.min + bounds.max);
        // All is read before anything is written: the processor need not find out that the axes are apart.
        let old = [self.bounds[0][x], self.bounds[1][y], self.bounds[2][z]];
        let [a, b, c] = old.map(|old| old.union(&bounds));
        (self.bounds[0][x], self.bounds[1][y], self.bounds[2][z]) = (a, b, c);
        self.counts[x][0] += 1;
        self.counts[y][1] += 1;
        self.counts[z][2] += 1;
    }

    /// Adds `count` primitives that are in the same bucket on each axis.
    pub(crate) fn add_many(&mut self, at: [usize; 3], count: u32, bounds: &Bounds3A) {
        for (axis, i) in at.into_iter().enumerate() {
            self.counts[i][axis] += count;
            self.bounds[axis][i] = self.bounds[axis][i].union(bounds);
        }
    }

    fn unite(&mut self, other: &Self) {
        for (counts, other) in self.counts.iter_mut().zip(&other.counts) {
            for (count, other) in counts.iter_mut().zip(other) {
                *count += other;
            }
        }
        for axis in 0..3 {
            for i in 0..CAPACITY {
                self.bounds[axis][i] = self.bounds[axis][i].union(&other.bounds[axis][i]);
            }
        }
    }

    /// The boundary of least weight between the first `count` buckets of any axis; [`Boundary::place`] counts buckets.
    ///
    /// All axes at once, one in each lane, and in f32: bounds are multiplied by a power of two that brings those of
    /// `all` to about 1, so that no product overflows. Where one side has no primitives its area is infinite, and the
    /// weight NaN, which is less than nothing.
    pub(crate) fn cheapest_boundary(&self, count: usize, all: &Bounds3A) -> (Axis, Boundary) {
        let scale = unit_scale(all.diagonal());
        // The weight of all from each bucket on in one sweep back, and of all before it in another one forth.
        let mut behind = [Vec3A::ZERO; CAPACITY];
        let mut sides = Halves::EMPTY;
        for i in (1..count).rev() {
            sides.add(self, i);
            behind[i] = sides.weights(scale);
        }
        let mut least = Vec3A::INFINITY;
        let mut place = Vec3A::ZERO;
        let mut sides = Halves::EMPTY;
        for (i, behind) in behind.iter().enumerate().take(count).skip(1) {
            sides.add(self, i - 1);
            let weights = sides.weights(scale) + *behind;
            let is_less = weights.cmplt(least);
            least = Vec3A::select(is_less, weights, least);
            place = Vec3A::select(is_less, Vec3A::splat(i as f32), place);
        }
        let axis = Axis::ALL
            .into_iter()
            .fold(Axis::X, |best, axis| if least[axis.index()] < least[best.index()] { axis } else { best });
        let weight = 2.0 * f64::from(least[axis.index()]) / f64::from(scale).powi(2);
        (axis, Boundary { place: place[axis.index()] as usize, weight })
    }
}

/// What lies on one side of a boundary on each axis.
struct Halves {
    counts: Vec3A,
    bounds: [Bounds3A; 3],
}

impl Halves {
    const EMPTY: Self = Self { counts: Vec3A::ZERO, bounds: [Bounds3A::EMPTY; 3] };

    #[inline(always)]
    fn add<const CAPACITY: usize>(&mut self, buckets: &Buckets<CAPACITY>, i: usize) {
        let [x, y, z, _] = buckets.counts[i].map(|count| count as i32 as f32);
        self.counts += Vec3A::new(x, y, z);
        for (side, bounds) in self.bounds.iter_mut().zip(&buckets.bounds) {
            *side = side.union(&bounds[i]);
        }
    }

    /// Count times half of the area.
    #[inline(always)]
    fn weights(&self, scale: f32) -> Vec3A {
        let [x, y, z] = [0, 1, 2].map(|axis| self.bounds[axis].diagonal() * scale);
        let Mat3A { x_axis: x, y_axis: y, z_axis: z } = Mat3A::from_cols(x, y, z).transpose();
        self.counts * (x * y + y * z + z * x)
    }
}
