//! Triangles smaller than what f32 can tell of their distance, in instances: I20.

use geometry::glam::{DAffine3, DMat3, DVec3};
use geometry::{Ray, Transform, TriangleMesh};

use super::placed::Placed;
use crate::spheres::in_parallel;
use crate::triangles::far::triangle_on_ray;
use crate::triangles::generate::soup;
use crate::{Outcome, Random, Run};

/// I20: rays that f64 holds exactly in the mesh's space and f32 does not, from 2²² to 2³⁶ sizes away. Nothing is
/// excused.
///
/// Of the wide tree's filter of triangles, the error of the rounded origin covers the product of two errors, and the
/// other way round: without either of them all passes, without both 230 of the 20 000 quick trials fail (by hand,
/// 2026-11-25).
pub(super) fn small_triangles(run: &Run) -> Outcome {
    in_parallel(run, 120, run.effort.pick(400, 300_000), |number, random, trials| {
        // Maps whose inverses f64 holds.
        let maps = [
            DMat3::IDENTITY,
            DMat3::from_cols(DVec3::new(1.0, 2.0, 0.0), DVec3::Y, DVec3::new(3.0, 0.0, 1.0)),
            DMat3::from_cols(DVec3::new(0.0, -0.25, 0.0), DVec3::Z, DVec3::new(8.0, 0.0, 0.0)),
        ];
        let map = maps[number as usize % maps.len()];
        let far = 2.0_f64.powi(random.below(55) as i32 - 20);
        let size = far * f64::from(random.power_of_two(-36.0, -22.0));
        // 2⁻²⁰ from the object's origin, by numbers of 26 bits.
        let at = far * 2.0_f64.powi(-46) * (2.0_f64.powi(26) * random.vector().as_dvec3()).round();
        let matrix = DAffine3::from_mat3_translation(map, -(map * at));
        let directions: Vec<_> = (0..24).map(|_| random.vector()).collect();
        let inverse = map.inverse();
        let on_ray = |d: DVec3, random: &mut Random| triangle_on_ray([at - far * d, d], at, size, random);
        let mesh = soup(directions.iter().map(|d| on_ray(inverse * d.as_dvec3(), random)));
        let placed = placed(mesh.ok(), matrix);
        trials.check(placed.is_some(), || format!("{matrix:?} is refused"));
        let Some(placed) = placed else { return };
        let ray = |d: geometry::glam::Vec3| Ray::new((-far * d.as_dvec3()).as_vec3(), d);
        let hits = directions.iter().filter(|d| placed.judge_strictly(trials, &ray(**d))).count();
        trials.check(hits > 0, || format!("{placed:?} is not hit by any of the rays at it"));
    })
}

fn placed(mesh: Option<TriangleMesh>, matrix: DAffine3) -> Option<Placed> {
    Placed::new(mesh?.into(), vec![Transform::from_affine(matrix).ok()?])
}
