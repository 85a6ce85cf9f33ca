//! Cutting a node's references by a plane.

use geometry::Axis;

use super::ClippedBounds;
use super::bins::Plane;
use crate::prim_info::PrimInfo;
use crate::split::partition;
use crate::{Cancelled, ProgressReporter};

/// What becomes of a node's references.
pub(super) struct Cut {
    plane: Plane,
    /// How many lie on each side as they are.
    whole: [usize; 2],
    /// What becomes of those that the plane cuts, on each side.
    parts: [Vec<PrimInfo>; 2],
}

impl Cut {
    /// How `plane` cuts `prims`.
    ///
    /// A reference that lies on both sides is nevertheless kept whole where it costs less to enlarge one side by it
    /// than to count it on both: Stich's reference unsplitting, section 4.4.
    pub(super) fn new(
        prims: &[PrimInfo],
        plane: &Plane,
        clipped: &ClippedBounds,
        progress: &ProgressReporter,
    ) -> Result<Self, Cancelled> {
        let mut cut = Self { plane: *plane, whole: [0, 0], parts: [Vec::new(), Vec::new()] };
        for (i, p) in prims.iter().enumerate() {
            progress.check_step(i)?;
            let [is_before, is_behind] = plane.sides_of(p);
            if !(is_before && is_behind) {
                cut.whole[usize::from(is_behind)] += 1;
            } else if let Some(side) = side_of_whole(p, plane) {
                cut.parts[side].push(*p);
            } else {
                let halves = plane.halves(p).map(|half| clipped(p.index(), &half));
                let halves =
                    [0, 1].map(|side| halves[side].is_valid().then(|| PrimInfo::new(&halves[side], p.index())));
                if halves.iter().all(Option::is_none) {
                    cut.parts[0].push(*p);
                }
                for (half, parts) in halves.into_iter().zip(&mut cut.parts) {
                    parts.extend(half);
                }
            }
        }
        Ok(cut)
    }

    pub(super) fn axis(&self) -> Axis {
        self.plane.axis
    }

    /// How many references each side has.
    pub(super) fn counts(&self) -> [usize; 2] {
        [0, 1].map(|side| self.whole[side] + self.parts[side].len())
    }

    /// Puts the references of the sides into `room`, whose first `count` are those that are cut: the first side at its
    /// beginning, the second one at `second`.
    pub(super) fn place(
        &self,
        room: &mut [PrimInfo],
        count: usize,
        second: usize,
        progress: &ProgressReporter,
    ) -> Result<(), Cancelled> {
        let before = partition(&mut room[..count], |p| self.plane.sides_of(p) == [true, false], progress)?;
        let through = partition(&mut room[before..count], |p| self.plane.sides_of(p)[0], progress)?;
        let [a, b] = &self.parts;
        room.copy_within(before + through..count, second + b.len());
        room[second..second + b.len()].copy_from_slice(b);
        room[before..before + a.len()].copy_from_slice(a);
        Ok(())
    }
}

/// The side on which a reference is kept whole, where that costs less than to have a part of it on both.
fn side_of_whole(p: &PrimInfo, plane: &Plane) -> Option<usize> {
    let bounds = p.bounds();
    let costs = [0, 1].map(|side| {
        let ((own, count), (other, other_count)) = (plane.sides[side], plane.sides[1 - side]);
        let grown = own.union(&bounds).surface_area() * f64::from(count);
        grown + other.area_or_zero() * (f64::from(other_count) - 1.0)
    });
    let side = usize::from(costs[1] < costs[0]);
    (costs[side] < plane.weight).then_some(side)
}
