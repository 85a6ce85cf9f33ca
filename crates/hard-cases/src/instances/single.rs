//! One level of instancing: rigid, scaled, sheared, mirrored, and far from its own origin.

use std::sync::Arc;

use geometry::glam::{DAffine3, DMat3, DVec3, Vec3};
use geometry::{Sphere, Transform, TriangleMesh};

use super::ellipsoid;
use super::placed::{Placed, bumpy, norm};
use crate::spheres::{Trials, in_parallel};
use crate::{Outcome, Random, Run};

/// Rays to a transform.
const RAYS: usize = 16;

/// A rotation by any angle around any axis.
pub(super) fn rotation(random: &mut Random) -> DMat3 {
    let axis = random.direction().as_dvec3();
    let angle = f64::from(random.unit()) * 360.0;
    Transform::rotate(angle, axis).map_or(DMat3::IDENTITY, |t| t.matrix().matrix3)
}

/// A translation by up to `distance` on each axis.
pub(super) fn translation(random: &mut Random, distance: f64) -> DVec3 {
    random.vector().as_dvec3() * distance
}

/// A scale of 10 to a power within ± `decades` on each axis.
fn scale(random: &mut Random, decades: f64) -> DVec3 {
    DVec3::from_array([0; 3].map(|_| 10.0_f64.powf(decades * f64::from(random.signed()))))
}

/// Rays at a mesh behind transforms that `make` draws; those that [`Transform`] refuses are not tried.
fn judge_all(run: &Run, stream: u32, make: impl Fn(&mut Random) -> DAffine3 + Sync) -> Outcome {
    in_parallel(run, stream, run.effort.pick(150, 6_000_000), |_, random, trials| {
        if let Ok(transform) = Transform::from_affine(make(random)) {
            judge_transform(trials, random, transform);
        }
    })
}

fn judge_transform(trials: &mut Trials, random: &mut Random, transform: Transform) {
    let size = random.power_of_two(-3.0, 3.0);
    let center = size * random.vector();
    let Some(placed) = bumpy(random, center, size).and_then(|mesh| Placed::new(mesh, vec![transform])) else { return };
    for _ in 0..RAYS {
        placed.judge(trials, &placed.aimed(random));
    }
    if let Ok(sphere) = Sphere::new(center, size) {
        ellipsoid::judge(trials, random, sphere, &transform);
    }
}

/// I02: rotations, and translations by 1 to 10⁷.
pub(super) fn rigid(run: &Run) -> Outcome {
    judge_all(run, 102, |random| {
        let distance = 10.0_f64.powf(7.0 * f64::from(random.unit()));
        DAffine3::from_mat3_translation(rotation(random), translation(random, distance))
    })
}

/// I03: 10⁻⁶ to 10⁶ times as large.
pub(super) fn uniform_scale(run: &Run) -> Outcome {
    judge_all(run, 103, |random| {
        let scale = 10.0_f64.powf(6.0 * f64::from(random.signed()));
        DAffine3::from_mat3_translation(rotation(random) * scale, translation(random, scale))
    })
}

/// I04: the axes scaled by factors that are up to 10⁶ apart.
pub(super) fn uneven_scale(run: &Run) -> Outcome {
    judge_all(run, 104, |random| {
        let scale = scale(random, 3.0);
        DAffine3::from_mat3_translation(DMat3::from_diagonal(scale), translation(random, scale.max_element()))
    })
}

/// I05: shears by up to 10³, and any matrix at all.
pub(super) fn shear(run: &Run) -> Outcome {
    judge_all(run, 105, |random| {
        let mut m = if random.bits() & 1 == 0 {
            DMat3::IDENTITY
        } else {
            DMat3::from_cols(random.vector().as_dvec3(), random.vector().as_dvec3(), random.vector().as_dvec3())
        };
        let (i, j) = (random.below(3), random.below(3));
        m.col_mut(i)[(i + 1 + j % 2) % 3] += 10.0_f64.powf(6.0 * f64::from(random.unit()) - 3.0);
        DAffine3::from_mat3_translation(m, translation(random, 10.0))
    })
}

