//! S14, S19, S20: in what order nodes are visited, and which question is asked, changes no answer.

use std::sync::Arc;

use bvh_flat::MAX_DEPTH;
use geometry::glam::Vec3;
use geometry::{Interval, Ray};

use super::judge::Judge;
use crate::build::meshes::mesh_of;
use crate::build::sweep::{configs, depth, rays_at, tree_over};
use crate::build::{cascades, small_meshes};
use crate::{Outcome, Random, Run, Tries};

/// S14: rays from the end of a cascade where its primitives crowd, which put as many nodes on the stack as there can
/// be.
pub(super) fn deep_trees(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 114);
    for (name, mesh) in cascades(&mut random) {
        let shared = Arc::new(mesh.clone());
        for config in configs(&[1, 4]) {
            let depth = tree_over(&mut tries, name, &shared, &config).map_or(0, |bvh| depth(bvh.bvh()));
            tries.check((1..=MAX_DEPTH).contains(&depth), || format!("{name}: depth {depth}"));
        }
        let Some(judge) = Judge::new(&mut tries, run, mesh) else { continue };
        for i in 0..run.effort.pick(300, 100_000) {
            let axis = Vec3::AXES[i % 3];
            let direction = if i % 2 == 0 { axis } else { axis + 1e-3 * random.vector() };
            // At the crowded end and behind it; and towards it from the other.
            let origin = random.power_of_two(-149.0, 3.0) * random.vector();
            let far = random.power_of_two(0.0, 60.0) * axis;
            for ray in [Ray::new(origin, direction), Ray::new(origin - axis, direction), Ray::new(far, origin - far)] {
                judge.consistent(&mut tries, &ray, Interval::FULL);
            }
        }
    }
    tries.outcome()
}

/// S19: large triangles through each other, so that the box that is entered first often has the hit that does not
/// count.
pub(super) fn overlapping(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 119);
    let mut hits = 0;
    let (rounds, count) = run.effort.pick((5, 500), (100, 10_000));
    for _ in 0..rounds {
        let mesh = mesh_of((0..200).map(|_| [0, 1, 2].map(|_| 5.0 * random.vector())));
        let rays = rays_at(&mesh, count, &mut random);
        let Some(judge) = Judge::new(&mut tries, run, mesh) else { continue };
        for ray in &rays {
            hits += usize::from(judge.tolerant(&mut tries, ray, Interval::FULL));
            // The rest of the scene, from beyond the first hit.
            if let Some(first) = judge.hit(ray, Interval::FULL) {
                judge.tolerant(&mut tries, ray, Interval::new(first.t, f32::INFINITY));
            }
        }
    }
    tries.check(hits > rounds * count / 4, || format!("only {hits} rays can hit"));
    // A large plate across a small one: the box of the large is entered first, and its hit is behind.
    let plate = [Vec3::new(-10.0, -10.0, 0.0), Vec3::new(10.0, -10.0, 0.0), Vec3::new(0.0, 10.0, 9.0)];
    let small = [Vec3::new(-1.0, -6.0, 1.8), Vec3::new(1.0, -6.0, 1.8), Vec3::new(0.0, -4.0, 1.8)];
    for mesh in [mesh_of([plate, small]), mesh_of([small, plate])] {
        let Some(judge) = Judge::new(&mut tries, run, mesh) else { continue };
        for i in 0..100 {
            let (x, y) = (0.02 * (i % 10) as f32 - 0.09, -5.5 + 0.1 * (i / 10) as f32);
            judge.tolerant(&mut tries, &Ray::new([x, y, -3.0], [0.0, 0.0, 1.0]), Interval::FULL);
            judge.tolerant(&mut tries, &Ray::new([x, y, 20.0], [0.0, 0.0, -1.0]), Interval::FULL);
        }
    }
    tries.outcome()
}

/// S20: there is any hit where there is a closest hit, in every interval, on every mesh of the catalogue's builds.
pub(super) fn any_and_closest(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 120);
    for (_, mesh) in small_meshes(&mut random) {
        let rays = rays_at(&mesh, run.effort.pick(200, 20_000), &mut random);
        let Some(judge) = Judge::new(&mut tries, run, mesh) else { continue };
        for ray in &rays {
            let Some(hit) = judge.consistent(&mut tries, ray, Interval::FULL) else { continue };
            let (a, b) = (2.0 * random.unit() * hit.t, 2.0 * random.unit() * hit.t);
            for (t_min, t_max) in [(0.0, hit.t), (0.0, hit.t.next_up()), (hit.t, f32::INFINITY), (a.min(b), a.max(b))] {
                judge.consistent(&mut tries, ray, Interval::new(t_min, t_max));
            }
        }
    }
    tries.outcome()
}
