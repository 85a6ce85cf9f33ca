//! The exact tier must answer as real arithmetic does: without any exception, on what is hardest.

mod answers;

use bvh_flat::geometry::glam::{DAffine3, DMat3, DVec3, Vec3};
use bvh_flat::geometry::{Ray, TraversalRay, TriangleMesh};

use self::answers::{Answers, Findings, aimed, check_all, mesh_of, star};
use crate::support::Random;

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
    let positions: Vec<Vec3> = sphere.positions().iter().map(|p| (4.0 * p).round()).collect();
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
        // Each layer is the first with some coordinates moved, or folded about its first edge; two of them are the
        // same.
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
        let positions: Vec<Vec3> = sphere.positions().iter().map(|p| factor(scale) * p).collect();
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
        let answers = Answers::instance(star(2, 0.5, 37), DAffine3 { matrix3: linear, translation });
        let (rays, rounded) = through_the_map(&answers, 250, i as u64, [1.0; 2]);
        moved += rounded;
        all = all.and(check_all(&answers, &rays, true));
    }
    assert!(all.hits > 2_000 && moved > 1_000, "{moved} {all:?}");
}

/// Instances in whose space the direction is of the order of the least number of f32, or has components that are: what
/// f32 has of it is up to half a unit off, and the largest component of the f64 direction is what counts.
#[test]
fn denormal_directions_in_instances() {
    let (mut all, mut rounded) = (Findings::default(), 0);
    for (i, exponent) in (-149..=-125).step_by(2).enumerate() {
        // The mesh is so small in its own space that t is in the range of f32, and of the size 1 in the world.
        let (small, large) = (2.0_f64.powi(-24), 2.0_f64.powi(24));
        let sphere = star(2, 0.5, 43);
        let positions: Vec<Vec3> = sphere.positions().iter().map(|p| small as f32 * p).collect();
        let mesh = TriangleMesh::new(positions, sphere.triangles().to_vec()).expect("indices are in range");
        let answers = Answers::instance(mesh, DAffine3::from_scale(DVec3::splat(large)));
        // The direction in the world is a normal number, and 2²⁴ times that in the mesh's space.
        let (rays, off) = through_the_map(&answers, 30, i as u64, [small, 2.0_f64.powi(exponent) * large]);
        rounded += off;
        all = all.and(check_all(&answers, &rays, true));
    }
    assert!(all.hits > 3_000 && rounded > 1_000, "{rounded} {all:?}");
}

/// `count` rays of the world of each kind at the mesh of an instance, that come from within three times `size` in its
/// space; those that f64 holds exactly there, which is what the oracle knows, and how many of them f32 does not hold.
/// Their directions are scaled by `speed`.
fn through_the_map(answers: &Answers, count: usize, seed: u64, [size, speed]: [f64; 2]) -> (Vec<Ray>, usize) {
    let place = answers.place;
    assert_eq!(place.matrix().matrix3 * place.inverse_matrix().matrix3, DMat3::IDENTITY);
    let mut rounded = 0;
    let rays = aimed(&answers.exact[0], count, seed, |r, _| 3.0 * size as f32 * r.vector())
        .iter()
        .map(|local| {
            // Aimed in world space, where vertices are rounded: the ray passes them closely.
            let (from, to) = (local.origin.as_dvec3(), (local.origin + local.direction).as_dvec3());
            let origin = place.point(from).as_vec3();
            Ray::new(origin, (speed * (place.point(to) - origin.as_dvec3())).as_vec3())
        })
        .filter(|ray| {
            let Some(world) = TraversalRay::new(ray) else { return false };
            let Some(local) = place.ray_to_object(&world) else { return false };
            rounded += usize::from(local.is_rounded());
            place.point(local.origin64()) == ray.origin.as_dvec3()
                && place.vector(local.direction64()) == ray.direction.as_dvec3()
        })
        .collect();
    (rays, rounded)
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
