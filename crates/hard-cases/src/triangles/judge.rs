//! The subject's answers beside the exact ones.

use std::cmp::Ordering;
use std::sync::Arc;

use geometry::glam::{DVec3, Vec3};
use geometry::{Hit, Interval, Ray, Shape, SurfacePoint, TraversalRay, TriangleMesh};
use oracle::{Agreement, Closest, MeshOracle, Oracle, PointAgreement, Tally, Verdict};
use primitive::{MaterialId, Surface, SurfaceInteraction};

use super::findings::{Fallible, Findings, Quantity};
use crate::Run;

/// Wrong primitives that are excused: their exact t differs from the least by no more than the spacing of f32.
pub(crate) const TIES: &str = "ties within the spacing of t";

/// Half the spacing of f32 at 1.
const U: f64 = f32::EPSILON as f64 / 2.0;

/// A mesh with who is asked about it and who knows.
pub(crate) struct Specimen {
    pub(crate) mesh: Arc<TriangleMesh>,
    pub(crate) shape: Box<dyn Shape + Send + Sync>,
    pub(crate) oracle: MeshOracle,
    /// Nothing is excused.
    is_exact: bool,
}

impl Specimen {
    pub(crate) fn new(run: &Run, mesh: TriangleMesh) -> Fallible<Self> {
        let oracle = MeshOracle::new(&mesh);
        let mesh = Arc::new(mesh);
        Ok(Self { shape: run.subject.shape(Arc::clone(&mesh))?, mesh, oracle, is_exact: run.subject.is_exact() })
    }

    /// The subject's closest hit; a ray that is not valid has none.
    pub(crate) fn closest(&self, ray: &Ray, interval: Interval) -> Option<Hit> {
        self.shape.intersect(&TraversalRay::new(ray)?, interval)
    }

    /// Whether the subject promises to be exact.
    pub(crate) fn is_exact(&self) -> bool {
        self.is_exact
    }

    /// The exact closest hits.
    pub(crate) fn exact(&self, ray: &Ray, interval: Interval) -> Option<Closest> {
        self.oracle.closest(ray, interval, &mut Tally::default())
    }

    /// A trial of the watertight tier: the closest hit is an exact one, or the ray passes within
    /// `NEAR_EDGE` of an edge of the claimed triangle or of an exact one, or their exact t differ by no more than the
    /// spacing of f32, so that they are a tie; the exceptions are counted. Any hit and closest hit agree. The values of
    /// right hits are judged too. Of an exact subject [strictly](Self::judge_strictly). Returns the claim.
    pub(crate) fn judge(&self, ray: &Ray, interval: Interval, findings: &mut Findings) -> Option<Hit> {
        if self.is_exact {
            return self.judge_strictly(ray, interval, findings);
        }
        let claim = self.closest(ray, interval);
        self.judge_any(ray, interval, claim, findings);
        let exact = self.exact(ray, interval);
        let verdict = Agreement::of(claim.map(|h| (h.t, h.primitive)), exact.as_ref()).verdict;
        let is_excused = match verdict {
            Verdict::Right => {
                if let (Some(hit), Some(exact)) = (claim, &exact) {
                    self.judge_values(ray, &hit, exact, findings);
                }
                true
            }
            _ if self.passes_near_an_edge(ray, claim, exact.as_ref()) => {
                findings.count("disagreements at edges", 1);
                true
            }
            Verdict::WrongPrimitive if self.is_tie(ray, interval, claim, exact.as_ref()) => {
                findings.count(TIES, 1);
                true
            }
            _ => false,
        };
        findings.check(is_excused, || format!("{verdict:?}: {ray:?} {interval:?} hits {claim:?}, exact is {exact:?}"));
        claim
    }

