//! Whether there is any hit.

use std::cmp::Ordering;
use std::ops::ControlFlow;

use geometry::TraversalRay;
use geometry::exact::{ExactRay, cmp_plane};

use super::{Answered, Asked, AtStart, Found, Progress};
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
    at_start: AtStart,
}

impl<'a, Y: Layout> Answered<'a> for AnyQuery<'a, Y> {
    type Layout = Y;
    type Answer = bool;

    #[inline(always)]
    fn new(asked: Asked<'a, Y>) -> Self {
        Self { asked, found: None, at_start: AtStart::default() }
    }

    #[inline(always)]
    fn resumed(asked: Asked<'a, Y>, Progress { found, .. }: Progress) -> Self {
        Self { asked, found, at_start: AtStart::default() }
    }

    #[inline(always)]
    fn undecided(&mut self, ray: &TraversalRay, leaf: Child, lane: usize, _: bool) {
        if self.decide(ray, leaf, lane) {
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
    fn answer(&mut self, ray: &TraversalRay) -> bool {
        self.decide_at_start(ray);
        self.found.is_some()
    }
}

impl<Y: Layout> Query for AnyQuery<'_, Y> {
    const ORDERED: bool = false;

    #[inline(always)]
    fn leaf<L: Lanes>(&mut self, ray: &TraversalRay, leaf: Child) -> ControlFlow<(), f32> {
        let t_max = self.asked.interval.t_max();
        if let Some(Candidates { maybe, sure, at_start, high, .. }) = self.asked.candidates::<L>(leaf, t_max) {
            for lane in LanesOf(maybe & !at_start) {
                let is_sure = sure >> lane & 1 == 1 && self.asked.is_before_end(high[lane]);
                if is_sure || self.decide(ray, leaf, lane) {
                    self.found = Some(Found { leaf, lane, low: 0.0 });
                    return ControlFlow::Break(());
                }
            }
            if self.at_start.push(leaf, at_start) {
                self.decide_many_at_start(ray);
                if self.found.is_some() {
                    return ControlFlow::Break(());
                }
            }
        }
        ControlFlow::Continue(t_max)
    }
}

impl<Y: Layout> AnyQuery<'_, Y> {
    /// Takes the triangles at the start of the ray.
    #[inline(always)]
    fn decide_at_start(&mut self, ray: &TraversalRay) {
        while self.found.is_none()
            && let Some((leaf, lane)) = self.at_start.pop()
        {
            if !self.asked.is_left_behind(ray, leaf, lane) {
                self.undecided(ray, leaf, lane, true);
            }
        }
    }

    /// The same, where they are too many to wait for the end of the way.
    #[cold]
    #[inline(never)]
    fn decide_many_at_start(&mut self, ray: &TraversalRay) {
        self.decide_at_start(ray);
    }

    /// Whether a triangle of which f32 says too little is hit.
    #[cold]
    #[inline(never)]
    fn decide(&self, ray: &TraversalRay, leaf: Child, lane: usize) -> bool {
        let mut scratch = Y::Scratch::new();
        let Some(leaf) = self.asked.leaf(leaf, &mut scratch) else { return false };
        let vertices = leaf.vertices(lane);
        cmp_plane(ray, &vertices, self.asked.interval.t_min()) != Some(Ordering::Less)
            && ExactRay::unfiltered(ray).intersect_triangle(&vertices, self.asked.interval, &mut ()).is_some()
    }
}
