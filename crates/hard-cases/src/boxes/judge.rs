//! Says whether an answer about a mesh is right.

use std::sync::Arc;

use geometry::glam::DVec3;
use geometry::{Hit, Interval, Ray, Shape, TraversalRay, TriangleMesh};
use oracle::{Closest, ExactHit, ExactReal, MeshOracle, Oracle, PointLocation, Tally};

use crate::{AnyShape, Run, Tries};

/// A ray whose distance from an edge is less than this, in the unit of [`edge_distance`], may be decided either way by
/// a kernel that decides in f32.
const NEAR_EDGE: f64 = 32.0;

/// A mesh as the subject answers for it, as it answers alone, and as real arithmetic does.
pub(crate) struct Judge {
    mesh: Arc<TriangleMesh>,
    oracle: MeshOracle,
    shape: AnyShape,
    /// The same, asked triangle by triangle.
    alone: AnyShape,
    /// Nothing is excused.
    is_exact: bool,
}

impl Judge {
    /// A judge of what the subject makes of `mesh`; that it makes nothing of it is a failure.
    pub(crate) fn new(tries: &mut Tries, run: &Run, mesh: TriangleMesh) -> Option<Self> {
        let mesh = Arc::new(mesh);
        let shape = run.subject.shape(Arc::clone(&mesh));
        tries.check(shape.is_ok(), || format!("{} does not build: {:?}", run.subject.name(), shape.as_ref().err()));
        Some(Self {
            oracle: MeshOracle::new(&mesh),
            shape: shape.ok()?,
            alone: run.subject.without_tree(Arc::clone(&mesh)),
            is_exact: run.subject.is_exact(),
            mesh,
        })
    }

    /// The mesh.
    pub(crate) fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    /// The subject's shape.
    pub(crate) fn shape(&self) -> &(dyn Shape + Send + Sync) {
        &*self.shape
    }

    /// What the subject's shape must answer like.
    pub(crate) fn alone(&self) -> &(dyn Shape + Send + Sync) {
        &*self.alone
    }

    /// Whether a hit at t may be reported of the open interval; an exact one is rounded, to one of the ends at most.
    pub(crate) fn may_report(&self, t: f32, interval: Interval) -> bool {
        interval.contains(t) || (self.is_exact && (t == interval.t_min() || t == interval.t_max()))
    }

    /// The subject's closest hit; none of an invalid ray.
    pub(crate) fn hit(&self, ray: &Ray, interval: Interval) -> Option<Hit> {
        self.shape.intersect(&TraversalRay::new(ray)?, interval)
    }

    /// The exact answer.
    pub(crate) fn closest(&self, ray: &Ray, interval: Interval) -> Option<Closest> {
        self.oracle.closest(ray, interval, &mut Tally::default())
    }

    /// The answer must be the exact one: the smallest primitive of the least t, and t within 1 ulp.
    pub(crate) fn strict(&self, tries: &mut Tries, ray: &Ray, interval: Interval) {
        let hit = self.consistent(tries, ray, interval);
        let exact = self.closest(ray, interval);
        let holds = match (&hit, &exact) {
            (None, None) => true,
            (Some(hit), Some(exact)) => exact.primitives[0] == hit.primitive && is_within_an_ulp(hit.t, &exact.t),
            _ => false,
        };
        tries.check(holds, || report(ray, interval, hit, exact.as_ref()));
    }

    /// The answer must be the exact one, except about triangles of which the ray passes near an edge, and between hits
    /// whose t round to the same number; of an exact subject without exception.
    ///
    /// Returns whether there is an exact hit, so that the caller can see that the rays are worth something.
    pub(crate) fn tolerant(&self, tries: &mut Tries, ray: &Ray, interval: Interval) -> bool {
        let hit = self.consistent(tries, ray, interval);
        let exact = self.closest(ray, interval);
        let holds = self.is_right(ray, interval, hit, exact.as_ref());
        tries.check(holds, || report(ray, interval, hit, exact.as_ref()));
        exact.is_some()
    }

