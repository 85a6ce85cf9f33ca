use std::sync::Arc;

use geometry::{Hit, Shape, TriangleMesh};

use super::*;
use crate::wide::triangles::Layout;
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

/// A mesh, with a tree of each layout.
struct Trees {
    wide: WideMesh,
    blocks: Triangles,
    compact: Triangles,
}

impl Trees {
    fn new(mesh: TriangleMesh) -> Self {
        let mesh = Arc::new(mesh);
        let bounds: Vec<_> = (0..mesh.len()).map(|i| mesh.triangle_bounds(i)).collect();
        let bvh = FlatBvh::build(&bounds, &BuildConfig::default(), &()).expect("the default is valid");
        let (nodes, order) = (bvh.nodes(), bvh.order());
        let blocks = collapse::<FullNode>(nodes, false, &TriangleWriter::<Blocks>::new(&mesh, order, false), &());
        let compact = collapse::<CompactNode>(nodes, false, &TriangleWriter::<Compact>::new(&mesh, order, false), &());
        let triangles = |tree: Option<_>| Triangles { mesh: Arc::clone(&mesh), tree: tree.expect("small") };
        let (blocks, compact) = (triangles(blocks.ok()), triangles(compact.ok()));
        let wide = WideMesh::build(mesh, &BuildConfig::default()).expect("the default is valid");
        Self { wide, blocks, compact }
    }

    /// Triangles in a cube of 3.
    fn soup(random: &mut Random) -> Self {
        let positions: Vec<Vec3> = (0..400)
            .flat_map(|_| {
                let p = random.vector();
                [p, p + 0.5 * random.vector(), p + 0.5 * random.vector()]
            })
            .collect();
        let mesh = TriangleMesh::new(positions, (0..400).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect());
        Self::new(mesh.expect("in range"))
    }

    /// Squares of 1, up to 32 in x and y, in the plane z = 8: rays through whole numbers meet vertices. And all of them
    /// again, with every third vertex an ulp closer or further.
    fn lattice() -> Self {
        let z = |copy: u32, i: u32| {
            if copy == 0 { 8.0 } else { [8.0, 8.0_f32.next_up(), 8.0_f32.next_down()][i as usize % 3] }
        };
        let vertices = |copy: u32| (0..33 * 33).map(move |i| Vec3::new((i % 33) as f32, (i / 33) as f32, z(copy, i)));
        let positions: Vec<Vec3> = vertices(0).chain(vertices(1)).collect();
        let triangles = (0..2 * 32 * 32).flat_map(|i| {
            let vertex = |x: u32, y: u32| 33 * 33 * (i / 1024) + 33 * (i / 32 % 32 + y) + i % 32 + x;
            let [a, b, c, d] = [vertex(0, 0), vertex(1, 0), vertex(1, 1), vertex(0, 1)];
            [[a, b, c], [c, d, a]]
        });
        Self::new(TriangleMesh::new(positions, triangles.collect()).expect("in range"))
    }

    /// All answers in one call, by every width and layout, are those of one ray after the other; how many rays hit.
    fn check(&self, rays: &[RaySegment]) -> usize {
        let alone =
            rays.iter().map(|ray| prepared(ray).and_then(|(ray, interval)| self.wide.intersect(&ray, interval)));
        let alone: Vec<_> = alone.collect();
        for width in SimdWidth::available() {
            check::<Blocks>(&self.blocks, rays, &alone, width);
            check::<Compact>(&self.compact, rays, &alone, width);
        }
        alone.iter().flatten().count()
    }
}

fn check<Y: Layout>(triangles: &Triangles, rays: &[RaySegment], alone: &[Option<Hit>], width: SimdWidth) {
    check_query::<ClosestQuery<Y>>(triangles, rays, alone, width);
    let is_hit: Vec<_> = alone.iter().map(Option::is_some).collect();
    check_query::<AnyQuery<Y>>(triangles, rays, &is_hit, width);
}

