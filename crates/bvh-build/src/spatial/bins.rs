//! The best plane for a node.

use geometry::{Axis, Bounds3};

use super::ClippedBounds;
use crate::parallel;
use crate::prim_info::{Bounds3A, PrimInfo};
use crate::{Cancelled, ProgressReporter};

/// Into how many slices of equal thickness a node is cut on each axis.
const SLICES: usize = 16;

/// A plane that divides a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plane {
    pub(super) axis: Axis,
    pub(super) at: f32,
    /// The bounds of what is on each side, and how many references have a part there. As long as parts have not been
    /// asked for, of what is whole on each side.
    pub(super) sides: [(Bounds3A, u32); 2],
    /// Count times area of both sides.
    pub(super) weight: f64,
}

/// The plane of least weight between two slices on any axis, where that is below `limit`; `None` where no such plane
/// has something on both sides, and no more than `most` references altogether.
///
/// What takes the time is to ask for the parts of what a plane cuts. The weight without these is the least that the
/// plane can have, and planes are looked at in the order of that, as long as it is below the weight of the best: 3 of
/// 45 for each node of kitchen, 6 of apartment, 1 in ten nodes of hairball-procedural. With the parts in all slices,
/// asked for in advance, trees of the same cost took 1.5 to 2.3 times as long to build.
#[inline(never)] // Its arrays are large, and must not lie on the stack once for every level.
pub(super) fn cheapest_plane(
    prims: &[PrimInfo],
    bounds: &Bounds3,
    clipped: &ClippedBounds,
    most: usize,
    mut limit: f64,
    progress: &ProgressReporter,
) -> Result<Option<Plane>, Cancelled> {
    let mut planes = Vec::new();
    for axis in Axis::ALL {
        let slicing = Slicing::new(axis, bounds.min[axis.index()], bounds.max[axis.index()]);
        // Else the node is so thin that f32 has too few numbers for so many planes.
        if slicing.planes.is_sorted_by(|a, b| a < b) {
            // Not on the stack, which has them once for every level of the division among threads.
            let contents = |part: &[PrimInfo]| Box::new(Contents::of(part, &slicing));
            planes.extend(parallel::fold(prims, progress, &contents, &Contents::plus)?.planes(&slicing));
        }
    }
    planes.retain(|plane: &Plane| plane.fits(most) && plane.weight < limit);
    planes.sort_by(|a, b| a.weight.total_cmp(&b.weight));
    let mut best = None;
    for plane in &planes {
        if plane.weight >= limit {
            break;
        }
        let plane = plane.with_parts(prims, clipped, progress)?;
        if plane.weight < limit {
            (limit, best) = (plane.weight, Some(plane));
        }
    }
    Ok(best)
}

impl Plane {
    fn new(axis: Axis, at: f32, sides: [(Bounds3A, u32); 2]) -> Self {
        let weight = sides.iter().map(|(bounds, count)| f64::from(*count) * bounds.area_or_zero()).sum();
        Self { axis, at, sides, weight }
    }

    fn fits(&self, most: usize) -> bool {
        let [a, b] = self.sides.map(|(_, count)| count as usize);
        a > 0 && b > 0 && a + b <= most
    }

    /// On which sides a reference has a part; what is flat and in the plane is behind it.
    #[inline]
    pub(super) fn sides_of(&self, p: &PrimInfo) -> [bool; 2] {
        let (axis, bounds) = (self.axis.index(), p.bounds());
        let begins_before = bounds.min[axis] < self.at;
        [begins_before, !begins_before || self.at < bounds.max[axis]]
    }

    /// The bounds of a reference that it cuts, on each side.
    pub(super) fn halves(&self, p: &PrimInfo) -> [Bounds3; 2] {
        let mut halves = [p.bounds().to_bounds(); 2];
        halves[0].max[self.axis.index()] = self.at;
        halves[1].min[self.axis.index()] = self.at;
        halves
    }

    /// The same with the parts of what it cuts.
    fn with_parts(
        &self,
        prims: &[PrimInfo],
        clipped: &ClippedBounds,
        progress: &ProgressReporter,
    ) -> Result<Self, Cancelled> {
        let parts = |part: &[PrimInfo]| {
            let mut parts = [Bounds3A::EMPTY; 2];
            for p in part.iter().filter(|p| self.sides_of(p) == [true, true]) {
                for (part, half) in parts.iter_mut().zip(self.halves(p)) {
                    *part = part.union(&clipped(p.index(), &half).into());
                }
            }
            parts
        };
        let parts = parallel::fold(prims, progress, &parts, &|a, b| [a[0].union(&b[0]), a[1].union(&b[1])])?;
        let [(a, a_count), (b, b_count)] = self.sides;
        Ok(Self::new(self.axis, self.at, [(a.union(&parts[0]), a_count), (b.union(&parts[1]), b_count)]))
    }
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

/// What begins and what ends in each slice: how many references, and the bounds of all of them.
struct Contents {
    begin: [(Bounds3A, u32); SLICES],
    end: [(Bounds3A, u32); SLICES],
}

impl Contents {
    fn of(prims: &[PrimInfo], slicing: &Slicing) -> Self {
        let mut contents = Self { begin: [(Bounds3A::EMPTY, 0); SLICES], end: [(Bounds3A::EMPTY, 0); SLICES] };
        for p in prims {
            let bounds = p.bounds();
            let [first, last] = slicing.range_of(p);
            for (all, count) in [&mut contents.begin[first], &mut contents.end[last]] {
                *all = all.union(&bounds);
                *count += 1;
            }
        }
        contents
    }

