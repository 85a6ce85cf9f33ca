//! Whether there is any hit.

use std::cmp::Ordering;
use std::ops::ControlFlow;

use geometry::TraversalRay;
use geometry::exact::ExactRay;

use super::{Answered, Asked, Found, Progress};
use crate::RaySegment;
use crate::simd::{Lanes, LanesOf};
use crate::wide::Child;
use crate::wide::packet::Group;
use crate::wide::traverse::Query;
use crate::wide::triangle_ray::Candidates;
use crate::wide::triangles::{Layout, Scratch};

/// Whether there is any hit.
pub(crate) struct AnyQuery<'a, Y> {
    asked: Asked<'a, Y>,
    /// Some hit.
    found: Option<Found>,
}

impl<'a, Y: Layout> Answered<'a> for AnyQuery<'a, Y> {
    type Layout = Y;
    type Answer = bool;

    #[inline(always)]
    fn new(asked: Asked<'a, Y>) -> Self {
        Self { asked, found: None }
    }

    #[inline(always)]
    fn resumed(asked: Asked<'a, Y>, Progress { found, .. }: Progress) -> Self {
        Self { asked, found }
    }

    #[inline(always)]
    fn undecided(&mut self, ray: &TraversalRay, leaf: Child, lane: usize, bounds: Option<[f32; 2]>) {
        let is_hit = match self.asked.cmp_to_start(ray, leaf, lane) {
            Some(Ordering::Less) => false,
            Some(Ordering::Greater) if bounds.is_some() => true,
            _ => self.decide(ray, leaf, lane),
        };
        if is_hit {
            self.found = Some(Found { leaf, lane, low: 0.0 });
        }
    }

    #[inline(always)]
    fn progress(&self) -> Progress {
        Progress { found: self.found, t_max: self.asked.interval.t_max() }
    }

    #[inline(always)]
    fn answers_of<L: Lanes>(group: &Group<L>, _: &[RaySegment], answers: &mut [bool]) {
        for lane in LanesOf(group.lanes) {
            if let Some(to) = answers.get_mut(usize::from(group.index[lane])) {
                *to = group.hits() >> lane & 1 == 1;
            }
        }
    }

    #[inline(always)]
    fn answer(&self, _: &TraversalRay) -> bool {
        self.found.is_some()
    }
}

impl<Y: Layout> Query for AnyQuery<'_, Y> {
    const ORDERED: bool = false;

    #[inline(always)]
    fn leaf<L: Lanes>(&mut self, ray: &TraversalRay, leaf: Child) -> ControlFlow<(), f32> {
        let t_max = self.asked.interval.t_max();
        if let Some(Candidates { maybe, sure, low, high }) = self.asked.candidates::<L>(leaf, t_max) {
            for lane in LanesOf(maybe) {
                let (low, high) = (low[lane], high[lane]);
                let is_sure = sure >> lane & 1 == 1 && self.asked.is_before_end(high);
                if is_sure && self.asked.is_behind_start(low) {
                    self.found = Some(Found { leaf, lane, low });
                } else {
                    self.undecided(ray, leaf, lane, is_sure.then_some([low, high]));
                }
                if self.found.is_some() {
                    return ControlFlow::Break(());
                }
            }
        }
        ControlFlow::Continue(t_max)
    }
}

impl<Y: Layout> AnyQuery<'_, Y> {
    #[cold]
    #[inline(never)]
    fn decide(&self, ray: &TraversalRay, leaf: Child, lane: usize) -> bool {
        let mut scratch = Y::Scratch::new();
        let Some(leaf) = self.asked.leaf(leaf, &mut scratch) else { return false };
        ExactRay::unfiltered(ray).intersect_triangle(&leaf.vertices(lane), self.asked.interval, &mut ()).is_some()
    }
}
