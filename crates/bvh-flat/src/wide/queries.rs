//! The three queries of a wide tree of triangles, as kernels.

use std::cmp::Ordering;
use std::ops::ControlFlow;

use geometry::exact::{Enclosure, ExactRay, values_of_hit};
use geometry::{Hit, HitVisitor, Interval, TraversalRay, TriangleHit, Visit, Work, round_down, round_up};

use super::arena::Child;
use super::collapse::WideTree;
use super::traverse::{Query, Traversal};
use super::triangle_ray::{Candidates, TriangleRay};
use super::triangles::TriangleLeaf;
use crate::simd::{Kernel, Lanes};

/// What all queries begin with.
#[derive(Clone, Copy)]
pub(crate) struct Asked<'a> {
    pub(crate) tree: &'a WideTree,
    pub(crate) ray: &'a TraversalRay,
    pub(crate) interval: Interval,
}

impl<'a> Asked<'a> {
    #[inline(always)]
    fn traversal(&self) -> Traversal<'a> {
        let Self { tree, ray, interval } = *self;
        Traversal { arena: &tree.arena, root: tree.root, ray, interval }
    }

    #[inline(always)]
    fn leaf(&self, leaf: Child) -> Option<TriangleLeaf<'a>> {
        TriangleLeaf::new(&self.tree.arena, leaf)
    }

    #[inline(always)]
    fn candidates<L: Lanes>(&self, triangles: &TriangleRay, leaf: Child, t_max: f32) -> Option<Candidates> {
        let leaf = self.leaf(leaf)?;
        triangles.candidates::<L>(leaf.numbers(), leaf.count(), [self.interval.t_min(), t_max])
    }

    /// Whether t* is in the interval for certain.
    #[inline(always)]
    fn is_inside(&self, low: f32, high: f32) -> bool {
        self.interval.t_min() < low && high < self.interval.t_max() && high < f32::MAX
    }
}

/// A number of lanes as a mask, from the lowest on.
struct LanesOf(u32);

impl Iterator for LanesOf {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        if self.0 == 0 {
            return None;
        }
        let lane = self.0.trailing_zeros() as usize & 7;
        self.0 &= self.0 - 1;
        Some(lane)
    }
}

/// The closest hit.
pub(crate) struct Closest<'a>(pub(crate) Asked<'a>);

impl Kernel for Closest<'_> {
    type Output = Option<Hit>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Option<Hit> {
        let t_max = self.0.interval.t_max();
        let triangles = TriangleRay::new(self.0.ray);
        let mut query = ClosestQuery { asked: self.0, triangles, t_max, found: None, enclosure: None };
        self.0.traversal().run::<L>(&mut query);
        let Found { leaf, lane, .. } = query.found?;
        let leaf = self.0.leaf(leaf)?;
        let vertices = leaf.permuted(lane, query.triangles.axes());
        let TriangleHit { t, u, v } = values_of_hit(self.0.ray, &vertices);
        Some(Hit { t, u, v, primitive: u64::from(leaf.primitive(lane)) })
    }
}

/// A triangle that is hit.
#[derive(Clone, Copy)]
struct Found {
    leaf: Child,
    lane: usize,
    /// Not above t*.
    low: f32,
}

struct ClosestQuery<'a> {
    asked: Asked<'a>,
    triangles: TriangleRay,
    /// Not below the t* of what was found.
    t_max: f32,
    found: Option<Found>,
    /// Narrower bounds of its t*, once there was a need for them.
    enclosure: Option<Enclosure>,
}

impl Query for ClosestQuery<'_> {
    const ORDERED: bool = true;

    #[inline(always)]
    fn leaf<L: Lanes>(&mut self, leaf: Child) -> ControlFlow<(), f32> {
        if let Some(Candidates { maybe, sure, low, high }) =
            self.asked.candidates::<L>(&self.triangles, leaf, self.t_max)
        {
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
                } else {
                    self.decide(leaf, lane);
                }
            }
        }
        ControlFlow::Continue(self.t_max)
    }
}

