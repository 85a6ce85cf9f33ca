//! Many rays in one call: one after the other, or several on their way at once.

use std::marker::PhantomData;

use geometry::glam::Vec3;
use geometry::{Interval, Ray, TraversalRay};

use super::arena::Child;
use super::box_ray::is_regular;
use super::collapse::WideTree;
use super::queries::{Answered, Asked, answer};
use super::traverse::{Next, Way, WayStack};
use super::triangles::{Layout, Triangles};
use crate::RaySegment;
use crate::simd::{Kernel, Lanes};

/// How many rays are on their way at once. On a tree of 149 MB, 6 gave 0.93 and 16 gave 0.91 of the speed of 10.
const FLIGHTS: usize = 10;

/// How many rays are looked at to choose how they are traced.
const CHUNK: usize = 4096;

/// The least tree, in bytes, for which rays may be interleaved: what the caches do not hold. Of a tree of 9 MB interleaving
/// takes 5 % of the speed, whatever the rays.
pub(crate) const LARGE: usize = 16 << 20;

/// From how many expected steps of a random ray on rays are interleaved that begin together and go apart: closest hit, and
/// any hit, which ends sooner.
///
/// What interleaving gave them (Mray/s before and after, one core of an AMD EPYC with 1 MiB of L2, 2026-11-25): kitchen, 11
/// steps, 4.6 and 4.2; black-forest, 9 steps, 2.9 and 2.4; dragon, 18 steps, 3.7 and 4.2; a hairball of 2.9 M triangles,
/// 116 steps, 0.91 and 1.25. For any hit: hall, 13 steps, 7.3 and 5.3; dragon 3.9 and 3.8; the hairball 1.1 and 1.6.
/// Of rays that also begin apart: dragon 2.2 and 4.0, terrain-rainier 3.0 and 5.0, the hairball 0.67 and 1.1; but kitchen 7.7
/// and 6.8. Of coherent rays it takes 10 % on every tree.
const MANY_STEPS: [f64; 2] = [15.0, 50.0];

/// The mean cosine between the directions of neighbouring rays above which they go the same way.
const SAME_WAY: f32 = 0.9;

/// The mean distance between the origins of neighbouring rays, as a part of the tree's diagonal, below which they begin
/// together.
const TOGETHER: f32 = 0.1;

/// A query `Q` of many rays.
pub(crate) struct Many<'a, 'r, Q: Answered<'a>> {
    pub(crate) triangles: &'a Triangles,
    pub(crate) rays: &'r [RaySegment],
    pub(crate) answers: &'r mut [Q::Answer],
    /// The least tree for which rays may be interleaved: [`LARGE`], but for tests.
    pub(crate) large: usize,
    pub(crate) query: PhantomData<Q>,
}

impl<'a, Q: Answered<'a>> Kernel for Many<'a, '_, Q> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { triangles, rays, answers, large, .. } = self;
        let tree = &triangles.tree;
        for (rays, answers) in rays.chunks(CHUNK).zip(answers.chunks_mut(CHUNK)) {
            match tree.root {
                Some(root) if tree.arena.memory() >= large && gains(tree, rays, Q::ORDERED) => {
                    interleaved::<L, Q>(triangles, root, rays, answers);
                }
                _ => one_by_one::<L, Q>(triangles, rays, answers),
            }
        }
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
    let begin_together = distances <= TOGETHER * count * tree.bounds.diagonal().length();
    let many = MANY_STEPS[usize::from(!is_closest)];
    !go_the_same_way && (!begin_together || tree.expected_steps >= many)
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
    stack: WayStack,
}

#[inline(always)]
fn one_by_one<'a, L: Lanes, Q: Answered<'a>>(triangles: &'a Triangles, rays: &[RaySegment], answers: &mut [Q::Answer]) {
    for (ray, to) in rays.iter().zip(answers) {
        *to = Q::Answer::default();
        if let Some((ray, interval)) = prepared(ray) {
            *to = answer::<L, Q>(triangles, &ray, interval);
        }
    }
}

