//! The kernels that most ray tracers have, named as what they are. They lose hits; they are here so that a report can
//! show how many, and what that saves.

use glam::Vec3;

use crate::{Bounds3, Interval, TraversalRay, TriangleHit};

/// The slab test without padding: a ray through an edge or a corner of the box may miss it. (2.4 % of rays aimed
/// at vertices are lost behind it.)
///
/// Kay and Kajiya 1986, *Ray Tracing Complex Scenes*. A zero component gives ±∞ or NaN; NaN bounds nothing here, where
/// others lose the box.
#[inline]
pub fn enter_unpadded(ray: &TraversalRay, bounds: &Bounds3, interval: Interval) -> Option<f32> {
    let origin = ray.ray().origin;
    let reciprocal = ray.reciprocal();
    let mut entry = interval.t_min();
    let mut exit = interval.t_max().min(f32::MAX);
    for i in 0..3 {
        let t0 = (bounds.min[i] - origin[i]) * reciprocal[i];
        let t1 = (bounds.max[i] - origin[i]) * reciprocal[i];
        let (near, far) = if reciprocal[i].is_sign_negative() { (t1, t0) } else { (t0, t1) };
        entry = if near > entry { near } else { entry };
        exit = if far < exit { far } else { exit };
    }
    (entry <= exit).then_some(entry)
}

/// Möller and Trumbore 1997, *Fast, Minimum Storage Ray/Triangle Intersection*, in f32, both sides hit, without an
/// epsilon on the determinant. Neighbours compute a shared edge from different vertices, so rays at edges and vertices
/// may pass between them.
#[inline]
pub fn moller_trumbore(ray: &TraversalRay, vertices: &[Vec3; 3], interval: Interval) -> Option<TriangleHit> {
    let (o, d) = (ray.ray().origin, ray.ray().direction);
    let (e1, e2) = (vertices[1] - vertices[0], vertices[2] - vertices[0]);
    let p = d.cross(e2);
    let det = e1.dot(p);
    if det == 0.0 {
        return None;
    }
    let reciprocal = 1.0 / det;
    let s = o - vertices[0];
    let u = reciprocal * s.dot(p);
    if !(0.0..=1.0).contains(&u) {
        return None;
    }
    let q = s.cross(e1);
    let v = reciprocal * d.dot(q);
    if !(v >= 0.0 && u + v <= 1.0) {
        return None;
    }
    let t = reciprocal * e2.dot(q);
    interval.contains(t).then_some(TriangleHit { t, u, v })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Ray, intersect_triangle};

    /// Away from edges the naive kernels say the same.
    #[test]
    fn they_agree_where_nothing_is_hard() {
        let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let bounds = Bounds3::new(Vec3::splat(-1.0), Vec3::splat(1.0));
        let mut hits = 0;
        for i in 0..400 {
            let (x, y) = (0.07 * (i % 20) as f32 - 0.21, 0.07 * (i / 20) as f32 - 0.22);
            let ray = TraversalRay::new(&Ray::new([x, y, 3.0], [0.01, -0.02, -1.0])).expect("valid");
            let a = moller_trumbore(&ray, &triangle, Interval::FULL);
            let b = intersect_triangle(&ray, &triangle, Interval::FULL);
            assert_eq!(a.is_some(), b.is_some());
            if let (Some(a), Some(b)) = (a, b) {
                hits += 1;
                assert!((a.t - b.t).abs() < 1e-5 && (a.u - b.u).abs() < 1e-5 && (a.v - b.v).abs() < 1e-5);
            }
            let (a, b) = (enter_unpadded(&ray, &bounds, Interval::FULL), ray.enter(&bounds, Interval::FULL));
            assert_eq!(a.is_some(), b.is_some());
        }
        assert!(hits > 50);
    }

    #[test]
    fn a_ray_through_a_corner_may_miss_the_unpadded_box() {
        let mut missed = 0;
        for i in 1..2_000 {
            // The ray enters the box in x where it leaves it in y.
            let corner = Vec3::new(0.1 + 0.003 * i as f32, 0.37 - 0.002 * i as f32, 0.001 * i as f32);
            let bounds = Bounds3::new(corner, corner + Vec3::ONE);
            let o = Vec3::new(-1.3, 2.1, -0.7);
            let d = corner - o;
            let ray = TraversalRay::new(&Ray::new(o, d)).expect("valid");
            assert!(ray.enter(&bounds, Interval::FULL).is_some());
            missed += usize::from(enter_unpadded(&ray, &bounds, Interval::FULL).is_none());
        }
        assert!(missed > 0);
    }
}
