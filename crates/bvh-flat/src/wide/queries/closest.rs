//! The closest hit.

use std::cmp::Ordering;
use std::ops::ControlFlow;

use geometry::exact::{Enclosure, ExactRay, HitLanes, are_coplanar, values_of_hit};
use geometry::{Hit, TraversalRay, TriangleHit, round_down, round_up};

use super::{Answered, Asked, Found, Progress};
use crate::RaySegment;
use crate::simd::{LANES, Lanes, LanesOf};
use crate::wide::Child;
use crate::wide::batch::prepared;
use crate::wide::packet::Group;
use crate::wide::traverse::Query;
use crate::wide::triangle_ray::Candidates;
use crate::wide::triangles::{Layout, Scratch};

/// The closest hit.
pub(crate) struct ClosestQuery<'a, Y> {
    asked: Asked<'a, Y>,
    /// Not below the t* of what was found.
    t_max: f32,
    found: Option<Found>,
    /// Narrower bounds of its t*, once there was a need for them.
    enclosure: Option<Enclosure>,
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
        Self { asked, t_max, found, enclosure: None }
    }

    #[inline(always)]
    fn undecided(&mut self, ray: &TraversalRay, leaf: Child, lane: usize, bounds: Option<[f32; 2]>) {
        if self.is_found_again(leaf, lane) {
            return;
        }
        match (self.asked.cmp_to_start(ray, leaf, lane), bounds) {
            (Some(Ordering::Less), _) => (),
            (Some(Ordering::Greater), Some(bounds)) => self.find(leaf, lane, bounds),
            _ => self.decide(ray, leaf, lane),
        }
    }

    #[inline(always)]
    fn progress(&self) -> Progress {
        Progress { found: self.found, t_max: self.t_max }
    }

    #[inline(always)]
    fn answer(&self, ray: &TraversalRay) -> Option<Hit> {
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
        if let Some(Candidates { maybe, sure, low, high }) = self.asked.candidates::<L>(leaf, self.t_max) {
            for lane in LanesOf(maybe) {
                let (low, high) = (low[lane], high[lane]);
                let is_sure = sure >> lane & 1 == 1;
                if is_sure && low > self.t_max {
                    continue;
                }
                let is_first = self.found.as_ref().is_none_or(|found| high < found.low);
                let is_closest = is_sure && is_first && self.asked.is_before_end(high);
                if is_closest && self.asked.is_behind_start(low) {
                    self.find(leaf, lane, [low, high]);
                } else if !is_sure || self.found.is_none() || !self.is_tie(leaf, lane) {
                    self.undecided(ray, leaf, lane, is_closest.then_some([low, high]));
                }
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

    /// Whether a triangle that is hit lies in the plane of the closest so far, as a tile on a floor does: then t* is
    /// the same, and it is taken if its number is the smaller one. (Without it such a tie was found by the exact answer
    /// for both, which took a quarter of the time of random rays in a hall of such tiles.)
    #[cold]
    #[inline(never)]
    fn is_tie(&mut self, leaf: Child, lane: usize) -> bool {
        let mut scratch = [Y::Scratch::new(), Y::Scratch::new()];
        let [scratch, best_scratch] = &mut scratch;
        let Some(Found { leaf: best_leaf, lane: best_lane, low }) = self.found else { return false };
        let (Some(triangle), Some(best)) = (self.asked.leaf(leaf, scratch), self.asked.leaf(best_leaf, best_scratch))
        else {
            return false;
        };
        let is_tie = are_coplanar(&triangle.vertices(lane), &best.vertices(best_lane));
        if is_tie && triangle.primitive(lane) < best.primitive(best_lane) {
            self.found = Some(Found { leaf, lane, low });
        }
        is_tie
    }

    /// Takes a triangle of which f32 says too little.
    #[cold]
    #[inline(never)]
    fn decide(&mut self, ray: &TraversalRay, leaf: Child, lane: usize) {
        let mut scratch = [Y::Scratch::new(), Y::Scratch::new()];
        let [scratch, best_scratch] = &mut scratch;
        let Some(triangle) = self.asked.leaf(leaf, scratch) else { return };
        let vertices = triangle.vertices(lane);
        let exact = ExactRay::unfiltered(ray);
        let Some(enclosure) = exact.intersect_triangle(&vertices, self.asked.interval, &mut ()) else { return };
        if let Some(Found { leaf: best_leaf, lane: best_lane, .. }) = self.found {
            let Some(best) = self.asked.leaf(best_leaf, best_scratch) else { return };
            let best_vertices = best.vertices(best_lane);
            let best_enclosure = self.enclosure.get_or_insert_with(|| exact.enclose(&best_vertices));
            let order = exact.compare((&enclosure, &vertices), (best_enclosure, &best_vertices), &mut ());
            let order = order.then_with(|| triangle.primitive(lane).cmp(&best.primitive(best_lane)));
            if order != Ordering::Less {
                return;
            }
        }
        self.found = Some(Found { leaf, lane, low: round_down(enclosure.low()) });
        self.t_max = round_up(enclosure.high());
        self.enclosure = Some(enclosure);
    }
}
