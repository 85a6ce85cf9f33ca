//! The recursion from the root down, where space may be split.

use super::bins::cheapest_plane;
use super::cut::Cut;
use super::{ClippedBounds, SpatialSplits};
use crate::Cancelled;
use crate::prim_info::{Extent, PrimInfo};
use crate::recursive::{Rules, finish};
use crate::split::{Split, split};
use crate::subtree::{Block, Part, Step};

/// What holds for a whole recursion.
pub(crate) struct Setting<'a> {
    rules: &'a Rules<'a>,
    clipped: &'a ClippedBounds<'a>,
    /// The surface area of the children's overlap from which on space is split.
    least_overlap: f64,
    least_references: usize,
}

impl<'a> Setting<'a> {
    /// For a tree that takes up `extent`.
    pub(crate) fn new(
        rules: &'a Rules,
        splits: &SpatialSplits,
        clipped: &'a ClippedBounds<'a>,
        extent: &Extent,
    ) -> Self {
        let least_overlap = f64::from(splits.overlap_threshold) * extent.bounds.surface_area();
        let least_references = splits.least_references as usize;
        Self { rules, clipped, least_overlap, least_references }
    }
}

/// References to split, and the room for more.
pub(crate) struct Group<'a> {
    /// The references are the first `count`.
    room: &'a mut [PrimInfo],
    count: usize,
    extent: Extent,
    setting: &'a Setting<'a>,
}

impl<'a> Group<'a> {
    /// All references: the first `count` of `room`, whose extent is `extent`.
    pub(crate) fn new(room: &'a mut [PrimInfo], count: usize, extent: Extent, setting: &'a Setting<'a>) -> Self {
        Self { room, count, extent, setting }
    }

    fn may_be_cut(&self) -> bool {
        self.room.len() > self.count && self.count >= self.setting.least_references
    }

    /// The best cut by a plane, if it is better than `object`, and there is room for it.
    fn cheaper_cut(&self, object: &Split) -> Result<Option<Cut>, Cancelled> {
        if !self.may_be_cut() {
            return Ok(None);
        }
        let [a, b] = object.extents.map(|extent| extent.bounds);
        if a.intersection(&b).area_or_zero() <= self.setting.least_overlap {
            return Ok(None);
        }
        let prims = &self.room[..self.count];
        let [a_count, b_count] = [object.middle, self.count - object.middle].map(|count| count as f64);
        let Setting { rules: Rules { progress, .. }, clipped, .. } = self.setting;
        let weight = a_count * a.surface_area() + b_count * b.surface_area();
        let bounds = self.extent.bounds.to_bounds();
        let Some(plane) = cheapest_plane(prims, &bounds, clipped, self.room.len(), weight, progress)? else {
            return Ok(None);
        };
        let cut = Cut::new(prims, &plane, clipped, progress)?;
        let counts = cut.counts();
        Ok((!counts.contains(&0) && counts[0] + counts[1] <= self.room.len()).then_some(cut))
    }
}

impl Part for Group<'_> {
    fn prims(&self) -> &[PrimInfo] {
        &self.room[..self.count]
    }

    /// The depth is limited as for sets of primitives, with the room as the size of a part: a split divides the room
    /// too, and where a node must be halved, the room that is left over is given up.
    fn split(self, depth: u32) -> Result<Step<Self>, Cancelled> {
        let rules @ Rules { limit, progress, .. } = self.setting.rules;
        let is_free = limit.allows_any_split(depth, self.room.len());
        let Some(object) = split(&mut self.room[..self.count], &self.extent, rules, is_free)? else {
            return Ok(Step::Leaf(self.extent.bounds.to_bounds(), self));
        };
        let cut = if is_free { self.cheaper_cut(&object)? } else { None };
        let Self { room, count, setting, .. } = self;
        let room = if is_free { room } else { &mut room[..count] };
        let counts = cut.as_ref().map_or([object.middle, count - object.middle], Cut::counts);
        let spare = room.len() - counts[0] - counts[1];
        let second = counts[0] + (spare as u128 * counts[0] as u128 / (counts[0] + counts[1]) as u128) as usize;
        match &cut {
            Some(cut) => cut.place(room, count, second, progress)?,
            None => room.copy_within(object.middle..count, second),
        }
        let (a, b) = room.split_at_mut(second);
        let [a_extent, b_extent] = match &cut {
            Some(_) => [Extent::of_many(&a[..counts[0]], progress)?, Extent::of_many(&b[..counts[1]], progress)?],
            None => object.extents,
        };
        Ok(Step::Interior(
            cut.map_or(object.axis, |cut| cut.axis()),
            Self { room: a, count: counts[0], extent: a_extent, setting },
            Self { room: b, count: counts[1], extent: b_extent, setting },
        ))
    }

    fn finish(&mut self, depth: u32, block: &mut Block) -> Result<Option<u32>, Cancelled> {
        if self.may_be_cut() {
            return Ok(None);
        }
        Ok(finish(self.prims(), self.setting.rules, depth, block))
    }
}
