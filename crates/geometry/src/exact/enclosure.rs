//! Two numbers around the exact parameter of a hit.

use std::cmp::Ordering;

use glam::{DVec3, Vec3};

use super::rational::Line;
use crate::TraversalRay;

/// Half the spacing of f64 at 1: the relative error of one rounding.
const U: f64 = f64::EPSILON / 2.0;

/// 2⁻¹⁰⁰⁰: more than underflow can add to a determinant (three products, by 2⁻¹⁰⁷⁵ each, of f64 components of a ray),
/// and less than any determinant of f32 data but zero.
const TINY: f64 = f64::from_bits((1023 - 1000) << 52);

/// A hit, by two numbers around the exact parameter: `low <= t* <= high`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
pub struct Enclosure {
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Enclosure {
    /// Not above t*.
    pub fn low(&self) -> f64 {
        self.low
    }

    /// Not below t*.
    pub fn high(&self) -> f64 {
        self.high
    }

    /// Where the line meets the plane of the triangle: t* = n·p / n·d with n = (v₁ − v₀) × (v₂ − v₀) and p = v₀ − o.
    /// `None` where n·d is not certain within 1/64 of itself.
    ///
    /// With u = 2⁻⁵³ and S = |v₁ − v₀| × |v₂ − v₀|, all terms added, n is wrong by 4u S: a rounding in each difference,
    /// in the product, and in the sum. Then n·p is wrong by 8u S·|p| and n·d by 7u S·|d|, to first order; 10u is for
    /// the rest.
    /// |N / D − N* / D*| <= (δN + |t| δD) / (|D| − δD), and 1/63 more of it for δD; the quotient and the ends are
    /// rounded.
    pub(super) fn of_plane(line: &Line, vertices: &[Vec3; 3]) -> Option<Self> {
        let Plane { numerator, denominator, numerator_error, denominator_error } = Plane::new(line, vertices);
        let t = numerator / denominator;
        let error = (numerator_error + t.abs() * denominator_error) / denominator.abs();
        let is_certain = denominator.abs() >= 64.0 * denominator_error;
        is_certain.then(|| Self::around(t, 1.03125 * error + 8.0 * U * t.abs()))
    }

    /// From exact numbers: within 8u.
    pub(super) fn exactly(line: &Line, vertices: &[Vec3; 3]) -> Self {
        let t = line.approximate(vertices).t;
        Self::around(t, 16.0 * U * t.abs())
    }

    /// What underflows is wrong by less than the least normal number.
    fn around(t: f64, error: f64) -> Self {
        let error = error + f64::MIN_POSITIVE;
        Self { low: t - error, high: t + error }
    }

    /// The nearest f32 to each end, of what may be a hit: nothing below 0 or beyond `f32::MAX` is.
    pub(super) fn rounded(&self) -> [f32; 2] {
        [self.low, self.high].map(|t| t.clamp(0.0, f32::MAX.into()) as f32)
    }
}

/// The order of the parameter where a ray meets the plane of a triangle, and `t`, where f64 is certain of it. The
/// triangle that a ray has just left is met a few ulp before or after 0, which is too near for f32, and needs neither
/// edges nor a division.
///
/// With the notation and the errors of `Enclosure::of_plane`, t* < t where n·p − t n·d and n·d have different signs;
/// the first is wrong by 8u S·|p| + 8u t S·|d| to first order, its own difference included, and so by less than 10u of
/// both.
#[inline(always)]
pub fn cmp_plane(ray: &TraversalRay, vertices: &[Vec3; 3], t: f32) -> Option<Ordering> {
    let plane = Plane::new(&Line { origin: ray.origin64(), direction: ray.direction64() }, vertices);
    let t = f64::from(t);
    let beyond = plane.numerator - t * plane.denominator;
    let error = plane.numerator_error + t.abs() * plane.denominator_error;
    let is_certain = (beyond.abs() > error) & (plane.denominator.abs() > plane.denominator_error);
    let is_less = (beyond < 0.0) != (plane.denominator < 0.0);
    is_certain.then_some(if is_less { Ordering::Less } else { Ordering::Greater })
}

/// n·p and n·d, each with a bound on its error: see [`Enclosure::of_plane`].
struct Plane {
    numerator: f64,
    denominator: f64,
    numerator_error: f64,
    denominator_error: f64,
}

impl Plane {
    #[inline(always)]
    fn new(line: &Line, vertices: &[Vec3; 3]) -> Self {
        let [v0, v1, v2] = vertices.map(|v| v.as_dvec3());
        let (a, b, p, d) = (v1 - v0, v2 - v0, v0 - line.origin, line.direction);
        let terms = |i: usize, j: usize| (a[i] * b[j], a[j] * b[i]);
        let terms = [terms(1, 2), terms(2, 0), terms(0, 1)];
        let n = DVec3::from_array(terms.map(|(x, y)| x - y));
        let size = DVec3::from_array(terms.map(|(x, y)| x.abs() + y.abs()));
        Self {
            numerator: dot(n, p),
            denominator: dot(n, d),
            numerator_error: 10.0 * U * dot(size, p.abs()) + TINY,
            denominator_error: 10.0 * U * dot(size, d.abs()) + TINY,
        }
    }
}

/// Written out, so that the same operations run in the same order on every target.
#[inline(always)]
fn dot(a: DVec3, b: DVec3) -> f64 {
    a.x * b.x + a.y * b.y + a.z * b.z
}
