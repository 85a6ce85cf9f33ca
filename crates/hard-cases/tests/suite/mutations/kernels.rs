//! Tests of boxes and triangles, each damaged in one way, for binary trees.

use geometry::glam::Vec3;
use geometry::{Bounds3, Interval, Kernels, TraversalRay, TriangleHit, intersect_triangle};

use super::subjects::Damaged;

pub fn with_kernels<K: Kernels + Sync>(name: &'static str) -> Damaged {
    Damaged { name, damage: |bvh| Box::new(bvh.with_kernels::<K>()) }
}

macro_rules! kernels {
    ($($(#[$doc:meta])* $name:ident: $enter:path, $triangle:path;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy)]
        pub struct $name;

        impl Kernels for $name {
            fn enter(ray: &TraversalRay, bounds: &Bounds3, interval: Interval) -> Option<f32> {
                $enter(ray, bounds, interval)
            }

            fn intersect_triangle(ray: &TraversalRay, v: &[Vec3; 3], interval: Interval) -> Option<TriangleHit> {
                $triangle(ray, v, interval)
            }
        }
    )*};
}

kernels! {
    /// A padded box test that orders planes by `d >= 0`, and has an infinity of the wrong sign for −0.
    OctantByComparison: enter_by_comparison, intersect_triangle;
    /// Edge functions in f32 of which the compiler has fused one product.
    ContractedEdges: TraversalRay::enter, contracted_edges;
    /// The same kernel with edge functions that are not damaged.
    SoundEdges: TraversalRay::enter, sound_edges;
    /// pbrt's error bound on t, below which hits are rejected.
    RejectedByDeltaT: TraversalRay::enter, rejected_by_delta_t;
    /// The Plücker test of Embree's robust mode, with its tolerance.
    TolerantPluecker: TraversalRay::enter, tolerant_pluecker;
    /// A determinant below 10⁻⁶ is parallel.
    AbsoluteEpsilon: TraversalRay::enter, absolute_epsilon;
}

fn enter_by_comparison(ray: &TraversalRay, bounds: &Bounds3, interval: Interval) -> Option<f32> {
    let (o, d) = (ray.ray().origin, ray.ray().direction);
    let (mut entry, mut exit) = (interval.t_min(), interval.t_max().min(f32::MAX));
    for i in 0..3 {
        let (near, far) = if d[i] >= 0.0 { (bounds.min[i], bounds.max[i]) } else { (bounds.max[i], bounds.min[i]) };
        let padding = 6.0 * f32::EPSILON;
        let near = (near - o[i]) * (d[i].recip() * (1.0 - padding)).clamp(-f32::MAX, f32::MAX);
        let far = (far - o[i]) * (d[i].recip() * (1.0 + padding));
        entry = if near > entry { near } else { entry };
        exit = if far < exit { far } else { exit };
    }
    (entry <= exit).then_some(entry)
}

/// Woop's test with the vertices sheared in f32.
fn woop(
    ray: &TraversalRay,
    v: &[Vec3; 3],
    interval: Interval,
    edge: impl Fn([f32; 2], [f32; 2]) -> f64,
) -> Option<TriangleHit> {
    let (o, d) = (ray.ray().origin, ray.ray().direction);
    let kz = (0..3).max_by(|&i, &j| d[i].abs().total_cmp(&d[j].abs()))?;
    let (kx, ky) = ((kz + 1) % 3, (kz + 2) % 3);
    let p = v.map(|v| v - o);
    let [a, b, c] = p.map(|p| [p[kx] - d[kx] / d[kz] * p[kz], p[ky] - d[ky] / d[kz] * p[kz]]);
    let e = [edge(c, b), edge(a, c), edge(b, a)];
    let det = e[0] + e[1] + e[2];
    if (e.iter().any(|e| *e < 0.0) && e.iter().any(|e| *e > 0.0)) || det == 0.0 {
        return None;
    }
    let z = p.map(|p| f64::from(p[kz]) / f64::from(d[kz]));
    let t = ((e[0] * z[0] + e[1] * z[1] + e[2] * z[2]) / det) as f32;
    interval.contains(t).then_some(TriangleHit { t, u: (e[1] / det) as f32, v: (e[2] / det) as f32 })
}

fn sound_edges(ray: &TraversalRay, v: &[Vec3; 3], interval: Interval) -> Option<TriangleHit> {
    woop(ray, v, interval, |p, q| f64::from(p[0]) * f64::from(q[1]) - f64::from(p[1]) * f64::from(q[0]))
}

fn contracted_edges(ray: &TraversalRay, v: &[Vec3; 3], interval: Interval) -> Option<TriangleHit> {
    woop(ray, v, interval, |p, q| p[0].mul_add(q[1], -(p[1] * q[0])).into())
}

/// *Physically Based Rendering*, fourth edition, section 6.8.7.
fn rejected_by_delta_t(ray: &TraversalRay, v: &[Vec3; 3], interval: Interval) -> Option<TriangleHit> {
    let hit = intersect_triangle(ray, v, interval)?;
    let gamma = |n: f32| n * 0.5 * f32::EPSILON / (1.0 - n * 0.5 * f32::EPSILON);
    let (o, d) = (ray.ray().origin, ray.ray().direction);
    let kz = (0..3).max_by(|&i, &j| d[i].abs().total_cmp(&d[j].abs()))?;
    let (kx, ky) = ((kz + 1) % 3, (kz + 2) % 3);
    let sheared = v.map(|v| {
        let p = v - o;
        Vec3::new(p[kx] - d[kx] / d[kz] * p[kz], p[ky] - d[ky] / d[kz] * p[kz], p[kz] / d[kz])
    });
    let [a, b, c] = sheared;
    let e = Vec3::new(b.x * c.y - b.y * c.x, c.x * a.y - c.y * a.x, a.x * b.y - a.y * b.x);
    let max = a.abs().max(b.abs()).max(c.abs());
    let (delta_x, delta_y, delta_z) = (gamma(5.0) * (max.x + max.z), gamma(5.0) * (max.y + max.z), gamma(3.0) * max.z);
    let delta_e = 2.0 * (gamma(2.0) * max.x * max.y + delta_y * max.x + delta_x * max.y);
    let max_e = e.abs().max_element();
    let det = e.x + e.y + e.z;
    let delta_t = 3.0 * (gamma(3.0) * max_e * max.z + delta_e * max.z + delta_z * max_e) / det.abs();
    (hit.t > delta_t).then_some(hit)
}

/// Embree's `triangle_intersector_pluecker.h`: edge functions relative to the origin, accepted within one ulp of their
/// sum.
fn tolerant_pluecker(ray: &TraversalRay, v: &[Vec3; 3], interval: Interval) -> Option<TriangleHit> {
    let (o, d) = (ray.ray().origin, ray.ray().direction);
    let [v0, v1, v2] = v.map(|v| v - o);
    let (e0, e1, e2) = (v2 - v0, v0 - v1, v1 - v2);
    let [u, v, w] = [e0.cross(v2 + v0), e1.cross(v0 + v1), e2.cross(v1 + v2)].map(|m| m.dot(d));
    let sum = u + v + w;
    let epsilon = f32::EPSILON * sum.abs();
    if u.min(v).min(w) < -epsilon && u.max(v).max(w) > epsilon {
        return None;
    }
    let n = e0.cross(e1);
    let den = n.dot(d);
    if den == 0.0 {
        return None;
    }
    let t = v0.dot(n) / den;
    interval.contains(t).then(|| TriangleHit { t, u: (u / sum).clamp(0.0, 1.0), v: (v / sum).clamp(0.0, 1.0) })
}

fn absolute_epsilon(ray: &TraversalRay, v: &[Vec3; 3], interval: Interval) -> Option<TriangleHit> {
    let det = (v[1] - v[0]).dot(ray.ray().direction.cross(v[2] - v[0]));
    if det.abs() < 1e-6 { None } else { intersect_triangle(ray, v, interval) }
}
