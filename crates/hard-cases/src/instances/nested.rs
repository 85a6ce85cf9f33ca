//! Instances in instances.

use geometry::Transform;
use geometry::glam::{DAffine3, DMat3, Vec3};

use super::placed::{Placed, bumpy};
use super::single::{rotation, translation};
use crate::spheres::in_parallel;
use crate::{Outcome, Random, Run};

/// `depth` turned, translated and slightly scaled spaces in one another.
fn chain(random: &mut Random, depth: usize, distance: f64) -> Vec<Transform> {
    let level = |_| {
        let scale = f64::from(random.power_of_two(-0.5, 0.5));
        let matrix = DAffine3::from_mat3_translation(rotation(random) * scale, translation(random, distance));
        Transform::from_affine(matrix).ok()
    };
    (0..depth).filter_map(level).collect()
}

/// I09: 1 to 64 levels, up to 10³ apart. The point, before it is rounded, is off by at most 0.1 ulp of f32 for each
/// level.
pub(super) fn deep(run: &Run) -> Outcome {
    in_parallel(run, 109, run.effort.pick(70, 1_000_000), |number, random, trials| {
        let depth = 1 << (number % 7);
        let distance = 10.0_f64.powf(3.0 * f64::from(random.unit()));
        let chain = chain(random, depth, distance);
        let Some(mut placed) = bumpy(random, Vec3::ZERO, 1.0).and_then(|mesh| Placed::new(mesh, chain)) else { return };
        placed.limits = Some((0.1, f64::INFINITY));
        for _ in 0..if depth > 16 { 2 } else { 8 } {
            placed.judge(trials, &placed.aimed(random));
        }
    })
}

/// I18: the bound of the point after k levels holds, and at 16 levels it is at most 4 ulp. Rigid and mirrored levels.
pub(super) fn bounds_of_points(run: &Run) -> Outcome {
    in_parallel(run, 118, run.effort.pick(100, 3_000_000), |number, random, trials| {
        let depth = [1, 2, 4, 8, 16][(number % 5) as usize];
        let mirror =
            |t: Transform| Transform::scale(DMat3::IDENTITY.x_axis * -2.0 + 1.0).and_then(|m| t.then_inside(&m)).ok();
        let chain = chain(random, depth, 100.0)
            .into_iter()
            .filter_map(|t| if random.below(3) == 0 { mirror(t) } else { Some(t) });
        let chain: Vec<Transform> = chain.collect();
        let Some(mut placed) = bumpy(random, Vec3::ZERO, 1.0).and_then(|mesh| Placed::new(mesh, chain)) else { return };
        placed.limits = Some((0.1, 4.0));
        for _ in 0..8 {
            placed.judge(trials, &placed.aimed(random));
        }
    })
}
