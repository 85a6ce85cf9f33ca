//! Coordinates that are large, small, or both: T07, T18, T19 and T23.

use geometry::glam::{DVec3, Vec3};
use geometry::{Bounds3, Interval, Ray, TraversalRay, TriangleMesh};
use scene::meshes;

use super::closed::{Closed, try_all};
use super::findings::{Fallible, Findings, Quantity, in_chunks, outcome_of};
use super::generate::{log_uniform, mapped, soup, spiky_sphere};
use super::judge::Specimen;
use crate::{Aim, Case, Outcome, Random, Run, aimed_rays};

pub(super) const T07: Case = Case { id: "T07", title: "everything scaled by 2^-60 to 2^57", run: t07 };
pub(super) const T18: Case = Case { id: "T18", title: "detail far from the origin", run: t18 };
pub(super) const T19: Case = Case { id: "T19", title: "coordinates whose products over- or underflow", run: t19 };
pub(super) const T23: Case = Case { id: "T23", title: "slivers without measurable area", run: t23 };

/// A power of two moves no bit: ids, u and v stay, and t is scaled exactly, whether the direction is scaled too or not.
fn t07(run: &Run) -> Outcome {
    let try_all = || -> Fallible<Findings> {
        let mesh = spiky_sphere(12, &mut Random::new(run.seed, 0x7070), |x| 1.0 + 5.0 * f64::from(x))?;
        let powers: Vec<i32> = (-60..=57).step_by(run.effort.pick(9, 1)).collect();
        let at = |k: i32| Ok((Specimen::new(run, mapped(&mesh, |p| p * 2.0_f64.powi(k))?)?, 2.0_f32.powi(k)));
        let scaled: Vec<(Specimen, f32)> = powers.into_iter().map(at).collect::<Fallible<_>>()?;
        let plain = Specimen::new(run, mesh)?;
        Ok(in_chunks(run, 0x707, run.effort.pick(4_000, 400_000), |i, random, findings| {
            let origin = 4.0 * random.vector();
            let Some(ray) = aimed_rays(&plain.mesh, Aim::ALL[i % 4], 1, random, |_| origin).next() else { return };
            let expected = plain.judge(&ray, Interval::FULL, findings);
            for (specimen, scale) in &scaled {
                for (direction, t_scale) in [(ray.direction, *scale), (ray.direction * *scale, 1.0)] {
                    let hit = specimen.closest(&Ray::new(ray.origin * *scale, direction), Interval::FULL);
                    let expected = expected.map(|hit| (hit.primitive, hit.t * t_scale, hit.u, hit.v));
                    findings.check(hit.map(|h| (h.primitive, h.t, h.u, h.v)) == expected, || {
                        format!("scaled by {scale}: {ray:?} hits {hit:?}, expected {expected:?}")
                    });
                }
            }
        }))
    };
    outcome_of(try_all())
}

/// Rough balls with edges of 10⁻³ to 1, at 1 to 10⁷ from the origin, as f32 rounds them. What rounding makes flat or
/// folded stays closed.
fn t18(run: &Run) -> Outcome {
    let mut random = Random::new(run.seed, 0x7120);
    let mut balls = Vec::new();
    for far in 0..8 {
        for detail in [1e-3, 1e-2, 1e-1, 1.0] {
            let at = DVec3::new(0.7, -0.9, 0.4) * 10.0_f64.powi(far);
            // An icosphere of three subdivisions has edges of about 0.14 radii.
            let radius = 7.0 * detail;
            let ulp = f64::from(f32::EPSILON) * at.length();
            if radius > 16.0 * ulp {
                balls.push((at, radius));
            }
        }
    }
    let closed = balls.into_iter().map(|(at, radius)| {
        let ball = meshes::icosphere(3, |_| 1.0 + 0.3 * f64::from(random.unit()))?;
        let mesh = mapped(&ball, |p| at + radius * p)?;
        let middle = Bounds3::new((at - 0.5 * radius).as_vec3(), (at + 0.5 * radius).as_vec3());
        Closed::around(run, mesh, 60, &middle, &mut random)
    });
    outcome_of(closed.collect::<Fallible<Vec<_>>>().map(|closed| {
        let leaks = try_all(run, 0x712, run.effort.pick(20_000, 5_000_000), &closed, &Aim::ALL);
        let judged = in_chunks(run, 0x722, run.effort.pick(15_000, 2_000_000), |i, random, findings| {
            let specimen = &closed[i % closed.len()].specimen;
            let bounds = specimen.shape.object_bound();
            let (origin, aim) =
                (bounds.centroid() + 2.0 * bounds.diagonal() * random.vector(), Aim::ALL[random.below(4)]);
            for ray in aimed_rays(&specimen.mesh, aim, 1, random, |_| origin) {
                specimen.judge(&ray, Interval::FULL, findings);
            }
        });
        let mut findings = leaks.and(judged);
        findings.require(Quantity::TError, 0.9999, 16.0);
        findings.require(Quantity::PointBound, 0.9999, 2.0);
        findings
    }))
}

