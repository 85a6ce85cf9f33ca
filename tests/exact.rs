//! The exact tier must answer as real arithmetic does: without any exception, on what is hardest.

use std::sync::Arc;

use bvh_flat::geometry::exact::{TierCounts, intersect_triangle_exact};
use bvh_flat::geometry::glam::{DAffine3, DMat3, DVec3, Vec3};
use bvh_flat::geometry::{Hit, Interval, Ray, Shape, Transform, TraversalRay, TriangleMesh, Visit};
use bvh_flat::{BuildConfig, ExactMesh, MeshBvh, SplitMethod};
use oracle::{ExactTransform, MeshOracle, Oracle, Tally};
use rayon::prelude::*;

use crate::support::Random;

fn mesh_of(triangles: impl IntoIterator<Item = [Vec3; 3]>) -> TriangleMesh {
    let positions: Vec<Vec3> = triangles.into_iter().flatten().collect();
    let indices = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    TriangleMesh::new(positions, indices).expect("indices are in range")
}

/// One mesh in every form that answers.
struct Answers {
    exact: Vec<ExactMesh>,
    /// The default tier, of which the same is not expected.
    default: MeshBvh,
    oracle: MeshOracle,
    /// From the mesh's space to that of the rays.
    place: Transform,
}

/// What was found on the way.
#[derive(Clone, Copy, Debug, Default)]
struct Findings {
    rays: usize,
    hits: usize,
    ties: usize,
    default_is_wrong: usize,
    tiers: TierCounts,
}

