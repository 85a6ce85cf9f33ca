//! The best plane for a node.

use geometry::{Axis, Bounds3};

use super::ClippedBounds;
use crate::parallel::{self, SEQUENTIAL, try_join};
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

/// The plane of least weight between two slices on any axis, of equals the first along the first axis; `None` where no
/// plane has something on both sides, or no more than `most` references altogether. Where that is so on an axis, no
/// part is asked for: of identical primitives, each in all slices, that took most of a build's time.
#[inline(never)] // Its arrays are large, and must not lie on the stack once for every level.
pub(super) fn cheapest_plane(
    prims: &[PrimInfo],
    bounds: &Bounds3,
    clipped: &ClippedBounds,
    most: usize,
    progress: &ProgressReporter,
) -> Result<Option<Plane>, Cancelled> {
    let mut best: Option<Plane> = None;
    for axis in Axis::ALL {
        let (low, high) = (bounds.min[axis.index()], bounds.max[axis.index()]);
        let slicing = Slicing::new(axis, low, high);
        // Else the node is so thin that f32 has too few numbers for so many planes.
        if !slicing.planes.is_sorted_by(|a, b| a < b) {
            continue;
        }
        let count = |part: &[PrimInfo]| Counts::of(part, &slicing);
        let sides = parallel::fold(prims, progress, &count, &Counts::plus)?.sides();
        let fits = sides.map(|[a, b]| a > 0 && b > 0 && a as usize + b as usize <= most);
        if fits.contains(&true) {
            let parts = slices(prims, &slicing, clipped, progress)?;
            let plane = cheapest_of(&parts, &sides, &fits, &slicing);
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

    /// The slices in which a primitive is.
    fn range_of(&self, p: &PrimInfo) -> [usize; 2] {
        let bounds = p.bounds();
        self.range(bounds.min[self.axis.index()], bounds.max[self.axis.index()])
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

/// How many references begin and end in each slice.
struct Counts {
    begin: [u32; SLICES],
    end: [u32; SLICES],
}

impl Counts {
    fn of(prims: &[PrimInfo], slicing: &Slicing) -> Self {
        let mut counts = Self { begin: [0; SLICES], end: [0; SLICES] };
        for p in prims {
            let [first, last] = slicing.range_of(p);
            counts.begin[first] += 1;
            counts.end[last] += 1;
        }
        counts
    }

    fn plus(mut self, other: Self) -> Self {
        for i in 0..SLICES {
            self.begin[i] += other.begin[i];
            self.end[i] += other.end[i];
        }
        self
    }

    /// For each plane, how many references have a part before it and behind it; before the first there is nothing.
    fn sides(&self) -> [[u32; 2]; SLICES] {
        let mut sides = [[0; 2]; SLICES];
        let mut behind: u32 = self.end.iter().sum();
        let mut before = 0;
        for (side, (begin, end)) in sides[1..].iter_mut().zip(self.begin.iter().zip(&self.end)) {
            before += begin;
            behind -= end;
            *side = [before, behind];
        }
        sides
    }
}

/// The bounds of the parts in each slice.
fn slices(
    prims: &[PrimInfo],
    slicing: &Slicing,
    clipped: &ClippedBounds,
    progress: &ProgressReporter,
) -> Result<[Bounds3A; SLICES], Cancelled> {
    if prims.len() > SEQUENTIAL {
        progress.check()?;
        let (a, b) = prims.split_at(prims.len() / 2);
        let (a, b) = try_join(|| slices(a, slicing, clipped, progress), || slices(b, slicing, clipped, progress))?;
        return Ok(std::array::from_fn(|i| a[i].union(&b[i])));
    }
    let mut slices = [Bounds3A::EMPTY; SLICES];
    let axis = slicing.axis.index();
    for p in prims {
        let [first, last] = slicing.range_of(p);
        if first == last {
            slices[first] = slices[first].union(&p.bounds());
            continue;
        }
        let bounds = p.bounds().to_bounds();
        for (slice, planes) in slices.iter_mut().zip(slicing.planes.windows(2)).take(last + 1).skip(first) {
            let mut part = bounds;
            part.min[axis] = part.min[axis].max(planes[0]);
            part.max[axis] = part.max[axis].min(planes[1]);
            *slice = slice.union(&clipped(p.index(), &part).into());
        }
    }
    Ok(slices)
}

/// The plane of least weight among those that fit.
fn cheapest_of(
    slices: &[Bounds3A; SLICES],
    counts: &[[u32; 2]; SLICES],
    fits: &[bool; SLICES],
    slicing: &Slicing,
) -> Option<Plane> {
    let mut best: Option<Plane> = None;
    let mut behind = [Bounds3A::EMPTY; SLICES + 1];
    for i in (1..SLICES).rev() {
        behind[i] = behind[i + 1].union(&slices[i]);
    }
    let mut before = Bounds3A::EMPTY;
    for i in 1..SLICES {
        before = before.union(&slices[i - 1]);
        let sides = [(before, counts[i][0]), (behind[i], counts[i][1])];
        let weight = sides.iter().map(|(bounds, count)| f64::from(*count) * bounds.area_or_zero()).sum();
        if fits[i] && best.is_none_or(|best| weight < best.weight) {
            best = Some(Plane { axis: slicing.axis, at: slicing.planes[i], sides, weight });
        }
    }
    best
}
