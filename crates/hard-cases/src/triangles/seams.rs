//! How a mesh is put together must not show: T11 to T13.

use std::ops::ControlFlow;
use std::sync::Arc;

use bvh_flat::{BuildConfig, BvhAggregate};
use geometry::glam::Vec3;
use geometry::{Bounds3, Hit, Interval, Ray, Shape, TraversalRay, TriangleMesh};
use oracle::{ExactHit, Oracle, Tally};
use primitive::{GeometricPrimitive, MaterialId, MediumInterface, Primitive, Surface};

use super::findings::{Fallible, Findings, in_chunks, outcome_of};
use super::generate::{soup, spiky_sphere};
use super::judge::Specimen;
use crate::{Aim, Case, Outcome, Random, Run, aimed_rays};

pub(super) const T11: Case = Case { id: "T11", title: "T-junctions: gaps are gaps", run: t11 };
pub(super) const T12: Case = Case { id: "T12", title: "unwelded seams, also between geometries", run: t12 };
pub(super) const T13: Case = Case { id: "T13", title: "either winding, and the sides of normals", run: t13 };

/// A sheet whose neighbour has a vertex in the middle of the common edge, which is 64 to 4096 ulp off: rays through the
/// gap or the overlap, and around it.
fn t11(run: &Run) -> Outcome {
    let mut random = Random::new(run.seed, 0x70b0);
    let junctions: Vec<(Vec3, Vec3, f32)> = (0..run.effort.pick(40, 400))
        .map(|_| {
            let (a, b) = (random.vector(), random.vector());
            let off = [64.0, 256.0, 1024.0, 4096.0][random.below(4)] * f32::EPSILON * random.signed().signum();
            (a, b, off)
        })
        .collect();
    let sheets = junctions.iter().enumerate().flat_map(|(i, &(a, b, off))| {
        let at = Vec3::Z * (3 * i) as f32;
        let (a, b, across) = (a + at, b + at, Vec3::new(a.y - b.y, b.x - a.x, 0.5));
        let middle = 0.5 * (a + b) + off * across;
        [[a, b, a + across], [a, middle, a - across], [middle, b, a - across]]
    });
    let specimen = soup(sheets).map_err(Into::into).and_then(|mesh| Specimen::new(run, mesh));
    outcome_of(specimen.map(|specimen| {
        let mut findings = in_chunks(run, 0x70b, run.effort.pick(20_000, 5_000_000), |i, random, findings| {
            let i = i % junctions.len();
            let [a, b, _] = specimen.mesh.vertices(3 * i);
            let target = a + (0.3 + 0.4 * random.unit()) * (b - a) + 2e-4 * random.vector();
            let origin = target + 4.0 * random.direction();
            let interval = Interval::new(0.5, 2.0);
            let hit = specimen.judge(&Ray::new(origin, target - origin), interval, findings);
            findings.count(if hit.is_some() { "hits" } else { "misses" }, 1);
        });
        findings.require_count("hits", 100);
        findings.require_count("misses", 100);
        findings
    }))
}

/// A closed mesh, as it is; with vertices of their own for each triangle, in another order; and in two halves that are
/// primitives of their own. All give the same t, and of equal ones the first in their own order: so nothing leaks where
/// indices and trees meet. Exact subjects compare exact t within a mesh; between the halves the rounded t counts.
fn t12(run: &Run) -> Outcome {
    let try_all = || -> Fallible<Findings> {
        let mut random = Random::new(run.seed, 0x70c0);
        let mesh = spiky_sphere(20, &mut random, |x| 1.0 + 5.0 * f64::from(x))?;
        let n = mesh.len();
        // 7 and the number of triangles have no common divisor: a permutation.
        let shuffled: Vec<usize> = (0..n).map(|i| (7 * i + 3) % n).collect();
        let unwelded = Specimen::new(run, soup(shuffled.iter().map(|&i| mesh.vertices(i)))?)?;
        let surface = Surface::of_material(MaterialId::from_index(0).ok_or("no material")?);
        let half = |part: &[usize]| -> Fallible<_> {
            let triangles = part.iter().map(|&i| mesh.triangles()[i]).collect();
            let mesh = Arc::new(TriangleMesh::new(mesh.positions().to_vec(), triangles)?);
            Ok(GeometricPrimitive::new(run.subject.shape(mesh)?, surface, MediumInterface::default()))
        };
        // Every third triangle is in the other half, so that the seams are everywhere.
        let (a, b): (Vec<usize>, Vec<usize>) = (0..n).partition(|i| i % 3 != 0);
        let halves = BvhAggregate::build(vec![half(&a)?, half(&b)?], &BuildConfig::default())?;
        let halved = [&a[..], &b[..]].concat();
        let specimen = Specimen::new(run, mesh)?;
        let middle = Bounds3::new(Vec3::splat(-0.3), Vec3::splat(0.3));
        Ok(in_chunks(run, 0x70c, run.effort.pick(30_000, 10_000_000), |i, random, findings| {
            let origin = random.point_in(&middle);
            let Some(ray) = aimed_rays(&specimen.mesh, Aim::ALL[i % 4], 1, random, |_| origin).next() else { return };
            let Some(prepared) = TraversalRay::new(&ray) else { return };
            let welded = specimen.closest(&ray, Interval::FULL);
            let ties = welded.map_or(Vec::new(), |hit| triangles_at(&specimen, &prepared, hit.t));
            let hits = if specimen.is_exact() {
                specimen.oracle.all_hits(&ray, Interval::FULL, &mut Tally::default())
            } else {
                Vec::new()
            };
            let first = |order: &[usize]| {
                if specimen.is_exact() {
                    return first_of(&hits, order);
                }
                let place = order.iter().position(|&i| ties.contains(&(i as u64)));
                welded.and_then(|hit| Some((hit.t, place? as u64)))
            };
            let first_of_halves = || {
                if !specimen.is_exact() {
                    return first(&halved);
                }
                let behind = first(&b).map(|(t, place)| (t, place + a.len() as u64));
                first(&a).into_iter().chain(behind).min_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)))
            };
            let answer = |hit: Option<Hit>| hit.map(|hit| (hit.t, hit.primitive));
            let (other, split) = (unwelded.closest(&ray, Interval::FULL), halves.intersect(&prepared, Interval::FULL));
            findings.count("leaks", [welded, other, split].iter().filter(|hit| hit.is_none()).count() as u64);
            findings.count("ties", u64::from(ties.len() > 1));
            let is_same = answer(other) == first(&shuffled) && answer(split) == first_of_halves();
            findings.check(welded.is_some() && is_same, || {
                format!("{ray:?}: welded {welded:?}, unwelded {other:?}, in halves {split:?}; ties {ties:?}")
            });
        }))
    };
    outcome_of(try_all())
}

