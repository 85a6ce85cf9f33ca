//! S21: boxes that are kept in bytes.

use std::sync::Arc;

use bvh_flat::{BuildConfig, BuildError, WideLayout, WideMesh};
use geometry::glam::Vec3;
use geometry::{Interval, Ray, TriangleMesh};

use crate::triangles::findings::{Fallible, Findings, in_chunks, outcome_of};
use crate::triangles::generate::{log_uniform, soup};
use crate::triangles::judge::Specimen;
use crate::{Aim, AnyShape, Library, Outcome, Random, Run, Subject};

/// The library's compact layout.
struct Compact;

impl Subject for Compact {
    fn name(&self) -> String {
        "wide, exact, compact".to_owned()
    }

    fn shape(&self, mesh: Arc<TriangleMesh>) -> Result<AnyShape, BuildError> {
        Ok(Box::new(WideMesh::build_observed(mesh, &BuildConfig::default(), WideLayout::Compact, &())?))
    }

    fn without_tree(&self, mesh: Arc<TriangleMesh>) -> AnyShape {
        Library::default().without_tree(mesh)
    }

    fn is_exact(&self) -> bool {
        true
    }
}

/// Tiny triangles at distances of 10⁻³ to 10⁶ from the origin, near which they are 10⁻³ large and farther away as small
/// as f32 has them: boxes span up to 10⁹ times what is in them. From within and from up to 10⁹ away, answers are the
/// exact ones. A ray then tests a large part of all triangles, so there are fewer than in other cases: of 300 000, and 4
/// million rays, the end was not in sight after 45 minutes.
pub(super) fn boxes(run: &Run) -> Outcome {
    let mesh = |random: &mut Random| {
        let triangles = (0..run.effort.pick(3_000, 30_000)).map(|_| {
            let a = log_uniform(random, 1e-3, 1e6) * random.direction();
            let size = (16.0 * f32::EPSILON * a.abs().max_element()).max(1e-3);
            [a, a + size * random.vector(), a + size * random.vector()]
        });
        soup(triangles.collect::<Vec<[Vec3; 3]>>())
    };
    let try_all = || -> Fallible<Findings> {
        let specimen = Specimen::new(&Run { subject: &Compact, ..*run }, mesh(&mut Random::new(run.seed, 121))?)?;
        let count = run.effort.pick(20_000, 400_000);
        let mut findings = in_chunks(run, 0x621, count, |i, random, findings| {
            let target = Aim::ALL[i % 4].target(&specimen.mesh, random);
            let origin = match i % 3 {
                0 => log_uniform(random, 1e-3, 1e6) * random.direction(),
                1 => log_uniform(random, 1e6, 1e9) * random.direction(),
                _ => target + log_uniform(random, 1e-3, 1e3) * Vec3::AXES[random.below(3)],
            };
            let hit = specimen.judge(&Ray::new(origin, target - origin), Interval::FULL, findings);
            findings.count("hits", u64::from(hit.is_some()));
        });
        findings.require_count("hits", count as u64 / 10);
        Ok(findings)
    };
    outcome_of(try_all())
}
