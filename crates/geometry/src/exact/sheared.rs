//! The first two tiers: a triangle in the frame of the ray, in f64, and how wrong that can be.

use glam::{DVec3, Vec3};

use crate::{Bounds3, Shear, TraversalRay};

/// Half the spacing of f64 at 1: the relative error of one rounding.
const U: f64 = f64::EPSILON / 2.0;

/// 2⁻⁷⁰⁰: more than underflow can add to an edge function, and less than any edge function of f32 data but zero.
///
/// A product is wrong by up to 2⁻¹⁰⁷⁵ where it underflows; sums never are. In an edge function that is multiplied by
/// two sheared coordinates, which are below 2¹⁹². Of f32 data an edge function is a multiple of 2⁻⁵⁹⁶.
const TINY: f64 = f64::from_bits((1023 - 700) << 52);

/// 2⁻⁶⁵⁰: the reciprocal of a larger sum times a component of a direction, which is above 2⁻¹⁵¹, and products with it,
/// are far from the ends of f64.
const LEAST_SUM: f64 = f64::from_bits((1023 - 650) << 52);

/// The frame in which the ray is the z axis: that of Woop, Benthin and Wald 2013 in f64, with x and y times d_z, by
/// which nothing waits for a division; kz is the axis of the largest component of the f64 direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    kx: usize,
    ky: usize,
    kz: usize,
    /// The origin in the order kx, ky, kz.
    origin: [f64; 3],
    /// The direction in that order.
    d: [f64; 3],
}

/// A triangle in the frame of a ray.
///
/// *Errors*, with u = 2⁻⁵³ and to first order; the factors below leave a quarter and more for the rest, the roundings
/// of the bounds included. A coordinate x = pₓ d_z − dₓ p_z is wrong by δ <= 2u |pₓ d_z| + 2u |dₓ p_z| + u |x|: one
/// rounding in each p, one in each product, one in the difference. An edge function e = x_c y_b − y_c x_b is then wrong
/// by E <= 2δ (X + Y + δ) + 4u X Y, where X and Y bound the coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sheared {
    x: [f64; 3],
    y: [f64; 3],
    z: [f64; 3],
    /// The largest component of the direction.
    dz: f64,
    /// The edge functions, each that of the edge opposite to its vertex; in real arithmetic a common multiple of
    /// det[pⱼ, pₖ, d].
    edges: [f64; 3],
}

impl Frame {
    #[inline(always)]
    pub(super) fn new(ray: &TraversalRay) -> Self {
        let &Shear { kx, ky, kz, .. } = ray.shear();
        Self::along([kx, ky, kz], ray.permuted64())
    }

    /// The frame of an origin and a direction whose coordinates are in the order of these axes.
    #[inline(always)]
    pub(super) fn along([kx, ky, kz]: [usize; 3], [origin, d]: [[f64; 3]; 2]) -> Self {
        Self { kx, ky, kz, origin, d }
    }

    /// A bound on the error of the edge functions of every triangle inside of `bounds`: with M the largest coordinate
    /// relative to the origin, times |d_z|, δ <= 6u M and X, Y <= 2M give 64 u M² to first order; 128 is for the rest.
    /// Infinite for bounds that are empty.
    pub(super) fn edge_error(&self, bounds: &Bounds3) -> f64 {
        let [kx, ky, kz] = [self.kx, self.ky, self.kz];
        let o = DVec3::from_array(self.origin);
        let corner = |c: Vec3| DVec3::new(c[kx].into(), c[ky].into(), c[kz].into());
        let m = (corner(bounds.min) - o).abs().max((corner(bounds.max) - o).abs()).max_element() * self.d[2].abs();
        128.0 * U * m * m + TINY
    }

    #[inline]
    pub(super) fn shear(&self, vertices: &[Vec3; 3]) -> Sheared {
        // Three ways instead of three indices, which would send every vertex through memory.
        self.shear_permuted(&match self.kz {
            0 => vertices.map(|v| [v.y, v.z, v.x]),
            1 => vertices.map(|v| [v.z, v.x, v.y]),
            _ => vertices.map(|v| [v.x, v.y, v.z]),
        })
    }

    /// Vertices whose coordinates are in the order kx, ky, kz.
    #[inline(always)]
    pub(super) fn shear_permuted(&self, vertices: &[[f32; 3]; 3]) -> Sheared {
        let [dx, dy, dz] = self.d;
        let mut sheared = Sheared { x: [0.0; 3], y: [0.0; 3], z: [0.0; 3], dz, edges: [0.0; 3] };
        for (i, &[x, y, z]) in vertices.iter().enumerate() {
            let z = f64::from(z) - self.origin[2];
            sheared.x[i] = (f64::from(x) - self.origin[0]) * dz - dx * z;
            sheared.y[i] = (f64::from(y) - self.origin[1]) * dz - dy * z;
            sheared.z[i] = z;
        }
        let (x, y) = (&sheared.x, &sheared.y);
        sheared.edges = [x[2] * y[1] - y[2] * x[1], x[0] * y[2] - y[0] * x[2], x[1] * y[0] - y[1] * x[0]];
        sheared
    }

