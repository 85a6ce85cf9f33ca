//! One answer from every instruction set: T17.

use std::sync::Arc;

use bvh_flat::{BuildConfig, SimdWidth, WideMesh};
use geometry::{Hit, Interval, Ray, Shape, TraversalRay};
use scene::meshes;

use super::findings::{Fallible, Findings, in_chunks, outcome_of};
use super::generate::{log_uniform, spiky_sphere};
use crate::exact_triangles::ExactTriangles;
use crate::{Aim, Case, Outcome, Random, Run};

pub(super) const T17: Case = Case { id: "T17", title: "one answer from every instruction set", run: t17 };

/// Spikes and a rough ball, aimed at where triangles meet, from within and from up to a thousand radii away, with the
/// interval also ending at the hit: the bits of every width that the processor has are those of no tree and no lanes.
fn t17(run: &Run) -> Outcome {
    let try_all = || -> Fallible<Findings> {
        let mut random = Random::new(run.seed, 0x7110);
        let meshes = [
            spiky_sphere(12, &mut random, |x| 1.0 + 5.0 * f64::from(x))?,
            meshes::icosphere(2, |_| 1.0 + 0.2 * f64::from(random.unit()))?,
        ];
        let trees: Vec<(ExactTriangles, WideMesh)> = meshes
            .into_iter()
            .map(|mesh| {
                let mesh = Arc::new(mesh);
                Ok((ExactTriangles::new(Arc::clone(&mesh)), WideMesh::build(mesh, &BuildConfig::default())?))
            })
            .collect::<Fallible<_>>()?;
        let mut findings = in_chunks(run, 0x711, run.effort.pick(6_000, 1_000_000), |i, random, findings| {
            let (alone, wide) = &trees[i % trees.len()];
            let origin = log_uniform(random, 0.1, 1e3) * random.direction();
            let target = Aim::ALL[random.below(4)].target(wide.mesh(), random);
            let Some(ray) = TraversalRay::new(&Ray::new(origin, target - origin)) else { return };
            let closest = alone.intersect(&ray, Interval::FULL);
            findings.count("hits", u64::from(closest.is_some()));
            let t = closest.map_or(1.0, |hit| hit.t);
            let behind = Interval::new(t, f32::INFINITY);
            for interval in [Interval::FULL, Interval::up_to(t), Interval::up_to(t.next_up()), behind] {
                let expected = bits(alone.intersect(&ray, interval));
                for width in SimdWidth::available() {
                    let wide = wide.with_simd_width(width);
                    let (hit, any) = (wide.intersect(&ray, interval), wide.intersect_p(&ray, interval));
                    findings.check(bits(hit) == expected && any == expected.is_some(), || {
                        format!("{}: {ray:?} {interval:?} hits {hit:?}, any {any}, not {expected:?}", width.name())
                    });
                }
            }
        });
        findings.count("widths", SimdWidth::available().len() as u64);
        findings.require_count("hits", run.effort.pick(3_000, 500_000));
        Ok(findings)
    };
    outcome_of(try_all())
}

fn bits(hit: Option<Hit>) -> Option<(u64, [u32; 3])> {
    hit.map(|h| (h.primitive, [h.t, h.u, h.v].map(f32::to_bits)))
}
