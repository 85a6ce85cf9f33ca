//! A shape of one's own, a torus as a signed distance field, among meshes.

use std::error::Error;

use bvh_flat::geometry::glam::{DVec3, Vec2, dvec3};
use bvh_flat::primitive::{GeometricPrimitive, MaterialId, MediumInterface, Primitive, Surface};
use bvh_flat::{BuildConfig, BvhAggregate, WideMesh, geometry::*};

/// The least step, across the surface: above the rounding of f64, below that of f32.
const NEAR: f64 = 1e-9;
struct Torus;
fn distance(p: DVec3) -> f64 {
    (p.x.hypot(p.z) - 1.0).hypot(p.y) - 0.25
}

impl Shape for Torus {
    fn object_bound(&self) -> Bounds3 {
        Bounds3::new([-1.25, -0.25, -1.25], [1.25, 0.25, 1.25])
    }

    // Sphere tracing from the box on, in and out: where the sides change depends on the ray alone, as it must.
    fn visit_hits(&self, ray: &TraversalRay, interval: Interval, visitor: &mut dyn HitVisitor) -> Visit {
        let mut t = ray.enter(&self.object_bound(), Interval::FULL).map_or(f64::INFINITY, f64::from);
        let away = |t: f64| distance(ray.origin64() + t * ray.direction64());
        let (mut is_outside, mut t_max) = (away(t) > 0.0, interval.t_max());
        while t < t_max.into() && away(t) < 4.0 {
            t += (away(t).abs().max(NEAR) / ray.direction64().length()).max(4.0 * f64::EPSILON * t);
            if (away(t) > 0.0) != is_outside && interval.with_t_max(t_max).contains(t as f32) {
                t_max = visitor.hit(Hit { t: t as f32, u: 0.0, v: 0.0, primitive: 0 })?;
            }
            is_outside = away(t) > 0.0;
        }
        std::ops::ControlFlow::Continue(t_max)
    }

    fn surface_point(&self, ray: &TraversalRay, hit: &Hit) -> SurfacePoint {
        let way = f64::from(hit.t) * ray.direction64();
        let p = ray.origin64() + way;
        let slope = |axis: DVec3| distance(p + 1e-6 * axis) - distance(p - 1e-6 * axis);
        let n = dvec3(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z)).normalize();
        // t is rounded to f32, so p is off by half an ulp of it along the ray.
        SurfacePoint { p, p_error: DVec3::splat(2.0 * NEAR) + 1e-7 * way.abs(), n, uv: Vec2::ZERO }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let floor = TriangleMesh::new([[-9.0, -1.0, -9.0], [9.0, -1.0, -9.0], [0.0, -1.0, 9.0]], vec![[0, 2, 1]])?;
    let floor = WideMesh::build(floor, &BuildConfig::balanced())?;
    let surface = Surface::of_material(MaterialId::from_index(0).ok_or("too many materials")?);
    let floor = Box::new(GeometricPrimitive::new(floor, surface, MediumInterface::VACUUM));
    let torus = Box::new(GeometricPrimitive::new(Torus, surface, MediumInterface::VACUUM));
    let world = BvhAggregate::<Box<dyn Primitive>>::build(vec![floor, torus], &BuildConfig::balanced())?;
    for x in [0.0, 1.0] {
        let ray = TraversalRay::new(&Ray::new([x, 3.0, 0.0], [0.0, -1.0, 0.0])).ok_or("the ray has no direction")?;
        let hit = world.intersect(&ray, Interval::FULL).ok_or("the floor is below")?;
        println!("x = {x}: {} at t = {}", ["the floor", "the torus"][hit.primitive as usize], hit.t);
    }
    Ok(())
}
