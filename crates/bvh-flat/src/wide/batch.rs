//! Many rays in one call: one after the other, or several on their way at once.

use std::marker::PhantomData;

use geometry::glam::Vec3;
use geometry::{Interval, Ray, TraversalRay};

use super::arena::Child;
use super::box_ray::is_regular;
use super::collapse::WideTree;
use super::queries::{Answered, Asked};
use super::traverse::{Next, Way, traverse};
use crate::RaySegment;
use crate::simd::{Kernel, Lanes};

/// How many rays are on their way at once. On a tree of 149 MB, 6 gave 0.93 and 16 gave 0.91 of the speed of 10.
const FLIGHTS: usize = 10;

/// How many rays are looked at to choose how they are traced.
const CHUNK: usize = 4096;

/// From how many bytes of a tree on rays are interleaved, if they go apart. What interleaving gives (Mray/s before and
/// after, one core of an AMD EPYC with 1 MiB of L2, 2026-11-25): closest hit of random rays, 4 MB 5.2 and 5.6; 20 MB 2.7 and
/// 4.7; 52 MB 2.3 and 3.9; 149 MB 0.65 and 1.17. Of coherent rays it takes 10 % at every size.
pub(crate) const LARGE_FOR_CLOSEST: usize = 8 << 20;

/// The same for any hit, where a ray visits less before it ends: 20 MB 5.0 and 3.5; 52 MB 3.9 and 3.8; 84 MB 9.7 and 8.3;
/// 149 MB 1.1 and 1.65.
pub(crate) const LARGE_FOR_ANY: usize = 128 << 20;

/// The mean cosine between the directions of neighbouring rays above which they go the same way.
const COHERENT: f32 = 0.9;

/// A query `Q` of many rays.
pub(crate) struct Many<'a, 'r, Q: Answered<'a>> {
    pub(crate) tree: &'a WideTree,
    pub(crate) rays: &'r [RaySegment],
    pub(crate) answers: &'r mut [Q::Answer],
    /// From how many bytes of a tree on rays are interleaved, if they go apart.
    pub(crate) large: usize,
    pub(crate) query: PhantomData<Q>,
}

impl<'a, Q: Answered<'a>> Kernel for Many<'a, '_, Q> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { tree, rays, answers, large, .. } = self;
        for (rays, answers) in rays.chunks(CHUNK).zip(answers.chunks_mut(CHUNK)) {
            match tree.root {
                Some(root) if tree.arena.memory() >= large && !are_coherent(rays) => {
                    interleaved::<L, Q>(tree, root, rays, answers);
                }
                _ => one_by_one::<L, Q>(tree, rays, answers),
            }
        }
    }
}

/// Whether neighbouring rays go the same way, as every sixteenth pair of them tells.
fn are_coherent(rays: &[RaySegment]) -> bool {
    let direction = |ray: &RaySegment| Vec3::from(ray.direction).normalize_or_zero();
    let cosines = rays.windows(2).step_by(16).map(|pair| direction(&pair[0]).dot(direction(&pair[1])));
    let (sum, count) = cosines.fold((0.0, 0.0_f32), |(sum, count), cosine| (sum + cosine, count + 1.0));
    sum >= COHERENT * count
}

/// A ray that can be traced, and where.
#[inline(always)]
fn prepared(ray: &RaySegment) -> Option<(TraversalRay, Interval)> {
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
}

#[inline(always)]
fn one_by_one<'a, L: Lanes, Q: Answered<'a>>(tree: &'a WideTree, rays: &[RaySegment], answers: &mut [Q::Answer]) {
    for (ray, answer) in rays.iter().zip(answers) {
        *answer = Q::Answer::default();
        if let Some((ray, interval)) = prepared(ray) {
            *answer = alone::<L, Q>(tree, &ray, interval);
        }
    }
}

