//! Shapes that change what a tree says: another closest hit, hit points without bounds, a filter before the exact test.

use std::ops::ControlFlow;

use bvh_flat::WideMesh;
use geometry::{Bounds3, Hit, HitVisitor, Interval, Shape, SurfacePoint, TraversalRay, Visit};

/// A shape that hears of hits one by one and keeps the closest by a rule of its own.
pub struct OwnRule<S, R> {
    pub shape: S,
    pub rule: R,
}

impl<S: Shape, R: Fn(&Hit, &Hit) -> bool + Send + Sync> Shape for OwnRule<S, R> {
    fn object_bound(&self) -> Bounds3 {
        self.shape.object_bound()
    }

    fn primitive_count(&self) -> u64 {
        self.shape.primitive_count()
    }

    fn visit_hits(&self, ray: &TraversalRay, interval: Interval, visitor: &mut dyn HitVisitor) -> Visit {
        self.shape.visit_hits(ray, interval, visitor)
    }

    fn intersect(&self, ray: &TraversalRay, interval: Interval) -> Option<Hit> {
        let mut closest: Option<Hit> = None;
        let _ = self.shape.visit_hits(ray, interval, &mut |hit: Hit| {
            if closest.as_ref().is_none_or(|best| (self.rule)(&hit, best)) {
                closest = Some(hit);
            }
            ControlFlow::Continue(closest.map_or(interval.t_max(), |best| best.t_max_for_ties()))
        });
        closest
    }

    fn surface_point(&self, ray: &TraversalRay, hit: &Hit) -> SurfacePoint {
        self.shape.surface_point(ray, hit)
    }
}

/// Hit points without their bound: spawned rays start on the surface, on either side of it.
pub struct WithoutBounds<S>(pub S);

impl<S: Shape> Shape for WithoutBounds<S> {
    fn object_bound(&self) -> Bounds3 {
        self.0.object_bound()
    }

    fn primitive_count(&self) -> u64 {
        self.0.primitive_count()
    }

    fn visit_hits(&self, ray: &TraversalRay, interval: Interval, visitor: &mut dyn HitVisitor) -> Visit {
        self.0.visit_hits(ray, interval, visitor)
    }

    fn surface_point(&self, ray: &TraversalRay, hit: &Hit) -> SurfacePoint {
        // A rounded point, of which a renderer believes that it is exact.
        let point = self.0.surface_point(ray, hit);
        SurfacePoint { p: point.p.as_vec3().as_dvec3(), p_error: Default::default(), ..point }
    }
}

/// The filter of eight triangles, for one: edge functions of vertices sheared in f32, against a bound on their error. A
/// hit that it rules out is lost.
pub struct Filtered {
    pub wide: WideMesh,
    /// The bound, of the triangle's largest extent D and the depth |A_z| of its first vertex.
    pub error: fn(f32, f32) -> f32,
}

/// Half the spacing of f32 at 1.
const U: f32 = f32::EPSILON / 2.0;

/// What it was at first: without the product of the errors of two coordinates, which counts where D is below u |A_z|.
pub fn error_without_products(d: f32, az: f32) -> f32 {
    U * d * (64.0 * az + 144.0 * d)
}

pub fn sound_error(d: f32, az: f32) -> f32 {
    error_without_products(d, az) + 256.0 * U * U * az * az
}

impl Filtered {
    fn is_ruled_out(&self, ray: &TraversalRay, hit: &Hit) -> bool {
        let v = self.wide.mesh().vertices(hit.primitive as usize);
        let (o, shear) = (ray.ray().origin, ray.shear());
        let [a, b, c] = v.map(|v| {
            let p = v - o;
            [p[shear.kx] - shear.sx * p[shear.kz], p[shear.ky] - shear.sy * p[shear.kz]]
        });
        let edge = |p: [f32; 2], q: [f32; 2]| p[0].mul_add(q[1], -(p[1] * q[0]));
        let e = [edge(c, b), edge(a, c), edge(b, a)];
        let extent = Bounds3::from_points(v).diagonal().max_element();
        let error = (self.error)(extent, (v[0] - o)[shear.kz].abs());
        e.iter().any(|e| *e < -error) && e.iter().any(|e| *e > error)
    }
}

impl Shape for Filtered {
    fn object_bound(&self) -> Bounds3 {
        self.wide.object_bound()
    }

    fn primitive_count(&self) -> u64 {
        self.wide.primitive_count()
    }

    fn visit_hits(&self, ray: &TraversalRay, interval: Interval, visitor: &mut dyn HitVisitor) -> Visit {
        self.wide.visit_hits(ray, interval, visitor)
    }

    fn intersect(&self, ray: &TraversalRay, interval: Interval) -> Option<Hit> {
        self.wide.intersect(ray, interval).filter(|hit| !self.is_ruled_out(ray, hit))
    }

    fn intersect_p(&self, ray: &TraversalRay, interval: Interval) -> bool {
        self.intersect(ray, interval).is_some()
    }

    fn surface_point(&self, ray: &TraversalRay, hit: &Hit) -> SurfacePoint {
        self.wide.surface_point(ray, hit)
    }
}