/// I06: mirrored along one axis or along all of them. (The normal's side is judged in every case.)
pub(super) fn mirrored(run: &Run) -> Outcome {
    judge_all(run, 106, |random| {
        let mut scale = scale(random, 1.0);
        match random.below(4) {
            3 => scale = -scale,
            axis => scale[axis] = -scale[axis],
        }
        DAffine3::from_mat3_translation(rotation(random) * DMat3::from_diagonal(scale), translation(random, 10.0))
    })
}

/// I08: condition numbers from 10³ to 10¹². All below 2²⁰ are accepted; of what is accepted the answers are judged.
pub(super) fn nearly_singular(run: &Run) -> Outcome {
    in_parallel(run, 108, run.effort.pick(150, 6_000_000), |_, random, trials| {
        let flat = 10.0_f64.powf(-3.0 - 9.0 * f64::from(random.unit()));
        let squeeze = DMat3::from_diagonal(DVec3::new(1.0, flat, 1.0));
        let matrix = rotation(random) * squeeze * rotation(random);
        let transform = Transform::from_affine(DAffine3::from_mat3_translation(matrix, translation(random, 1.0)));
        let condition = norm(&matrix) * norm(&matrix.inverse());
        trials.count(if transform.is_ok() { "accepted" } else { "refused" }, 1);
        match transform {
            Ok(transform) => {
                trials.largest("condition accepted", condition);
                judge_transform(trials, random, transform);
            }
            Err(error) => {
                trials.check(condition > (1 << 20) as f64, || format!("{matrix}: {error}, κ is only {condition:e}"));
            }
        }
    })
}

/// I10: the direction is not normalised inside: whatever its length, t is the exact one. Scales of 2⁻⁶⁰ to 2⁶⁰.
pub(super) fn unnormalised(run: &Run) -> Outcome {
    in_parallel(run, 110, run.effort.pick(150, 6_000_000), |_, random, trials| {
        let scale = f64::from(random.power_of_two(-30.0, 30.0));
        let matrix = DAffine3::from_mat3_translation(rotation(random) * scale, translation(random, scale));
        let (Ok(transform), Some(mesh)) = (Transform::from_affine(matrix), bumpy(random, Vec3::ZERO, 1.0)) else {
            return;
        };
        let Some(placed) = Placed::new(mesh, vec![transform]) else { return };
        for _ in 0..RAYS {
            let mut ray = placed.aimed(random);
            ray.direction *= random.power_of_two(-60.0, 60.0);
            placed.judge(trials, &ray);
        }
    })
}

/// I19: a mesh 10³ to 10⁶ sizes from its own origin, that lands near the world's.
pub(super) fn far_from_its_origin(run: &Run) -> Outcome {
    in_parallel(run, 119, run.effort.pick(150, 6_000_000), |number, random, trials| {
        let size = random.power_of_two(-3.0, 3.0);
        let center = size * 10.0_f32.powf(3.0 + 3.0 * random.unit()) * random.direction();
        let matrix = if number % 3 == 0 { DMat3::IDENTITY } else { rotation(random) };
        let back = translation(random, f64::from(size)) - matrix * center.as_dvec3();
        let transform = Transform::from_affine(DAffine3::from_mat3_translation(matrix, back));
        // Faces along the axes have boxes without depth: the entry into them is as wrong as the local ray is.
        let mesh = if number % 2 == 0 { bumpy(random, center, size) } else { cube(center, size) };
        let (Ok(transform), Some(mesh)) = (transform, mesh) else { return };
        let Some(placed) = Placed::new(mesh, vec![transform]) else { return };
        for _ in 0..RAYS {
            placed.judge(trials, &placed.aimed(random));
        }
        if let Ok(sphere) = Sphere::new(center, size) {
            ellipsoid::judge(trials, random, sphere, &transform);
        }
    })
}

fn cube(center: Vec3, size: f32) -> Option<Arc<TriangleMesh>> {
    let [center, size] = [center.as_dvec3(), DVec3::splat(size.into())];
    scene::meshes::cuboid(center - size, center + size).ok().map(Arc::new)
}
