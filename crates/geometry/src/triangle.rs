//! The watertight triangle test, and the point on the triangle that it found.

use glam::{DVec3, Vec2, Vec3, Vec3A};

use crate::exact::exact_weights;
use crate::{Bounds3, Interval, MAX_COORDINATE, Shear, SurfacePoint, TraversalRay};

/// Half the spacing of f64 at 1: the relative error of one rounding.
const U64: f64 = f64::EPSILON / 2.0;

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// The ray's parameter.
    pub t: f32,
    /// The barycentric of the second vertex, in [0, 1].
    pub u: f32,
    /// The barycentric of the third vertex, in [0, 1].
    pub v: f32,
}

/// Where `ray` meets the closed triangle with `t` in the open `interval`; both sides are hit.
///
/// *Decision.* The vertices are sheared into the frame in which the ray is the z axis (Woop, Benthin and Wald 2013), in
/// f32 and with two roundings a coordinate: triangles that share a vertex get the same bits for it. The edge functions
/// of these coordinates are exact in sign, since the products of two f32 are exact in f64 and a difference of two
/// floats never has the wrong sign. So neighbours agree about every shared edge and vertex, by position and not by
/// index, and a closed mesh has no leak. An edge function of zero is inside, for both neighbours. There is no epsilon.
/// A triangle that the sheared ray sees edge-on has no inside and is not hit; its neighbours are.
///
/// *Values.* `t`, `u` and `v` are evaluated in f64 for the accepted triangle alone, and rounded to f32 once. `t` is
/// that of the triangle's plane, kept between the depths of its vertices, hence never beyond the triangle; and not
/// below the entry into the triangle's own box: with that, the closest of many triangles is the same for every tree
/// over them. A triangle whose box the padded box test misses is not hit.
///
/// Total: non-finite vertices are not hit; no NaN comes out.
#[inline]
pub fn intersect_triangle(ray: &TraversalRay, vertices: &[Vec3; 3], interval: Interval) -> Option<TriangleHit> {
    if is_inside(ray, vertices) { hit_of(ray, vertices, interval) } else { None }
}

/// Where a ray that passes through the triangle meets it. Not compiled in place: most triangles of a leaf are missed.
#[inline(never)]
fn hit_of(ray: &TraversalRay, vertices: &[Vec3; 3], interval: Interval) -> Option<TriangleHit> {
    let t = plane_t(ray, vertices)? as f32;
    // The entry only makes it larger. Where many triangles lie behind one another, most need no more than this.
    if t >= interval.t_max() {
        return None;
    }
    let entry = ray.enter(&watertight_triangle_bounds(vertices), interval)?;
    let t = t.max(entry);
    if !interval.contains(t) {
        return None;
    }
    let Weights { b, .. } = Weights::of_plane_hit(ray, vertices)?;
    Some(TriangleHit { t, u: b[1] as f32, v: b[2] as f32 })
}

/// The box of a triangle: no exact decision needs more.
///
/// Not [valid](Bounds3::is_valid) where a coordinate is NaN, infinite or beyond [`MAX_COORDINATE`].
#[inline(always)] // A call would write the vertices to memory and read them back in other pieces: a third of the time.
pub fn triangle_bounds(vertices: &[Vec3; 3]) -> Bounds3 {
    match corners(vertices) {
        Some([min, max]) => Bounds3::new(min, max),
        None => Bounds3::from_points(*vertices),
    }
}

/// The box of a triangle, grown by 2⁻²¹ of its largest extent: with it, no box test loses a hit of
/// [`intersect_triangle`].
///
/// A vertex is displaced by the roundings of its sheared coordinates, by at most 2u |pₓ| + 4u |Sₓ p_z| with u = 2⁻²⁴
/// and p its position relative to the origin. Relative to the hit h, |pₓ| <= |hₓ| + L and |Sₓ p_z| <= |hₓ| + L for the
/// largest extent L, so the triangle may seem hit up to 6u |hₓ| + 6u L beside itself. The first part is in the ray's
/// padding; the second, which a far vertex of a long triangle brings, must be in the box: 8u L, rounded outward.
///
/// Not [valid](Bounds3::is_valid) where [`triangle_bounds`] is not.
#[inline(always)]
pub fn watertight_triangle_bounds(vertices: &[Vec3; 3]) -> Bounds3 {
    let Some([min, max]) = corners(vertices) else { return Bounds3::from_points(*vertices) };
    let limit = Vec3A::splat(MAX_COORDINATE);
    let growth = Vec3A::splat((max - min).max_element() * (4.0 * f32::EPSILON));
    let low = Vec3A::from_array((min - growth).to_array().map(next_down)).max(-limit);
    let high = Vec3A::from_array((max + growth).to_array().map(|x| -next_down(-x))).min(limit);
    Bounds3::new(low, high)
}