    /// Vertices in the order x, y, z again.
    pub(super) fn unpermuted(&self, vertices: &[[f32; 3]; 3]) -> [Vec3; 3] {
        vertices.map(|p| {
            let mut v = Vec3::ZERO;
            (v[self.kx], v[self.ky], v[self.kz]) = (p[0], p[1], p[2]);
            v
        })
    }
}

/// The larger of two numbers, neither of them NaN.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The largest size of three numbers.
#[inline(always)]
fn largest(v: &[f64; 3]) -> f64 {
    larger(larger(v[0].abs(), v[1].abs()), v[2].abs())
}

impl Sheared {
    /// The smallest and the largest edge function.
    #[inline(always)]
    pub(super) fn edge_range(&self) -> [f64; 2] {
        let [a, b, c] = self.edges;
        // The comparisons fail for NaN, which cannot be: everything is finite.
        let (low, high) = if a < b { (a, b) } else { (b, a) };
        [if c < low { c } else { low }, if c > high { c } else { high }]
    }

    /// A bound on the errors of these edge functions: with R >= X, Y and Z bounding the depths times |d_z|,
    /// |pₓ d_z| <= R + Z and so δ <= 3u R + 4u Z, here 8u (R + Z); and E <= δ (4.5 R + 2δ), here 5 δ (R + δ).
    #[inline(always)]
    pub(super) fn edge_error(&self) -> f64 {
        let r = larger(largest(&self.x), largest(&self.y));
        let delta = self.error(r);
        5.0 * delta * (r + delta) + TINY
    }

    /// δ, of R.
    #[inline(always)]
    fn error(&self, r: f64) -> f64 {
        8.0 * U * (r + largest(&self.z) * self.dz.abs())
    }

    /// Whether the ray passes beside the box of the triangle in its frame for certain: all three vertices lie on one
    /// side of it. Of an origin 10⁹ triangles away, from which all three coordinates are nearly the same number and the
    /// edge functions say nothing, this still does.
    pub(super) fn is_passed_by(&self) -> bool {
        let error = self.error(larger(largest(&self.x), largest(&self.y))) + f64::MIN_POSITIVE;
        [self.x, self.y].iter().any(|c| c.iter().all(|&c| c > error) || c.iter().all(|&c| c < -error))
    }

    /// The barycentrics eᵢ / Σe of the second and the third vertex, and whether they are certain within 2⁻²⁴.
    ///
    /// Each is wrong by (E + 3E |bᵢ|) / (Σe − 3E) at most, 4E / Σe to first order, and by six roundings. (A bound that
    /// rounding to f32 would hide, 2⁻²⁸, was too much: it sent every triangle 10⁵ times its size away to exact
    /// numbers.)
    #[inline(always)]
    pub(super) fn barycentrics(&self) -> ([f64; 2], bool) {
        const SAFETY: f64 = (1_u64 << 26) as f64;
        let [e0, e1, e2] = self.edges;
        let sum = e0 + e1 + e2;
        // The division of `t`.
        let r = 1.0 / (sum * self.dz) * self.dz;
        ([e1 * r, e2 * r], sum.abs() >= SAFETY * self.edge_error())
    }

    /// t* of a hit rounded to the nearest f32, and whether that is certain: Σ eᵢ zᵢ / Σe / d_z.
    ///
    /// A mean of the depths Z, whose weights are wrong by 6E / (|Σe| − 3E) together, here 8E / |Σe|. The roundings: one
    /// in each z, three in the sum of products and two in Σe, of which all terms have one sign but for what E covers;
    /// two products, a reciprocal. Here 16u Z.
    #[inline(always)]
    pub(super) fn t(&self) -> (f32, bool) {
        let ([e0, e1, e2], [z0, z1, z2]) = (self.edges, self.z);
        let sum = e0 + e1 + e2;
        let r = 1.0 / (sum * self.dz);
        let t = (e0 * z0 + e1 * z1 + e2 * z2) * r;
        let size = larger(larger(z0.abs(), z1.abs()), z2.abs());
        let error = size * (8.0 * self.edge_error() + 16.0 * U * sum.abs()) * r.abs();
        let (low, high) = ((t - error) as f32, (t + error) as f32);
        // What may underflow or overflow is left to others.
        let is_certain = (low == high) & (low >= f32::MIN_POSITIVE) & (high < f32::MAX) & (sum.abs() >= LEAST_SUM);
        (low, is_certain)
    }
}
