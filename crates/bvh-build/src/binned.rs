//! The recursion by the surface area heuristic along all axes: each level moves primitives from one array to another,
//! which is faster than moving them within one, and can be done by many threads.
//!
//! Rejected: to divide clusters of up to 16 neighbours along the Morton curve instead of primitives, in nodes of more
//! than 128 (after Hendrich, Meister and Bittner, *Parallel BVH Construction using Progressive Hierarchical
//! Refinement*, 2017). Builds take 0.76 to 0.85 of the time, but rays visit 2 % more nodes on dragon and 18 % more on
//! black-forest, where large triangles lie among small ones; with clusters only of triangles of like size that lie
//! close together 2 and 5 % more, for 0.8 to 0.95 of the time.

mod block;
mod cells;

pub(crate) use cells::LEAST_DIVIDED;

use geometry::Axis;
use geometry::glam::Vec3A;

use crate::parallel::{self, try_join};
use crate::prim_info::{Bounds3A, Extent, PrimInfo};
use crate::recursive::Rules;
use crate::room::Room;
use crate::split::sah::{Limit, Plane, cheapest_plane};
use crate::split::{Split, split};
use crate::subtree::{Block, Part, Step, Subtree};
use crate::{BuildConfig, Cancelled, ProgressReporter, SplitAxes, SplitMethod};

/// Whether trees are grown here.
pub(crate) fn is_for(config: &BuildConfig) -> bool {
    config.split_method == SplitMethod::Sah && config.axes == SplitAxes::All
}

/// The subtree of `prims`, whose extent is `extent`.
pub(crate) fn grow(prims: &mut [PrimInfo], extent: Extent, rules: &Rules) -> Result<Subtree, Cancelled> {
    let mut other = Room::zeroed(prims.len());
    Subtree::grow(Group { prims, other: &mut other, extent, rules }, 1, rules)
}

/// A set of primitives to split.
struct Group<'a> {
    prims: &'a mut [PrimInfo],
    /// Where they are moved to: as much room.
    other: &'a mut [PrimInfo],
    extent: Extent,
    rules: &'a Rules<'a>,
}

/// The plane that the heuristic finds for a node at `depth`; `None` where the set is a leaf, or must be split without
/// one.
fn cheapest(prims: &[PrimInfo], extent: &Extent, rules: &Rules, depth: u32) -> Result<Option<Plane>, Cancelled> {
    let Rules { config, limit, progress, .. } = rules;
    let is_weighed = prims.len() > config.full_sweep as usize
        && !Limit::is_cheap(prims.len(), config)
        && limit.allows_any_split(depth, prims.len())
        && extent.is_spread()
        && extent.bounds.has_area();
    if is_weighed {
        cheapest_plane(prims, extent, config, Limit::of(prims.len(), extent, config), progress)
    } else {
        Ok(None)
    }
}

impl Part for Group<'_> {
    fn prims(&self) -> &[PrimInfo] {
        self.prims
    }

    fn split(mut self, depth: u32) -> Result<Step<Self>, Cancelled> {
        let plane = cheapest(self.prims, &self.extent, self.rules, depth)?;
        let Rules { limit, progress, .. } = self.rules;
        let (axis, middle, extents) = match plane {
            Some(plane) => {
                let sides = self.other.split_at_mut(plane.middle).into();
                let centroids = distribute(self.prims, sides, &plane, progress)?;
                std::mem::swap(&mut self.prims, &mut self.other);
                (plane.axis, plane.middle, plane.extents(centroids))
            }
            None => {
                let is_free = limit.allows_any_split(depth, self.prims.len());
                match split(self.prims, &self.extent, self.rules, is_free)? {
                    Some(Split { axis, middle, extents }) => (axis, middle, extents),
                    None => return Ok(Step::Leaf(self.extent.bounds.to_bounds(), self)),
                }
            }
        };
        let Self { prims, other, rules, .. } = self;
        let (a, b) = prims.split_at_mut(middle);
        let (a_other, b_other) = other.split_at_mut(middle);
        Ok(Step::Interior(
            axis,
            Self { prims: a, other: a_other, extent: extents[0], rules },
            Self { prims: b, other: b_other, extent: extents[1], rules },
        ))
    }

    fn grow_many(mut self: Box<Self>, depth: u32) -> Result<Result<Subtree, Box<Self>>, Cancelled> {
        if self.prims.len() < cells::LEAST || !self.extent.is_spread() {
            return Ok(Err(self));
        }
        Ok(match cells::divide(&mut self, depth)? {
            Some(divided) => Ok(cells::grow(*self, divided)?),
            None => Err(self),
        })
    }

    fn finish(&mut self, depth: u32, block: &mut Block) -> Result<Option<u32>, Cancelled> {
        block::grow(self, depth, block).map(Some)
    }
}

/// Copies `prims` to the side of the plane where each is; the bounds of the doubled centroids on each.
fn distribute(
    prims: &[PrimInfo],
    sides: [&mut [PrimInfo]; 2],
    plane: &Plane,
    progress: &ProgressReporter,
) -> Result<[Bounds3A; 2], Cancelled> {
    /// Above this, a second thread is worth waking.
    const SEQUENTIAL: usize = 1 << 15;
    if prims.len() > SEQUENTIAL && parallel::threads() > 1 {
        let (a, b) = prims.split_at(prims.len() / 2);
        let count_behind = |part: &[PrimInfo]| part.iter().filter(|p| plane.is_behind(p.centroid2())).count();
        let behind = parallel::fold(a, progress, &count_behind, &|a, b| a + b)?;
        let [before, after] = sides;
        let ((a_before, b_before), (a_after, b_after)) =
            (before.split_at_mut(a.len() - behind), after.split_at_mut(behind));
        let (a, b) = try_join(
            || distribute(a, [a_before, a_after], plane, progress),
            || distribute(b, [b_before, b_after], plane, progress),
        )?;
        return Ok([0, 1].map(|side| a[side].union(&b[side])));
    }
    Ok(match plane.axis {
        Axis::X => distribute_along::<0>(prims, sides, plane),
        Axis::Y => distribute_along::<1>(prims, sides, plane),
        Axis::Z => distribute_along::<2>(prims, sides, plane),
    })
}

/// The same by one thread, of a plane on this axis.
fn distribute_along<const AXIS: usize>(
    prims: &[PrimInfo],
    sides: [&mut [PrimInfo]; 2],
    plane: &Plane,
) -> [Bounds3A; 2] {
    // Without a branch: half of all would be mispredicted. And what the next primitive needs is in registers: memory
    // would have to hand on what was just written to it.
    let side_of = plane.sides::<AXIS>();
    let [mut before, mut behind] = [Bounds3A::EMPTY; 2];
    let mut next = 0;
    for (i, p) in prims.iter().enumerate() {
        let centroid2 = p.centroid2();
        let is_behind = side_of.is_behind(centroid2);
        let side = (is_behind.bitmask() & 1) as usize;
        sides[side][if side == 0 { next } else { i - next }] = *p;
        next += 1 - side;
        // What is on the other side is pushed to an infinity, where it does not count.
        let low = Vec3A::select(is_behind, Vec3A::INFINITY, Vec3A::NEG_INFINITY);
        let high = -low;
        before = Bounds3A { min: before.min.min(centroid2.max(low)), max: before.max.max(centroid2.min(high)) };
        behind = Bounds3A { min: behind.min.min(centroid2.max(high)), max: behind.max.max(centroid2.min(low)) };
    }
    [before, behind]
}
