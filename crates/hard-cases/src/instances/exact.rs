//! Transforms without any rounding: an instance is its flattened copy, to the bit.

use std::sync::Arc;

use geometry::glam::{DAffine3, DMat3, DVec3};
use geometry::{Interval, Transform, TraversalRay, TriangleMesh};
use primitive::Primitive;

use super::placed::{Placed, bumpy, mesh_primitive};
use crate::spheres::in_parallel;
use crate::{Outcome, Run};

/// I01: the identity, exchanges and mirrorings of the axes, and scales by powers of two. Hits, points and the answers
/// of any-hit are those of the mesh with transformed vertices.
pub(super) fn bit_identical(run: &Run) -> Outcome {
    in_parallel(run, 101, run.effort.pick(300, 3_000_000), |number, random, trials| {
        let mut axes = DVec3::AXES;
        for i in 0..3 {
            axes.swap(i, random.below(3));
            if random.bits() & 1 == 1 {
                axes[i] = -axes[i];
            }
        }
        let power = random.power_of_two(-30.0, 30.0).log2().round().exp2();
        let linear = DMat3::from_cols(axes[0], axes[1], axes[2]) * f64::from(power);
        let linear = if number == 0 { DMat3::IDENTITY } else { linear };
        let offset = random.vector();
        let mesh = bumpy(random, offset, 1.0);
        let (Ok(transform), Some(mesh)) = (Transform::from_affine(DAffine3::from_mat3(linear)), mesh) else { return };
        let moved = mesh.positions().iter().map(|p| transform.point(p.as_dvec3()).as_vec3());
        let flat = TriangleMesh::new(moved, mesh.triangles().to_vec()).ok().and_then(|m| mesh_primitive(&Arc::new(m)));
        let (Some(flat), Some(placed)) = (flat, Placed::new(mesh, vec![transform])) else { return };
        for _ in 0..16 {
            let ray = placed.aimed(random);
            let Some(traversal) = TraversalRay::new(&ray) else { continue };
            let answer = |primitive: &dyn Primitive| {
                let hit = primitive.intersect(&traversal, Interval::FULL);
                let p = hit.map(|hit| primitive.interaction(&traversal, &hit).p().map(|x| x + 0.0));
                let bits = hit.map(|hit| [hit.t, hit.u, hit.v].map(f32::to_bits));
                let any = primitive.intersect_p(&traversal, Interval::FULL);
                (bits, hit.map(|hit| hit.primitive), p.map(|p| p.to_array()), any)
            };
            let (instance, copy) = (answer(&*placed.primitive), answer(&*flat));
            trials.count("hits", u64::from(instance.3));
            trials.check(instance == copy, || format!("{placed:?} {ray:?}: {instance:?}, but the copy {copy:?}"));
        }
    })
}
