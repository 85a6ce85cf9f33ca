//! Small integers, where edge functions are exactly zero: T05, T09 and T10.

use geometry::glam::{DVec3, Vec3};
use geometry::{ClosestHit, Interval, Ray, TraversalRay, TriangleMesh};
use oracle::{PointLocation, Tally};
use scene::meshes;

use super::findings::{Fallible, Findings, in_chunks, outcome_of};
use super::generate::{mapped, soup, voxels};
use super::judge::Specimen;
use crate::{Case, Outcome, Random, Run};

pub(super) const T05: Case = Case { id: "T05", title: "lattices, along axes and diagonals", run: t05 };
pub(super) const T09: Case = Case { id: "T09", title: "rays in the planes of triangles", run: t09 };
pub(super) const T10: Case = Case { id: "T10", title: "cubes, along edges and diagonals", run: t10 };

/// An integer from −`n` to `n` on each axis.
fn integers(random: &mut Random, n: usize) -> Vec3 {
    Vec3::from_array([0; 3].map(|_| random.below(2 * n + 1) as f32 - n as f32))
}

/// The direction with the sign of each zero drawn.
fn with_random_zeros(d: Vec3, random: &mut Random) -> Vec3 {
    Vec3::from_array(d.to_array().map(|x| if x == 0.0 { [0.0, -0.0][random.below(2)] } else { x }))
}

/// A solid block with random cells missing from its middle and its faces.
fn block(n: i32, random: &mut Random) -> Fallible<TriangleMesh> {
    let missing: Vec<bool> = (0..n * n * n).map(|_| random.below(3) == 0).collect();
    Ok(voxels(n, |[x, y, z]| !missing[(x + n * (y + n * z)) as usize])?)
}

/// Rays with slopes of 0, 1, 2 and 1/2 through lattice points and midlines. Nothing is rounded in any of them, so the
/// answer is the canonical one. They may not cost more than three times the work of rays beside the lattice.
fn t05(run: &Run) -> Outcome {
    let n = run.effort.pick(10, 24);
    let specimen = block(n, &mut Random::new(run.seed, 0x7050)).and_then(|mesh| Specimen::new(run, mesh));
    let count = run.effort.pick(15_000, 5_000_000);
    outcome_of(specimen.map(|specimen| {
        let mut findings = in_chunks(run, 0x705, count, |_, random, findings| {
            let target = 0.5 * integers(random, 2 * n as usize).abs();
            let slopes =
                [Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::ONE, Vec3::new(2.0, 1.0, 0.0), Vec3::new(2.0, 1.0, -1.0)];
            let mut d = slopes[[0, 0, 1, 2, 3, 4][random.below(6)]].to_array();
            d.rotate_right(random.below(3));
            let d = with_random_zeros(Vec3::from_array(d.map(|x| x * [1.0, -1.0][random.below(2)])), random);
            let origin = target - random.below(2 * n as usize) as f32 * 0.5 * d;
            let ray = Ray::new(origin, d * 2.0_f32.powi(random.below(9) as i32 - 4));
            specimen.judge_strictly(&ray, Interval::FULL, findings);
            let beside = Ray::new(origin + Vec3::new(0.31, 0.23, 0.17), ray.direction);
            findings.count("work on the lattice", work(&specimen, &ray));
            findings.count("work beside the lattice", work(&specimen, &beside));
        });
        let (on, beside) = (findings.counted("work on the lattice"), findings.counted("work beside the lattice"));
        findings.check(on <= 3 * beside, || format!("the lattice costs {on} steps, {beside} beside it"));
        findings
    }))
}

/// Nodes and triangles of a closest-hit query.
fn work(specimen: &Specimen, ray: &Ray) -> u64 {
    let Some(ray) = TraversalRay::new(ray) else { return 0 };
    let mut closest = ClosestHit::new(Interval::FULL);
    let _ = specimen.shape.visit_hits(&ray, Interval::FULL, &mut closest);
    closest.work().nodes + closest.work().primitives
}