    /// A trial without any allowance: the canonical primitive and the correctly rounded t.
    pub(crate) fn judge_strictly(&self, ray: &Ray, interval: Interval, findings: &mut Findings) -> Option<Hit> {
        let claim = self.closest(ray, interval);
        self.judge_any(ray, interval, claim, findings);
        let exact = self.exact(ray, reported(interval));
        let expected = exact.as_ref().map(|e| (e.t.to_f32(), e.primitives[0]));
        findings.check(claim.map(|h| (h.t, h.primitive)) == expected, || {
            format!("{ray:?} {interval:?} hits {claim:?}, exact is {exact:?}")
        });
        if let (Some(hit), Some(exact)) = (claim, &exact) {
            self.judge_values(ray, &hit, exact, findings);
        }
        claim
    }

    /// Whether any-hit says the same as closest-hit.
    pub(crate) fn judge_any(&self, ray: &Ray, interval: Interval, claim: Option<Hit>, findings: &mut Findings) {
        let any = TraversalRay::new(ray).is_some_and(|r| self.shape.intersect_p(&r, interval));
        findings
            .check(any == claim.is_some(), || format!("any hit {any}, closest hit {claim:?}: {ray:?} {interval:?}"));
    }

    /// The errors of t and of the point, and the bound on the latter, for a hit on one of the exact primitives.
    pub(crate) fn judge_values(&self, ray: &Ray, hit: &Hit, exact: &Closest, findings: &mut Findings) {
        if !exact.primitives.contains(&hit.primitive) {
            return;
        }
        let error = Agreement::of(Some((hit.t, hit.primitive)), Some(exact)).t_error.unwrap_or(f64::INFINITY);
        let kappa = self.kappa(ray, hit.primitive);
        if kappa <= 10.0 {
            findings.measure(Quantity::TError, error);
        } else {
            findings.measure(Quantity::TErrorByKappa, error / kappa);
        }
        let (u, v) = (f64::from(hit.u), f64::from(hit.v));
        let in_range = u >= 0.0 && v >= 0.0 && u + v <= 1.0 + 2.0 * U;
        findings.check(in_range, || format!("barycentrics out of range: {ray:?} hits {hit:?}"));
        let Some(prepared) = TraversalRay::new(ray) else { return };
        let exact_point = exact.point(ray);
        let point = self.shape.surface_point(&prepared, hit);
        let interaction = interaction(point);
        let in_f64 = PointAgreement::of(point.p, point.p_error, &exact_point);
        let rounded = PointAgreement::of(interaction.p().as_dvec3(), interaction.p_error().as_dvec3(), &exact_point);
        findings.check(in_f64.is_bounded && rounded.is_bounded, || {
            format!("a bound is violated: {ray:?} hits {hit:?} at {point:?}, {in_f64:?}, {rounded:?}")
        });
        // A point at the origin of coordinates has no unit of its own.
        let largest = |v: DVec3| v.abs().max_element();
        let size = self.vertices(hit.primitive).map(largest).into_iter().fold(0.0, f64::max);
        if largest(point.p) >= size * U {
            findings.measure(Quantity::PointError, rounded.error);
            findings.measure(Quantity::PointBound, rounded.bound);
            findings.measure(Quantity::PointTightness, rounded.tightness);
        }
    }

    /// |d| |n| / |d·n|: how much the ray grazes the triangle.
    pub(crate) fn kappa(&self, ray: &Ray, primitive: u64) -> f64 {
        let n = self.normal(primitive);
        let d = direction(ray);
        d.length() * n.length() / d.dot(n).abs()
    }

    /// A vector along the normal of a triangle, in f64; zero where two edges are parallel in f64.
    pub(crate) fn normal(&self, primitive: u64) -> DVec3 {
        let [a, b, c] = self.vertices(primitive);
        unit_scale(b - a).cross(unit_scale(c - a))
    }

    pub(crate) fn vertices(&self, primitive: u64) -> [DVec3; 3] {
        self.mesh.vertices(primitive as usize).map(|v| v.as_dvec3())
    }

