//! B03, B04, B05, B12: primitives that no plane separates.

use std::sync::Arc;

use bvh_flat::SplitMethod;
use bvh_flat::bvh_build::MortonBits;
use geometry::glam::Vec3;
use geometry::{Bounds3, Interval, Ray, Shape, TraversalRay};

use super::meshes::{concentric, identical, on_ten_points, uniform};
use super::sweep::{LEAVES, build_work, checked_tree, configs, depth, label, rays_at, sweep, tree_over};
use crate::{Outcome, Random, Run, Tries};

/// No build may touch more than this many times what it touches of a uniform scene.
pub(super) const WORK_RATIO: u64 = 4;

/// B03: many identical triangles tie for every ray; number 0 wins.
pub(super) fn many_identical(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 3);
    let n = run.effort.pick(10_000, 1_000_000);
    let (mesh, plain) = (Arc::new(identical(n)), Arc::new(uniform(n, &mut random)));
    let one = identical(1);
    let rays: Vec<Ray> = rays_at(&one, 30, &mut random);
    for config in configs(&[1, 4]) {
        let bvh = tree_over(&mut tries, "identical", &mesh, &config);
        let uniform = tree_over(&mut tries, "uniform", &plain, &config);
        let Some((bvh, uniform)) = bvh.zip(uniform) else { continue };
        let (work, usual) = (build_work(bvh.bvh()), build_work(uniform.bvh()));
        tries.check(work <= WORK_RATIO * usual, || format!("{}: {work}, not {usual}", label("work", &config)));
        number_0_wins(&mut tries, &label("identical", &config), &bvh, &one, &rays);
    }
    match run.subject.shape(mesh) {
        Ok(shape) => {
            let one = run.subject.without_tree(Arc::new(one));
            number_0_wins(&mut tries, "identical", &*shape, &*one, &rays);
        }
        Err(error) => tries.check(false, || error.to_string()),
    }
    tries.outcome()
}

/// Of copies of `one`, the first is hit, as it would be alone.
fn number_0_wins(tries: &mut Tries, name: &str, shape: &dyn Shape, one: &dyn Shape, rays: &[Ray]) {
    for ray in rays.iter().filter_map(TraversalRay::new) {
        let (hit, alone) = (shape.intersect(&ray, Interval::FULL), one.intersect(&ray, Interval::FULL));
        tries.check(hit == alone, || format!("{name}: {:?} gives {hit:?}, not {alone:?}", ray.ray()));
    }
}

/// B04: concentric triangles of sizes from 1 to 2³⁹ are split by count.
pub(super) fn many_concentric(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mesh = concentric(run.effort.pick(400, 4_000));
    let rays = rays_at(&mesh, run.effort.pick(60, 600), &mut Random::new(run.seed, 4));
    let shallow = mesh.len().ilog2() as usize + 3;
    let shared = Arc::new(mesh.clone());
    for config in configs(&LEAVES) {
        let Some(bvh) = tree_over(&mut tries, "concentric", &shared, &config) else { continue };
        let depth = depth(bvh.bvh());
        tries.check(depth <= shallow, || format!("{}: depth {depth}", label("concentric", &config)));
    }
    sweep(&mut tries, run, "concentric", mesh, &rays, &LEAVES);
    tries.outcome()
}

/// B05: as many coincident primitives as 8 and 16 bits can count, and one more or less, where the leaf may have as
/// many.
pub(super) fn counts_of_leaves(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let at = Bounds3::new(Vec3::splat(-1.0), Vec3::splat(1.0));
    for n in [255, 256, 257, 65_534, 65_535, 65_536, 65_537] {
        let bounds = vec![at; n];
        let leaves: &[u32] = run.effort.pick(&[255, 65_535], &[1, 254, 255, 256, 65_534, 65_535]);
        for config in configs(leaves) {
            let bvh = checked_tree(&mut tries, &format!("{n} coincident"), &bounds, &config);
            // One leaf wherever they fit into it; the largest leaf and what is in it have been checked.
            let fits = n <= config.max_primitives_in_leaf as usize;
            let nodes = bvh.map_or(0, |bvh| bvh.nodes().len());
            tries.check((nodes == 1) == fits, || format!("{}: {nodes} nodes", label(&format!("{n}"), &config)));
        }
    }
    let n = 65_537;
    let mesh = identical(n);
    let ray = TraversalRay::new(&Ray::new([0.1, -0.2, 9.0], [0.0, 0.01, -1.0])).expect("a valid ray");
    let expected = identical(1).intersect(&ray, Interval::FULL);
    let hit = run.subject.shape(Arc::new(mesh)).ok().and_then(|shape| shape.intersect(&ray, Interval::FULL));
    tries.check(expected.is_some() && hit == expected, || format!("{n}: {hit:?}, not {expected:?}"));
    tries.outcome()
}

/// B12: many primitives with few Morton codes.
pub(super) fn few_codes(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 12);
    let mesh = on_ten_points(run.effort.pick(3_000, 100_000), &mut random);
    let rays = rays_at(&mesh, run.effort.pick(50, 200), &mut random);
    sweep(&mut tries, run, "on ten points", mesh.clone(), &rays, run.effort.pick(&[1, 4], &LEAVES));
    let mesh = Arc::new(mesh);
    for bits in [MortonBits::Bits30, MortonBits::Bits42, MortonBits::Bits63] {
        let config = bvh_flat::BuildConfig::new(SplitMethod::Hlbvh).with_morton_bits(bits);
        // That every primitive has a leaf is checked with the tree.
        let depth = tree_over(&mut tries, "on ten points", &mesh, &config).map_or(usize::MAX, |bvh| depth(bvh.bvh()));
        tries.check(depth <= mesh.len().ilog2() as usize + 10, || format!("{bits:?}: depth {depth}"));
    }
    tries.outcome()
}