/// The least and the largest coordinates; `None` where one is NaN, infinite or beyond [`MAX_COORDINATE`].
#[inline(always)]
fn corners(vertices: &[Vec3; 3]) -> Option<[Vec3A; 2]> {
    let (a, b, c) = (Vec3A::from(vertices[0]), Vec3A::from(vertices[1]), Vec3A::from(vertices[2]));
    let limit = Vec3A::splat(MAX_COORDINATE);
    // False for NaN.
    let is_valid = a.abs().cmple(limit) & b.abs().cmple(limit) & c.abs().cmple(limit);
    is_valid.all().then(|| [a.min(b).min(c), a.max(b).max(c)])
}

/// [`f32::next_down`] of a finite number, without a branch.
#[inline]
fn next_down(x: f32) -> f32 {
    // Zeros of either sign become the negative one, and go away from zero like all negative numbers.
    let bits = (x - 0.0).to_bits() | u32::from(x == 0.0) << 31;
    f32::from_bits(if bits >> 31 == 1 { bits + 1 } else { bits.wrapping_sub(1) })
}

/// Whether the sheared ray passes through the closed triangle: all edge functions of one sign, and not all zero.
#[inline(always)]
fn is_inside(ray: &TraversalRay, vertices: &[Vec3; 3]) -> bool {
    let &Shear { kx, ky, kz, sx, sy, .. } = ray.shear();
    let o = ray.origin_and_time();
    let [ox, oy, oz] = [o[kx], o[ky], o[kz]];
    let [a, b, c] = vertices.map(|v| {
        // Four, so that no axis is out of range.
        let v = [v.x, v.y, v.z, 0.0];
        let z = v[kz & 3] - oz;
        let x = (v[kx & 3] - ox) - sx * z;
        let y = (v[ky & 3] - oy) - sy * z;
        (f64::from(x), f64::from(y))
    });
    let e0 = c.0 * b.1 - c.1 * b.0;
    let e1 = a.0 * c.1 - a.1 * c.0;
    let e2 = b.0 * a.1 - b.1 * a.0;
    // One branch: which sign each has cannot be predicted. The sum is NaN where any is.
    let (low, high) = if e0 < e1 { (e0, e1) } else { (e1, e0) };
    let (low, high) = (if e2 < low { e2 } else { low }, if e2 > high { e2 } else { high });
    ((low >= 0.0) | (high <= 0.0)) & ((e0 + e1 + e2).abs() > 0.0)
}

/// The barycentric weights of the point where the f64 ray meets the triangle's plane, clamped into the triangle.
struct Weights {
    b: [f64; 3],
    /// A bound on Σ |bᵢ − bᵢ*| against the exact, unclamped weights.
    error: f64,
}

impl Weights {
    /// The computation of [`is_inside`] in f64 from the f64 ray, with x and y times d_z, by which nothing is divided
    /// but the weights, once.
    ///
    /// With u = 2⁻⁵³: a sheared coordinate x = pₓ d_z − dₓ p_z has at most the error 3u (|pₓ d_z| + |dₓ p_z|) = 3u X,
    /// by a rounding in p, in the product and in the difference; an edge function then at most 8u (X_c Y_b + Y_c X_b),
    /// to first order, here 12u; Σ |δbᵢ| <= 2 Σ |δeᵢ| / |Σ eᵢ|. Clamping moves the weights by twice the clamped sum at
    /// most. `None` where the plane is edge-on even in f64.
    #[inline]
    fn of_plane_hit(ray: &TraversalRay, vertices: &[Vec3; 3]) -> Option<Self> {
        let shear = ray.shear();
        let (o, d) = (ray.origin64(), ray.direction64());
        let [dx, dy, dz] = [d[shear.kx], d[shear.ky], d[shear.kz]];
        let mut x = [0.0; 3];
        let mut y = [0.0; 3];
        let mut x_size = [0.0; 3];
        let mut y_size = [0.0; 3];
        for i in 0..3 {
            let p = vertices[i].as_dvec3() - o;
            let [px, py, pz] = [p[shear.kx], p[shear.ky], p[shear.kz]];
            x[i] = px * dz - dx * pz;
            y[i] = py * dz - dy * pz;
            x_size[i] = (px * dz).abs() + (dx * pz).abs();
            y_size[i] = (py * dz).abs() + (dy * pz).abs();
        }
        const EDGES: [(usize, usize); 3] = [(2, 1), (0, 2), (1, 0)];
        let e = EDGES.map(|(i, j)| x[i] * y[j] - y[i] * x[j]);
        let e_size: f64 = EDGES.iter().map(|&(i, j)| x_size[i] * y_size[j] + y_size[i] * x_size[j]).sum();
        let e_error = 12.0 * U64 * e_size;
        let det = e[0] + e[1] + e[2];
        if det == 0.0 || !det.is_finite() {
            return None;
        }
        let inside = e.map(|e| e.abs() * f64::from(u8::from((e < 0.0) == (det < 0.0))));
        let sum = inside[0] + inside[1] + inside[2];
        let r = 1.0 / sum;
        Some(Self { b: inside.map(|e| e * r), error: 2.0 * (e_error + (sum - det.abs())) / det.abs() })
    }
}

