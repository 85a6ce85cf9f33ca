//! The surface area heuristic over all boundaries between a few primitives, on all axes.

use geometry::Axis;

use super::{Boundary, Limit};
use crate::config::MAX_BUCKETS;
use crate::prim_info::{Bounds3A, Extent, PrimInfo};
use crate::split::Split;
use crate::{Cancelled, ProgressReporter};

/// The most primitives that are swept.
pub(crate) const MAX_SWEPT: usize = MAX_BUCKETS;

/// Splits `prims`, at most [`MAX_SWEPT`], at the cheapest boundary between two centroids on any axis.
#[inline(never)] // Its arrays are large, and must not lie on the stack once for every level.
pub(super) fn split(
    prims: &mut [PrimInfo],
    limit: Limit,
    progress: &ProgressReporter,
) -> Result<Option<Split>, Cancelled> {
    let sorted = Sorted::new(prims);
    let Some((axis, middle)) = sorted.cheapest_boundary(prims, 0, prims.len(), limit) else { return Ok(None) };
    sorted.permute(axis, prims);
    Split::at(middle, axis, prims, progress).map(Some)
}

/// A few primitives in the order of their centroids on each axis. Sorted once for a whole subtree: parts of it stay in
/// order when they are separated (as Wald and Havran 2006 do for kd-trees).
pub(crate) struct Sorted {
    /// On each axis, the places of the primitives.
    places: [[u8; MAX_SWEPT]; 3],
}

impl Sorted {
    /// The order of `prims`, at most [`MAX_SWEPT`].
    pub(crate) fn new(prims: &[PrimInfo]) -> Self {
        let mut places = [[0; MAX_SWEPT]; 3];
        let mut keys = [0; MAX_SWEPT];
        let keys = &mut keys[..prims.len()];
        for (axis, places) in Axis::ALL.into_iter().zip(&mut places) {
            for (place, (key, p)) in keys.iter_mut().zip(prims).enumerate() {
                *key = u64::from(ordered_bits(p.centroid2_on(axis))) << 32 | place as u64;
            }
            keys.sort_unstable();
            for (place, key) in places.iter_mut().zip(&*keys) {
                *place = *key as u8;
            }
        }
        Self { places }
    }

    /// Of the boundaries between two different centroids among the `prims` from `begin` to `end` of the orders, the one
    /// of least weight, of equals the first along the first axis: the axis, and the place in its order. `None` where it
    /// is not below `limit`.
    pub(crate) fn cheapest_boundary(
        &self,
        prims: &[PrimInfo],
        begin: usize,
        end: usize,
        limit: Limit,
    ) -> Option<(Axis, usize)> {
        let mut best = (Axis::X, Boundary::NONE);
        for (axis, places) in Axis::ALL.into_iter().zip(&self.places) {
            let at = |i: usize| &prims[places[i] as usize];
            if at(begin).centroid2_on(axis) == at(end - 1).centroid2_on(axis) {
                continue;
            }
            let mut behind = [0.0; MAX_SWEPT];
            let mut side = Bounds3A::EMPTY;
            for i in (begin + 1..end).rev() {
                side = side.union(&at(i).bounds());
                behind[i] = (end - i) as f64 * side.surface_area();
            }
            let mut side = Bounds3A::EMPTY;
            for (place, behind) in behind.iter().enumerate().take(end).skip(begin + 1) {
                let last = at(place - 1);
                side = side.union(&last.bounds());
                let weight = (place - begin) as f64 * side.surface_area() + behind;
                if weight < best.1.weight && last.centroid2_on(axis) < at(place).centroid2_on(axis) {
                    best = (axis, Boundary { place, weight });
                }
            }
        }
        limit.is_above(best.1.weight).then_some((best.0, best.1.place))
    }

    /// The indices of the primitives from `begin` to `end`.
    pub(crate) fn indices(&self, prims: &[PrimInfo], begin: usize, end: usize) -> impl Iterator<Item = u32> {
        self.places[0][begin..end].iter().map(|&place| prims[place as usize].index())
    }

    /// What the primitives from `begin` to `end` take up.
    pub(crate) fn extent(&self, prims: &[PrimInfo], begin: usize, end: usize) -> Extent {
        self.places[0][begin..end].iter().fold(Extent::EMPTY, |extent, &place| extent.with(&prims[place as usize]))
    }

    /// Orders the part from `begin` to `end` on `axis` by centroids, of equal ones by the primitives' indices, so that
    /// its halves do not depend on how the primitives lay.
    pub(crate) fn break_ties(&mut self, axis: Axis, prims: &[PrimInfo], begin: usize, end: usize) {
        self.places[axis.index()][begin..end].sort_unstable_by_key(|&place| {
            let p = &prims[place as usize];
            (ordered_bits(p.centroid2_on(axis)), p.index())
        });
    }

    /// Parts the primitives from `begin` to `end` on every axis as they lie before and behind `middle` on `axis`.
    pub(crate) fn part(&mut self, axis: Axis, begin: usize, middle: usize, end: usize) {
        let mut is_first = [false; MAX_SWEPT];
        for &place in &self.places[axis.index()][begin..middle] {
            is_first[place as usize] = true;
        }
        for other in Axis::ALL.into_iter().filter(|&other| other != axis) {
            let places = &mut self.places[other.index()][begin..end];
            let mut behind = [0; MAX_SWEPT];
            let (mut first, mut second) = (0, 0);
            // Without a branch: half of all would be mispredicted.
            for i in 0..places.len() {
                let place = places[i];
                places[first] = place;
                behind[second] = place;
                let is_first = usize::from(is_first[place as usize]);
                first += is_first;
                second += 1 - is_first;
            }
            places[first..].copy_from_slice(&behind[..second]);
        }
    }

    /// Brings `prims` into the order on `axis`.
    pub(crate) fn permute(&self, axis: Axis, prims: &mut [PrimInfo]) {
        let mut old = [PrimInfo::ZERO; MAX_SWEPT];
        let old = &mut old[..prims.len()];
        old.copy_from_slice(prims);
        for (p, &place) in prims.iter_mut().zip(&self.places[axis.index()]) {
            *p = old[place as usize];
        }
    }
}

/// Bits that compare as the number does. Not for NaN, nor for negative zero, which a centroid never is.
fn ordered_bits(x: f32) -> u32 {
    let bits = x.to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}
