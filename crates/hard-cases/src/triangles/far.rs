//! Triangles smaller than what f32 can tell of their distance: T25.

use geometry::glam::{DVec3, Vec3};
use geometry::{Interval, Ray};

use super::findings::{Fallible, Findings, in_chunks, outcome_of};
use super::generate::soup;
use super::judge::Specimen;
use crate::{Case, Outcome, Random, Run};

pub(super) const T25: Case = Case { id: "T25", title: "triangles 2^20 to 2^44 times their size away", run: t25 };

/// A triangle of about `size` near `at`, a point on the ray, which passes through its inside, at an edge, or at a
/// vertex. In three of four the vertices lie on either side of where f32 rounds a coordinate relative to the origin up
/// or down, a step that is larger than the triangle; else they are in one place for f32.
pub(crate) fn triangle_on_ray([origin, direction]: [DVec3; 2], at: DVec3, size: f64, random: &mut Random) -> [Vec3; 3] {
    let axis = random.below(3);
    let mut along = 0.0;
    if random.below(4) != 0 && direction[axis].abs() > 0.25 * direction.abs().max_element() {
        let from = f64::from(origin[axis] as f32);
        let step = f64::from((from.abs() as f32).next_up()) - from.abs();
        let middle = from + step * (((at[axis] - from) / step).floor() + 0.5);
        along = (middle - at[axis]) / direction[axis];
    }
    let p = at + along * direction;
    let [b, c] = [0; 2].map(|_| size * random.vector().as_dvec3());
    let [u, v] = [random.unit(), random.unit()].map(f64::from);
    let a = p - match random.below(3) {
        0 => 0.5 * (u * b + v * c),
        1 => u * b,
        _ => DVec3::ZERO,
    };
    [a, a + b, a + c].map(|p| p.as_vec3())
}

/// Sixteen triangles around the origin, each with a ray at it from 2²⁰ to 2⁴⁴ sizes away. The way is a power of two, so
/// that f32 holds an origin from which the ray passes through zero exactly: what is wrong is what the kernel rounds.
/// (Without the product of two errors in the wide tree's filter of triangles 646 of the quick trials fail;
/// `tests/suite/mutations` has that bound in a filter of its own.)
fn t25(run: &Run) -> Outcome {
    let view = |random: &mut Random, findings: &mut Findings| -> Fallible<()> {
        let far = 2.0_f32.powi(random.below(55) as i32 - 20);
        let size = f64::from(far * random.power_of_two(-44.0, -20.0));
        let directions = [0; 16].map(|_| random.direction());
        let ray = |d: Vec3| [-far * d, d].map(|v| v.as_dvec3());
        let mesh = soup(directions.map(|d| triangle_on_ray(ray(d), DVec3::ZERO, size, random)))?;
        let specimen = Specimen::new(run, mesh)?;
        for direction in directions {
            let hit = specimen.judge(&Ray::new(-far * direction, direction), Interval::FULL, findings);
            findings.count("hits", u64::from(hit.is_some()));
        }
        Ok(())
    };
    let count = run.effort.pick(600, 400_000);
    let mut findings = in_chunks(run, 0x719, count, |_, random, findings| {
        let tried = view(random, findings);
        findings.check(tried.is_ok(), || format!("could not be tried: {tried:?}"));
    });
    findings.require_count("hits", 8 * count as u64);
    outcome_of(Ok(findings))
}
