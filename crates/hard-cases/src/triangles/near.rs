//! Origins and surfaces that are next to each other: T14, T15, T20 and T24.

use std::cmp::Ordering;

use geometry::glam::{DVec2, Vec3};
use geometry::{Hit, Interval, MeshError, Ray, TriangleMesh};
use oracle::Tally;
use scene::meshes;

use super::findings::{Fallible, Findings, in_chunks, outcome_of};
use super::generate::{log_uniform, soup, spiky_sphere};
use super::judge::{Specimen, TIES};
use crate::{Case, Outcome, Random, Run};

pub(super) const T14: Case = Case { id: "T14", title: "origins on planes, edges and vertices", run: t14 };
pub(super) const T15: Case = Case { id: "T15", title: "origins 1 to 8 ulp off the surface", run: t15 };
pub(super) const T20: Case = Case { id: "T20", title: "double layers 1 to 4 ulp apart", run: t20 };
pub(super) const T24: Case = Case { id: "T24", title: "triangles that reach around the origin", run: t24 };

/// A trial: what was hit lies ahead of the origin, exactly, however near.
fn check_ahead(specimen: &Specimen, ray: &Ray, hit: Option<Hit>, findings: &mut Findings) {
    let Some(hit) = hit else { return };
    let sign = specimen.sign_of_t(ray, hit.primitive);
    findings.count("hits behind the origin", u64::from(sign == Some(Ordering::Less)));
    findings.count("hits at the origin", u64::from(sign == Some(Ordering::Equal)));
    findings.check(sign.is_none_or(Ordering::is_gt), || format!("{sign:?} for the exact t: {ray:?} hits {hit:?}"));
}

/// What a case of T14 has small coordinates of.
#[derive(Clone, Copy)]
enum Grid {
    /// Integers: nothing is rounded.
    Integers,
    /// Thirds of integers, rounded: an origin in the plane is off it by as little as 2⁻⁶⁰.
    Thirds,
    /// One coordinate is that of the whole triangle, the others are any.
    Plane,
}

impl Grid {
    fn of(i: usize) -> Self {
        [Self::Integers, Self::Thirds, Self::Plane][i % 3]
    }

    fn rounded(self, p: Vec3) -> Vec3 {
        if matches!(self, Self::Thirds) { p / 3.0 } else { p }
    }
}

/// Triangles of small coordinates; the origin is a vertex, on an edge, within, or beside the triangle in its plane.
fn t14(run: &Run) -> Outcome {
    let mut random = Random::new(run.seed, 0x70e0);
    let count = run.effort.pick(300, 3_000);
    // Multiples of 4, so that middles of middles are integers too.
    let corners: Vec<[Vec3; 3]> = (0..count)
        .map(|i| {
            let plane = 7.0 * random.signed();
            [0; 3].map(|_| match Grid::of(i) {
                Grid::Plane => {
                    let mut p = 9.0 * random.vector();
                    p[i / 3 % 3] = plane;
                    p
                }
                _ => 4.0 * Vec3::from_array([0; 3].map(|_| random.below(12) as f32 - 6.0)),
            })
        })
        .collect();
    let triangles = corners.iter().enumerate().map(|(i, t)| t.map(|p| Grid::of(i).rounded(p)));
    let specimen = soup(triangles).map_err(Into::into).and_then(|mesh| Specimen::new(run, mesh));
    outcome_of(specimen.map(|specimen| {
        let mut findings = in_chunks(run, 0x70e, run.effort.pick(20_000, 5_000_000), |_, random, findings| {
            let i = random.below(count);
            let [a, b, c] = corners[i];
            let mut origin = match random.below(5) {
                0 => a,
                1 => 0.5 * (a + b),
                2 => 0.5 * a + 0.25 * b + 0.25 * c,
                3 => 0.25 * a + 0.75 * c,
                _ => a + (c - b),
            };
            if matches!(Grid::of(i), Grid::Plane) {
                origin[i / 3 % 3] = a[i / 3 % 3];
            }
            let origin = Grid::of(i).rounded(origin);
            let direction = match random.below(3) {
                0 => Vec3::from_array([0; 3].map(|_| random.below(7) as f32 - 3.0)),
                _ => random.direction(),
            };
            let ray = Ray::new(origin, direction);
            let hit = specimen.judge(&ray, Interval::FULL, findings);
            let side = specimen.oracle.side_of_plane(i as u32, origin, &mut Tally::default());
            findings.count("origins in the plane", u64::from(side == Some(Ordering::Equal)));
            if direction != Vec3::ZERO {
                check_ahead(&specimen, &ray, hit, findings);
            }
        });
        findings.require_count("origins in the plane", run.effort.pick(12_000, 3_000_000));
        findings
    }))
}

