//! Buckets: primitives in a few heaps along one axis.

use super::{Boundary, Projection};
use crate::parallel::{SEQUENTIAL, try_join};
use crate::prim_info::{Extent, PrimInfo};
use crate::{Cancelled, ProgressReporter};

/// The primitives with their centroids in one bucket.
#[derive(Clone, Copy)]
struct Bucket {
    count: usize,
    extent: Extent,
}

impl Bucket {
    const EMPTY: Self = Self { count: 0, extent: Extent::EMPTY };

    fn union(&self, other: &Self) -> Self {
        Self { count: self.count + other.count, extent: self.extent.union(&other.extent) }
    }

    /// Count times area; 0 where it has no primitives.
    fn weight(&self) -> f64 {
        if self.count == 0 { 0.0 } else { self.count as f64 * self.extent.bounds.surface_area() }
    }
}

/// As many as the projection has, at most `CAPACITY`; those behind stay empty.
pub(super) struct Buckets<const CAPACITY: usize>([Bucket; CAPACITY]);

impl<const CAPACITY: usize> Buckets<CAPACITY> {
    pub(super) const EMPTY: Self = Self([Bucket::EMPTY; CAPACITY]);

    /// Adds `prims` to them.
    pub(super) fn add(
        &mut self,
        prims: &[PrimInfo],
        projection: Projection,
        progress: &ProgressReporter,
    ) -> Result<(), Cancelled> {
        if prims.len() > SEQUENTIAL {
            progress.check()?;
            let (a, b) = prims.split_at(prims.len() / 2);
            let mut other = Self::EMPTY;
            try_join(|| self.add(a, projection, progress), || other.add(b, projection, progress))?;
            for (bucket, other) in self.0.iter_mut().zip(&other.0) {
                *bucket = bucket.union(other);
            }
            return Ok(());
        }
        for p in prims {
            let bucket = &mut self.0[projection.bucket(p) as usize];
            bucket.count += 1;
            bucket.extent = bucket.extent.with(p);
        }
        Ok(())
    }

    /// The boundary of least weight, of equals the first; [`Boundary::place`] counts buckets.
    pub(super) fn cheapest_boundary(&self) -> Boundary {
        // The weight of all from each bucket on in one sweep back, and of all before it in another one forth.
        let mut behind = [0.0; CAPACITY];
        let mut side = Bucket::EMPTY;
        for (behind, bucket) in behind.iter_mut().zip(&self.0).rev() {
            side = side.union(bucket);
            *behind = side.weight();
        }
        let all = side.count;
        let mut best = Boundary::NONE;
        let mut side = Bucket::EMPTY;
        for (place, (bucket, behind)) in (1..).zip(self.0.iter().zip(&behind[1..])) {
            side = side.union(bucket);
            let weight = side.weight() + behind;
            if weight < best.weight && 0 < side.count && side.count < all {
                best = Boundary { place, weight };
            }
        }
        best
    }

    /// What the primitives before and behind a boundary take up.
    pub(super) fn extents(&self, place: usize) -> [Extent; 2] {
        let (a, b) = self.0.split_at(place);
        [a, b].map(|side| side.iter().fold(Extent::EMPTY, |extent, bucket| extent.union(&bucket.extent)))
    }
}
