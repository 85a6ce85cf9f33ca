//! A mesh in every form that answers, and the rays that it is asked.

use std::sync::Arc;

use bvh_flat::geometry::exact::{TierCounts, intersect_triangle_exact};
use bvh_flat::geometry::glam::{DAffine3, Vec3};
use bvh_flat::geometry::{Hit, Interval, Ray, Shape, Transform, TraversalRay, TriangleMesh, Visit};
use bvh_flat::{BuildConfig, ExactMesh, MeshBvh, SimdWidth, SplitMethod, WideLayout, WideMesh};
use oracle::{ExactTransform, MeshOracle, Oracle, Tally};
use rayon::prelude::*;

use crate::support::Random;

pub fn mesh_of(triangles: impl IntoIterator<Item = [Vec3; 3]>) -> TriangleMesh {
    let positions: Vec<Vec3> = triangles.into_iter().flatten().collect();
    let indices = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    TriangleMesh::new(positions, indices).expect("indices are in range")
}

/// One mesh in every form that answers.
pub struct Answers {
    pub exact: Vec<ExactMesh>,
    /// One of each layout, on the widest and on the portable lanes.
    pub wide: Vec<WideMesh>,
    /// The default tier, of which the same is not expected.
    pub default: MeshBvh,
    pub oracle: MeshOracle,
    /// From the mesh's space to that of the rays.
    pub place: Transform,
}

/// What was found on the way.
#[derive(Clone, Copy, Debug, Default)]
pub struct Findings {
    pub rays: usize,
    pub hits: usize,
    pub ties: usize,
    pub default_is_wrong: usize,
    pub tiers: TierCounts,
}

impl Findings {
    pub fn and(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            hits: self.hits + other.hits,
            ties: self.ties + other.ties,
            default_is_wrong: self.default_is_wrong + other.default_is_wrong,
            tiers: TierCounts {
                filter: self.tiers.filter + other.tiers.filter,
                certificate: self.tiers.certificate + other.tiers.certificate,
                exact: self.tiers.exact + other.tiers.exact,
            },
        }
    }
}

impl Answers {
    pub fn new(mesh: TriangleMesh) -> Self {
        let oracle = MeshOracle::new(&mesh);
        Self::with_oracle(mesh, oracle, Transform::IDENTITY)
    }

    pub fn instance(mesh: TriangleMesh, map: DAffine3) -> Self {
        let oracle = MeshOracle::instance(&mesh, ExactTransform::new(&map).expect("finite"));
        Self::with_oracle(mesh, oracle, Transform::from_affine(map).expect("can be inverted"))
    }

    fn with_oracle(mesh: TriangleMesh, oracle: MeshOracle, place: Transform) -> Self {
        let mesh = Arc::new(mesh);
        let build = |(i, method): (usize, SplitMethod)| {
            let config = BuildConfig::new(method).with_max_primitives_in_leaf([1, 2, 4, 8][i % 4]);
            MeshBvh::build(Arc::clone(&mesh), &config).expect("the configuration is valid")
        };
        let trees: Vec<MeshBvh> = SplitMethod::ALL.into_iter().enumerate().map(build).collect();
        let wide = |(layout, width): (WideLayout, SimdWidth)| {
            WideMesh::new(&trees[1], layout).expect("small enough").with_simd_width(width)
        };
        let wide = WideLayout::ALL.into_iter().zip([SimdWidth::widest(), SimdWidth::PORTABLE]).map(wide).collect();
        Self { exact: trees.iter().map(MeshBvh::exact).collect(), wide, default: trees[0].clone(), oracle, place }
    }

    fn all(&self) -> impl Iterator<Item = &dyn Shape> {
        let wide = self.wide.iter().map(|wide| wide as &dyn Shape);
        self.exact.iter().map(|exact| exact as &dyn Shape).chain(wide)
    }

