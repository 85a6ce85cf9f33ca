//! S01, S02, S03, S05, S13: rays in the faces of boxes, and from them.

use std::sync::Arc;

use bvh_flat::{FlatBvh, MeshBvh};
use geometry::glam::{Vec2, Vec3};
use geometry::{Hit, HitVisitor, Interval, Ray, Shape, TraversalRay, Visit, Work};

use super::judge::Judge;
use crate::build::meshes::{cuboid, mesh_of};
use crate::build::sweep::configs;
use crate::{Outcome, Random, Run, Tries};

/// Vectors with each component from `values`.
fn lattice(values: &[f32]) -> impl Iterator<Item = Vec3> {
    let n = values.len();
    let component = move |i: usize| values[i % n];
    (0..n.pow(3)).map(move |i| Vec3::new(component(i), component(i / n), component(i / n / n)))
}

/// Directions along axes and face diagonals: those with a zero.
fn directions_with_zeros() -> impl Iterator<Item = Vec3> {
    lattice(&[-1.0, 0.0, 1.0]).filter(|d| *d != Vec3::ZERO && d.to_array().contains(&0.0))
}

/// On the faces, edges and corners of the unit cube, within it, and before and behind it.
const PLACES: [f32; 5] = [-2.0, 0.0, 0.5, 1.0, 3.0];

/// S01: zero components of the direction, and an origin in the plane of a face. All arithmetic is exact here, and so
/// must be the answer.
pub(super) fn zero_components(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let Some(judge) = Judge::new(&mut tries, run, cuboid(Vec3::ZERO, Vec3::ONE)) else { return tries.outcome() };
    for direction in directions_with_zeros() {
        for origin in lattice(&PLACES) {
            judge.strict(&mut tries, &Ray::new(origin, direction), Interval::FULL);
        }
    }
    tries.outcome()
}

/// S02: the same with every sign of every zero: the same bits.
pub(super) fn negative_zeros(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let Some(judge) = Judge::new(&mut tries, run, cuboid(Vec3::ZERO, Vec3::ONE)) else { return tries.outcome() };
    for direction in directions_with_zeros() {
        for origin in lattice(&PLACES) {
            let expected = judge.hit(&Ray::new(origin, direction), Interval::FULL);
            for signs in 1..64 {
                let ray = Ray::new(with_signs(origin, signs), with_signs(direction, signs >> 3));
                let hit = judge.hit(&ray, Interval::FULL);
                tries.check(hit == expected, || format!("{ray:?}: {hit:?}, with positive zeros {expected:?}"));
            }
        }
    }
    tries.outcome()
}

/// The zeros of `v` with the sign of their bits in `signs`.
fn with_signs(v: Vec3, signs: usize) -> Vec3 {
    let negative = |i: usize| signs >> i & 1 == 1;
    Vec3::from_array([0, 1, 2].map(|i| if v[i] == 0.0 && negative(i) { -0.0 } else { v[i] }))
}

/// S03: rays along the faces and edges of a block of cubes hit what is perpendicular to them, and visit exactly the
/// nodes whose closed boxes they meet.
pub(super) fn within_faces(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let n = run.effort.pick(4, 8);
    let cubes: Vec<_> =
        (0..n * n * n).map(|i| Vec3::new((i % n) as f32, (i / n % n) as f32, (i / n / n) as f32)).collect();
    let cubes: Vec<_> = cubes.into_iter().map(|at| cuboid(at, at + Vec3::ONE)).collect();
    let mesh = Arc::new(scene::meshes::merge(&cubes).expect("few enough triangles"));
    let trees: Vec<MeshBvh> =
        configs(&[1, 4]).filter_map(|config| MeshBvh::build(Arc::clone(&mesh), &config).ok()).collect();
    let Some(judge) = Judge::new(&mut tries, run, (*mesh).clone()) else { return tries.outcome() };
    let ends = [-1.0, 0.0, 0.5, n as f32, n as f32 + 1.0];
    for i in 0..(2 * n + 3) * (2 * n + 3) {
        let [a, b] = [i % (2 * n + 3), i / (2 * n + 3)].map(|x| 0.5 * x as f32 - 0.5);
        for (end, axis) in ends.into_iter().flat_map(|end| (0..3).map(move |axis| (end, axis))) {
            for sign in [1.0, -1.0] {
                let turned = |x: f32, y: f32, z: f32| {
                    let mut v = [x, y, z];
                    v.rotate_right(axis);
                    Vec3::from_array(v)
                };
                let ray = Ray::new(turned(end, a, b), turned(sign, 0.0, 0.0));
                judge.strict(&mut tries, &ray, Interval::FULL);
                let Some(traversal) = TraversalRay::new(&ray) else { continue };
                for bvh in &trees {
                    let (visited, met) = (nodes_visited(bvh, &traversal), nodes_met(bvh.bvh(), &ray));
                    tries.check(visited == met, || format!("{ray:?} visits {visited} nodes and meets {met}"));
                }
            }
        }
    }
    tries.outcome()
}

