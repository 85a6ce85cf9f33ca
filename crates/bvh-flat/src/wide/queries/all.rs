//! All hits, for a visitor.

use std::collections::BTreeSet;
use std::marker::PhantomData;
use std::ops::ControlFlow;

use geometry::exact::ExactRay;
use geometry::{Hit, HitVisitor, Interval, TraversalRay, TriangleHit, Visit, Work};

use super::Asked;
use crate::simd::{Kernel, Lanes, LanesOf};
use crate::wide::Child;
use crate::wide::traverse::{Query, traverse};
use crate::wide::triangle_ray::Candidates;
use crate::wide::triangles::{Layout, Scratch, Triangles};

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