    /// A ray from within a closed mesh must hit something. Returns whether the origin is within.
    pub(crate) fn does_not_leak(&self, tries: &mut Tries, ray: &Ray) -> bool {
        if self.oracle.locate(ray.origin, &mut Tally::default()) != PointLocation::Inside {
            return false;
        }
        let hit = self.consistent(tries, ray, Interval::FULL);
        // A t beyond f32 is no answer.
        let exact = self.closest(ray, Interval::FULL);
        let has_answer = exact.as_ref().is_some_and(|exact| Interval::FULL.contains(exact.t.to_f32()));
        tries.check(hit.is_some() || !has_answer, || {
            format!("leak from within: {}", report(ray, Interval::FULL, hit, exact.as_ref()))
        });
        true
    }

    /// The subject must answer as the mesh does that is asked triangle by triangle, closest hit and any hit.
    pub(crate) fn consistent(&self, tries: &mut Tries, ray: &Ray, interval: Interval) -> Option<Hit> {
        let traversal = TraversalRay::new(ray)?;
        let hit = self.shape.intersect(&traversal, interval);
        let any = self.shape.intersect_p(&traversal, interval);
        let alone = self.alone.intersect(&traversal, interval);
        tries.check(hit == alone && any == hit.is_some(), || {
            format!("{ray:?} {interval:?}: {hit:?}, any hit {any}, without a tree {alone:?}")
        });
        hit
    }

    fn is_right(&self, ray: &Ray, interval: Interval, hit: Option<Hit>, exact: Option<&Closest>) -> bool {
        if self.is_exact {
            // An exact t beyond f32 is no answer.
            let exact = exact.filter(|exact| exact.t.cmp_f64(f32::MAX.into()).is_lt());
            return hit.map(|h| (h.primitive, h.t)) == exact.map(|e| (e.primitives[0], e.t.to_f32()));
        }
        let is_near = |primitive: u64| edge_distance(ray, &self.mesh, primitive as usize) < NEAR_EDGE;
        if let (Some(hit), Some(exact)) = (&hit, exact)
            && exact.primitives.contains(&hit.primitive)
        {
            return is_within_an_ulp(hit.t, &exact.t) || is_near(hit.primitive);
        }
        let all = self.oracle.all_hits(ray, interval, &mut Tally::default());
        // What was claimed is there,
        let claim_holds = hit.is_none_or(|hit| {
            let found = all.iter().find(|h| h.primitive == hit.primitive);
            is_near(hit.primitive) || found.is_some_and(|h| is_within_an_ulp(hit.t, &h.t))
        });
        // and nothing is before it.
        let is_before = |h: &ExactHit| hit.is_none_or(|hit| h.t.to_f32().next_up() < hit.t);
        let is_expected = |h: &ExactHit| interval.contains(h.t.to_f32()) && !is_near(h.primitive);
        claim_holds && !all.iter().any(|h| is_before(h) && is_expected(h))
    }
}

fn is_within_an_ulp(t: f32, exact: &ExactReal) -> bool {
    let nearest = exact.to_f32();
    nearest.next_down() <= t && t <= nearest.next_up()
}

fn report(ray: &Ray, interval: Interval, hit: Option<Hit>, exact: Option<&Closest>) -> String {
    let exact = exact.map(|exact| (exact.t.to_f32(), &exact.primitives));
    format!("{ray:?} {interval:?}: {hit:?}, exactly {exact:?}")
}

/// The least of |eᵢ| / (|d| |edgeᵢ| |p|∞ u) over the triangle's edges: how far the ray passes from an edge, in units of
/// what one rounding of the largest coordinate relative to the origin is; 0 for a triangle without extent. Below the
/// normal numbers a rounding is 2⁻¹⁵⁰. In f64: the threshold needs no exactness.
pub(crate) fn edge_distance(ray: &Ray, mesh: &TriangleMesh, triangle: usize) -> f64 {
    let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3().normalize());
    let v = mesh.vertices(triangle).map(|v| v.as_dvec3());
    let p = v.map(|v| v - o);
    let size = p.into_iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    let rounding = (size * f64::from(f32::EPSILON) / 2.0).max(2.0_f64.powi(-150));
    let distance = |i: usize, j: usize| -> f64 {
        // By the edge, not by the other vertex: from far away these are nearly the same vector.
        let edge: DVec3 = v[j] - v[i];
        let e = p[i].cross(edge).dot(d);
        if edge == DVec3::ZERO { 0.0 } else { e.abs() / (edge.length() * rounding) }
    };
    distance(0, 1).min(distance(1, 2)).min(distance(2, 0))
}
