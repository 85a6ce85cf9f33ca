//! The closest hit.

use std::cmp::Ordering;
use std::ops::ControlFlow;

use geometry::exact::{Enclosure, ExactRay, HitLanes, are_coplanar, cmp_plane, values_of_hit};
use geometry::{Hit, TraversalRay, TriangleHit, round_down, round_up};

use super::{Answered, Asked, AtStart, Found, Progress};
use crate::RaySegment;
use crate::simd::{LANES, Lanes, LanesOf};
use crate::wide::Child;
use crate::wide::batch::prepared;
use crate::wide::packet::Group;
use crate::wide::traverse::Query;
use crate::wide::triangle_ray::Candidates;
use crate::wide::triangles::{Layout, Scratch, TriangleLeaf};

/// The closest hit.
pub(crate) struct ClosestQuery<'a, Y> {
    asked: Asked<'a, Y>,
    /// Not below the t* of what was found.
    t_max: f32,
    found: Option<Found>,
    /// Narrower bounds of its t*, once there was a need for them.
    enclosure: Option<Enclosure>,
    at_start: AtStart,
}

impl<'a, Y: Layout> Answered<'a> for ClosestQuery<'a, Y> {
    type Layout = Y;
    type Answer = Option<Hit>;

    #[inline(always)]
    fn new(asked: Asked<'a, Y>) -> Self {
        let t_max = asked.interval.t_max();
        Self::resumed(asked, Progress { found: None, t_max })
    }

    #[inline(always)]
    fn resumed(asked: Asked<'a, Y>, Progress { found, t_max }: Progress) -> Self {
        Self { asked, t_max, found, enclosure: None, at_start: AtStart::default() }
    }

    #[inline(always)]
    fn undecided(&mut self, ray: &TraversalRay, leaf: Child, lane: usize, is_sure: bool) {
        self.decide(ray, leaf, lane, is_sure);
    }

    #[inline(always)]
    fn progress(&self) -> Progress {
        Progress { found: self.found, t_max: self.t_max }
    }

    #[inline(always)]
    fn answer(&mut self, ray: &TraversalRay) -> Option<Hit> {
        self.decide_at_start(ray);
        let Found { leaf, lane, .. } = self.found?;
        let mut scratch = Y::Scratch::new();
        let leaf = self.asked.leaf(leaf, &mut scratch)?;
        let vertices = leaf.permuted(lane, self.asked.ray.axes());
        let TriangleHit { t, u, v } = values_of_hit(ray, &vertices);
        Some(Hit { t, u, v, primitive: u64::from(leaf.primitive(lane)) })
    }

    #[inline(always)]
    fn answers_of<L: Lanes>(group: &Group<L>, rays: &[RaySegment], answers: &mut [Option<Hit>]) {
        let (values, primitives, hits) = (group.values(), group.primitives(), group.hits());
        for lane in LanesOf(group.lanes) {
            let place = usize::from(group.index[lane]);
            let (Some(ray), Some(to)) = (rays.get(place), answers.get_mut(place)) else { return };
            *to = None;
            if hits >> lane & 1 == 1 {
                let (t, u, v) = (values.t[lane], values.u[lane], values.v[lane]);
                *to = Some(Hit { t, u, v, primitive: primitives[lane].into() });
                if values.is_certain[lane] == 0 {
                    *to = difficult_hit(ray, &group.hit_lanes(), lane, primitives[lane]);
                }
            }
        }
    }
}

/// A hit whose values take more than f64.
#[cold]
#[inline(never)]
fn difficult_hit(ray: &RaySegment, hits: &HitLanes<LANES>, lane: usize, primitive: u32) -> Option<Hit> {
    let (ray, _) = prepared(ray)?;
    let vertex = |i: usize| [0, 1, 2].map(|axis: usize| hits.vertices[axis][i][lane]);
    let TriangleHit { t, u, v } = values_of_hit(&ray, &[vertex(0), vertex(1), vertex(2)]);
    Some(Hit { t, u, v, primitive: primitive.into() })
}

