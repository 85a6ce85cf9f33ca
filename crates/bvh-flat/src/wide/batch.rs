//! Many rays in one call: in packets, several on their way at once, or one after the other.

use std::marker::PhantomData;

use geometry::glam::Vec3;
use geometry::{Interval, Ray, TraversalRay};

use super::arena::Child;
use super::collapse::WideTree;
use super::packet::{Together, WORTHWHILE};
use super::queries::{Answered, Asked, answer};
use super::traverse::{Next, Way, WayStack};
use super::triangles::{Layout, Triangles};
use crate::RaySegment;
use crate::simd::{Kernel, Lanes, SimdWidth};

/// How many rays are on their way at once. On a tree of 149 MB, 6 gave 0.93 and 16 gave 0.91 of the speed of 10.
const FLIGHTS: usize = 10;

/// The least tree, in bytes, for which rays may be interleaved: what the caches do not hold. Of a tree of 9 MB
/// interleaving takes 5 % of the speed, whatever the rays.
pub(crate) const LARGE: usize = 16 << 20;

/// From how many expected steps of a random ray on rays are interleaved that begin together and go apart: closest hit,
/// and any hit, which ends sooner.
///
/// What interleaving gave them (Mray/s before and after, one core of an AMD EPYC with 1 MiB of L2, 2026-11-25):
/// kitchen, 11 steps, 4.6 and 4.2; black-forest, 9 steps, 2.9 and 2.4; dragon, 18 steps, 3.7 and 4.2; a hairball of 2.9
/// M triangles, 116 steps, 0.91 and 1.25. For any hit: hall, 13 steps, 7.3 and 5.3; dragon 3.9 and 3.8; the hairball
/// 1.1 and 1.6. Of rays that also begin apart: dragon 2.2 and 4.0, terrain-rainier 3.0 and 5.0, the hairball 0.67 and
/// 1.1; but kitchen 7.7 and 6.8. Of coherent rays it takes 10 % on every tree.
const MANY_STEPS: [f64; 2] = [15.0, 50.0];

/// The mean cosine between the directions of neighbouring rays above which they go the same way.
const SAME_WAY: f32 = 0.9;

/// The mean distance between the origins of neighbouring rays, as a part of the tree's diagonal, below which they begin
/// together.
const BEGIN_TOGETHER: f32 = 0.1;

/// How many rays go alone before packets are tried again: at first, and when packets did not pay time after time.
const ALONE: [usize; 2] = [512, 16384];

/// So many rays in packets that paid are a reason to try again soon.
const PAID: usize = 512;

/// The answers of a query `Q` to many rays, as many as there are of both. Rays may be interleaved in trees from `large`
/// bytes on: [`LARGE`], but for tests.
///
/// Each way is a kernel of its own. (With all in one, closures and calls were no longer compiled in place, which took
/// half of the speed of all ways, and to compile the crate took three times as long.)
pub(crate) fn answer_many<'a, Q: Answered<'a>>(
    triangles: &'a Triangles,
    width: SimdWidth,
    large: usize,
    rays: &[RaySegment],
    answers: &mut [Q::Answer],
) {
    let query = PhantomData::<Q>;
    let count = rays.len().min(answers.len());
    let (mut rays, mut answers) = (&rays[..count], &mut answers[..count]);
    let mut alone = ALONE[0];
    while !rays.is_empty() {
        let together = width.run(Together { triangles, width, rays, answers, worthwhile: WORTHWHILE, query });
        if together >= PAID {
            alone = ALONE[0];
        }
        (rays, answers) = (&rays[together..], &mut answers[together..]);
        let (first, rest) = rays.split_at(alone.min(rays.len()));
        let (first_answers, rest_answers) = answers.split_at_mut(first.len());
        match triangles.tree.root {
            Some(root) if triangles.tree.arena.memory() >= large && gains(&triangles.tree, first, Q::ORDERED) => {
                width.run(Interleaved { triangles, width, root, rays: first, answers: first_answers, query });
            }
            _ => {
                for (ray, to) in first.iter().zip(first_answers) {
                    *to = answer_alone::<Q>(triangles, width, ray);
                }
            }
        }
        (rays, answers) = (rest, rest_answers);
        alone = (2 * alone).min(ALONE[1]);
    }
}

/// The answer to a ray by itself.
#[inline]
pub(super) fn answer_alone<'a, Q: Answered<'a>>(
    triangles: &'a Triangles,
    width: SimdWidth,
    ray: &RaySegment,
) -> Q::Answer {
    match prepared(ray) {
        Some((ray, interval)) => answer::<Q>(triangles, width, &ray, interval),
        None => Q::Answer::default(),
    }
}

