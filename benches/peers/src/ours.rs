//! This library, as its users call it.

use std::sync::Arc;

use bvh_flat::geometry::{Interval, Shape, TraversalRay, TriangleMesh};
use bvh_flat::{BuildConfig, WideMesh};

use crate::tracer::{Hit, Peer, Ray, Tracer};

pub fn configurations() -> [(&'static str, BuildConfig); 2] {
    [("balanced", BuildConfig::balanced()), ("high", BuildConfig::high())]
}

pub fn build(mesh: Arc<TriangleMesh>, config: &BuildConfig) -> Option<Box<dyn Peer>> {
    Some(Box::new(Ours(WideMesh::build(mesh, config).ok()?)))
}

struct Ours(WideMesh);

fn ray_of(ray: &Ray) -> Option<(TraversalRay, Interval)> {
    let interval = Interval::new(ray.t_min, ray.t_max);
    let ray = TraversalRay::new(&bvh_flat::geometry::Ray::new(ray.origin, ray.direction))?;
    Some((ray, interval))
}

impl Tracer for Ours {
    fn closest(&self, ray: &Ray) -> Hit {
        let hit = ray_of(ray).and_then(|(ray, interval)| self.0.intersect(&ray, interval));
        hit.map_or(Hit::MISS, |hit| Hit { t: hit.t, primitive: hit.primitive as u32 })
    }

    fn any(&self, ray: &Ray) -> bool {
        ray_of(ray).is_some_and(|(ray, interval)| self.0.intersect_p(&ray, interval))
    }

    fn bytes(&self) -> Option<usize> {
        Some(self.0.memory())
    }
}
