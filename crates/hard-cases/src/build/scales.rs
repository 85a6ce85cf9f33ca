//! B09, B13, B14, B15, B24, B25: the very large, the very small, and both at once.

use std::sync::Arc;

use geometry::glam::Vec3;
use geometry::{Interval, MAX_COORDINATE, Ray, Shape, TraversalRay, TriangleMesh};

use super::coincident::WORK_RATIO;
use super::meshes::{mixed_scales, needles, one_over_all, scaled, teapot_in_a_stadium, uniform};
use super::sweep::{LEAVES, build_work, configs, counted, label, rays_at, sweep, tree_over};
use crate::boxes::judge::Judge;
use crate::{Aim, Outcome, Random, Run, Tries};

/// Sweeps over all builds, and compares the subject with the exact answer. Returns how many rays hit something.
fn sweep_and_judge(tries: &mut Tries, run: &Run, name: &str, mesh: TriangleMesh, rays: &[Ray]) -> usize {
    let few = &rays[..rays.len().min(100)];
    sweep(tries, run, name, mesh.clone(), few, run.effort.pick(&[1, 4], &LEAVES));
    let Some(judge) = Judge::new(tries, run, mesh) else { return 0 };
    rays.iter().filter(|ray| judge.tolerant(tries, ray, Interval::FULL)).count()
}

/// B09: a ray at the teapot visits at most twice the nodes that it would in a scene of the teapot alone.
pub(super) fn teapot_in_stadium(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 9);
    let [teapot, stadium] = teapot_in_a_stadium(run.effort.pick(4, 8), &mut random).map(Arc::new);
    let rays: Vec<TraversalRay> = (0..run.effort.pick(200, 2_000))
        .filter_map(|i| {
            let (origin, target) = (2e-3 * random.vector(), Aim::ALL[i % 4].target(&teapot, &mut random));
            TraversalRay::new(&Ray::new(origin, target - origin))
        })
        .collect();
    for config in configs(&[1, 4]) {
        let alone = tree_over(&mut tries, "teapot", &teapot, &config);
        let both = tree_over(&mut tries, "stadium", &stadium, &config);
        let Some((alone, both)) = alone.zip(both) else { continue };
        let [mut usual, mut nodes] = [0, 0];
        for ray in &rays {
            let (expected, work) = counted(&alone, ray, Interval::FULL);
            let (hit, work_in_stadium) = counted(&both, ray, Interval::FULL);
            tries.check(hit == expected, || format!("{:?}: {hit:?}, in the teapot {expected:?}", ray.ray()));
            usual += work.nodes;
            nodes += work_in_stadium.nodes;
        }
        tries.check(nodes <= 2 * usual, || format!("{}: {nodes} nodes, not {usual}", label("stadium", &config)));
    }
    match run.subject.shape(Arc::clone(&stadium)) {
        Ok(shape) => {
            let alone = run.subject.without_tree(Arc::clone(&stadium));
            for ray in rays.iter().take(20) {
                let (hit, expected) = (shape.intersect(ray, Interval::FULL), alone.intersect(ray, Interval::FULL));
                tries.check(hit == expected, || format!("{:?}: {hit:?}, not {expected:?}", ray.ray()));
            }
        }
        Err(error) => tries.check(false, || error.to_string()),
    }
    tries.outcome()
}

/// B13: up to the end of the domain everything is as at 1; beyond it, nothing is hit.
pub(super) fn huge(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 13);
    let n = run.effort.pick(200, 20_000);
    for scale in [1e10, 1e15, 1e17, MAX_COORDINATE / 2.0] {
        let mesh = scaled(n, scale, &mut random);
        let rays = rays_at(&mesh, run.effort.pick(150, 2_000), &mut random);
        let hits = sweep_and_judge(&mut tries, run, &format!("scale {scale}"), mesh, &rays);
        tries.check(hits > rays.len() / 4, || format!("scale {scale}: only {hits} rays can hit"));
    }
    for scale in [1e19, 1e30, 2e38] {
        let mesh = scaled(n, scale, &mut random);
        let rays = rays_at(&mesh, 100, &mut random);
        sweep_and_judge(&mut tries, run, &format!("scale {scale}"), mesh, &rays);
    }
    tries.outcome()
}