/// Points of a rough ball as f32 rounds them, and up to 8 ulp further on each axis.
fn t15(run: &Run) -> Outcome {
    let mesh = || -> Result<TriangleMesh, MeshError> {
        let mut random = Random::new(run.seed, 0x70f0);
        let ball = meshes::icosphere(3, |_| 3.0 + f64::from(random.unit()))?;
        let spiky = spiky_sphere(12, &mut random, |x| 1.0 + 5.0 * f64::from(x))?;
        meshes::merge([&ball, &spiky])
    };
    let specimen = mesh().map_err(Into::into).and_then(|mesh| Specimen::new(run, mesh));
    outcome_of(specimen.map(|specimen| {
        in_chunks(run, 0x70f, run.effort.pick(20_000, 5_000_000), |_, random, findings| {
            let [a, b, c] = specimen.mesh.vertices(random.below(specimen.mesh.len()));
            let u = random.unit();
            let p = a + u * (b - a) + (1.0 - u) * random.unit() * (c - a);
            let origin = Vec3::from_array(p.to_array().map(|x| {
                let steps = random.below(9);
                let step = if random.below(2) == 0 { f32::next_up } else { f32::next_down };
                (0..steps).fold(x, |x, _| step(x))
            }));
            let ray = Ray::new(origin, random.direction());
            let hit = specimen.judge(&ray, Interval::FULL, findings);
            check_ahead(&specimen, &ray, hit, findings);
        })
    }))
}

/// Two parallel sheets in every direction, 1 to 4 ulp apart in each coordinate. Seen from where t tells them apart, the
/// nearer one is hit; from further away, one of the two, which is counted.
fn t20(run: &Run) -> Outcome {
    let mut random = Random::new(run.seed, 0x7140);
    let count = run.effort.pick(300, 3_000);
    let mut triangles = Vec::new();
    for i in 0..count {
        // Coordinates in [1, 2), where the spacing is one; every sheet has its own place in a row.
        let axis = i % 3;
        let sheet = [0; 3].map(|_| {
            let mut p = Vec3::new(1.0 + random.unit(), 1.0 + random.unit(), 1.0 + random.unit());
            if i % 2 == 0 {
                p[axis] = 1.5;
            }
            p
        });
        let steps = (1 + random.below(4)) as f32 * f32::EPSILON;
        let shifted = sheet.map(|mut p| {
            p[axis] += steps;
            p
        });
        // The farther one first, or the nearer one.
        triangles.push(if random.below(2) == 0 { [sheet, shifted] } else { [shifted, sheet] });
    }
    let layers = |pair: &[[Vec3; 3]; 2]| -> Fallible<Specimen> { Specimen::new(run, soup(*pair)?) };
    let specimens: Fallible<Vec<Specimen>> = triangles.iter().map(layers).collect();
    outcome_of(specimens.map(|specimens| {
        in_chunks(run, 0x714, run.effort.pick(20_000, 5_000_000), |_, random, findings| {
            let i = random.below(count);
            let (specimen, axis) = (&specimens[i], i % 3);
            let [a, b, c] = specimen.mesh.vertices(0);
            let u = 0.1 + 0.6 * random.unit();
            let target = a + u * (b - a) + (0.9 - u) * random.unit() * (c - a);
            let mut direction = 0.2 * random.vector();
            direction[axis] = [1.0, -1.0][random.below(2)];
            // At t of about 0.4 the spacing of t is a quarter of that of the coordinates.
            let mut near = Findings::default();
            specimen.judge(&Ray::new(target - 0.4 * direction, direction), Interval::FULL, &mut near);
            let ties = near.counted(TIES);
            near.check(i % 2 == 1 || ties == 0, || {
                format!("a tie between sheets that t tells apart: {target}, {direction}")
            });
            specimen.judge(&Ray::new(target - 100.0 * direction, direction), Interval::FULL, findings);
            *findings = std::mem::take(findings).and(near);
        })
    }))
}

/// Large triangles in whose plane the origin nearly lies, so that they reach from behind it to before it, with edges
/// and vertices near the ray; among sheets that lie truly behind or before.
fn t24(run: &Run) -> Outcome {
    let mut random = Random::new(run.seed, 0x7180);
    let sizes = [1.0, 1e2, 1e4, 1e6];
    let count = run.effort.pick(200, 2_000);
    let triangles: Vec<[Vec3; 3]> = (0..count)
        .map(|i| {
            let n = random.direction().as_dvec3();
            let off = n * f64::from(random.power_of_two(-24.0, 0.0)) * f64::from(random.signed().signum());
            let (x, y) = n.any_orthonormal_pair();
            let size = sizes[i % sizes.len()];
            // The origin lies near the middle, near an edge or near a vertex.
            let corners = [DVec2::new(-1.0, -0.7), DVec2::new(1.0, -0.7), DVec2::new(0.0, 1.2)];
            let at = [DVec2::ZERO, DVec2::new(0.1, -0.7), corners[1]][random.below(3)];
            corners.map(|c| ((c - at) * size).extend(1.0)).map(|c| (x * c.x + y * c.y + off).as_vec3())
        })
        .collect();
    let specimens: Fallible<Vec<Specimen>> =
        triangles.chunks(4).map(|four| Specimen::new(run, soup(four.iter().copied())?)).collect();
    outcome_of(specimens.map(|specimens| {
        in_chunks(run, 0x718, run.effort.pick(25_000, 5_000_000), |_, random, findings| {
            let specimen = &specimens[random.below(specimens.len())];
            let near = log_uniform(random, 1e-7, 1.0);
            let origin = near * random.vector();
            let ray = Ray::new(origin, random.direction());
            let hit = specimen.judge(&ray, Interval::FULL, findings);
            check_ahead(specimen, &ray, hit, findings);
        })
    }))
}
