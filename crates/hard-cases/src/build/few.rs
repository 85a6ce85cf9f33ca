//! B01, B02: nothing, and next to nothing.

use std::sync::Arc;

use bvh_flat::BvhAggregate;
use geometry::glam::Vec3;
use geometry::{Interval, Ray, Shape, TraversalRay, Work};
use primitive::Primitive;

use super::meshes::{mesh_of, triangle_at};
use super::sweep::{LEAVES, configs, counted, label, rays_at, sweep, tree_over};
use crate::boxes::judge::Judge;
use crate::{Outcome, Random, Run, Tries};

/// B01: no triangles, or none that could be hit: a tree without nodes, that every ray misses without work.
pub(super) fn nothing(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let meshes = [
        ("no triangles", mesh_of([])),
        ("only NaN", mesh_of([[Vec3::NAN; 3]; 5])),
        ("only infinities", mesh_of([[Vec3::INFINITY; 3], [Vec3::NEG_INFINITY; 3]])),
        ("only outside of the domain", mesh_of([triangle_at(Vec3::splat(1e30), 1e30); 9])),
    ];
    let rays = rays_at(&mesh_of([]), 50, &mut Random::new(run.seed, 1));
    for (name, mesh) in meshes {
        let mesh = Arc::new(mesh);
        for config in configs(&LEAVES) {
            let Some(bvh) = tree_over(&mut tries, name, &mesh, &config) else { continue };
            let is_empty =
                bvh.bvh().nodes().is_empty() && bvh.object_bound().is_empty() && bvh.bvh().order().is_empty();
            tries.check(is_empty, || format!("{}: not empty", label(name, &config)));
            is_missed(&mut tries, &label(name, &config), &bvh, &rays);
        }
        match run.subject.shape(Arc::clone(&mesh)) {
            Ok(shape) => is_missed(&mut tries, name, &shape, &rays),
            Err(error) => tries.check(false, || format!("{name}: {error}")),
        }
    }
    for config in configs(&LEAVES) {
        let aggregate = BvhAggregate::<Box<dyn Primitive>>::build(Vec::new(), &config);
        let is_missed = aggregate.is_ok_and(|aggregate| {
            let mut rays = rays.iter().filter_map(TraversalRay::new);
            aggregate.world_bound().is_empty() && !rays.any(|ray| aggregate.intersect_p(&ray, Interval::FULL))
        });
        tries.check(is_missed, || label("an aggregate of nothing", &config));
    }
    tries.outcome()
}

fn is_missed(tries: &mut Tries, name: &str, shape: &dyn Shape, rays: &[Ray]) {
    for ray in rays.iter().filter_map(TraversalRay::new) {
        let (hit, work) = counted(shape, &ray, Interval::FULL);
        let holds = hit.is_none() && work == Work::default() && !shape.intersect_p(&ray, Interval::FULL);
        tries.check(holds, || format!("{name}: {:?} gives {hit:?} after {work:?}", ray.ray()));
    }
}

/// B02: one triangle to five.
pub(super) fn one_to_five(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 2);
    for round in 0..run.effort.pick(20, 500) {
        for n in 1..=5 {
            let mesh = mesh_of((0..n).map(|_| triangle_at(2.0 * random.vector(), 3.0)));
            let rays = rays_at(&mesh, 20, &mut random);
            sweep(&mut tries, run, &format!("{n} triangles, round {round}"), mesh.clone(), &rays, &LEAVES);
            let Some(judge) = Judge::new(&mut tries, run, mesh) else { continue };
            for ray in &rays {
                judge.tolerant(&mut tries, ray, Interval::FULL);
            }
        }
    }
    tries.outcome()
}