    fn plus(mut self: Box<Self>, other: Box<Self>) -> Box<Self> {
        let slices = self.begin.iter_mut().chain(&mut self.end);
        for ((bounds, count), (other_bounds, other_count)) in slices.zip(other.begin.iter().chain(&other.end)) {
            *bounds = bounds.union(other_bounds);
            *count += other_count;
        }
        self
    }

    /// The planes, with the bounds of what they leave whole on either side, and how many references have a part there.
    fn planes(&self, slicing: &Slicing) -> [Plane; SLICES - 1] {
        let mut behind = [(Bounds3A::EMPTY, 0); SLICES + 1];
        for i in (1..SLICES).rev() {
            behind[i] = (behind[i + 1].0.union(&self.begin[i].0), behind[i + 1].1 + self.end[i].1);
        }
        let mut before = (Bounds3A::EMPTY, 0);
        std::array::from_fn(|i| {
            before = (before.0.union(&self.end[i].0), before.1 + self.begin[i].1);
            Plane::new(slicing.axis, slicing.planes[i + 1], [before, behind[i + 1]])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::glam::Vec3;
    use geometry::{clipped_triangle_bounds, triangle_bounds};

    /// Triangles with corners up to `size` from a place anywhere in the unit cube.
    fn triangles(count: u64, size: f32, seed: u64) -> Vec<[Vec3; 3]> {
        let mut state = seed;
        let mut unit = || {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
            (state >> 40) as f32 / (1 << 24) as f32
        };
        let mut vector = |scale: f32| scale * Vec3::new(unit(), unit(), unit());
        (0..count)
            .map(|_| {
                let place = vector(1.0);
                [0; 3].map(|_| place + vector(size))
            })
            .collect()
    }

    /// The search that looks at every primitive for every plane.
    fn naive(prims: &[PrimInfo], bounds: &Bounds3, clipped: &ClippedBounds, most: usize, limit: f64) -> Option<f64> {
        let mut least = None;
        for axis in Axis::ALL {
            let slicing = Slicing::new(axis, bounds.min[axis.index()], bounds.max[axis.index()]);
            let is_thin = slicing.planes.windows(2).any(|planes| planes[0] >= planes[1]);
            for &at in slicing.planes[1..SLICES].iter().filter(|_| !is_thin) {
                let mut sides = [(Bounds3A::EMPTY, 0); 2];
                for p in prims {
                    let b = p.bounds().to_bounds();
                    let [min, max] = [b.min, b.max].map(|corner| corner[axis.index()]);
                    let (is_before, is_behind) = (min < at, at < max || min >= at);
                    for side in [0, 1].into_iter().filter(|&side| [is_before, is_behind][side]) {
                        let mut half = b;
                        if is_before && is_behind {
                            [&mut half.max, &mut half.min][side][axis.index()] = at;
                            half = clipped(p.index(), &half);
                        }
                        let (bounds, count) = &mut sides[side];
                        (*bounds, *count) = (bounds.union(&half.into()), *count + 1);
                    }
                }
                let [a, b] = sides.map(|(_, count)| count as usize);
                let weight = sides.iter().map(|(b, count)| b.area_or_zero() * f64::from(*count)).sum();
                if a > 0 && b > 0 && a + b <= most && weight < least.unwrap_or(limit) {
                    least = Some(weight);
                }
            }
        }
        least
    }

    #[test]
    fn the_plane_is_the_cheapest_of_all() {
        let (mut found, mut refused) = (0, 0);
        for seed in 0..300 {
            let mut triangles = triangles(5 + seed % 90, [0.01, 0.1, 1.0][seed as usize % 3], seed);
            if seed % 2 == 0 {
                // On a lattice: flat ones, and many that end at planes.
                triangles.iter_mut().flatten().for_each(|v| *v = (8.0 * *v).floor() / 16.0);
            }
            let clipped = |i: u32, to: &Bounds3| clipped_triangle_bounds(&triangles[i as usize], to);
            let prims: Vec<_> = (0..).zip(&triangles).map(|(i, t)| PrimInfo::new(&triangle_bounds(t), i)).collect();
            let bounds = prims.iter().fold(Bounds3::EMPTY, |all, p| all.union(&p.bounds().to_bounds()));
            let (most, whole) = (prims.len() * 11 / 10, prims.len() as f64 * bounds.surface_area());
            for limit in [f64::INFINITY, whole, 0.7 * whole, 0.5 * whole] {
                let progress = ProgressReporter::unobserved();
                let plane = cheapest_plane(&prims, &bounds, &clipped, most, limit, &progress).expect("nobody cancels");
                assert_eq!(plane.map(|plane| plane.weight), naive(&prims, &bounds, &clipped, most, limit), "{seed}");
                *if plane.is_some() { &mut found } else { &mut refused } += 1;
            }
        }
        assert!(found > 200 && refused > 100, "{found} {refused}");
    }

    #[test]
    fn contents_of_halves_are_those_of_all() {
        let triangles = triangles(100, 0.3, 1);
        let prims: Vec<_> = (0..).zip(&triangles).map(|(i, t)| PrimInfo::new(&triangle_bounds(t), i)).collect();
        let slicing = Slicing::new(Axis::Y, 0.0, 1.3);
        let of = |prims: &[PrimInfo]| Box::new(Contents::of(prims, &slicing));
        let (a, b) = prims.split_at(37);
        assert_eq!(of(a).plus(of(b)).planes(&slicing), of(&prims).planes(&slicing));
    }
}
