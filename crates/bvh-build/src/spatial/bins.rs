//! The best plane for a node.

use geometry::{Axis, Bounds3};

use super::ClippedBounds;
use crate::parallel::{SEQUENTIAL, try_join};
use crate::prim_info::{Bounds3A, PrimInfo};
use crate::{Cancelled, ProgressReporter};

/// Into how many slices of equal thickness a node is cut on each axis.
const SLICES: usize = 16;

/// A plane that divides a node, and what is on either side by the slices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plane {
    pub(super) axis: Axis,
    pub(super) at: f32,
    /// The bounds of the parts on each side, and how many references have one there.
    pub(super) sides: [(Bounds3A, u32); 2],
    /// Count times area of both sides.
    pub(super) weight: f64,
}

/// The plane of least weight between two slices on any axis, of equals the first along the first axis; `None` where no plane
/// has something on both sides.
#[inline(never)] // Its arrays are large, and must not lie on the stack once for every level.
pub(super) fn cheapest_plane(
    prims: &[PrimInfo],
    bounds: &Bounds3,
    clipped: &ClippedBounds,
    progress: &ProgressReporter,
) -> Result<Option<Plane>, Cancelled> {
    let mut best: Option<Plane> = None;
    for axis in Axis::ALL {
        let (low, high) = (bounds.min[axis.index()], bounds.max[axis.index()]);
        let slicing = Slicing::new(axis, low, high);
        // Else the node is so thin that f32 has too few numbers for so many planes.
        if slicing.planes.is_sorted_by(|a, b| a < b) {
            let slices = Slices::of(prims, &slicing, clipped, progress)?;
            let plane = slices.cheapest_plane(&slicing);
            best = match (best, plane) {
                (Some(best), Some(plane)) if best.weight <= plane.weight => Some(best),
                (best, plane) => plane.or(best),
            };
        }
    }
    Ok(best)
}

/// Slices along an axis: the i-th one is from plane i to plane i + 1.
struct Slicing {
    axis: Axis,
    planes: [f32; SLICES + 1],
    scale: f32,
}

impl Slicing {
    fn new(axis: Axis, low: f32, high: f32) -> Self {
        let mut planes = [high; SLICES + 1];
        for (i, plane) in planes[..SLICES].iter_mut().enumerate() {
            *plane = low + (high - low) * (i as f32 / SLICES as f32);
        }
        Self { axis, planes, scale: SLICES as f32 / (high - low) }
    }

    /// The slices in which bounds from `min` to `max` are, more than in their faces.
    fn range(&self, min: f32, max: f32) -> [usize; 2] {
        // An estimate, which rounding may have put into a neighbour.
        let estimate = |x: f32| (((x - self.planes[0]) * self.scale) as usize).min(SLICES - 1);
        let (mut first, mut last) = (estimate(min), estimate(max));
        while first > 0 && min < self.planes[first] {
            first -= 1;
        }
        while first + 1 < SLICES && min >= self.planes[first + 1] {
            first += 1;
        }
        while last + 1 < SLICES && max > self.planes[last + 1] {
            last += 1;
        }
        while last > first && max <= self.planes[last] {
            last -= 1;
        }
        [first, last.max(first)]
    }
}

/// What is in each slice: the bounds of the parts, and how many references begin and end there.
struct Slices {
    bounds: [Bounds3A; SLICES],
    begin: [u32; SLICES],
    end: [u32; SLICES],
}

impl Slices {
    fn of(
        prims: &[PrimInfo],
        slicing: &Slicing,
        clipped: &ClippedBounds,
        progress: &ProgressReporter,
    ) -> Result<Self, Cancelled> {
        if prims.len() > SEQUENTIAL {
            progress.check()?;
            let (a, b) = prims.split_at(prims.len() / 2);
            let (mut a, b) =
                try_join(|| Self::of(a, slicing, clipped, progress), || Self::of(b, slicing, clipped, progress))?;
            for i in 0..SLICES {
                a.bounds[i] = a.bounds[i].union(&b.bounds[i]);
                a.begin[i] += b.begin[i];
                a.end[i] += b.end[i];
            }
            return Ok(a);
        }
        let mut slices = Self { bounds: [Bounds3A::EMPTY; SLICES], begin: [0; SLICES], end: [0; SLICES] };
        let axis = slicing.axis.index();
        for p in prims {
            let bounds = p.bounds();
            let [first, last] = slicing.range(bounds.min[axis], bounds.max[axis]);
            slices.begin[first] += 1;
            slices.end[last] += 1;
            if first == last {
                slices.bounds[first] = slices.bounds[first].union(&bounds);
                continue;
            }
            let bounds = bounds.to_bounds();
            for i in first..=last {
                let mut part = bounds;
                part.min[axis] = part.min[axis].max(slicing.planes[i]);
                part.max[axis] = part.max[axis].min(slicing.planes[i + 1]);
                slices.bounds[i] = slices.bounds[i].union(&clipped(p.index(), &part).into());
            }
        }
        Ok(slices)
    }

    fn cheapest_plane(&self, slicing: &Slicing) -> Option<Plane> {
        let mut best: Option<Plane> = None;
        let mut behind = [(Bounds3A::EMPTY, 0); SLICES + 1];
        for i in (1..SLICES).rev() {
            behind[i] = (behind[i + 1].0.union(&self.bounds[i]), behind[i + 1].1 + self.end[i]);
        }
        let mut before = (Bounds3A::EMPTY, 0);
        for (i, &behind) in behind.iter().enumerate().take(SLICES).skip(1) {
            before = (before.0.union(&self.bounds[i - 1]), before.1 + self.begin[i - 1]);
            let sides = [before, behind];
            let weight = sides.iter().map(|(bounds, count)| f64::from(*count) * bounds.area_or_zero()).sum();
            if sides.iter().all(|(_, count)| *count > 0) && best.is_none_or(|best| weight < best.weight) {
                best = Some(Plane { axis: slicing.axis, at: slicing.planes[i], sides, weight });
            }
        }
        best
    }
}