/// Lone triangles are not hit by rays in their plane where nothing is rounded; where the shear is, such hits are
/// counted. In a closed mesh with walls that the rays run along, the neighbours keep everything closed.
fn t09(run: &Run) -> Outcome {
    let count = run.effort.pick(20_000, 5_000_000);
    let alone = in_chunks(run, 0x709, count, |i, random, findings| {
        let [a, b, c] = [0; 3].map(|_| integers(random, 6));
        let (p, q) = (random.below(7) as f32 - 3.0, random.below(7) as f32 - 3.0);
        let d = if i % 4 == 0 { b - a } else { p * (b - a) + q * (c - a) };
        let inner = a + random.below(3) as f32 * (b - a) + random.below(2) as f32 * (c - a);
        let (ray, Ok(mesh)) = (Ray::new(inner - 4.0 * d, with_random_zeros(d, random)), soup([[a, b, c]])) else {
            return;
        };
        let Ok(specimen) = Specimen::new(run, mesh) else { return };
        let is_exact = d.abs().max_element().log2().fract() == 0.0;
        if is_exact {
            specimen.judge_strictly(&ray, Interval::FULL, findings);
        } else {
            specimen.judge(&ray, Interval::FULL, findings);
        }
    });
    let n = run.effort.pick(8, 16);
    outcome_of(rough_blocks(run, n).map(|blocks| {
        let closed = in_chunks(run, 0x719, 2 * count, |i, random, findings| {
            let (specimen, map) = &blocks[i % blocks.len()];
            let origin = 0.5 * integers(random, 2 * n as usize).abs();
            let (d, far) = (integers(random, 3), random.below(3) as f32);
            let (origin, d) = (map(origin), if i / 3 % 2 == 0 { map(d) } else { map(origin + far * d) - map(origin) });
            let ray = Ray::new(origin, with_random_zeros(d, random));
            let inside = specimen.oracle.locate(origin, &mut Tally::default()) == PointLocation::Inside;
            if inside && d != Vec3::ZERO {
                let hit = specimen.judge(&ray, Interval::FULL, findings);
                findings.count("rays from inside", 1);
                findings.count("leaks", u64::from(hit.is_none()));
                findings.check(hit.is_some(), || format!("a leak: {ray:?}"));
            }
        });
        let mut findings = alone.and(closed);
        findings.require_count("rays from inside", count as u64 / 20);
        findings
    }))
}

type Map = fn(Vec3) -> Vec3;

/// A block of cells with walls to run along, and the same with coordinates and planes that floats do not have.
fn rough_blocks(run: &Run, n: i32) -> Fallible<Vec<(Specimen, Map)>> {
    let maps: [Map; 3] =
        [|p| p, |p| p * 0.1 + Vec3::new(0.3, 0.7, -0.9), |p| Vec3::new(p.x - p.y, p.y + p.z, p.z) / 3.0];
    let mut random = Random::new(run.seed, 0x7090);
    let mesh = block(n, &mut random)?;
    let specimen = |map: Map| {
        let mesh = mapped(&mesh, |p| map(p.as_vec3()).as_dvec3())?;
        Ok((Specimen::new(run, mesh)?, map))
    };
    maps.into_iter().map(specimen).collect()
}

/// All lattice rays at a cube of lattice size, strictly; and at cubes elsewhere, where rays with a piece inside must
/// meet the surface.
fn t10(run: &Run) -> Outcome {
    let cube =
        |side: f64| Ok::<_, Box<dyn std::error::Error + Send + Sync>>(meshes::cuboid(DVec3::ZERO, DVec3::splat(side))?);
    let exact = || -> Fallible<Findings> {
        let specimen = Specimen::new(run, cube(2.0)?)?;
        let n = 5 * 5 * 5;
        // Origins from −1 to 3, directions from −2 to 2; with 0 and −0.
        Ok(in_chunks(run, 0x70a, run.effort.pick(n * n, 8 * n * n), |i, random, findings| {
            let lattice = |i: usize| Vec3::new((i % 5) as f32, (i / 5 % 5) as f32, (i / 25 % 5) as f32);
            let d = with_random_zeros(lattice(i / n) - 2.0, random);
            specimen.judge_strictly(&Ray::new(lattice(i % n) - 1.0, d), Interval::FULL, findings);
        }))
    };
    let rounded = || -> Fallible<Findings> {
        let side = 0.7_f32;
        let corner = |i: usize, far: f32| Vec3::from_array([0, 1, 2].map(|a| if i >> a & 1 == 1 { far } else { 0.0 }));
        let at = [Vec3::ZERO, Vec3::new(0.1, -0.3, 77.7), Vec3::new(1e4, -3e3, 0.1)];
        let cubes: Fallible<Vec<_>> = at
            .iter()
            .map(|&at| Ok((Specimen::new(run, mapped(&cube(side.into())?, |p| p + at.as_dvec3())?)?, at)))
            .collect();
        let cubes = cubes?;
        Ok(in_chunks(run, 0x71a, run.effort.pick(15_000, 2_000_000), |i, random, findings| {
            let (specimen, at) = &cubes[i % cubes.len()];
            // Through two opposite corners, or from the middle to a corner, an edge's middle or along a face diagonal.
            let corners =
                [random.below(8), random.below(8)].map(|i| (at.as_dvec3() + corner(i, side).as_dvec3()).as_vec3());
            let middle = *at + 0.5 * side;
            let (origin, target) = match i / 3 % 3 {
                0 => (middle, corners[0]),
                1 => (middle, 0.5 * corners[0] + 0.5 * corners[1]),
                _ => (corners[0] + (1.0 + random.unit()) * (corners[0] - middle), middle),
            };
            let ray = Ray::new(origin, target - origin);
            if ray.direction.length() > 0.01 {
                let hit = specimen.judge(&ray, Interval::FULL, findings);
                findings.count("leaks", u64::from(hit.is_none()));
                findings.check(hit.is_some(), || format!("a leak: {ray:?}"));
            }
        }))
    };
    outcome_of(exact().and_then(|exact| Ok(exact.and(rounded()?))))
}