    /// The order of t* and 0 for the plane of the triangle, exactly; `None` where the ray is so nearly parallel to it
    /// that f64 cannot tell.
    pub(crate) fn sign_of_t(&self, ray: &Ray, primitive: u64) -> Option<Ordering> {
        let side = self.oracle.side_of_plane(primitive as u32, ray.origin, &mut Tally::default())?;
        let (n, d) = (self.normal(primitive), direction(ray));
        let along = n.dot(d) / (n.length() * d.length());
        match side {
            Ordering::Equal => Some(Ordering::Equal),
            _ if along > 1e-9 => Some(side.reverse()),
            _ if along < -1e-9 => Some(side),
            _ => None,
        }
    }

    fn passes_near_an_edge(&self, ray: &Ray, claim: Option<Hit>, exact: Option<&Closest>) -> bool {
        let claimed = claim.iter().map(|hit| hit.primitive);
        let exact = exact.into_iter().flat_map(|e| e.primitives.iter().copied());
        claimed.chain(exact).any(|primitive| self.passes_near(ray, primitive))
    }

    /// Whether it is no matter that the answer about the triangle is not the exact one: the ray
    /// [passes near](Self::passes_near) an edge, and the subject does not promise to be exact.
    pub(crate) fn is_excused(&self, ray: &Ray, primitive: u64) -> bool {
        !self.is_exact && self.passes_near(ray, primitive)
    }

    /// Whether the ray passes an edge of the triangle at less than `NEAR_EDGE` in this unit: the distance of the
    /// edge's line from the ray's, times the sine of their angle, over u and the largest coordinate of a vertex
    /// relative to the origin.
    pub(crate) fn passes_near(&self, ray: &Ray, primitive: u64) -> bool {
        /// In units of half the spacing of f32.
        const NEAR_EDGE: f64 = 32.0;
        let p = self.vertices(primitive).map(|v| v - ray.origin.as_dvec3());
        let size = p.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
        let d = direction(ray);
        [(0, 1), (1, 2), (2, 0)].into_iter().any(|(i, j)| {
            let e = (p[i] / size).cross(p[j] / size).dot(d).abs();
            let edge = (p[j] - p[i]).length() / size;
            // NaN: an edge without length is near everything.
            let distance = e / (d.length() * edge * U);
            distance.is_nan() || distance < NEAR_EDGE
        })
    }

    /// Whether the claimed primitive is hit, at a t that f32 does not tell from the least.
    fn is_tie(&self, ray: &Ray, interval: Interval, claim: Option<Hit>, exact: Option<&Closest>) -> bool {
        let (Some(claim), Some(exact)) = (claim, exact) else { return false };
        let hits = self.oracle.all_hits(ray, interval, &mut Tally::default());
        let least = exact.t.to_f64();
        hits.iter().any(|hit| hit.primitive == claim.primitive && hit.t.minus(least).cmp_f64(exact.t.ulp32()).is_le())
    }
}

/// The part of the interval with a t to report: beyond `f32::MAX` there is none.
fn reported(interval: Interval) -> Interval {
    interval.with_t_max(interval.t_max().min(f32::MAX))
}

/// A hit point as a renderer sees it.
pub(crate) fn interaction(point: SurfacePoint) -> SurfaceInteraction {
    let surface = MaterialId::from_index(0).map_or(Surface::MediumBoundary, Surface::of_material);
    SurfaceInteraction { point, time: 0.0, wo: Vec3::Z, surface, media: None }
}

/// The direction with a largest component of 1, so that nothing over- or underflows.
fn direction(ray: &Ray) -> DVec3 {
    unit_scale(ray.direction.as_dvec3())
}

/// The vector with a largest component of 1; zero stays zero.
fn unit_scale(v: DVec3) -> DVec3 {
    let size = v.abs().max_element();
    if size > 0.0 { v / size } else { v }
}