fn check_query<'a, Q: Answered<'a>>(
    triangles: &'a Triangles,
    rays: &[RaySegment],
    alone: &[Q::Answer],
    width: SimdWidth,
) where
    Q::Answer: Clone + PartialEq + std::fmt::Debug,
{
    let mut answers = vec![Q::Answer::default(); rays.len()];
    answer_many::<Q>(triangles, width, 0, rays, &mut answers);
    assert_eq!(answers, alone, "{}", width.name());
    // All of them in packets, whether or not that pays; and all in turns.
    answers.fill(Q::Answer::default());
    let (answers_to, query) = (&mut answers, PhantomData::<Q>);
    let count = width.run(Together { triangles, width, rays, answers: answers_to, worthwhile: 0.0, query });
    assert_eq!((count, &answers[..]), (rays.len(), alone), "together, {}", width.name());
    answers.fill(Q::Answer::default());
    let (answers_to, root) = (&mut answers, triangles.tree.root.expect("not empty"));
    width.run(Interleaved { triangles, width, root, rays, answers: answers_to, query });
    assert_eq!(answers, alone, "interleaved, {}", width.name());
}

/// Pixel i of an image so many tiles wide, of 8 × 8 pixels each.
fn in_tiles(i: u32, tiles: u32) -> [u32; 2] {
    let (tile, i) = (i / 64, i % 64);
    [8 * (tile % tiles) + i % 8, 8 * (tile / tiles) + i / 8]
}

#[test]
fn interleaved_rays_have_the_answers_of_single_ones() {
    let mut random = Random(5);
    let trees = Trees::soup(&mut random);
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
    assert!(gains(&trees.blocks.tree, &rays, true) && !gains(&trees.blocks.tree, &rays[..1], true));
    let hits = trees.check(&rays);
    assert!((1000..4000).contains(&hits), "{hits}");
}

/// From a point and side by side, across octants and largest axes, with single rays among them that are not valid, run
/// along an axis or end early, and a last packet that is not full.
#[test]
fn rays_that_go_together_have_the_answers_of_single_ones() {
    let trees = Trees::soup(&mut Random(7));
    for from_a_point in [true, false] {
        for eye in [Vec3::new(0.0, 0.0, -3.0), Vec3::new(2.5, -2.0, 0.25), Vec3::new(0.0, 4.0, 0.0)] {
            let forward = -eye.normalize();
            let side = forward.any_orthonormal_vector();
            let up = side.cross(forward);
            let ray = |i: u32| {
                let [x, y] = in_tiles(i, 20).map(|x| x as f32 / 80.0 - 1.0);
                let offset = x * side + y * up;
                let (mut origin, mut direction) =
                    if from_a_point { (eye, forward + 0.7 * offset) } else { (eye + 2.0 * offset, forward) };
                let (mut t_min, mut t_max) = (0.0, f32::INFINITY);
                match i % 61 {
                    0 => direction = Vec3::ZERO.with_z(direction.z),
                    7 => origin.x = f32::NAN,
                    20 => t_max = eye.length(),
                    21 => t_max = -1.0,
                    33 => t_min = eye.length(),
                    _ => {}
                }
                RaySegment { origin: origin.into(), t_min, direction: direction.into(), t_max }
            };
            let rays: Vec<RaySegment> = (0..160 * 160 - 13).map(ray).collect();
            let hits = trees.check(&rays);
            assert!(hits > 4000, "{hits}");
        }
    }
}

/// Where f32 decides little. A ray meets a vertex or an edge, or the inside of two triangles, and several triangles at
/// the same t or an ulp apart, where many of the intervals end.
#[test]
fn rays_together_through_vertices_have_the_answers_of_single_ones() {
    let trees = Trees::lattice();
    for ends in [[0.0, 2.0], [0.0, 1.0], [1.0, 2.0], [0.0, 1.0_f32.next_up()], [1.0_f32.next_down(), 1.0]] {
        let ray = |i: u32| {
            // A half of the tiles is shifted off the edges.
            let [x, y] = in_tiles(i, 8).map(|x| x as f32 / 2.0 + 0.2 * (i / 64 % 2) as f32);
            let direction = Vec3::new(x + 4.0, y + 2.0, 8.0);
            RaySegment { origin: [-4.0, -2.0, 0.0], t_min: ends[0], direction: direction.into(), t_max: ends[1] }
        };
        let rays: Vec<RaySegment> = (0..64 * 64).map(ray).collect();
        let hits = trees.check(&rays);
        assert!((200..=rays.len()).contains(&hits), "{hits}");
    }
}