/// Of the hits on triangles of `order` with the least t, the rounded t and the first place.
fn first_of(hits: &[ExactHit], order: &[usize]) -> Option<(f32, u64)> {
    let places = hits.iter().filter_map(|hit| Some((hit, order.iter().position(|&i| i as u64 == hit.primitive)?)));
    let mut places = places.peekable();
    let least = places.peek()?.0;
    let place = places.take_while(|(hit, _)| hit.t == least.t).map(|(_, place)| place).min()?;
    Some((least.t.to_f32(), place as u64))
}

/// All triangles that the subject reports at this t.
fn triangles_at(specimen: &Specimen, ray: &TraversalRay, t: f32) -> Vec<u64> {
    let mut found = Vec::new();
    let _ = specimen.shape.visit_hits(ray, Interval::FULL, &mut |hit: Hit| {
        if hit.t == t {
            found.push(hit.primitive);
        }
        ControlFlow::Continue(f32::INFINITY)
    });
    found
}

/// A mesh and the same inside out: the same triangles are hit, and the normals tell exactly which way the ray goes.
fn t13(run: &Run) -> Outcome {
    let try_all = || -> Fallible<Findings> {
        let mesh = spiky_sphere(20, &mut Random::new(run.seed, 0x70d0), |x| 1.0 + 5.0 * f64::from(x))?;
        let turned = mesh.triangles().iter().map(|&[a, b, c]| [a, c, b]).collect();
        let turned = Specimen::new(run, TriangleMesh::new(mesh.positions().to_vec(), turned)?)?;
        let specimen = Specimen::new(run, mesh)?;
        Ok(in_chunks(run, 0x70d, run.effort.pick(8_000, 2_000_000), |i, random, findings| {
            let origin = 8.0 * random.vector();
            let Some(ray) = aimed_rays(&specimen.mesh, Aim::ALL[i % 4], 1, random, |_| origin).next() else { return };
            let ray = if i % 5 == 0 { Ray::new(ray.origin.with_y(0.0), ray.direction.with_y(-0.0)) } else { ray };
            let front = specimen.judge(&ray, Interval::FULL, findings);
            let back = turned.judge(&ray, Interval::FULL, findings);
            let answer = |hit: Option<Hit>| hit.map(|hit| (hit.t, hit.primitive));
            findings.check(answer(front) == answer(back), || format!("{ray:?} hits {front:?}, turned {back:?}"));
            let (Some(hit), Some(prepared)) = (front, TraversalRay::new(&ray)) else { return };
            let normals = [&specimen, &turned].map(|s| s.shape.surface_point(&prepared, &hit).n);
            let crossings = specimen.oracle.crossings(&ray, Interval::FULL, &mut Tally::default());
            let crossing = crossings.iter().find(|crossing| crossing.hit.primitive == hit.primitive);
            let is_right = crossing.is_none_or(|c| c.is_outward == (normals[0].dot(ray.direction.as_dvec3()) > 0.0));
            findings
                .check(normals[0] == -normals[1] && is_right, || format!("{ray:?} hits {hit:?}, normals {normals:?}"));
        }))
    };
    outcome_of(try_all())
}