/// Closed meshes of one size from 10⁻³⁰ to 2⁵⁷, and one with spikes from 10⁻⁶ to 10⁶ in it.
fn t19(run: &Run) -> Outcome {
    let mut random = Random::new(run.seed, 0x7130);
    let sizes = [1e-30, 1e-20, 1e-15, 1e-10, 1.0, 1e10, 1e15, 2.0_f64.powi(57)];
    let mut closed: Vec<Fallible<Closed>> = Vec::new();
    for size in sizes {
        let sphere = spiky_sphere(16, &mut random, |x| size * (1.0 + 5.0 * f64::from(x)));
        let middle = Bounds3::new(Vec3::splat(-0.3 * size as f32), Vec3::splat(0.3 * size as f32));
        closed.push(sphere.map_err(Into::into).and_then(|mesh| Closed::around(run, mesh, 60, &middle, &mut random)));
    }
    let radii: Vec<f32> = (0..400).map(|_| log_uniform(&mut random, 1e-6, 1e6)).collect();
    let wild = spiky_sphere(20, &mut random, |x| f64::from(radii[(x * 400.0) as usize]));
    let middle = Bounds3::new(Vec3::splat(-3e-7), Vec3::splat(3e-7));
    closed.push(wild.map_err(Into::into).and_then(|mesh| Closed::around(run, mesh, 60, &middle, &mut random)));
    let count = run.effort.pick(50_000, 10_000_000);
    outcome_of(closed.into_iter().collect::<Fallible<Vec<_>>>().map(|c| try_all(run, 0x713, count, &c, &Aim::ALL)))
}

/// Triangles with three vertices nearly, or exactly, in a row: as the oracle says, and without a NaN in anything.
fn t23(run: &Run) -> Outcome {
    let mut random = Random::new(run.seed, 0x7170);
    let slivers: Vec<[Vec3; 3]> = (0..run.effort.pick(300, 3_000))
        .map(|i| {
            let size = log_uniform(&mut random, 1e-8, 1e4);
            let (a, b) = (size * random.vector(), size * random.vector());
            let off = log_uniform(&mut random, 1e-18, 1e-6) * size * random.vector();
            match i % 4 {
                0 => [a, b, a.lerp(b, random.unit())],
                1 => [a, b, a.lerp(b, random.unit()) + off],
                2 => [a, b, b + off],
                _ => [a, a, b],
            }
        })
        .collect();
    let mesh = || -> Fallible<TriangleMesh> { Ok(soup(slivers)?) };
    outcome_of(mesh().and_then(|mesh| Specimen::new(run, mesh)).map(|specimen| {
        in_chunks(run, 0x717, run.effort.pick(15_000, 2_000_000), |i, random, findings| {
            let [a, b, c] = specimen.mesh.vertices(random.below(specimen.mesh.len()));
            let target = a + random.unit() * (b - a) + 0.5 * random.unit() * (c - a);
            let size = (b - a).length().max((c - a).length());
            let origin = target + size * random.direction();
            let ray = Ray::new(origin, if i % 2 == 0 { target - origin } else { a.midpoint(c) - origin });
            let Some(hit) = specimen.judge(&ray, Interval::FULL, findings) else { return };
            let Some(prepared) = TraversalRay::new(&ray) else { return };
            let point = specimen.shape.surface_point(&prepared, &hit);
            let all = [point.p, point.p_error, point.n, DVec3::new(hit.t.into(), hit.u.into(), hit.v.into())];
            let is_unit = (point.n.length() - 1.0).abs() < 1e-12;
            findings.count("hits", 1);
            findings.check(all.iter().all(|v| v.is_finite()) && is_unit && point.uv.is_finite(), || {
                format!("{ray:?} hits {hit:?} at {point:?}")
            });
        })
    }))
}
