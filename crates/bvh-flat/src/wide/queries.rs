//! The three queries of a wide tree of triangles, as kernels.

use std::cmp::Ordering;
use std::marker::PhantomData;

use geometry::exact::cmp_plane;
use geometry::{Interval, TraversalRay};

use super::arena::Child;
use super::collapse::WideTree;
use super::packet::Group;
use super::traverse::{Query, traverse};
use super::triangle_ray::{Candidates, TriangleRay};
use super::triangles::{Layout, Scratch, TriangleLeaf, Triangles};
use crate::RaySegment;
use crate::simd::{Kernel, Lanes, SimdWidth};

mod all;
mod any;
mod closest;

pub(crate) use all::All;
pub(crate) use any::AnyQuery;
pub(crate) use closest::ClosestQuery;

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

    /// Whether a triangle lies behind the start of the ray for certain: most often it is the one that the ray has just
    /// left.
    #[inline(always)]
    fn is_left_behind(&self, ray: &TraversalRay, leaf: Child, lane: usize) -> bool {
        let mut scratch = Y::Scratch::new();
        let Some(leaf) = self.leaf(leaf, &mut scratch) else { return true };
        cmp_plane(ray, &leaf.vertices(lane), self.interval.t_min()) == Some(Ordering::Less)
    }

    /// Whether t* is before the end of the interval for certain.
    #[inline(always)]
    fn is_before_end(&self, high: f32) -> bool {
        high < self.interval.t_max() && high < f32::MAX
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

    /// Takes a triangle of which f32 says too little: at most, that it is hit for certain, if t* is in the interval.
    fn undecided(&mut self, ray: &TraversalRay, leaf: Child, lane: usize, is_sure: bool);

    /// How far it has come.
    fn progress(&self) -> Progress;

    /// The answer, when the ray's way is at its end.
    fn answer(&mut self, ray: &TraversalRay) -> Self::Answer;

    /// The answers of eight rays of a packet of `rays`, into their places.
    fn answers_of<L: Lanes>(group: &Group<L>, rays: &[RaySegment], answers: &mut [Self::Answer]);
}

/// The answer of a query `Q` of one ray.
///
/// Rejected: to prepare the ray here, in registers, with what is rarely asked preparing it anew. Of 1533 instructions
/// of a primary ray in sponza it took 81 away, and no time: the way to the first node waits as long for the reciprocals
/// (sponza's and bunny's rays −2 to +4 %, kitchen's −4 to −3 %).
#[inline(always)]
pub(crate) fn answer<'a, Q: Answered<'a>>(
    triangles: &'a Triangles,
    width: SimdWidth,
    ray: &TraversalRay,
    interval: Interval,
) -> Q::Answer {
    let ends = [interval.t_min(), interval.t_max()];
    width.run(One { triangles, ray, ends: bytemuck::must_cast(ends), query: PhantomData::<Q> })
}

struct One<'a, 'r, Q> {
    triangles: &'a Triangles,
    ray: &'r TraversalRay,
    /// The two ends of its interval, in one number. Two would be written one by one and read as one vector, and such a
    /// load waits until both have left the store queue: 9 ns of each ray, of AVX2.
    ends: u64,
    query: PhantomData<Q>,
}

impl<'a, Q: Answered<'a>> Kernel for One<'a, '_, Q> {
    type Output = Q::Answer;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Q::Answer {
        let Self { triangles, ray, ends, .. } = self;
        let [t_min, t_max] = bytemuck::must_cast(ends);
        let interval = Interval::new(t_min, t_max);
        let mut query = Q::new(Asked::new(triangles, ray, interval));
        let WideTree { arena, root, .. } = &triangles.tree;
        traverse::<L, <Q::Layout as Layout>::Node>(arena, *root, ray, interval, &mut query);
        query.answer(ray)
    }
}

/// Triangles at the start of a ray, to be decided about when its way is at its end: most often it has left one of them,
/// for which a hit elsewhere, or in any-hit queries some hit, need not wait.
#[derive(Clone, Copy, Default)]
struct AtStart {
    leaves: [(Child, u32); AtStart::CAPACITY],
    len: usize,
}

impl AtStart {
    const CAPACITY: usize = 4;

    /// Adds lanes of a leaf, if there are any; whether there is room for no more. Without a branch: every leaf comes
    /// here, and which one the ray has left is hard to foresee.
    #[inline(always)]
    fn push(&mut self, leaf: Child, lanes: u32) -> bool {
        self.leaves[self.len % Self::CAPACITY] = (leaf, lanes);
        self.len += usize::from(lanes != 0);
        self.len == Self::CAPACITY
    }

    /// Takes one out.
    #[inline(always)]
    fn pop(&mut self) -> Option<(Child, usize)> {
        let (leaf, lanes) = self.leaves.get_mut(self.len.wrapping_sub(1))?;
        let lane = lanes.trailing_zeros() as usize;
        *lanes &= lanes.wrapping_sub(1);
        self.len -= usize::from(*lanes == 0);
        Some((*leaf, lane))
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
