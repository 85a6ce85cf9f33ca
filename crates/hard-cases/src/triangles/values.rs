//! The values of hits: T08 and T16.

use geometry::glam::{DVec3, Vec3};
use geometry::{Interval, Ray, TraversalRay};
use scene::meshes;

use super::findings::{Fallible, Quantity, in_chunks, outcome_of};
use super::generate::{log_uniform, soup, spiky_sphere};
use super::judge::Specimen;
use crate::{Aim, Case, Outcome, Random, Run, aimed_rays};

pub(super) const T08: Case = Case { id: "T08", title: "skinny triangles, grazed at 0.01 to 1 degree", run: t08 };
pub(super) const T16: Case = Case { id: "T16", title: "t, barycentrics and hit points", run: t16 };

/// The shape of Embree's issue 387: edges of 11.2, 9.7 and 1.4, seen from 600 away under half a degree, where its
/// robust mode reported a hit at t = 12291; and variations of it. No t lies beyond the triangle's own vertices.
fn t08(run: &Run) -> Outcome {
    let mut random = Random::new(run.seed, 0x7080);
    let count = run.effort.pick(300, 3_000);
    let triangles: Vec<([Vec3; 3], Vec3)> = (0..count)
        .map(|i| {
            let skinny = if i == 0 { 1.4 } else { log_uniform(&mut random, 0.01, 3.0) };
            let (along, at) = (random.direction(), 300.0 * random.vector());
            let across = along.cross(random.direction()).normalize_or(Vec3::Y);
            // The third corner over 9.7 of the long edge's 11.2, at the height that leaves the shortest edge.
            let height = skinny * 0.3;
            ([at, at + 11.2 * along, at + 9.7 * along + height * across], along.cross(across))
        })
        .collect();
    let specimen = soup(triangles.iter().map(|t| t.0)).map_err(Into::into).and_then(|mesh| Specimen::new(run, mesh));
    outcome_of(specimen.map(|specimen| {
        let mut findings = in_chunks(run, 0x708, run.effort.pick(20_000, 1_000_000), |_, random, findings| {
            let i = random.below(count);
            let ([a, b, c], normal) = triangles[i];
            let target = a + random.unit() * (b - a) + random.unit() * (c - a);
            let degrees = log_uniform(random, 0.01, 1.0);
            let aside = (random.signed() * (b - a).normalize_or(Vec3::X)
                + random.signed() * (c - a).normalize_or(Vec3::Y))
            .normalize_or(Vec3::X);
            let origin = target + 600.0 * (aside + degrees.to_radians() * normal);
            let direction = (target - origin).normalize_or(Vec3::X);
            let ray = Ray::new(origin, direction);
            let Some(hit) = specimen.judge(&ray, Interval::FULL, findings) else { return };
            findings.count("hits", 1);
            // Depths along the ray's largest component, in which t counts.
            let k = (0..3).max_by(|&i, &j| direction[i].abs().total_cmp(&direction[j].abs())).unwrap_or(0);
            let depths =
                specimen.vertices(hit.primitive).map(|v| (v[k] - f64::from(origin[k])) / f64::from(direction[k]));
            let (near, far) =
                (depths.into_iter().fold(f64::INFINITY, f64::min), depths.into_iter().fold(0.0, f64::max));
            let t = f64::from(hit.t);
            findings.check(near * (1.0 - 1e-7) <= t && t <= far * (1.0 + 1e-7), || {
                format!("t beyond the triangle at {near} to {far}: {ray:?} hits {hit:?}")
            });
        });
        findings.require_count("hits", 1_000);
        findings
    }))
}

/// Everything that a hit says, on rough balls and spikes seen from inside and from up to a thousand radii away: the
/// barycentrics are in range and name the same point as t, t is as exact as demanded, and the bound holds and is tight.
fn t16(run: &Run) -> Outcome {
    let try_all = || -> Fallible<_> {
        let mut random = Random::new(run.seed, 0x7100);
        let meshes = [
            meshes::icosphere(4, |_| 1.0 + 0.2 * f64::from(random.unit()))?,
            spiky_sphere(16, &mut random, |x| 1.0 + 5.0 * f64::from(x))?,
            meshes::cuboid(DVec3::new(-1.0, -2.0, -0.5), DVec3::new(1.5, 0.3, 0.7))?,
        ];
        let specimens: Vec<Specimen> = meshes.into_iter().map(|m| Specimen::new(run, m)).collect::<Fallible<_>>()?;
        let mut findings = in_chunks(run, 0x710, run.effort.pick(20_000, 10_000_000), |i, random, findings| {
            let specimen = &specimens[i % specimens.len()];
            let origin = log_uniform(random, 0.1, 1e3) * random.direction();
            let aim = Aim::ALL[random.below(3)];
            let Some(ray) = aimed_rays(&specimen.mesh, aim, 1, random, |_| origin).next() else { return };
            // Half of the rays somewhere into the triangle beside the target.
            let ray = if i % 2 == 0 { Ray::new(origin, ray.direction + 0.1 * random.vector()) } else { ray };
            let Some(hit) = specimen.judge(&ray, Interval::FULL, findings) else { return };
            let [a, b, c] = specimen.vertices(hit.primitive);
            let (u, v) = (f64::from(hit.u), f64::from(hit.v));
            let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
            let (from_uv, from_t) = (a + u * (b - a) + v * (c - a), o + f64::from(hit.t) * d);
            let size =
                [o, f64::from(hit.t) * d, a, b, c].map(|v| v.abs().max_element()).into_iter().fold(0.0, f64::max);
            let difference = (from_uv - from_t).abs().max_element() / (size * f64::from(f32::EPSILON));
            findings
                .check(difference <= 4.0, || format!("{difference} ulp between (u, v) and t: {ray:?} hits {hit:?}"));
            let prepared = TraversalRay::new(&ray);
            let n = prepared.map_or(DVec3::ZERO, |ray| specimen.shape.surface_point(&ray, &hit).n);
            let across = n.dot(specimen.normal(hit.primitive).normalize_or_zero());
            findings
                .check((n.length() - 1.0).abs() < 1e-12 && across > 1.0 - 1e-9, || format!("the normal {n}: {ray:?}"));
        });
        findings.require(Quantity::TError, 0.9999, 16.0);
        findings.require(Quantity::PointBound, 1.0, 2.0);
        Ok(findings)
    };
    outcome_of(try_all())
}
