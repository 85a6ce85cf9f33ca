//! Closed meshes, out of which no ray may come: T01 to T04 and T06.

use geometry::glam::Vec3;
use geometry::{Bounds3, Interval, MeshError, Ray, TriangleMesh};
use oracle::{Oracle, PointLocation, Tally};
use scene::meshes;

use super::findings::{Fallible, Findings, in_chunks, outcome_of};
use super::generate::{log_uniform, mapped, needle, skew_rotation, spiky_sphere};
use super::judge::Specimen;
use crate::{Aim, Case, Outcome, Random, Run};

pub(super) const T01: Case = Case { id: "T01", title: "closed meshes, aimed at edges", run: t01 };
pub(super) const T02: Case = Case { id: "T02", title: "closed meshes, aimed at vertices and corners", run: t02 };
pub(super) const T03: Case = Case { id: "T03", title: "closed meshes of spikes, radii 1 to 1000", run: t03 };
pub(super) const T04: Case = Case { id: "T04", title: "Embree's watertightness test, aimed", run: t04 };
pub(super) const T06: Case = Case { id: "T06", title: "closed twisted needles, aspect 10^3 to 10^7", run: t06 };

/// A closed mesh and points that are certainly within it.
pub(super) struct Closed {
    pub(super) specimen: Specimen,
    inner: Vec<Vec3>,
    /// Whether a ray that is aimed at an inner point from outside certainly passes through the inside: f32 rounds its
    /// direction, and the points lie deeper than that.
    can_be_aimed_at: bool,
}

impl Closed {
    /// The mesh with up to `count` of the points of `candidates` that lie deep within it: so do their neighbours at
    /// `depth` in the directions of the axes.
    ///
    /// # Errors
    /// Where the mesh is refused, or 10,000 candidates hold no such point.
    pub(super) fn new(
        run: &Run,
        mesh: TriangleMesh,
        count: usize,
        depth: f32,
        mut candidates: impl FnMut() -> Vec3,
    ) -> Fallible<Self> {
        let specimen = Specimen::new(run, mesh)?;
        let is_deep = |p: &Vec3| {
            let tally = &mut Tally::default();
            let is_clear = |axis: Vec3| {
                let (from, step) = (*p - depth * axis, 2.0 * depth * axis);
                !specimen.oracle.any(&Ray::new(from, step), Interval::up_to(1.0), tally)
            };
            Vec3::AXES.into_iter().all(is_clear)
                && specimen.oracle.locate(*p, &mut Tally::default()) == PointLocation::Inside
        };
        let inner: Vec<Vec3> = (0..10_000.max(count)).map(|_| candidates()).filter(is_deep).take(count).collect();
        if inner.is_empty() {
            return Err("no point deep within the mesh".into());
        }
        let size = specimen.mesh.positions().iter().fold(0.0_f32, |size, p| size.max(p.abs().max_element()));
        let can_be_aimed_at = depth >= 32.0 * f32::EPSILON * size;
        Ok(Self { specimen, inner, can_be_aimed_at })
    }

    /// [`new`](Self::new) with points of a box.
    pub(super) fn around(
        run: &Run,
        mesh: TriangleMesh,
        count: usize,
        bounds: &Bounds3,
        random: &mut Random,
    ) -> Fallible<Self> {
        let depth = bounds.diagonal().max_element() / 16_384.0;
        Self::new(run, mesh, count, depth, || random.point_in(bounds))
    }

    /// A trial: a ray from within meets the surface. Two in 64 are judged in full.
    pub(super) fn try_from_inside(&self, aim: Aim, i: usize, random: &mut Random, findings: &mut Findings) {
        let origin = self.inner[random.below(self.inner.len())];
        let direction = match aim {
            Aim::Anywhere => random.direction(),
            _ => aim.target(&self.specimen.mesh, random) - origin,
        };
        self.try_ray(&Ray::new(origin, direction), i, findings);
    }

    /// A trial: a ray from outside that passes a target on the surface and then a point deep within meets the surface.
    /// Where that is not certain, there is no trial.
    pub(super) fn try_from_outside(&self, aim: Aim, i: usize, random: &mut Random, findings: &mut Findings) {
        let inner = self.inner[random.below(self.inner.len())];
        let target = aim.target(&self.specimen.mesh, random);
        let origin = target + (0.25 + random.unit()) * (target - inner);
        if self.can_be_aimed_at && self.specimen.oracle.locate(origin, &mut Tally::default()) == PointLocation::Outside
        {
            findings.count("rays from outside", 1);
            self.try_ray(&Ray::new(origin, target - origin), i, findings);
        }
    }

    fn try_ray(&self, ray: &Ray, i: usize, findings: &mut Findings) {
        if ray.direction == Vec3::ZERO {
            return;
        }
        let hit = self.specimen.closest(ray, Interval::FULL);
        self.specimen.judge_any(ray, Interval::FULL, hit, findings);
        findings.count("leaks", u64::from(hit.is_none()));
        findings.check(hit.is_some(), || format!("a leak: {ray:?}"));
        if i % 64 < 2 {
            self.specimen.judge(ray, Interval::FULL, findings);
        }
    }
}