/// The parameter at which the f64 ray meets the triangle's plane, kept within the vertices' depths along the ray's
/// largest component.
///
/// By the plane's equation and not by the weighted depths: for an origin in the plane of an axis-parallel triangle it
/// is exactly 0, where the weighted sum left 10⁻¹⁷ of either sign (of rays spawned from such a floor 2.7 % hit it
/// again). `None` for a triangle without area, which the rounded shear may have given some.
#[inline]
fn plane_t(ray: &TraversalRay, vertices: &[Vec3; 3]) -> Option<f64> {
    let v = vertices.map(|v| v.as_dvec3());
    let n = (v[1] - v[0]).cross(v[2] - v[0]);
    if n == DVec3::ZERO {
        return None;
    }
    let (o, d, kz) = (ray.origin64(), ray.direction64(), ray.shear().kz);
    let z = v.map(|v| v[kz] - o[kz]);
    let (low, high) = (z[0].min(z[1]).min(z[2]), z[0].max(z[1]).max(z[2]));
    // Rounding is monotone: these are the least and the largest of the three quotients.
    let (nearest, farthest) = if d[kz] < 0.0 { (high / d[kz], low / d[kz]) } else { (low / d[kz], high / d[kz]) };
    let t = n.dot(v[0] - o) / n.dot(d);
    // Edge-on in f64, the plane's equation says nothing (NaN); then the nearest depth.
    Some(if t > nearest { t.min(farthest) } else { nearest })
}

/// Barycentric weights, and a bound on the sum of their errors; they add up to 1 within 2u.
#[inline]
fn weights_within(ray: &TraversalRay, vertices: &[Vec3; 3], bounds: &Bounds3) -> ([f64; 3], f64) {
    /// A small part of what f32 can tell.
    const FINE: f64 = 1.0 / (1_u64 << 27) as f64;
    let in_f64 = Weights::of_plane_hit(ray, vertices).map(|weights| (weights.b, weights.error));
    if let Some((b, error)) = in_f64
        && error <= FINE
    {
        return (b, error);
    }
    let exact = if bounds.is_valid() { exact_weights(ray, vertices) } else { None };
    let exact = exact.map(|[u, v]| ([(1.0 - u - v).max(0.0), u, v], 24.0 * U64));
    exact.or(in_f64).unwrap_or(([1.0, 0.0, 0.0], 1.0))
}