    /// Every query about one ray and interval, in every tree, against the oracle.
    fn check(&self, ray: &Ray, interval: Interval) -> Findings {
        let Some(local) = TraversalRay::new(ray).and_then(|ray| self.place.ray_to_object(&ray)) else {
            return Findings::default();
        };
        let context = || format!("{ray:?} {interval:?}");
        let below_max = interval.with_t_max(interval.t_max().min(f32::MAX));
        let hits = self.oracle.all_hits(ray, below_max, &mut Tally::default());
        let all: Vec<(u64, u32)> = hits.iter().map(|hit| (hit.primitive, hit.t.to_f32().to_bits())).collect();
        let closest = all.first().copied();
        let mut findings = Findings { rays: 1, hits: usize::from(closest.is_some()), ..Findings::default() };
        findings.ties = usize::from(hits.len() > 1 && hits[0].t == hits[1].t);
        findings.default_is_wrong =
            usize::from(self.default.intersect(&local, interval).map(|h| h.primitive) != closest.map(|c| c.0));

        let (reference, tiers) = self.exact[0].intersect_counted(&local, interval);
        findings.tiers = tiers;
        assert_eq!(reference.map(|hit| (hit.primitive, hit.t.to_bits())), closest, "{}", context());
        for exact in self.all() {
            let hit = exact.intersect(&local, interval);
            let bits = |hit: Hit| (hit.primitive, [hit.t, hit.u, hit.v].map(f32::to_bits));
            assert_eq!(hit.map(bits), reference.map(bits), "{}", context());
            assert_eq!(exact.intersect_p(&local, interval), closest.is_some(), "{}", context());
            let mut visited = Vec::new();
            let _ = exact.visit_hits(&local, interval, &mut |hit: Hit| {
                visited.push((hit.primitive, hit.t.to_bits()));
                Visit::Continue(interval.t_max())
            });
            visited.sort_unstable_by_key(|&(primitive, t)| (t, primitive));
            let mut expected = all.clone();
            expected.sort_unstable_by_key(|&(primitive, t)| (t, primitive));
            assert_eq!(visited, expected, "{}", context());
        }
        if let Some(hit) = reference {
            assert!(hit.u >= 0.0 && hit.v >= 0.0 && hit.u + hit.v <= 1.0 + f32::EPSILON, "{hit:?} {}", context());
            let vertices = self.exact[0].mesh().vertices(hit.primitive as usize);
            let alone = intersect_triangle_exact(&local, &vertices, interval).expect("the triangle is hit");
            assert_eq!((alone.t, alone.u, alone.v), (hit.t, hit.u, hit.v), "{}", context());
        }
        findings
    }

    /// The ray, and the ray with the f32 next to the closest t* as either end of the interval.
    fn check_with_ends(&self, ray: &Ray) -> Findings {
        let findings = self.check(ray, Interval::FULL);
        let closest = self.oracle.closest(ray, Interval::up_to(f32::MAX), &mut Tally::default());
        let Some(t) = closest.map(|closest| closest.t.to_f32()) else { return findings };
        let up_to = |t: f32| self.check(ray, Interval::up_to(t));
        let from = |t: f32| self.check(ray, Interval::new(t, f32::INFINITY));
        findings.and(up_to(t)).and(up_to(t.next_up())).and(from(t)).and(from(t.next_down().max(0.0)))
    }
}

/// `count` rays of each kind: at the inside, at edges, at vertices, at corners of nodes, along axes, along edges and in
/// planes, and at random.
pub fn aimed(
    mesh: &ExactMesh,
    count: usize,
    seed: u64,
    mut origin: impl FnMut(&mut Random, usize) -> Vec3,
) -> Vec<Ray> {
    let mut random = Random::new(seed);
    let nodes = mesh.bvh().nodes();
    let mut rays = Vec::new();
    for i in 0..8 * count {
        let v = mesh.mesh().vertices(random.below(mesh.mesh().len()));
        let o = origin(&mut random, i);
        let s = random.unit();
        let target = match i % 8 {
            0 => v[0] + 0.5 * s * (v[1] - v[0]) + 0.4 * (v[2] - v[0]),
            1 | 2 => v[0].lerp(v[1], s),
            3 | 4 => v[random.below(3)],
            5 => nodes[random.below(nodes.len())].bounds().corners()[random.below(8)],
            6 => {
                let axis = random.below(3);
                let mut start = v[random.below(3)];
                start[axis] = o[axis];
                let mut direction = Vec3::ZERO;
                direction[axis] = if random.below(2) == 0 { 1.0 } else { -1.0 };
                rays.push(Ray::new(start, direction));
                continue;
            }
            _ => {
                // From a vertex or beyond it along an edge: in the planes of all triangles there.
                rays.push(Ray::new(v[0] - (v[1] - v[0]) * [0.0, 1.0, 0.5][random.below(3)], v[1] - v[0]));
                continue;
            }
        };
        rays.push(Ray::new(o, target - o));
    }
    rays
}

pub fn check_all(answers: &Answers, rays: &[Ray], ends: bool) -> Findings {
    let check = |ray: &Ray| if ends { answers.check_with_ends(ray) } else { answers.check(ray, Interval::FULL) };
    rays.par_iter().map(check).reduce(Findings::default, Findings::and)
}

pub fn star(subdivisions: u32, spikes: f64, seed: u64) -> TriangleMesh {
    let mut random = Random::new(seed);
    scene::meshes::icosphere(subdivisions, |_| 1.0 + spikes * f64::from(random.unit())).expect("a mesh")
}