impl<Y: Layout> Query for ClosestQuery<'_, Y> {
    const ORDERED: bool = true;

    #[inline(always)]
    fn leaf<L: Lanes>(&mut self, ray: &TraversalRay, leaf: Child) -> ControlFlow<(), f32> {
        if let Some(Candidates { maybe, sure, at_start, low, high }) = self.asked.candidates::<L>(leaf, self.t_max) {
            for lane in LanesOf(maybe & !at_start) {
                let (low, high) = (low[lane], high[lane]);
                let is_sure = sure >> lane & 1 == 1;
                if is_sure && low > self.t_max {
                    continue;
                }
                let is_first = self.found.as_ref().is_none_or(|found| high < found.low);
                if is_sure && is_first && self.asked.is_before_end(high) {
                    self.find(leaf, lane, [low, high]);
                } else if !self.is_found_again(leaf, lane) {
                    self.decide(ray, leaf, lane, is_sure);
                }
            }
            if self.at_start.push(leaf, at_start) {
                self.decide_many_at_start(ray);
            }
        }
        ControlFlow::Continue(self.t_max)
    }
}

impl<Y: Layout> ClosestQuery<'_, Y> {
    /// Takes a triangle that is the closest so far, with bounds of its t*.
    #[inline(always)]
    fn find(&mut self, leaf: Child, lane: usize, [low, high]: [f32; 2]) {
        (self.found, self.enclosure) = (Some(Found { leaf, lane, low }), None);
        self.t_max = high;
    }

    /// Whether a triangle is the closest so far, met again in another leaf.
    #[inline(always)]
    fn is_found_again(&self, leaf: Child, lane: usize) -> bool {
        let primitive = |leaf, lane| Y::primitive(self.asked.triangles, leaf, lane);
        self.found.as_ref().is_some_and(|found| primitive(found.leaf, found.lane) == primitive(leaf, lane))
    }

    /// Takes the triangles at the start of the ray.
    ///
    /// Compiled in place, which is a tenth of the speed of diffuse rays on a small scan.
    #[inline(always)]
    fn decide_at_start(&mut self, ray: &TraversalRay) {
        while let Some((leaf, lane)) = self.at_start.pop() {
            if !self.asked.is_left_behind(ray, leaf, lane) {
                self.decide(ray, leaf, lane, true);
            }
        }
    }

    /// The same, where they are too many to wait for the end of the way.
    #[cold]
    #[inline(never)]
    fn decide_many_at_start(&mut self, ray: &TraversalRay) {
        self.decide_at_start(ray);
    }

    /// Takes a triangle of which f32 says too little: at most, that it is hit for certain, if t* is in the interval.
    #[cold]
    #[inline(never)]
    fn decide(&mut self, ray: &TraversalRay, leaf: Child, lane: usize, is_sure: bool) {
        let mut scratch = [Y::Scratch::new(), Y::Scratch::new()];
        let [scratch, best_scratch] = &mut scratch;
        let Some(triangle) = self.asked.leaf(leaf, scratch) else { return };
        let best = self.found.and_then(|found| Some((found, self.asked.leaf(found.leaf, best_scratch)?)));
        let vertices = triangle.vertices(lane);
        let is_smaller = |best: &TriangleLeaf, best_lane| triangle.primitive(lane) < best.primitive(best_lane);
        if let Some((Found { lane: best_lane, low, .. }, best)) = &best
            && is_sure
            && are_coplanar(&vertices, &best.vertices(*best_lane))
        {
            // A tile on a floor: t* is the same. (Without this such a tie was found by the exact answer for both, which
            // took a quarter of the time of random rays in a hall of such tiles.)
            if is_smaller(best, *best_lane) {
                self.found = Some(Found { leaf, lane, low: *low });
            }
            return;
        }
        if cmp_plane(ray, &vertices, self.asked.interval.t_min()) == Some(Ordering::Less) {
            return;
        }
        let exact = ExactRay::unfiltered(ray);
        let Some(enclosure) = exact.intersect_triangle(&vertices, self.asked.interval, &mut ()) else { return };
        if let Some((Found { lane: best_lane, .. }, best)) = &best {
            let best_vertices = best.vertices(*best_lane);
            let best_enclosure = self.enclosure.get_or_insert_with(|| exact.enclose(&best_vertices));
            match exact.compare((&enclosure, &vertices), (best_enclosure, &best_vertices), &mut ()) {
                Ordering::Less => (),
                Ordering::Equal if is_smaller(best, *best_lane) => (),
                _ => return,
            }
        }
        self.found = Some(Found { leaf, lane, low: round_down(enclosure.low()) });
        self.t_max = round_up(enclosure.high());
        self.enclosure = Some(enclosure);
    }
}
