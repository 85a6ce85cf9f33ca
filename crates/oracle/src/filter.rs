//! The tests of a ray and a triangle in f64, with a certificate.

use std::cmp::Ordering;

use geometry::glam::DVec3;

use crate::segment::Segment;

/// The relative error of one rounding.
const U: f64 = f64::EPSILON / 2.0;

/// What underflow can add to an error. Rounded vertices are wrong by 2⁻¹⁰⁷⁴ more, a product by 2⁻¹⁰⁷⁵, and each of
/// these errors is multiplied by at most two factors below 2²⁰² (see [`LARGEST`]). Sums and products of three f32 never
/// underflow in f64, and are never smaller than 2⁻⁴⁴⁷ unless zero, so that this costs nothing.
const TINY: f64 = 1e-180;

/// The largest coordinate of a rounded vertex for which a certificate is given. 10⁶⁰ < 2²⁰⁰.
const LARGEST: f64 = 1e60;

/// The vertices of a triangle in f64.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FloatTriangle {
    pub(crate) vertices: [DVec3; 3],
    /// Whether the vertices are rounded, each coordinate with a relative error of at most 2u; else they are exact.
    pub(crate) is_rounded: bool,
}

/// What f64 can say about a ray and a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Verdict {
    /// There is no hit.
    Miss,
    /// There is one, and its t lies within these numbers.
    Hit([f64; 2]),
    /// The certificate fails.
    Unsure,
}

/// A number with a bound on its error.
#[derive(Clone, Copy, Debug)]
struct Bounded {
    value: f64,
    error: f64,
}

impl Bounded {
    /// The sign of the exact number, where the error leaves no doubt.
    fn order(self) -> Option<Ordering> {
        // NaN and infinity fail the comparison.
        if self.value.abs() > self.error && self.value.is_finite() { self.value.partial_cmp(&0.0) } else { None }
    }
}

/// A vector with a size s >= |v| for each component. The error of a component is at most u s for a difference of points
/// and 4u s for a cross product.
#[derive(Clone, Copy, Debug)]
struct BoundedVector {
    value: DVec3,
    size: DVec3,
}

impl FloatTriangle {
    /// The difference of two points: one rounding, and 2u of each point that is rounded itself.
    fn difference(&self, a: DVec3, b: DVec3, rounded: DVec3) -> BoundedVector {
        let value = a - b;
        let inherited = if self.is_rounded { rounded * 2.0 } else { DVec3::ZERO };
        BoundedVector { value, size: value.abs() + inherited }
    }

    fn relative_to(&self, o: DVec3) -> [BoundedVector; 3] {
        self.vertices.map(|v| self.difference(v, o, v.abs()))
    }

    /// The normal (v₁ − v₀) × (v₂ − v₀), with an error of at most 4u size.
    fn normal(&self) -> BoundedVector {
        let [v0, v1, v2] = self.vertices;
        let a = self.difference(v1, v0, v1.abs() + v0.abs());
        let b = self.difference(v2, v0, v2.abs() + v0.abs());
        cross(&a, &b)
    }

    fn is_too_large(&self) -> bool {
        self.is_rounded && !self.vertices.iter().all(|v| v.abs().max_element() < LARGEST)
    }

    /// What f64 knows of [`intersect`](crate::triangle::intersect), under either edge rule.
    pub(crate) fn intersect(&self, ray: &Segment) -> Verdict {
        if self.is_too_large() {
            return Verdict::Unsure;
        }
        let d = ray.direction;
        let p = self.relative_to(ray.origin);
        let e = [(1, 2), (2, 0), (0, 1)].map(|(i, j)| dot_exact(&cross(&p[i], &p[j]), d).order());
        let any = |order| e.contains(&Some(order));
        if any(Ordering::Less) && any(Ordering::Greater) {
            return Verdict::Miss;
        }
        if e.contains(&None) {
            return Verdict::Unsure;
        }
        let n = self.normal();
        match range_of_ratio(dot(&n, &p[0]), dot_exact(&n, d)) {
            Some(range) if ray.contains_none(range) => Verdict::Miss,
            Some(range) if ray.contains_all(range) => Verdict::Hit(range),
            _ => Verdict::Unsure,
        }
    }

    /// What f64 knows of [`side_of_plane`](crate::triangle::side_of_plane) for a point of f32;
    /// `None` where it is not certain.
    pub(crate) fn side_of_plane(&self, p: DVec3) -> Option<Ordering> {
        if self.is_too_large() {
            return None;
        }
        let q = self.difference(p, self.vertices[0], self.vertices[0].abs());
        dot(&self.normal(), &q).order()
    }
}