impl ClosestQuery<'_> {
    /// Takes a triangle of which f32 says too little.
    #[cold]
    #[inline(never)]
    fn decide(&mut self, leaf: Child, lane: usize) {
        let Some(triangle) = self.asked.leaf(leaf) else { return };
        let vertices = triangle.vertices(lane);
        let exact = ExactRay::unfiltered(self.asked.ray);
        let Some(enclosure) = exact.intersect_triangle(&vertices, self.asked.interval, &mut ()) else { return };
        if let Some(Found { leaf: best_leaf, lane: best_lane, .. }) = self.found {
            let Some(best) = self.asked.leaf(best_leaf) else { return };
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
pub(crate) struct Any<'a>(pub(crate) Asked<'a>);

impl Kernel for Any<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<L: Lanes>(self) -> bool {
        let mut query = AnyQuery { asked: self.0, triangles: TriangleRay::new(self.0.ray), is_hit: false };
        self.0.traversal().run::<L>(&mut query);
        query.is_hit
    }
}

struct AnyQuery<'a> {
    asked: Asked<'a>,
    triangles: TriangleRay,
    is_hit: bool,
}

impl Query for AnyQuery<'_> {
    const ORDERED: bool = false;

    #[inline(always)]
    fn leaf<L: Lanes>(&mut self, leaf: Child) -> ControlFlow<(), f32> {
        let t_max = self.asked.interval.t_max();
        if let Some(Candidates { maybe, sure, low, high }) = self.asked.candidates::<L>(&self.triangles, leaf, t_max) {
            for lane in LanesOf(maybe) {
                let is_sure = sure >> lane & 1 == 1 && self.asked.is_inside(low[lane], high[lane]);
                if is_sure || self.decide(leaf, lane) {
                    self.is_hit = true;
                    return ControlFlow::Break(());
                }
            }
        }
        ControlFlow::Continue(t_max)
    }
}

impl AnyQuery<'_> {
    #[cold]
    #[inline(never)]
    fn decide(&self, leaf: Child, lane: usize) -> bool {
        let Some(leaf) = self.asked.leaf(leaf) else { return false };
        let exact = ExactRay::unfiltered(self.asked.ray);
        exact.intersect_triangle(&leaf.vertices(lane), self.asked.interval, &mut ()).is_some()
    }
}

/// All hits, for a visitor.
pub(crate) struct All<'a, 'v> {
    pub(crate) asked: Asked<'a>,
    pub(crate) visitor: &'v mut dyn HitVisitor,
}

impl Kernel for All<'_, '_> {
    type Output = Visit;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Visit {
        let Self { asked, visitor } = self;
        let visit = ControlFlow::Continue(asked.interval.t_max());
        let triangles = TriangleRay::new(asked.ray);
        let mut query = AllQuery { asked, triangles, visitor, work: Work::default(), visit };
        asked.traversal().run::<L>(&mut query);
        let AllQuery { visitor, work, visit, .. } = query;
        visitor.work(work);
        visit
    }
}

struct AllQuery<'a, 'v> {
    asked: Asked<'a>,
    triangles: TriangleRay,
    visitor: &'v mut dyn HitVisitor,
    work: Work,
    visit: Visit,
}

impl Query for AllQuery<'_, '_> {
    const ORDERED: bool = true;

    #[inline(always)]
    fn leaf<L: Lanes>(&mut self, leaf: Child) -> ControlFlow<(), f32> {
        self.work.primitives += leaf.count() as u64;
        if let ControlFlow::Continue(t_max) = self.visit
            && let Some(Candidates { maybe, .. }) = self.asked.candidates::<L>(&self.triangles, leaf, t_max)
        {
            self.tell(leaf, maybe);
        }
        self.visit
    }

    #[inline(always)]
    fn node(&mut self) {
        self.work.nodes += 1;
    }
}

impl AllQuery<'_, '_> {
    #[inline(never)]
    fn tell(&mut self, leaf: Child, maybe: u32) {
        let Some(leaf) = self.asked.leaf(leaf) else { return };
        let exact = ExactRay::unfiltered(self.asked.ray);
        for lane in LanesOf(maybe) {
            let ControlFlow::Continue(t_max) = self.visit else { return };
            let (vertices, interval) = (leaf.vertices(lane), self.asked.interval.with_t_max(t_max));
            let Some(enclosure) = exact.intersect_triangle(&vertices, interval, &mut ()) else { continue };
            let TriangleHit { t, u, v } = exact.values(&vertices, &enclosure, &mut ());
            self.visit = self.visitor.hit(Hit { t, u, v, primitive: u64::from(leaf.primitive(lane)) });
        }
    }
}