/// The point where `ray` meets the plane of the triangle, clamped into the triangle.
///
/// `p_error` bounds the distance from the exact intersection of the f64 ray with the plane, for each axis: the weights'
/// error times the triangle's extent on that axis (the weights' errors add up to zero), and the roundings of the sum.
/// Where f64 says little, of a triangle that is nearly edge-on, the weights are exact ones, rounded. `uvs` are the
/// vertices' texture coordinates. The normal of a degenerate triangle, which no ray hits, is zero.
pub fn triangle_surface_point(ray: &TraversalRay, vertices: &[Vec3; 3], uvs: &[Vec2; 3]) -> SurfacePoint {
    let v = vertices.map(|v| v.as_dvec3());
    let n = (v[1] - v[0]).cross(v[2] - v[0]).normalize_or_zero();
    let bounds = Bounds3::from_points(*vertices);
    let (b, error) = weights_within(ray, vertices, &bounds);
    let p = b[0] * v[0] + b[1] * v[1] + b[2] * v[2];
    let extent = bounds.max.as_dvec3() - bounds.min.as_dvec3();
    let size = v[0].abs().max(v[1].abs()).max(v[2].abs());
    let uv = b[0] as f32 * uvs[0] + b[1] as f32 * uvs[1] + b[2] as f32 * uvs[2];
    SurfacePoint { p, p_error: extent * error + size * DVec3::splat(8.0 * U64), n, uv }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Ray;

    const TRIANGLE: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

    fn hit(o: [f32; 3], d: [f32; 3]) -> Option<TriangleHit> {
        intersect_triangle(&TraversalRay::new(&Ray::new(o, d)).expect("valid"), &TRIANGLE, Interval::FULL)
    }

    #[test]
    fn hits_inside_from_both_sides() {
        for z in [2.0_f32, -2.0] {
            let h = hit([0.25, 0.5, z], [0.0, 0.0, -z.signum()]).expect("inside");
            assert_eq!((h.t, h.u, h.v), (2.0, 0.25, 0.5));
        }
    }

    #[test]
    fn edges_and_vertices_are_inside() {
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.0), (0.5, 0.5), (0.0, 0.5)] {
            assert!(hit([x, y, 1.0], [0.0, 0.0, -1.0]).is_some(), "{x} {y}");
        }
        for (x, y) in [(-1e-7, 0.0), (0.5, 0.500_001), (0.5, -1e-30)] {
            assert!(hit([x, y, 1.0], [0.0, 0.0, -1.0]).is_none(), "{x} {y}");
        }
    }

    /// A corridor of which the ray meets an edge whose ends are far away: the displacement by the far vertices is more
    /// than the ray's own padding, and the box must contain it.
    #[test]
    fn long_edges_do_not_leak() {
        for exponent in 0..8 {
            let l = 10.0_f32.powi(exponent);
            let wall = [
                [Vec3::new(-l, 0.0, 0.0), Vec3::new(l, 0.0, 0.0), Vec3::new(l, -4.0, 0.0)],
                [Vec3::new(-l, 0.0, 0.0), Vec3::new(l, -4.0, 0.0), Vec3::new(-l, -4.0, 0.0)],
            ];
            let roof = wall.map(|t| t.map(|v| Vec3::new(v.x, 0.0, v.y)));
            for i in 0..2_000 {
                let o = Vec3::new(0.001 * i as f32 - 1.0, -0.504_514, -0.488_323_33);
                let beside = l * f32::EPSILON * ((i % 17) as f32 - 8.0) / 8.0;
                let target = Vec3::new(o.x - 2.12 + 0.002 * i as f32, beside, -beside * 0.7);
                let ray = TraversalRay::new(&Ray::new(o, target - o)).expect("valid");
                let hit = wall.iter().chain(&roof).any(|t| intersect_triangle(&ray, t, Interval::FULL).is_some());
                assert!(hit || target.x.abs() > l, "{l} {o} {target}");
            }
        }
    }

    #[test]
    fn edge_on_degenerate_and_non_finite_triangles_are_not_hit() {
        assert!(hit([-1.0, 0.25, 0.0], [1.0, 0.0, 0.0]).is_none());
        let ray = TraversalRay::new(&Ray::new([0.25, 0.25, 1.0], [0.0, 0.0, -1.0])).expect("valid");
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let t = [Vec3::ZERO, Vec3::X, Vec3::new(0.0, bad, 0.0)];
            assert!(intersect_triangle(&ray, &t, Interval::FULL).is_none());
        }
        assert!(intersect_triangle(&ray, &[Vec3::ZERO, Vec3::ONE, Vec3::ONE], Interval::FULL).is_none());
    }

    /// S08: scaling the direction by a power of two scales t exactly.
    #[test]
    fn t_counts_in_multiples_of_the_direction() {
        let h = hit([0.3, 0.3, 1.7], [0.01, 0.02, -1.0]).expect("inside");
        for k in [-60, -3, 5, 60] {
            let s = 2.0_f32.powi(k);
            let scaled = hit([0.3, 0.3, 1.7], [0.01 * s, 0.02 * s, -s]).expect("inside");
            assert_eq!((scaled.t * s, scaled.u, scaled.v), (h.t, h.u, h.v));
        }
    }

    #[test]
    fn the_point_is_on_the_triangle_within_its_bound() {
        let ray = TraversalRay::new(&Ray::new([0.3, 0.2, 5.0], [0.001, 0.03, -1.0])).expect("valid");
        let s = triangle_surface_point(&ray, &TRIANGLE, &[Vec2::ZERO, Vec2::X, Vec2::Y]);
        assert_eq!(s.p.z, 0.0);
        assert_eq!(s.n, DVec3::Z);
        assert!(s.p_error.max_element() < 1e-14 && s.p_error.min_element() >= 0.0);
        let x = f64::from(0.3_f32) + 5.0 * f64::from(0.001_f32);
        assert!((s.p.x - x).abs() <= s.p_error.x && s.uv.x == x as f32);
    }
}