/// The nodes that are visited when all hits are asked for.
fn nodes_visited(shape: &dyn Shape, ray: &TraversalRay) -> u64 {
    struct All(Work);
    impl HitVisitor for All {
        fn hit(&mut self, _: Hit) -> Visit {
            Visit::Continue(f32::INFINITY)
        }
        fn work(&mut self, work: Work) {
            self.0 += work;
        }
    }
    let mut all = All(Work::default());
    let _ = shape.visit_hits(ray, Interval::FULL, &mut all);
    all.0.nodes
}

/// The nodes whose closed box a ray along an axis meets.
fn nodes_met(bvh: &FlatBvh, ray: &Ray) -> u64 {
    let meets = |bounds: geometry::Bounds3| {
        (0..3).all(|i| match ray.direction[i] {
            d if d > 0.0 => ray.origin[i] <= bounds.max[i],
            d if d < 0.0 => ray.origin[i] >= bounds.min[i],
            _ => bounds.min[i] <= ray.origin[i] && ray.origin[i] <= bounds.max[i],
        })
    };
    bvh.nodes().iter().filter(|node| meets(node.bounds())).count() as u64
}

/// S05: origins inside of a box, on its faces, edges and corners, and an ulp beside them.
pub(super) fn origins(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 105);
    let (min, max) = (Vec3::new(-1.0, 0.25, 3.0), Vec3::new(2.0, 1.75, 3.5));
    let Some(judge) = Judge::new(&mut tries, run, cuboid(min, max)) else { return tries.outcome() };
    let mut inside = 0;
    for _ in 0..run.effort.pick(20_000, 10_000_000) {
        let coordinate = |i: usize, random: &mut Random| {
            let within = min[i] + random.unit() * (max[i] - min[i]);
            let place = [min[i], max[i], within][random.below(3)];
            [place, place, place.next_up(), place.next_down()][random.below(4)]
        };
        let origin = Vec3::from_array([0, 1, 2].map(|i| coordinate(i, &mut random)));
        let mut direction = random.vector();
        if random.below(4) == 0 {
            direction[random.below(3)] = 0.0;
        }
        let ray = Ray::new(origin, direction);
        judge.tolerant(&mut tries, &ray, Interval::FULL);
        inside += usize::from(judge.does_not_leak(&mut tries, &ray));
    }
    tries.check(inside > 100, || format!("only {inside} origins are inside"));
    tries.outcome()
}

/// S13: rectangles perpendicular to the axes, whose boxes have no thickness, hit head-on and obliquely.
pub(super) fn no_thickness(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 113);
    for axis in 0..3 {
        let at = |x: f32, y: f32, z: f32| {
            let mut v = [x, y, z];
            v.rotate_right(axis);
            Vec3::from_array(v)
        };
        let mesh = mesh_of((0..8).flat_map(|k| {
            let h = 0.5 * k as f32;
            let corners = [at(h, 0.0, 0.0), at(h, 4.0, 0.0), at(h, 4.0, 4.0), at(h, 0.0, 4.0)];
            [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]
        }));
        let Some(judge) = Judge::new(&mut tries, run, mesh) else { continue };
        for y in 0..=8 {
            for z in 0..=8 {
                for x in [-1.0, 0.0, 0.25, 4.0] {
                    for sign in [1.0, -1.0] {
                        let ray = Ray::new(at(x, 0.5 * y as f32, 0.5 * z as f32), at(sign, 0.0, 0.0));
                        judge.strict(&mut tries, &ray, Interval::FULL);
                    }
                }
            }
        }
        let mut hits = 0;
        let count = run.effort.pick(3_000, 1_000_000);
        for _ in 0..count {
            let target = Vec2::new(4.0 * random.unit(), 4.0 * random.unit());
            let target = at(0.5 * random.below(8) as f32, target.x, target.y);
            let origin = 6.0 * random.vector();
            hits += usize::from(judge.tolerant(&mut tries, &Ray::new(origin, target - origin), Interval::FULL));
        }
        tries.check(hits > count / 2, || format!("only {hits} rays can hit"));
    }
    tries.outcome()
}
