//! S17, S18: hits at the same t, and at nearly the same.

use std::sync::Arc;

use bvh_flat::BvhAggregate;
use geometry::glam::Vec3;
use geometry::{Hit, Interval, Ray, Shape, Sphere, TraversalRay};
use primitive::{GeometricPrimitive, MaterialId, MediumInterface, Primitive, Surface};

use super::judge::Judge;
use crate::build::meshes::{mesh_of, triangle_at};
use crate::build::sweep::{configs, rays_at};
use crate::{Outcome, Random, Run, Tries};

/// S17: of hits at one t the smallest number wins: among copies, among coplanar triangles that overlap, and among
/// different shapes.
pub(super) fn exact(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    copies(&mut tries, run);
    coplanar(&mut tries, run);
    different_shapes(&mut tries);
    tries.outcome()
}

/// Each triangle many times over, the copies mixed with each other.
fn copies(tries: &mut Tries, run: &Run) {
    let mut random = Random::new(run.seed, 117);
    let originals: Vec<[Vec3; 3]> = (0..40).map(|_| triangle_at(3.0 * random.vector(), 3.0)).collect();
    let chosen: Vec<usize> = (0..1_000).map(|_| random.below(originals.len())).collect();
    let first = |original: u64| chosen.iter().position(|&i| i as u64 == original);
    let (alone, mesh) = (mesh_of(originals.clone()), mesh_of(chosen.iter().map(|&i| originals[i])));
    let rays = rays_at(&alone, run.effort.pick(500, 50_000), &mut random);
    let alone = run.subject.without_tree(Arc::new(alone));
    let Some(judge) = Judge::new(tries, run, mesh) else { return };
    for ray in rays {
        let Some(traversal) = TraversalRay::new(&ray) else { continue };
        let hit = judge.consistent(tries, &ray, Interval::FULL);
        // Of two originals at one t, the one whose first copy comes first: compared by t alone.
        let expected = alone.intersect(&traversal, Interval::FULL);
        let holds = match (hit, expected) {
            (Some(hit), Some(expected)) => {
                let original = chosen[hit.primitive as usize] as u64;
                hit.t == expected.t && first(original) == Some(hit.primitive as usize)
            }
            (None, None) => true,
            _ => false,
        };
        tries.check(holds, || format!("{ray:?}: {hit:?}, of the originals {expected:?}"));
    }
}

/// Triangles with corners on a lattice in one plane, and rays whose t are exact.
fn coplanar(tries: &mut Tries, run: &Run) {
    let mut random = Random::new(run.seed, 217);
    for _ in 0..run.effort.pick(10, 500) {
        let mut corner = || Vec3::new(random.below(9) as f32, random.below(9) as f32, 2.0);
        let mesh = mesh_of((0..60).map(|_| [corner(), corner(), corner()]));
        let Some(judge) = Judge::new(tries, run, mesh) else { continue };
        for i in 0..17 * 17 {
            let (x, y) = (0.5 * (i % 17) as f32, 0.5 * (i / 17) as f32);
            judge.strict(tries, &Ray::new([x, y, 6.0], [0.0, 0.0, -0.5]), Interval::FULL);
            judge.strict(tries, &Ray::new([x + 4.0, y - 2.0, 6.0], [-0.5, 0.25, -0.5]), Interval::FULL);
        }
    }
}

/// A triangle and a sphere that a ray meets at t = 1, in both orders.
fn different_shapes(tries: &mut Tries) {
    let surface = Surface::of_material(MaterialId::from_index(0).expect("0 is an index"));
    let wall = mesh_of([[Vec3::new(-4.0, -4.0, 1.0), Vec3::new(4.0, -4.0, 1.0), Vec3::new(0.0, 4.0, 1.0)]]);
    let sphere = Sphere::new(Vec3::new(0.0, 0.0, 3.0), 2.0).expect("a valid sphere");
    let ray = TraversalRay::new(&Ray::new(Vec3::ZERO, Vec3::Z)).expect("a valid ray");
    let members = |sphere_first: bool| -> Vec<Box<dyn Primitive>> {
        let wall = Box::new(GeometricPrimitive::new(wall.clone(), surface, MediumInterface::VACUUM));
        let sphere = Box::new(GeometricPrimitive::new(sphere, surface, MediumInterface::VACUUM));
        if sphere_first { vec![sphere, wall] } else { vec![wall, sphere] }
    };
    for config in configs(&[1, 4]) {
        for sphere_first in [false, true] {
            let aggregate = BvhAggregate::build(members(sphere_first), &config).ok();
            let hit = aggregate.and_then(|aggregate| aggregate.intersect(&ray, Interval::FULL));
            let holds = hit.is_some_and(|hit| hit.t == 1.0 && hit.primitive == 0);
            tries.check(holds, || format!("a wall and a sphere, the sphere first: {sphere_first}: {hit:?}"));
        }
    }
}

/// S18: tilted copies of a triangle, each an ulp from the one before. Which of them is hit is told right where t,
/// rounded once, can tell; how often it cannot is a figure.
pub(super) fn near(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 118);
    let (mut unlike, mut hits) = (0_u32, 0_u32);
    for _ in 0..run.effort.pick(50, 5_000) {
        let mut corners = [0, 1, 2].map(|_| 5.0 * random.vector());
        let axis = random.below(3);
        let mesh = mesh_of((0..6).map(|_| {
            corners.iter_mut().for_each(|p| p[axis] = p[axis].next_up());
            corners
        }));
        let rays = rays_at(&mesh, 100, &mut random);
        let Some(judge) = Judge::new(&mut tries, run, mesh) else { continue };
        for ray in &rays {
            hits += u32::from(judge.tolerant(&mut tries, ray, Interval::FULL));
            let number = |hit: Option<Hit>| hit.map(|hit| hit.primitive);
            let exact = judge.closest(ray, Interval::FULL).map(|exact| exact.primitives[0]);
            unlike += u32::from(number(judge.hit(ray, Interval::FULL)) != exact);
        }
    }
    tries.check(hits > 1_000, || format!("only {hits} rays can hit"));
    tries.figure("rate of another primitive than the exact one", f64::from(unlike) / f64::from(hits.max(1)));
    tries.outcome()
}
