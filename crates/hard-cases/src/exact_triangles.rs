//! A mesh without a tree, decided about exactly.

use std::ops::ControlFlow;
use std::sync::Arc;

use geometry::exact::{Enclosure, ExactRay, intersect_triangle_exact};
use geometry::{
    Bounds3, Hit, HitVisitor, Interval, Shape, SurfacePoint, TraversalRay, TriangleHit, TriangleMesh, Visit, Work,
};

/// What exact meshes with a tree must answer like: every triangle in turn. The closest hit has the least exact t, and
/// of equal ones the smallest index.
pub(crate) struct ExactTriangles {
    mesh: Arc<TriangleMesh>,
    /// Those that can be hit at all.
    active: Vec<usize>,
    /// The bounds of these.
    bounds: Bounds3,
}

impl ExactTriangles {
    pub(crate) fn new(mesh: Arc<TriangleMesh>) -> Self {
        let active: Vec<usize> = (0..mesh.len()).filter(|&i| mesh.triangle_bounds(i).is_valid()).collect();
        let bounds = Bounds3::from_points(active.iter().flat_map(|&i| mesh.vertices(i)));
        Self { mesh, active, bounds }
    }
}

impl Shape for ExactTriangles {
    fn object_bound(&self) -> Bounds3 {
        self.mesh.object_bound()
    }

    fn primitive_count(&self) -> u64 {
        self.mesh.primitive_count()
    }

    fn visit_hits(&self, ray: &TraversalRay, mut interval: Interval, visitor: &mut dyn HitVisitor) -> Visit {
        visitor.work(Work { nodes: 0, primitives: self.primitive_count() });
        for &i in &self.active {
            if let Some(h) = intersect_triangle_exact(ray, &self.mesh.vertices(i), interval) {
                let hit = Hit { t: h.t, u: h.u, v: h.v, primitive: i as u64 };
                interval = interval.with_t_max(visitor.hit(hit)?);
            }
        }
        ControlFlow::Continue(interval.t_max())
    }

    fn intersect(&self, ray: &TraversalRay, interval: Interval) -> Option<Hit> {
        let exact = ExactRay::new(ray, &self.bounds);
        let mut closest: Option<(usize, Enclosure)> = None;
        for &i in &self.active {
            let vertices = self.mesh.vertices(i);
            let Some(enclosure) = exact.intersect_triangle(&vertices, interval, &mut ()) else { continue };
            // Of equal t the one before is the smaller.
            let is_closer = closest.as_ref().is_none_or(|(best, best_enclosure)| {
                let best = self.mesh.vertices(*best);
                exact.compare((&enclosure, &vertices), (best_enclosure, &best), &mut ()).is_lt()
            });
            if is_closer {
                closest = Some((i, enclosure));
            }
        }
        let (i, enclosure) = closest?;
        let TriangleHit { t, u, v } = exact.values(&self.mesh.vertices(i), &enclosure, &mut ());
        Some(Hit { t, u, v, primitive: i as u64 })
    }

    fn intersect_p(&self, ray: &TraversalRay, interval: Interval) -> bool {
        let exact = ExactRay::new(ray, &self.bounds);
        self.active.iter().any(|&i| exact.intersect_triangle(&self.mesh.vertices(i), interval, &mut ()).is_some())
    }

    fn surface_point(&self, ray: &TraversalRay, hit: &Hit) -> SurfacePoint {
        self.mesh.surface_point(ray, hit)
    }
}
