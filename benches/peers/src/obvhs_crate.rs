//! obvhs: trees of two children and of eight compressed ones, with the triangles copied in leaf order, as its examples
//! do.

use std::time::Duration;

use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::bvh2::{Bvh2, builder::build_bvh2_from_tris};
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh_from_tris};
use obvhs::ray::{Ray as ObvhsRay, RayHit};
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;

use crate::tracer::{Hit, Peer, Ray, Tracer, Triangles};

pub fn presets() -> [(&'static str, BvhBuildParams); 2] {
    [("medium", BvhBuildParams::medium_build()), ("very slow", BvhBuildParams::very_slow_build())]
}

pub fn input(triangles: &Triangles) -> Vec<Triangle> {
    let triangle = |&[v0, v1, v2]: &[[f32; 3]; 3]| Triangle { v0: v0.into(), v1: v1.into(), v2: v2.into() };
    triangles.0.iter().map(triangle).collect()
}

fn ordered(triangles: &[Triangle], order: &[u32]) -> Vec<RtTriangle> {
    order.iter().map(|&i| RtTriangle::from(&triangles[i as usize])).collect()
}

pub fn build_bvh2(triangles: &[Triangle], params: BvhBuildParams) -> Option<Box<dyn Peer>> {
    let tree = build_bvh2_from_tris(triangles, params, &mut Duration::default());
    let ordered = ordered(triangles, &tree.primitive_indices);
    Some(Box::new(Two(tree, ordered)))
}

pub fn build_cwbvh(triangles: &[Triangle], params: BvhBuildParams) -> Option<Box<dyn Peer>> {
    let tree = build_cwbvh_from_tris(triangles, params, &mut Duration::default());
    let ordered = ordered(triangles, &tree.primitive_indices);
    Some(Box::new(Eight(tree, ordered)))
}

struct Two(Bvh2, Vec<RtTriangle>);
struct Eight(CwBvh, Vec<RtTriangle>);

fn ray_of(ray: &Ray) -> ObvhsRay {
    ObvhsRay::new(Vec3A::from(ray.origin), Vec3A::from(ray.direction), ray.t_min, ray.t_max)
}

macro_rules! tracer {
    ($($tree:ty),*) => {$(
        impl Tracer for $tree {
            fn closest(&self, ray: &Ray) -> Hit {
                let mut hit = RayHit::none();
                self.0.ray_traverse(ray_of(ray), &mut hit, |ray, place| self.1[place].intersect(ray));
                match self.0.primitive_indices.get(hit.primitive_id as usize) {
                    Some(&primitive) => Hit { t: hit.t, primitive },
                    None => Hit::MISS,
                }
            }

            fn any(&self, ray: &Ray) -> bool {
                !self.0.ray_traverse_miss(ray_of(ray), |ray, place| self.1[place].intersect(ray))
            }
        }
    )*};
}

tracer!(Two, Eight);
