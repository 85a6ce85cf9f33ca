//! A mesh without a tree, decided about exactly.

use std::ops::ControlFlow;
use std::sync::Arc;

use geometry::exact::{Enclosure, ExactRay, intersect_triangle_exact};
use geometry::glam::Vec3;
use geometry::{
    Bounds3, Hit, HitVisitor, Interval, Shape, SurfacePoint, TraversalRay, TriangleHit, TriangleMesh, Visit, Work,
};

/// What exact meshes with a tree must answer like: every triangle in turn. The closest hit has the least exact t, and
/// of equal ones the smallest index.
pub(crate) struct ExactTriangles {
    mesh: Arc<TriangleMesh>,
    /// Those that can be hit at all, with their vertices.
    active: Vec<(usize, [Vec3; 3])>,
    /// The bounds of these.
    bounds: Bounds3,
}

impl ExactTriangles {
    pub(crate) fn new(mesh: Arc<TriangleMesh>) -> Self {
        let can_be_hit = |&i: &usize| mesh.triangle_bounds(i).is_valid();
        let active: Vec<_> = (0..mesh.len()).filter(can_be_hit).map(|i| (i, mesh.vertices(i))).collect();
        let bounds = Bounds3::from_points(active.iter().flat_map(|(_, vertices)| *vertices));
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
        for (i, vertices) in &self.active {
            if let Some(h) = intersect_triangle_exact(ray, vertices, interval) {
                let hit = Hit { t: h.t, u: h.u, v: h.v, primitive: *i as u64 };
                interval = interval.with_t_max(visitor.hit(hit)?);
            }
        }
        ControlFlow::Continue(interval.t_max())
    }

    fn intersect(&self, ray: &TraversalRay, interval: Interval) -> Option<Hit> {
        let exact = ExactRay::new(ray, &self.bounds);
        let mut closest: Option<(usize, &[Vec3; 3], Enclosure)> = None;
        for (i, vertices) in &self.active {
            let Some(enclosure) = exact.intersect_triangle(vertices, interval, &mut ()) else { continue };
            // Of equal t the one before is the smaller.
            let is_closer = closest.as_ref().is_none_or(|(_, best, best_enclosure)| {
                exact.compare((&enclosure, vertices), (best_enclosure, best), &mut ()).is_lt()
            });
            if is_closer {
                closest = Some((*i, vertices, enclosure));
            }
        }
        let (i, vertices, enclosure) = closest?;
        let TriangleHit { t, u, v } = exact.values(vertices, &enclosure, &mut ());
        Some(Hit { t, u, v, primitive: i as u64 })
    }

    fn intersect_p(&self, ray: &TraversalRay, interval: Interval) -> bool {
        let exact = ExactRay::new(ray, &self.bounds);
        self.active.iter().any(|(_, vertices)| exact.intersect_triangle(vertices, interval, &mut ()).is_some())
    }

    fn surface_point(&self, ray: &TraversalRay, hit: &Hit) -> SurfacePoint {
        self.mesh.surface_point(ray, hit)
    }
}