/// Aims at all of `closed` in turn, from inside, and one ray in four from outside.
pub(super) fn try_all(run: &Run, stream: u64, count: usize, closed: &[Closed], aims: &[Aim]) -> Findings {
    let mut findings = in_chunks(run, stream, count, |i, random, findings| {
        let closed = &closed[i % closed.len()];
        let aim = aims[random.below(aims.len())];
        match random.below(4) {
            0 if aim != Aim::Anywhere => closed.try_from_outside(aim, i, random, findings),
            _ => closed.try_from_inside(aim, i, random, findings),
        }
    });
    if closed.iter().all(|closed| closed.can_be_aimed_at) {
        findings.require_count("rays from outside", count as u64 / 50);
    }
    findings
}

/// pbrt's spiky sphere, a rough ball and a knot.
fn smooth_and_spiky(run: &Run, stream: u64) -> Fallible<Vec<Closed>> {
    let mut random = Random::new(run.seed, stream);
    let meshes = [
        spiky_sphere(16, &mut random, |x| 1.0 + 5.0 * f64::from(x))?,
        meshes::icosphere(4, |_| 1.0 + 0.2 * f64::from(random.unit()))?,
        meshes::torus_knot([2, 3], [2.0, 1.0], 0.4, 120, 12)?,
    ];
    let closed = meshes.into_iter().map(|mesh| {
        let bounds = Bounds3::from_points(mesh.positions().iter().copied());
        Closed::around(run, mesh, run.effort.pick(200, 2_000), &bounds, &mut random)
    });
    closed.collect()
}

fn t01(run: &Run) -> Outcome {
    let count = run.effort.pick(60_000, 40_000_000);
    outcome_of(smooth_and_spiky(run, 0x7010).map(|closed| try_all(run, 0x701, count, &closed, &[Aim::Edge])))
}

fn t02(run: &Run) -> Outcome {
    let count = run.effort.pick(60_000, 40_000_000);
    let aims = [Aim::Vertex, Aim::Vertex, Aim::Corner];
    outcome_of(smooth_and_spiky(run, 0x7020).map(|closed| try_all(run, 0x702, count, &closed, &aims)))
}

fn t03(run: &Run) -> Outcome {
    let sizes: &[usize] = run.effort.pick(&[16, 16, 48], &[16, 16, 50, 100, 200, 400]);
    let mut random = Random::new(run.seed, 0x7030);
    let closed: Fallible<Vec<Closed>> = sizes
        .iter()
        .map(|&size| {
            let radii: Vec<f32> = (0..size * size + 2).map(|_| log_uniform(&mut random, 1.0, 1_000.0)).collect();
            let mesh = spiky_sphere(size, &mut random, |x| f64::from(radii[(x * radii.len() as f32) as usize]))?;
            let middle = Bounds3::new(Vec3::splat(-0.5), Vec3::splat(0.5));
            Closed::around(run, mesh, run.effort.pick(200, 2_000), &middle, &mut random)
        })
        .collect();
    // From among spikes a ray meets many boxes: a quarter of the rays of T01 takes as long.
    let count = run.effort.pick(100_000, 10_000_000);
    let aims = [Aim::Edge, Aim::Vertex, Aim::Corner];
    outcome_of(closed.map(|closed| try_all(run, 0x703, count, &closed, &aims)))
}

/// A sphere of radius 2 where floats are 1/64 apart: the test of Embree's `verify` shoots random rays alone at it.
fn t04(run: &Run) -> Outcome {
    let center = Vec3::new(148_376.0, 1_234.0, -223_423.0);
    let mesh = || -> Result<TriangleMesh, MeshError> {
        mapped(&meshes::uv_sphere(99, 200, |_| 2.0)?, |p| p + center.as_dvec3())
    };
    let closed = mesh().map_err(Into::into).and_then(|mesh| {
        let cube = Bounds3::new(center - 1.0, center + 1.0);
        Closed::around(run, mesh, 500, &cube, &mut Random::new(run.seed, 0x7040))
    });
    let count = run.effort.pick(20_000, 10_000_000);
    outcome_of(closed.map(|closed| try_all(run, 0x704, count, &[closed], &Aim::ALL)))
}

/// Along the axis and askew; with rings far apart a triangle reaches from far before the origin to far behind it.
fn t06(run: &Run) -> Outcome {
    let mut random = Random::new(run.seed, 0x7060);
    let closed = (0..20).map(|i| {
        let length = [2e3, 2e4, 2e5, 2e6, 2e7][i / 4];
        let rings = [3, 9][i / 2 % 2];
        let straight = needle(length, rings)?;
        let turn = if i % 2 == 0 { geometry::glam::DMat3::IDENTITY } else { skew_rotation() };
        let mesh = mapped(&straight, |p| turn * p)?;
        let candidate = || {
            let along = 0.9 * random.signed() * (0.5 * length as f32);
            let along = if random.below(2) == 0 { along } else { along / 1_000.0 };
            (turn * Vec3::new(along, 0.5 * random.signed(), 0.5 * random.signed()).as_dvec3()).as_vec3()
        };
        Closed::new(run, mesh, 200, 0.05, candidate)
    });
    let count = run.effort.pick(60_000, 10_000_000);
    let aims = [Aim::Edge, Aim::Vertex, Aim::Corner];
    outcome_of(closed.collect::<Fallible<Vec<_>>>().map(|closed| try_all(run, 0x706, count, &closed, &aims)))
}