/// The cross product c = a × b, with S = |a| × |b| (all terms added) for its size and an error of at most 4u S: u for
/// each of the factors, one product, one difference.
fn cross(a: &BoundedVector, b: &BoundedVector) -> BoundedVector {
    let component = |i: usize| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a.size[j] * b.size[k] + a.size[k] * b.size[j]
    };
    let value = DVec3::from_array([0, 1, 2].map(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a.value[j] * b.value[k] - a.value[k] * b.value[j]
    }));
    BoundedVector { value, size: DVec3::new(component(0), component(1), component(2)) }
}

/// c·d for a cross product c and an exact d: 4u inherited, one product, two sums: 7u Σ S |d| at first order. The bound
/// is 8u, since it is itself computed with at most 6 roundings.
fn dot_exact(c: &BoundedVector, d: DVec3) -> Bounded {
    Bounded { value: dot_values(c.value, d), error: 8.0 * U * dot_values(c.size, d.abs()) + TINY }
}

/// c·p for a cross product c and a difference p: u more than [`dot_exact`].
fn dot(c: &BoundedVector, p: &BoundedVector) -> Bounded {
    Bounded { value: dot_values(c.value, p.value), error: 9.0 * U * dot_values(c.size, p.size) + TINY }
}

fn dot_values(a: DVec3, b: DVec3) -> f64 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// A range that contains n / d; `None` where d may be zero.
///
/// |N/D − n/d| <= (δN + |n/d| δD) / (|d| − δD); 4u |n/d| more for the roundings of the quotient and of the ends, and
/// 1/16 of the rest for those of the error.
fn range_of_ratio(n: Bounded, d: Bounded) -> Option<[f64; 2]> {
    d.order()?;
    let t = n.value / d.value;
    let error = 1.0625 * ((n.error + t.abs() * d.error) / (d.value.abs() - d.error)) + 4.0 * U * t.abs() + 1e-300;
    let range = [t - error, t + error];
    (range[0].is_finite() && range[1].is_finite()).then_some(range)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Random, hard_case};
    use crate::real::ExactReal;
    use crate::triangle::{self, EdgeRule};
    use crate::vector::{ExactTransform, vector};
    use geometry::glam::{DAffine3, DMat3, Vec3};

    /// The certificate is never wrong, and on triangles that are not aimed at it seldom fails.
    #[test]
    fn what_is_certain_is_true() {
        let mut random = Random::new(1);
        let mut certain = 0;
        for i in 0..20_000 {
            let (ray, interval, v) = hard_case(&mut random, i);
            let Some(segment) = Segment::new(&ray, interval) else { continue };
            let float = FloatTriangle { vertices: v.map(|v| v.as_dvec3()), is_rounded: false };
            check(&segment, &float, &v.map(|v| vector(v.as_dvec3())), &mut certain);
        }
        assert!(certain > 8_000, "{certain}");
    }

    #[test]
    fn what_is_certain_is_true_of_rounded_vertices_too() {
        let mut random = Random::new(2);
        let mut certain = 0;
        for i in 0..20_000 {
            let (mut ray, interval, v) = hard_case(&mut random, i);
            // At the origin nothing but underflow hides a tiny triangle.
            ray.origin = if i % 8 == 3 { Vec3::ZERO } else { ray.origin };
            let Some(segment) = Segment::new(&ray, interval) else { continue };
            let columns = [0, 1, 2].map(|_| DVec3::from_array(random.array(|r| r.signed())));
            let scale = [1.0, 1e-3, 1e80, 1e-161][i % 4];
            let matrix = DAffine3::from_mat3(DMat3::from_cols(columns[0], columns[1], columns[2]) * scale);
            let map = ExactTransform::new(&matrix).expect("finite");
            let exact = v.map(|v| map.point(&vector(v.as_dvec3())));
            let vertices = exact.each_ref().map(|p| DVec3::new(p[0].to_f64(), p[1].to_f64(), p[2].to_f64()));
            check(&segment, &FloatTriangle { vertices, is_rounded: true }, &exact, &mut certain);
        }
        assert!(certain > 4_000, "{certain}");
    }

    fn check(segment: &Segment, float: &FloatTriangle, exact: &[crate::vector::Vector; 3], certain: &mut usize) {
        let truth = triangle::intersect(segment, exact, EdgeRule::Closed);
        let verdict = float.intersect(segment);
        *certain += usize::from(verdict != Verdict::Unsure);
        match verdict {
            Verdict::Miss => assert!(truth.is_none(), "{segment:?} {float:?}"),
            Verdict::Hit([low, high]) => {
                let t: ExactReal = truth.expect("a certain hit is a hit").t;
                assert!(t.cmp_f64(low).is_ge() && t.cmp_f64(high).is_le(), "{segment:?} {float:?}");
            }
            Verdict::Unsure => {}
        }
        let side = triangle::side_of_plane(exact, &segment.exact_origin());
        assert!(float.side_of_plane(segment.origin).is_none_or(|s| s == side), "{segment:?} {float:?}");
    }
}
