//! The three queries of a wide tree of triangles, as kernels.

use std::cmp::Ordering;
use std::collections::BTreeSet;
use std::marker::PhantomData;
use std::ops::ControlFlow;

use geometry::exact::{Enclosure, ExactRay, HitLanes, are_coplanar, meets_plane_before, values_of_hit};
use geometry::{Hit, HitVisitor, Interval, TraversalRay, TriangleHit, Visit, Work, round_down, round_up};

use super::arena::Child;
use super::batch::prepared;
use super::collapse::WideTree;
use super::packet::Group;
use super::traverse::{Query, traverse};
use super::triangle_ray::{Candidates, TriangleRay};
use super::triangles::{Layout, Scratch, TriangleLeaf, Triangles};
use crate::RaySegment;
use crate::simd::{Kernel, LANES, Lanes, LanesOf, SimdWidth};

/// What all queries begin with.
#[derive(Clone, Copy)]
pub(crate) struct Asked<'a, Y> {
    triangles: &'a Triangles,
    interval: Interval,
    ray: TriangleRay,
    layout: PhantomData<Y>,
}

impl<'a, Y: Layout> Asked<'a, Y> {
    #[inline(always)]
    pub(crate) fn new(triangles: &'a Triangles, ray: &TraversalRay, interval: Interval) -> Self {
        Self { triangles, interval, ray: TriangleRay::new(ray), layout: PhantomData }
    }

    #[inline(always)]
    fn leaf<'s>(&'s self, leaf: Child, scratch: &'s mut Y::Scratch) -> Option<TriangleLeaf<'s>> {
        TriangleLeaf::new::<Y>(self.triangles, leaf, scratch)
    }

    #[inline(always)]
    fn candidates<L: Lanes>(&self, leaf: Child, t_max: f32) -> Option<Candidates> {
        let mut scratch = Y::Scratch::new();
        let leaf = self.leaf(leaf, &mut scratch)?;
        self.ray.candidates::<L>(leaf.numbers(), leaf.count(), [self.interval.t_min(), t_max])
    }

    /// Whether a triangle, though f32 leaves it open, lies before the interval for certain: most often it is the one that the
    /// ray has just left. (Compiled in place, it took a seventh of the speed of any-hit rays that never need it.)
    #[cold]
    #[inline(never)]
    fn is_before(&self, ray: &TraversalRay, leaf: Child, lane: usize) -> bool {
        let mut scratch = Y::Scratch::new();
        let triangle = self.leaf(leaf, &mut scratch);
        triangle.is_some_and(|leaf| meets_plane_before(ray, &leaf.vertices(lane), self.interval.t_min()))
    }

    /// Whether t* is in the interval for certain.
    #[inline(always)]
    fn is_inside(&self, low: f32, high: f32) -> bool {
        self.interval.t_min() < low && high < self.interval.t_max() && high < f32::MAX
    }
}

/// A query with an answer.
pub(crate) trait Answered<'a>: Query {
    /// Of which trees it is asked.
    type Layout: Layout;

    /// What is answered.
    type Answer: Default;

    /// The query of a ray.
    fn new(asked: Asked<'a, Self::Layout>) -> Self;

    /// The query of a ray that has come so far.
    fn resumed(asked: Asked<'a, Self::Layout>, progress: Progress) -> Self;

    /// Takes a triangle that may be hit, of which f32 says too little.
    fn undecided(&mut self, ray: &TraversalRay, leaf: Child, lane: usize);

    /// How far it has come.
    fn progress(&self) -> Progress;

    /// The answer, when the ray's way is at its end.
    fn answer(&self, ray: &TraversalRay) -> Self::Answer;

    /// The answers of eight rays of a packet of `rays`, into their places.
    fn answers_of<L: Lanes>(group: &Group<L>, rays: &[RaySegment], answers: &mut [Self::Answer]);
}

/// The answer of a query `Q` of one ray.
#[inline(always)]
pub(crate) fn answer<'a, Q: Answered<'a>>(
    triangles: &'a Triangles,
    width: SimdWidth,
    ray: &TraversalRay,
    interval: Interval,
) -> Q::Answer {
    let (t_min, t_max) = (interval.t_min(), interval.t_max());
    width.run(One { triangles, ray, t_min, t_max, query: PhantomData::<Q> })
}

struct One<'a, 'r, Q> {
    triangles: &'a Triangles,
    ray: &'r TraversalRay,
    /// The ends of its interval, one by one: see [`TriangleRay::new`].
    t_min: f32,
    t_max: f32,
    query: PhantomData<Q>,
}

impl<'a, Q: Answered<'a>> Kernel for One<'a, '_, Q> {
    type Output = Q::Answer;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Q::Answer {
        let Self { triangles, ray, t_min, t_max, .. } = self;
        let interval = Interval::new(t_min, t_max);
        let mut query = Q::new(Asked::new(triangles, ray, interval));
        let WideTree { arena, root, .. } = &triangles.tree;
        traverse::<L, <Q::Layout as Layout>::Node>(arena, *root, ray, interval, &mut query);
        query.answer(ray)
    }
}

/// A triangle that is hit.
#[derive(Clone, Copy)]
pub(crate) struct Found {
    pub(crate) leaf: Child,
    pub(crate) lane: usize,
    /// Not above t*.
    pub(crate) low: f32,
}

/// How far a query has come.
#[derive(Clone, Copy)]
pub(crate) struct Progress {
    pub(crate) found: Option<Found>,
    /// Up to where more is looked for.
    pub(crate) t_max: f32,
}

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
    fn undecided(&mut self, ray: &TraversalRay, leaf: Child, lane: usize) {
        if !self.is_found_again(leaf, lane) && !self.asked.is_before(ray, leaf, lane) {
            self.decide(ray, leaf, lane);
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
                if is_sure && is_first && self.asked.is_inside(low, high) {
                    (self.found, self.enclosure) = (Some(Found { leaf, lane, low }), None);
                    self.t_max = high;
                } else if !is_sure || self.found.is_none() || !self.is_tie(leaf, lane) {
                    self.undecided(ray, leaf, lane);
                }
            }
        }
        ControlFlow::Continue(self.t_max)
    }
}