impl Findings {
    fn and(self, other: Self) -> Self {
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
    fn new(mesh: TriangleMesh) -> Self {
        let oracle = MeshOracle::new(&mesh);
        Self::with_oracle(mesh, oracle, Transform::IDENTITY)
    }

    fn instance(mesh: TriangleMesh, map: DAffine3) -> Self {
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
        Self { exact: trees.iter().map(MeshBvh::exact).collect(), default: trees[0].clone(), oracle, place }
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
        for exact in &self.exact {
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
fn aimed(mesh: &ExactMesh, count: usize, seed: u64, mut origin: impl FnMut(&mut Random, usize) -> Vec3) -> Vec<Ray> {
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

fn check_all(answers: &Answers, rays: &[Ray], ends: bool) -> Findings {
    let check = |ray: &Ray| if ends { answers.check_with_ends(ray) } else { answers.check(ray, Interval::FULL) };
    rays.par_iter().map(check).reduce(Findings::default, Findings::and)
}

fn star(subdivisions: u32, spikes: f64, seed: u64) -> TriangleMesh {
    let mut random = Random::new(seed);
    scene::meshes::icosphere(subdivisions, |_| 1.0 + spikes * f64::from(random.unit())).expect("a mesh")
}

/// T01, T02, T03, S04, S16: closed meshes, never leaking, and the right triangle at every edge.
#[test]
fn closed_meshes() {
    let mut all = Findings::default();
    for (subdivisions, spikes) in [(0, 0.0), (2, 0.3), (3, 3.0), (3, 300.0)] {
        let answers = Answers::new(star(subdivisions, spikes, 5));
        let rays =
            aimed(&answers.exact[0], 200, 1, |r, i| if i % 2 == 0 { 0.3 * r.vector() } else { 3.0 * r.vector() });
        all = all.and(check_all(&answers, &rays, true));
        let inside: Vec<Ray> = rays.iter().filter(|ray| ray.origin.length() < 0.5).copied().collect();
        let hits = check_all(&answers, &inside, false).hits;
        assert!(hits == inside.len() && hits > 300, "a closed mesh leaks: {hits} of {}", inside.len());
    }
    assert!(all.rays > 25_000 && all.default_is_wrong > 500 && all.ties > 100, "{all:?}");
    assert!(all.tiers.filter > 5 * all.tiers.exact && all.tiers.exact > 10_000, "{all:?}");
}

/// T05: everything is exactly zero.
#[test]
fn lattices() {
    let mut random = Random::new(8);
    let mut point = || Vec3::new(random.below(5) as f32, random.below(5) as f32, random.below(5) as f32);
    let soup = mesh_of((0..150).map(|_| [point(), point(), point()]));
    let sphere = star(2, 1.0, 3);
    let positions = sphere.positions().iter().map(|p| (4.0 * p).round()).collect();
    let rounded = TriangleMesh::new(positions, sphere.triangles().to_vec()).expect("indices are in range");
    let mut all = Findings::default();
    for mesh in [soup, rounded] {
        let answers = Answers::new(mesh);
        let rays = aimed(&answers.exact[0], 150, 2, |r, _| (6.0 * r.vector()).round());
        all = all.and(check_all(&answers, &rays, true));
    }
    assert!(all.ties > 2_000 && all.tiers.exact > 20_000, "{all:?}");
}

/// T06, T08, T23: needles and slivers, some without any area.
#[test]
fn needles_and_slivers() {
    let mut random = Random::new(11);
    let triangles = (0..200).map(|i| {
        let (a, b) = (random.vector(), random.vector());
        let width = 10.0_f32.powi(-(i % 12));
        match i % 5 {
            0 => [a, b, a.midpoint(b)],
            1 => [a, a, b],
            2 => [a, a, a],
            _ => [a, b, b + width * random.vector()],
        }
    });
    let answers = Answers::new(mesh_of(triangles.collect::<Vec<_>>()));
    let rays = aimed(&answers.exact[0], 300, 3, |r, _| 2.0 * r.vector());
    let all = check_all(&answers, &rays, true);
    assert!(all.hits > 1_000 && all.tiers.exact > 500, "{all:?}");
}

/// S18, T20: planes an ulp apart that cross each other, and double layers 1 to 4 ulp apart.
#[test]
fn near_ties() {
    let mut random = Random::new(13);
    let mut all = Findings::default();
    for i in 0..200 {
        let mut v = [random.vector(), random.vector(), random.vector()];
        if i % 3 == 0 {
            v = v.map(|p| p + Vec3::splat(1_000.0));
        }
        let ulps = 1 + random.below(4);
        let mut moved = |x: f32| match random.below(3) {
            0 => (0..ulps).fold(x, |x, _| x.next_up()),
            1 => (0..ulps).fold(x, |x, _| x.next_down()),
            _ => x,
        };
        // Each layer is the first with some coordinates moved, or folded about its first edge; two of them are the same.
        let is_fold = i % 2 == 0;
        let mut layers = vec![v];
        for _ in 0..4 {
            let mut layer = v;
            for p in layer.iter_mut().skip(if is_fold { 2 } else { 0 }) {
                *p = Vec3::from_array(p.to_array().map(&mut moved));
            }
            layers.push(layer);
        }
        layers.push(layers[2]);
        let answers = Answers::new(mesh_of(layers));
        let rays: Vec<Ray> = (0..60)
            .map(|j| {
                // Beside the fold their t* differ by less than f64 can tell.
                let t = random.unit() * if is_fold && j % 3 != 0 { 1e-6 } else { 1.0 };
                let target = v[0].lerp(v[1], random.unit()).lerp(v[2], t);
                let origin = if j % 2 == 0 { v[0] + 3.0 * random.vector() } else { 9.0 * random.vector() };
                Ray::new(origin, target - origin)
            })
            .collect();
        all = all.and(check_all(&answers, &rays, false));
    }
    assert!(all.hits > 5_000 && all.default_is_wrong > 500 && all.tiers.exact > 500, "{all:?}");
}

/// T07, T19, B14: scales from the denormal numbers to the largest, of the mesh and of the direction.
#[test]
fn all_scales() {
    let mut all = Findings::default();
    for (i, scale) in [-148, -140, -126, -100, -60, -30, 0, 30, 58].into_iter().enumerate() {
        let sphere = star(2, 0.5, 17);
        let factor = |e: i32| 2.0_f64.powi(e) as f32;
        let positions = sphere.positions().iter().map(|p| factor(scale) * p).collect();
        let mesh = TriangleMesh::new(positions, sphere.triangles().to_vec()).expect("indices are in range");
        let answers = Answers::new(mesh);
        let mut rays = aimed(&answers.exact[0], 70, i as u64, |r, _| factor(scale) * 2.0 * r.vector());
        for (j, ray) in rays.iter_mut().enumerate() {
            let e = [0, -scale, 60, -60, -scale - 20][j % 5];
            ray.direction = (ray.direction.as_dvec3() * 2.0_f64.powi(e)).as_vec3();
        }
        all = all.and(check_all(&answers, &rays, true));
    }
    assert!(all.hits > 10_000, "{all:?}");
}

/// Every exponent of the domain in one triangle, which takes the largest integers.
#[test]
fn all_exponents_at_once() {
    let mut random = Random::new(19);
    let mut all = Findings::default();
    for _ in 0..150 {
        let mut wild = |low: i32, high: i32| {
            let e = low + random.below((high - low) as usize) as i32;
            (f64::from(1.0 + random.unit()) * 2.0_f64.powi(e)) as f32 * [1.0, -1.0, 0.0, 1.0, -1.0][random.below(5)]
        };
        let mut vector = |low: i32, high: i32| Vec3::new(wild(low, high), wild(low, high), wild(low, high));
        let triangles: Vec<[Vec3; 3]> = (0..6).map(|_| [0; 3].map(|_| vector(-149, 59))).collect();
        let origins: Vec<Vec3> = (0..40).map(|i| vector(-149, if i % 4 == 0 { 127 } else { 59 })).collect();
        let answers = Answers::new(mesh_of(triangles));
        let mut origins = origins.into_iter().cycle();
        let mut rays = aimed(&answers.exact[0], 5, 23, |_, _| origins.next().expect("it cycles"));
        for ray in &mut rays {
            ray.direction = if ray.direction.is_finite() { ray.direction } else { Vec3::X };
        }
        all = all.and(check_all(&answers, &rays, false));
    }
    assert!(all.rays > 4_000 && all.hits > 500 && all.tiers.exact > 500, "{all:?}");
}

/// T09, T14, T15: origins on the surface and an ulp beside it, rays in planes.
#[test]
fn origins_on_the_surface() {
    let answers = Answers::new(star(2, 0.5, 29));
    let mut random = Random::new(31);
    let rays: Vec<Ray> = (0..6_000)
        .map(|i| {
            let v = answers.exact[0].mesh().vertices(random.below(answers.exact[0].mesh().len()));
            let mut origin = [v[0], v[0].lerp(v[1], random.unit()), (v[0] + v[1] + v[2]) / 3.0][i % 3];
            if random.below(2) == 0 {
                let axis = random.below(3);
                origin[axis] = if random.below(2) == 0 { origin[axis].next_up() } else { origin[axis].next_down() };
            }
            let direction = [random.vector(), v[1] - v[0], v[2] - origin, random.vector()][i % 4];
            Ray::new(origin, direction)
        })
        .collect();
    let all = check_all(&answers, &rays, false);
    assert!(all.hits > 2_000 && all.tiers.exact > 2_000, "{all:?}");
}

/// Instances whose inverse is exact, and so the f64 ray in their space: the f32 ray is another one.
#[test]
fn instances() {
    let columns = |x: [f64; 3], y: [f64; 3], z: [f64; 3]| DMat3::from_cols(x.into(), y.into(), z.into());
    let maps = [
        (columns([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]), DVec3::new(1e4, -3e5, 0.1_f32.into())),
        (columns([0.0, 0.25, 0.0], [0.0, 0.0, -0.25], [4.0, 0.0, 0.0]), DVec3::new(123.0, 0.0, -77.0)),
        (columns([1.0, 2.0, 0.0], [0.0, 1.0, 0.0], [3.0, 0.0, 1.0]), DVec3::new(0.0, 5e6, 1.0)),
    ];
    let mut all = Findings::default();
    let mut moved = 0;
    for (i, (linear, translation)) in maps.into_iter().enumerate() {
        let mesh = star(2, 0.5, 37);
        let map = DAffine3 { matrix3: linear, translation };
        let answers = Answers::instance(mesh, map);
        let place = answers.place;
        assert_eq!(linear * place.inverse_matrix().matrix3, DMat3::IDENTITY);
        let rays: Vec<Ray> = aimed(&answers.exact[0], 250, i as u64, |r, _| 3.0 * r.vector())
            .iter()
            .map(|local| {
                // Aimed in world space, where vertices are rounded: the ray passes them closely.
                let (from, to) = (local.origin.as_dvec3(), (local.origin + local.direction).as_dvec3());
                let origin = place.point(from).as_vec3();
                Ray::new(origin, (place.point(to) - origin.as_dvec3()).as_vec3())
            })
            .filter(|ray| {
                // Only where f64 holds the transformed ray exactly, which is what the oracle knows.
                let Some(world) = TraversalRay::new(ray) else { return false };
                let Some(local) = place.ray_to_object(&world) else { return false };
                moved += usize::from(local.origin64() != local.ray().origin.as_dvec3());
                place.point(local.origin64()) == ray.origin.as_dvec3()
                    && place.vector(local.direction64()) == ray.direction.as_dvec3()
            })
            .collect();
        all = all.and(check_all(&answers, &rays, true));
    }
    assert!(all.hits > 2_000 && moved > 1_000, "{moved} {all:?}");
}

/// What is not a number, infinite or too far away is never hit, and moves no index.
#[test]
fn inactive_triangles() {
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30];
    let mut random = Random::new(41);
    let triangles = (0..60).map(|i| {
        let mut v = [random.vector(), random.vector(), random.vector()];
        if i % 3 == 0 {
            v[i / 3 % 3][i % 3] = bad[i / 3 % 4];
        }
        v
    });
    let answers = Answers::new(mesh_of(triangles.collect::<Vec<_>>()));
    let rays: Vec<Ray> = (0..2_000).map(|_| Ray::new(2.0 * random.vector(), random.vector())).collect();
    let all = check_all(&answers, &rays, false);
    assert!(all.hits > 200, "{all:?}");
    for mesh in [mesh_of([]), mesh_of([[Vec3::NAN; 3]])] {
        let empty = Answers::new(mesh);
        assert_eq!(check_all(&empty, &rays[..50], false).hits, 0);
    }
}