/// Each ray in turn goes down a step, to a node or a leaf that was asked for when it was last its turn: while one waits for
/// the memory, others go on. A step back leads to what was asked for before, and needs no turn: waiting for those too took
/// 7 % of the speed on 149 MB, and 9 % on 4 MB.
#[inline(always)]
fn interleaved<'a, L: Lanes, Q: Answered<'a>>(
    triangles: &'a Triangles,
    root: Child,
    rays: &[RaySegment],
    answers: &mut [Q::Answer],
) {
    let mut next_ray = 0;
    let mut flights: Vec<Flight<L, Q>> = Vec::with_capacity(FLIGHTS);
    while flights.len() < FLIGHTS
        && let Some((index, ray, interval)) = next_regular::<L, Q>(triangles, rays, answers, &mut next_ray)
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
                match next_regular::<L, Q>(triangles, rays, answers, &mut next_ray) {
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

/// The next ray that may be on its way with others; those before it that may not are answered.
#[inline(always)]
fn next_regular<'a, L: Lanes, Q: Answered<'a>>(
    triangles: &'a Triangles,
    rays: &[RaySegment],
    answers: &mut [Q::Answer],
    next: &mut usize,
) -> Option<(usize, TraversalRay, Interval)> {
    loop {
        let index = *next;
        let (ray, to) = (rays.get(index)?, answers.get_mut(index)?);
        *next += 1;
        *to = Q::Answer::default();
        let Some((ray, interval)) = prepared(ray) else { continue };
        if is_regular(&ray) {
            return Some((index, ray, interval));
        }
        *to = answer::<L, Q>(triangles, &ray, interval);
    }
}

#[cfg(all(test, feature = "build"))]
mod tests {
    use std::sync::Arc;

    use geometry::{Hit, Shape, TriangleMesh};

    use super::*;
    use crate::wide::{AnyQuery, Blocks, ClosestQuery, Compact, CompactNode, FullNode, TriangleWriter, collapse};
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
        let (nodes, order) = (bvh.nodes(), bvh.order());
        let blocks = collapse::<FullNode>(nodes, false, &TriangleWriter::<Blocks>::new(&mesh, order, false));
        let compact = collapse::<CompactNode>(nodes, false, &TriangleWriter::<Compact>::new(&mesh, order, false));
        let triangles = |tree: Option<_>| Triangles { mesh: Arc::clone(&mesh), tree: tree.expect("small") };
        let (blocks, compact) = (triangles(blocks), triangles(compact));
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
        assert!(gains(&blocks.tree, &rays, true) && !gains(&blocks.tree, &rays[..1], true));
        let alone = rays.iter().map(|ray| prepared(ray).and_then(|(ray, interval)| wide.intersect(&ray, interval)));
        let alone: Vec<_> = alone.collect();
        assert!(alone.iter().flatten().count() > 1000 && alone.contains(&None));
        for width in SimdWidth::available() {
            check::<Blocks>(&blocks, &rays, &alone, width);
            check::<Compact>(&compact, &rays, &alone, width);
        }
    }

    fn check<Y: Layout>(triangles: &Triangles, rays: &[RaySegment], alone: &[Option<Hit>], width: SimdWidth) {
        let mut hits = vec![None; rays.len()];
        let mut occluded = vec![true; rays.len()];
        let (answers, query) = (&mut hits, PhantomData::<ClosestQuery<Y>>);
        width.run(Many { triangles, rays, answers, large: 0, query });
        let (answers, query) = (&mut occluded, PhantomData::<AnyQuery<Y>>);
        width.run(Many { triangles, rays, answers, large: 0, query });
        assert_eq!(hits, alone, "{}", width.name());
        assert_eq!(occluded, alone.iter().map(Option::is_some).collect::<Vec<_>>(), "{}", width.name());
    }
}
