//! B10, B11, B20: scenes without extent on some axis, and zeros of both signs.

use std::sync::Arc;

use bvh_flat::bvh_build::MortonBits;
use bvh_flat::{BuildConfig, FlatBvh, SplitMethod};
use geometry::glam::Vec3;
use geometry::{Interval, Ray};

use super::meshes::{in_a_line, in_a_plane, mesh_of, morton_extremes, zeros_of_both_signs};
use super::sweep::{LEAVES, answers, configs, expected, label, rays_at, subject_answers, sweep, tree_over};
use crate::boxes::judge::Judge;
use crate::{Outcome, Random, Run, Tries};

/// B10: centroids at the ends of the Morton grid, with extents of zero on every choice of axes.
pub(super) fn ends_of_the_grid(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 10);
    for flat in 0..8 {
        for scale in [1.0, 1e-35, 1e14] {
            let name = format!("flat on {flat:03b}, scale {scale:e}");
            let mesh = morton_extremes(flat, scale);
            let rays = rays_at(&mesh, run.effort.pick(40, 1_000), &mut random);
            sweep(&mut tries, run, &name, mesh.clone(), &rays, run.effort.pick(&[1, 4], &LEAVES));
            let mesh = Arc::new(mesh);
            let expected = expected(&*mesh, &rays);
            for bits in [MortonBits::Bits30, MortonBits::Bits42, MortonBits::Bits63] {
                let config = BuildConfig::new(SplitMethod::Hlbvh).with_morton_bits(bits);
                if let Some(bvh) = tree_over(&mut tries, &name, &mesh, &config) {
                    answers(&mut tries, &label(&name, &config), &bvh, &expected);
                }
            }
        }
    }
    tries.outcome()
}

/// B11: everything in a plane, in a line, or in a point. Costs are finite, which is checked with the trees, and the
/// plane is hit.
pub(super) fn without_extent(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 11);
    let n = run.effort.pick(200, 5_000);
    let meshes = [
        ("in a plane", in_a_plane(n, &mut random), true),
        ("in a line", in_a_line(n), true),
        ("in a point", mesh_of(vec![[Vec3::new(1.0, 2.0, 3.0); 3]; n]), false),
    ];
    for (name, mesh, can_be_hit) in meshes {
        let mut rays = rays_at(&mesh, run.effort.pick(200, 2_000), &mut random);
        // And perpendicular to the plane, and within it.
        rays.extend((0..100).map(|_| Ray::new(10.0 * random.vector(), -Vec3::Z)));
        rays.extend((0..100).map(|_| Ray::new((10.0 * random.vector()).with_z(3.0), random.vector().with_z(0.0))));
        sweep(&mut tries, run, name, mesh.clone(), &rays, run.effort.pick(&[1, 4], &LEAVES));
        let Some(judge) = Judge::new(&mut tries, run, mesh) else { continue };
        let hits = rays.iter().filter(|ray| judge.tolerant(&mut tries, ray, Interval::FULL)).count();
        tries.check(can_be_hit == (hits > rays.len() / 10), || format!("{name}: {hits} rays can hit"));
    }
    tries.outcome()
}

/// B20: a zero of either sign is the same number, in the vertices and so in the tree.
pub(super) fn signs_of_zero(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 20);
    for round in 0..run.effort.pick(5, 100) {
        let [mixed, positive] = zeros_of_both_signs(200, &mut random).map(Arc::new);
        let rays = rays_at(&positive, run.effort.pick(100, 1_000), &mut random);
        let expected = expected(&*positive, &rays);
        for config in configs(&LEAVES) {
            let bvh = tree_over(&mut tries, "both", &mixed, &config);
            let Some((bvh, plain)) = bvh.zip(tree_over(&mut tries, "positive", &positive, &config)) else { continue };
            let name = label(&format!("round {round}"), &config);
            tries.check(bits(bvh.bvh()) == bits(plain.bvh()), || format!("{name}: the bits of the trees differ"));
            answers(&mut tries, &name, &bvh, &expected);
        }
        // The same answers with either sign of zero, and the same as without a tree.
        subject_answers(&mut tries, run, "both", Arc::clone(&mixed), &rays);
        let alone = run.subject.without_tree(positive);
        match run.subject.shape(mixed) {
            Ok(shape) => answers(&mut tries, "both", &*shape, &super::sweep::expected(&*alone, &rays)),
            Err(error) => tries.check(false, || error.to_string()),
        }
    }
    tries.outcome()
}

/// Everything in a tree, with floats as their bits.
/// Boxes, kinds and order of a tree, as bits.
type TreeBits<'a> = (Vec<[[u32; 3]; 2]>, Vec<(bool, usize, usize)>, &'a [u32]);

fn bits(bvh: &FlatBvh) -> TreeBits<'_> {
    let boxes = bvh.nodes().iter().map(|node| {
        let bounds = node.bounds();
        [bounds.min, bounds.max].map(|corner| corner.to_array().map(f32::to_bits))
    });
    let links = bvh.nodes().iter().map(|node| (node.is_leaf(), node.second_child(), node.axis()));
    (boxes.collect(), links.collect(), bvh.order())
}