/// Whether rays gain by being interleaved, as every sixteenth pair of neighbours tells.
fn gains(tree: &WideTree, rays: &[RaySegment], is_closest: bool) -> bool {
    let direction = |ray: &RaySegment| Vec3::from(ray.direction).normalize_or_zero();
    let (mut cosines, mut distances, mut count) = (0.0, 0.0, 0.0);
    for pair in rays.windows(2).step_by(16) {
        cosines += direction(&pair[0]).dot(direction(&pair[1]));
        distances += Vec3::from(pair[0].origin).distance(pair[1].origin.into());
        count += 1.0;
    }
    let go_the_same_way = cosines >= SAME_WAY * count;
    let begin_together = distances <= BEGIN_TOGETHER * count * tree.bounds.diagonal().length();
    let many = MANY_STEPS[usize::from(!is_closest)];
    !go_the_same_way && (!begin_together || tree.expected_steps >= many)
}

/// A ray that can be traced, and where.
#[inline(always)]
pub(super) fn prepared(ray: &RaySegment) -> Option<(TraversalRay, Interval)> {
    let interval = Interval::new(ray.t_min, ray.t_max);
    let ray = TraversalRay::new(&Ray { origin: ray.origin.into(), direction: ray.direction.into(), time: 0.0 })?;
    (!interval.is_empty()).then_some((ray, interval))
}

/// A ray on its way.
struct Flight<L: Lanes, Q> {
    ray: TraversalRay,
    query: Q,
    /// Which of the rays it is.
    index: usize,
    at: Child,
    way: Way<L>,
    stack: WayStack,
}

/// Each ray in turn goes down a step, to a node or a leaf that was asked for when it was last its turn: while one waits
/// for the memory, others go on. A step back leads to what was asked for before, and needs no turn: waiting for those
/// too took 7 % of the speed on 149 MB, and 9 % on 4 MB.
pub(crate) struct Interleaved<'a, 'r, Q: Answered<'a>> {
    triangles: &'a Triangles,
    width: SimdWidth,
    root: Child,
    rays: &'r [RaySegment],
    answers: &'r mut [Q::Answer],
    query: PhantomData<Q>,
}

impl<'a, Q: Answered<'a>> Kernel for Interleaved<'a, '_, Q> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { triangles, width, root, rays, answers, .. } = self;
        let mut next_ray = 0;
        let mut flights: Vec<Flight<L, Q>> = Vec::with_capacity(FLIGHTS);
        while flights.len() < FLIGHTS
            && let Some((index, ray, interval)) = next_regular::<Q>(triangles, width, rays, answers, &mut next_ray)
        {
            let (query, way) = (Q::new(Asked::new(triangles, &ray, interval)), Way::new::<true>(&ray, interval));
            flights.push(Flight { ray, query, index, at: root, way, stack: WayStack::new() });
        }
        let mut turn = 0;
        while let Some(flight) = flights.get_mut(turn) {
            match flight.way.step::<true, <Q::Layout as Layout>::Node, _>(
                &triangles.tree.arena,
                &flight.ray,
                flight.at,
                &mut flight.query,
                &mut flight.stack,
            ) {
                Some(Next::Back(child)) => {
                    flight.at = child;
                    continue;
                }
                Some(Next::Down(child)) => {
                    triangles.tree.arena.prefetch(child.place());
                    flight.at = child;
                }
                None => {
                    if let Some(answer) = answers.get_mut(flight.index) {
                        *answer = flight.query.answer(&flight.ray);
                    }
                    // The next ray takes its place, and its memory.
                    match next_regular::<Q>(triangles, width, rays, answers, &mut next_ray) {
                        Some((index, ray, interval)) => {
                            flight.query = Q::new(Asked::new(triangles, &ray, interval));
                            flight.way = Way::new::<true>(&ray, interval);
                            flight.stack.clear();
                            (flight.ray, flight.index, flight.at) = (ray, index, root);
                        }
                        None => {
                            flights.swap_remove(turn);
                        }
                    }
                }
            }
            turn = if turn + 1 < flights.len() { turn + 1 } else { 0 };
        }
    }
}

/// The next ray that may be on its way with others; those before it that may not are answered.
#[inline(always)]
fn next_regular<'a, Q: Answered<'a>>(
    triangles: &'a Triangles,
    width: SimdWidth,
    rays: &[RaySegment],
    answers: &mut [Q::Answer],
    next: &mut usize,
) -> Option<(usize, TraversalRay, Interval)> {
    loop {
        let index = *next;
        let (ray, to) = (rays.get(index)?, answers.get_mut(index)?);
        *next += 1;
        match prepared(ray) {
            Some((ray, interval)) if ray.is_regular() => return Some((index, ray, interval)),
            Some((ray, interval)) => *to = answer::<Q>(triangles, width, &ray, interval),
            None => *to = Q::Answer::default(),
        }
    }
}

#[cfg(all(test, feature = "build"))]
mod tests;
