//! All hits of a ray: T21 and T22.

use std::ops::ControlFlow;

use geometry::glam::{DVec3, Vec3};
use geometry::{Bounds3, Hit, Interval, Ray, TraversalRay};
use oracle::{Oracle, PointLocation, Tally};
use scene::meshes;

use super::findings::{Fallible, Findings, in_chunks, outcome_of};
use super::generate::spiky_sphere;
use super::judge::Specimen;
use crate::{Aim, Case, Outcome, Random, Run};

pub(super) const T21: Case = Case { id: "T21", title: "inside or outside, by the parity of hits", run: t21 };
pub(super) const T22: Case = Case { id: "T22", title: "all hits through stacked sheets", run: t22 };

/// The primitives of all hits, and whether each was told once.
fn all_hits(specimen: &Specimen, ray: &Ray) -> (Vec<u64>, bool) {
    let mut found = Vec::new();
    if let Some(ray) = TraversalRay::new(ray) {
        let _ = specimen.shape.visit_hits(&ray, Interval::FULL, &mut |hit: Hit| {
            found.push(hit.primitive);
            ControlFlow::Continue(f32::INFINITY)
        });
    }
    found.sort_unstable();
    let told = found.len();
    found.dedup();
    let is_once = found.len() == told;
    (found, is_once)
}

/// A trial: all hits are the exact ones, each once. Triangles whose edge the ray passes nearby may be there or not,
/// unless the subject is exact, and are counted where they differ. Returns the hits, and whether all of them are far
/// from edges.
fn judge_list(specimen: &Specimen, ray: &Ray, findings: &mut Findings) -> (Vec<u64>, bool) {
    let (found, is_once) = all_hits(specimen, ray);
    let hits = specimen.oracle.all_hits(ray, Interval::FULL, &mut Tally::default());
    let mut exact: Vec<u64> = hits.iter().map(|hit| hit.primitive).collect();
    exact.sort_unstable();
    let difference: Vec<u64> = found
        .iter()
        .filter(|p| !exact.contains(p))
        .chain(exact.iter().filter(|p| !found.contains(p)))
        .copied()
        .collect();
    findings.count("disagreements at edges", difference.len() as u64);
    findings.check(is_once && difference.iter().all(|&p| specimen.is_excused(ray, p)), || {
        format!("{ray:?} hits {found:?}, each once: {is_once}; exact are {exact:?}")
    });
    let is_clear = found.iter().chain(&exact).all(|&p| !specimen.passes_near(ray, p));
    (found, is_clear)
}

/// Points in and around spikes and a knot, with three rays each. The count is that of closed triangles, so where the
/// ray passes an edge it says nothing, which is counted.
fn t21(run: &Run) -> Outcome {
    let try_all = || -> Fallible<Findings> {
        let mut random = Random::new(run.seed, 0x7150);
        let meshes = [
            spiky_sphere(24, &mut random, |x| 1.0 + 5.0 * f64::from(x))?,
            meshes::torus_knot([2, 3], [2.0, 1.0], 0.4, 120, 12)?,
        ];
        let specimens: Vec<Specimen> = meshes.into_iter().map(|m| Specimen::new(run, m)).collect::<Fallible<_>>()?;
        let mut findings = in_chunks(run, 0x715, run.effort.pick(8_000, 1_000_000), |i, random, findings| {
            let specimen = &specimens[i % specimens.len()];
            let p = random.point_in(&Bounds3::new(Vec3::splat(-4.0), Vec3::splat(4.0)));
            let location = specimen.oracle.locate(p, &mut Tally::default());
            if location == PointLocation::OnSurface {
                return;
            }
            let is_inside = location == PointLocation::Inside;
            for _ in 0..3 {
                let ray = Ray::new(p, random.direction());
                let (hits, is_clear) = judge_list(specimen, &ray, findings);
                findings.count(if is_clear { "rays that tell" } else { "rays at edges" }, 1);
                findings.check(!is_clear || (hits.len() % 2 == 1) == is_inside, || {
                    format!("{location:?}, but {} hits: {ray:?}", hits.len())
                });
            }
        });
        findings.require_count("rays that tell", run.effort.pick(20_000, 2_500_000));
        Ok(findings)
    };
    outcome_of(try_all())
}

/// Twenty sheets of lattice quads over each other, with rays through corners, edges and diagonals of all at once, and
/// anywhere. Straight down nothing is rounded, and every list is exact.
fn t22(run: &Run) -> Outcome {
    let try_all = || -> Fallible<Findings> {
        let (n, sheets) = (4, 20);
        let grids: Vec<_> = (0..sheets)
            .map(|y| meshes::grid(n, n, |x, z| DVec3::new(x as f64, f64::from(y), z as f64)))
            .collect::<Result<_, _>>()?;
        let specimen = Specimen::new(run, meshes::merge(&grids)?)?;
        Ok(in_chunks(run, 0x716, run.effort.pick(8_000, 1_000_000), |i, random, findings| {
            let lattice = |random: &mut Random| 0.5 * random.below(2 * n + 1) as f32;
            let target = Vec3::new(lattice(random), random.below(sheets as usize) as f32, lattice(random));
            let mut own = Findings::default();
            let ray = match i % 3 {
                0 => Ray::new(target.with_y(25.0), Vec3::new(0.0, -1.0, -0.0)),
                1 => {
                    let origin =
                        Vec3::new(6.0 * random.unit() - 1.0, 30.0 * random.signed() + 10.0, 6.0 * random.unit() - 1.0);
                    Ray::new(origin, target - origin)
                }
                _ => {
                    let origin = random.point_in(&specimen.shape.object_bound());
                    let aim = Aim::Edge.target(&specimen.mesh, random);
                    Ray::new(origin, aim - origin)
                }
            };
            let (hits, _) = judge_list(&specimen, &ray, &mut own);
            let differences = own.counted("disagreements at edges");
            own.check(i % 3 != 0 || (differences == 0 && hits.len() >= sheets as usize), || {
                format!("{differences} differences, {} hits: {ray:?}", hits.len())
            });
            *findings = std::mem::take(findings).and(own);
        }))
    };
    outcome_of(try_all())
}