/// Each ray in turn goes down a step, to a node or a leaf that was asked for when it was last its turn: while one waits for
/// the memory, others go on. A step back leads to what was asked for before, and needs no turn: waiting for those too took
/// 7 % of the speed on 149 MB, and 9 % on 4 MB.
#[inline(always)]
fn interleaved<'a, L: Lanes, Q: Answered<'a>>(
    tree: &'a WideTree,
    root: Child,
    rays: &[RaySegment],
    answers: &mut [Q::Answer],
) {
    let mut next_ray = 0;
    let mut flights: Vec<Flight<L, Q>> = Vec::with_capacity(FLIGHTS);
    while flights.len() < FLIGHTS
        && let Some((index, ray, interval)) = next_regular::<L, Q>(tree, rays, answers, &mut next_ray)
    {
        let (query, way) = (Q::new(Asked::new(tree, &ray, interval)), Way::new::<true>(&ray, interval));
        flights.push(Flight { ray, query, index, at: root, way });
    }
    let mut turn = 0;
    while let Some(flight) = flights.get_mut(turn) {
        match flight.way.step::<true, _>(&tree.arena, &flight.ray, flight.at, &mut flight.query) {
            Some(Next::Back(child)) => {
                flight.at = child;
                continue;
            }
            Some(Next::Down(child)) => {
                tree.arena.prefetch(child.place());
                flight.at = child;
            }
            None => {
                if let Some(answer) = answers.get_mut(flight.index) {
                    *answer = flight.query.answer(&flight.ray);
                }
                // The next ray takes its place, and its memory.
                match next_regular::<L, Q>(tree, rays, answers, &mut next_ray) {
                    Some((index, ray, interval)) => {
                        flight.query = Q::new(Asked::new(tree, &ray, interval));
                        flight.way.begin::<true>(&ray, interval);
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

/// The next ray that may be on its way with others; those before it that may not are answered.
#[inline(always)]
fn next_regular<'a, L: Lanes, Q: Answered<'a>>(
    tree: &'a WideTree,
    rays: &[RaySegment],
    answers: &mut [Q::Answer],
    next: &mut usize,
) -> Option<(usize, TraversalRay, Interval)> {
    loop {
        let index = *next;
        let (ray, answer) = (rays.get(index)?, answers.get_mut(index)?);
        *next += 1;
        *answer = Q::Answer::default();
        let Some((ray, interval)) = prepared(ray) else { continue };
        if is_regular(&ray) {
            return Some((index, ray, interval));
        }
        *answer = alone::<L, Q>(tree, &ray, interval);
    }
}

#[inline(always)]
fn alone<'a, L: Lanes, Q: Answered<'a>>(tree: &'a WideTree, ray: &TraversalRay, interval: Interval) -> Q::Answer {
    let mut query = Q::new(Asked::new(tree, ray, interval));
    traverse::<L>(&tree.arena, tree.root, ray, interval, &mut query);
    query.answer(ray)
}

#[cfg(all(test, feature = "build"))]
mod tests {
    use std::sync::Arc;

    use geometry::{Shape, TriangleMesh};

    use super::*;
    use crate::wide::{AnyQuery, ClosestQuery, TriangleBlocks, collapse};
    use crate::{BuildConfig, FlatBvh, SimdWidth, WideMesh};

    /// Numbers in [−1, 1): the crate has no random numbers.
    struct Random(u64);

    impl Random {
        fn vector(&mut self) -> Vec3 {
            Vec3::from_array([0; 3].map(|_| {
                self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (self.0 >> 40) as f32 / 8_388_608.0 - 1.0
            }))
        }
    }

    #[test]
    fn interleaved_rays_have_the_answers_of_single_ones() {
        let mut random = Random(5);
        let positions: Vec<Vec3> = (0..400)
            .flat_map(|_| {
                let p = random.vector();
                [p, p + 0.5 * random.vector(), p + 0.5 * random.vector()]
            })
            .collect();
        let mesh = TriangleMesh::new(positions, (0..400).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect());
        let mesh = Arc::new(mesh.expect("in range"));
        let bounds: Vec<_> = (0..mesh.len()).map(|i| mesh.triangle_bounds(i)).collect();
        let bvh = FlatBvh::build(&bounds, &BuildConfig::default(), &()).expect("the default is valid");
        let tree = collapse(&bvh, &TriangleBlocks { mesh: &mesh, order: bvh.order() }).expect("small");
        let wide = WideMesh::build(Arc::clone(&mesh), &BuildConfig::default()).expect("the default is valid");
        // Some of one axis only, which are irregular, some invalid, and some along the same way.
        let rays: Vec<RaySegment> = (0..5000)
            .map(|i| {
                let mut direction = random.vector();
                match i % 10 {
                    0 => direction = Vec3::ZERO.with_x(direction.x),
                    1 => direction.y = [f32::NAN, f32::INFINITY, 0.0][i / 10 % 3],
                    2 => direction = Vec3::ZERO,
                    _ => {}
                }
                let t_max = if i % 3 == 0 { 0.7 } else { f32::INFINITY };
                RaySegment { origin: (1.5 * random.vector()).into(), t_min: 0.0, direction: direction.into(), t_max }
            })
            .collect();
        assert!(!are_coherent(&rays) && are_coherent(&rays[..1]));
        for width in SimdWidth::available() {
            let mut hits = vec![None; rays.len()];
            let mut occluded = vec![true; rays.len()];
            let (tree, rays) = (&tree, &rays);
            width.run(Many::<ClosestQuery> { tree, rays, answers: &mut hits, large: 0, query: PhantomData });
            width.run(Many::<AnyQuery> { tree, rays, answers: &mut occluded, large: 0, query: PhantomData });
            let alone = rays.iter().map(|ray| prepared(ray).and_then(|(ray, interval)| wide.intersect(&ray, interval)));
            let alone: Vec<_> = alone.collect();
            assert_eq!(hits, alone, "{}", width.name());
            assert_eq!(occluded, alone.iter().map(Option::is_some).collect::<Vec<_>>(), "{}", width.name());
            assert!(alone.iter().flatten().count() > 1000 && alone.contains(&None));
        }
    }
}