/// B14: among denormal numbers trees still answer as the list does. From 2⁻⁴⁰ to 2⁻⁸⁰ everything is, bit for bit, as at
/// 1: t, u and v have no scale.
///
/// That denormal numbers are not flushed to zero is assumed: setting the processor's mode is `unsafe`, and outside of
/// the domain.
pub(super) fn denormal(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 14);
    let n = run.effort.pick(200, 20_000);
    for scale in [1e-38, 1e-40, 1e-43, 2e-45] {
        let mesh = scaled(n, scale, &mut random);
        let rays = rays_at(&mesh, 100, &mut random);
        sweep(&mut tries, run, &format!("scale {scale:e}"), mesh, &rays, run.effort.pick(&[1, 4], &LEAVES));
    }
    let mesh = scaled(n, 1.0, &mut random);
    let rays = rays_at(&mesh, run.effort.pick(500, 20_000), &mut random);
    let Some(plain) = Judge::new(&mut tries, run, mesh.clone()) else { return tries.outcome() };
    for k in [-40, -60, -80] {
        let s = 2.0_f32.powi(k);
        let positions: Vec<Vec3> = mesh.positions().iter().map(|&p| s * p).collect();
        let small = TriangleMesh::new(positions, mesh.triangles().to_vec()).expect("the same indices");
        let Some(small) = Judge::new(&mut tries, run, small) else { continue };
        for ray in &rays {
            let hit = plain.hit(ray, Interval::FULL);
            let same = small.hit(&Ray::new(s * ray.origin, s * ray.direction), Interval::FULL);
            tries.check(hit == same, || format!("{ray:?}: {hit:?}, times 2^{k} {same:?}"));
        }
    }
    tries.outcome()
}

/// B15: sizes over 24 decades and places over 12.
pub(super) fn of_all_scales(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 15);
    let mesh = mixed_scales(run.effort.pick(500, 50_000), &mut random);
    let rays = rays_at(&mesh, run.effort.pick(500, 5_000), &mut random);
    let hits = sweep_and_judge(&mut tries, run, "mixed scales", mesh, &rays);
    tries.check(hits > rays.len() / 4, || format!("only {hits} rays can hit"));
    tries.outcome()
}

/// B24: needles cost no more to build than other triangles, and what is far enough from an edge of one is decided
/// exactly.
pub(super) fn very_long(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 24);
    let n = run.effort.pick(1_000, 100_000);
    let (mesh, plain) = (needles(n, &mut random), Arc::new(uniform(n, &mut random)));
    let shared = Arc::new(mesh.clone());
    for config in configs(&[1, 4]) {
        let bvh = tree_over(&mut tries, "needles", &shared, &config);
        let Some((bvh, uniform)) = bvh.zip(tree_over(&mut tries, "uniform", &plain, &config)) else { continue };
        let (work, usual) = (build_work(bvh.bvh()), build_work(uniform.bvh()));
        tries.check(work <= WORK_RATIO * usual, || format!("{}: {work}, not {usual}", label("work", &config)));
    }
    let rays = rays_at(&mesh, run.effort.pick(300, 3_000), &mut random);
    sweep_and_judge(&mut tries, run, "needles", mesh, &rays);
    tries.outcome()
}

/// B25: one triangle over the whole scene, and tiny ones before and behind it.
pub(super) fn one_large(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 25);
    let mesh = one_over_all(run.effort.pick(1_000, 1_000_000), &mut random);
    let mut rays = rays_at(&mesh, run.effort.pick(200, 500), &mut random);
    // Half of them at tiny ones that the large one may hide.
    rays.extend((0..run.effort.pick(200, 500)).map(|_| {
        let target = mesh.vertices(1 + random.below(mesh.len() - 1)).into_iter().sum::<Vec3>() / 3.0;
        let origin = target + 20.0 * random.vector();
        Ray::new(origin, target - origin)
    }));
    let hits = sweep_and_judge(&mut tries, run, "one over all", mesh, &rays);
    tries.check(hits > rays.len() / 2, || format!("only {hits} rays can hit"));
    tries.outcome()
}
