//! bvh: its traversal by distance. Its own triangle test culls back faces and has no interval, so triangles are tested
//! by that of Möller and Trumbore, written here.

use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::{BHShape, BoundingHierarchy};
use bvh::bvh::Bvh;
use nalgebra::{Point3, Vector3};

use crate::tracer::{Hit, Peer, Ray, Tracer, Triangles};

#[derive(Clone)]
pub struct Triangle {
    vertices: [Point3<f32>; 3],
    primitive: u32,
    node: usize,
}

impl Bounded<f32, 3> for Triangle {
    fn aabb(&self) -> Aabb<f32, 3> {
        let [a, b, c] = &self.vertices;
        Aabb::with_bounds(a.inf(b).inf(c), a.sup(b).sup(c))
    }
}

impl BHShape<f32, 3> for Triangle {
    fn set_bh_node_index(&mut self, node: usize) {
        self.node = node;
    }

    fn bh_node_index(&self) -> usize {
        self.node
    }
}

pub fn input(triangles: &Triangles) -> Vec<Triangle> {
    let triangle = |(primitive, vertices): (u32, &[[f32; 3]; 3])| Triangle {
        vertices: vertices.map(Point3::from),
        primitive,
        node: 0,
    };
    (0..).zip(&triangles.0).map(triangle).collect()
}

pub fn build(triangles: &[Triangle]) -> Option<Box<dyn Peer>> {
    let mut triangles = triangles.to_vec();
    let tree = <Bvh<f32, 3> as BoundingHierarchy<f32, 3>>::build_par(&mut triangles);
    Some(Box::new(Tree { tree, triangles }))
}

struct Tree {
    tree: Bvh<f32, 3>,
    triangles: Vec<Triangle>,
}

impl Tree {
    fn trace(&self, ray: &Ray, is_any: bool) -> Hit {
        let (origin, direction) = (Point3::from(ray.origin), Vector3::from(ray.direction));
        let (bvh_ray, length) = (bvh::ray::Ray::new(origin, direction), direction.norm());
        let mut closest = Hit { t: ray.t_max, primitive: u32::MAX };
        for triangle in self.tree.nearest_traverse_iterator(&bvh_ray, &self.triangles) {
            // Leaves come in the order of their boxes, whose distances are in units of length.
            let slice = bvh_ray.intersection_slice_for_aabb(&triangle.aabb());
            if slice.is_some_and(|(entry, _)| entry > closest.t * length) {
                break;
            }
            if let Some(t) = moller_trumbore(origin, direction, &triangle.vertices)
                && t > ray.t_min
                && t < closest.t
            {
                closest = Hit { t, primitive: triangle.primitive };
                if is_any {
                    break;
                }
            }
        }
        if closest.primitive == u32::MAX { Hit::MISS } else { closest }
    }
}

fn moller_trumbore(origin: Point3<f32>, direction: Vector3<f32>, [a, b, c]: &[Point3<f32>; 3]) -> Option<f32> {
    let (e1, e2) = (b - a, c - a);
    let p = direction.cross(&e2);
    let determinant = e1.dot(&p);
    if determinant == 0.0 {
        return None;
    }
    let reciprocal = 1.0 / determinant;
    let s = origin - a;
    let u = reciprocal * s.dot(&p);
    let q = s.cross(&e1);
    let v = reciprocal * direction.dot(&q);
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then(|| reciprocal * e2.dot(&q))
}

impl Tracer for Tree {
    fn closest(&self, ray: &Ray) -> Hit {
        self.trace(ray, false)
    }

    fn any(&self, ray: &Ray) -> bool {
        self.trace(ray, true).primitive != u32::MAX
    }
}
