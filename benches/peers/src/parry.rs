//! parry3d: a TriMesh with the tree that it builds. It has no query for any hit: the closest one answers it.

use parry3d::math::Vector;
use parry3d::query::{Ray as ParryRay, RayCast};
use parry3d::shape::TriMesh;

use crate::tracer::{Hit, Peer, Ray, Tracer, Triangles};

pub fn build(triangles: &Triangles) -> Option<Box<dyn Peer>> {
    let vertices = triangles.0.as_flattened().iter().map(|&[x, y, z]| Vector::new(x, y, z)).collect();
    let indices = (0..triangles.0.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Some(Box::new(Mesh(TriMesh::new(vertices, indices).ok()?)))
}

struct Mesh(TriMesh);

impl Tracer for Mesh {
    fn closest(&self, ray: &Ray) -> Hit {
        let [[ox, oy, oz], [dx, dy, dz]] = [ray.origin, ray.direction];
        let parry_ray = ParryRay::new(Vector::new(ox, oy, oz), Vector::new(dx, dy, dz));
        let hit = self.0.bvh().cast_ray(&parry_ray, ray.t_max.min(f32::MAX), |i, best| {
            let t = self.0.triangle(i).cast_local_ray(&parry_ray, best, false);
            t.filter(|&t| t > ray.t_min)
        });
        hit.map_or(Hit::MISS, |(primitive, t)| Hit { t, primitive })
    }

    fn any(&self, ray: &Ray) -> bool {
        Tracer::closest(self, ray).primitive != u32::MAX
    }
}