impl<Y: Layout> ClosestQuery<'_, Y> {
    /// Whether a triangle is the closest so far, met again in another leaf.
    #[inline(always)]
    fn is_found_again(&self, leaf: Child, lane: usize) -> bool {
        let primitive = |leaf, lane| Y::primitive(self.asked.triangles, leaf, lane);
        self.found.as_ref().is_some_and(|found| primitive(found.leaf, found.lane) == primitive(leaf, lane))
    }

    /// Whether a triangle that is hit lies in the plane of the closest so far, as a tile on a floor does: then t* is the same, and
    /// it is taken if its number is the smaller one. (Without it such a tie was found by the exact answer for both, which took a
    /// quarter of the time of random rays in a hall of such tiles.)
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
    fn undecided(&mut self, ray: &TraversalRay, leaf: Child, lane: usize) {
        if !self.asked.is_before(ray, leaf, lane) && self.decide(ray, leaf, lane) {
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
                if sure >> lane & 1 == 1 && self.asked.is_inside(low[lane], high[lane]) {
                    self.found = Some(Found { leaf, lane, low: low[lane] });
                } else {
                    self.undecided(ray, leaf, lane);
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

/// All hits, for a visitor.
pub(crate) struct All<'a, 'v, Y> {
    pub(crate) triangles: &'a Triangles,
    pub(crate) ray: &'a TraversalRay,
    pub(crate) interval: Interval,
    pub(crate) visitor: &'v mut dyn HitVisitor,
    pub(crate) layout: PhantomData<Y>,
}

impl<Y: Layout> Kernel for All<'_, '_, Y> {
    type Output = Visit;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Visit {
        let Self { triangles, ray, interval, visitor, .. } = self;
        let visit = ControlFlow::Continue(interval.t_max());
        let asked = Asked::<Y>::new(triangles, ray, interval);
        let mut query = AllQuery { asked, visitor, work: Work::default(), visit, told: BTreeSet::new() };
        traverse::<L, Y::Node>(&triangles.tree.arena, triangles.tree.root, ray, interval, &mut query);
        let AllQuery { visitor, work, visit, .. } = query;
        visitor.work(work);
        visit
    }
}

struct AllQuery<'a, 'v, Y> {
    asked: Asked<'a, Y>,
    visitor: &'v mut dyn HitVisitor,
    work: Work,
    visit: Visit,
    /// The triangles that the visitor knows, where they may be in several leaves.
    told: BTreeSet<u32>,
}

impl<Y: Layout> Query for AllQuery<'_, '_, Y> {
    const ORDERED: bool = true;

    #[inline(always)]
    fn leaf<L: Lanes>(&mut self, ray: &TraversalRay, leaf: Child) -> ControlFlow<(), f32> {
        self.work.primitives += leaf.count() as u64;
        if let ControlFlow::Continue(t_max) = self.visit
            && let Some(Candidates { maybe, .. }) = self.asked.candidates::<L>(leaf, t_max)
        {
            self.tell(ray, leaf, maybe);
        }
        self.visit
    }

    #[inline(always)]
    fn node(&mut self) {
        self.work.nodes += 1;
    }
}

impl<Y: Layout> AllQuery<'_, '_, Y> {
    #[inline(never)]
    fn tell(&mut self, ray: &TraversalRay, leaf: Child, maybe: u32) {
        let mut scratch = Y::Scratch::new();
        let Some(leaf) = self.asked.leaf(leaf, &mut scratch) else { return };
        let exact = ExactRay::unfiltered(ray);
        for lane in LanesOf(maybe) {
            let ControlFlow::Continue(t_max) = self.visit else { return };
            let (vertices, interval) = (leaf.vertices(lane), self.asked.interval.with_t_max(t_max));
            let Some(enclosure) = exact.intersect_triangle(&vertices, interval, &mut ()) else { continue };
            let primitive = leaf.primitive(lane);
            if self.asked.triangles.tree.is_split && !self.told.insert(primitive) {
                continue;
            }
            let TriangleHit { t, u, v } = exact.values(&vertices, &enclosure, &mut ());
            self.visit = self.visitor.hit(Hit { t, u, v, primitive: u64::from(primitive) });
        }
    }
}
