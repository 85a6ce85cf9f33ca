//! The quadratic equation of a line and a sphere.

use glam::DVec3;

use super::Sphere;
use super::expansion::Expansion;
use crate::TraversalRay;

/// The relative error of one rounding in f64.
const U: f64 = f64::EPSILON / 2.0;

/// Which relative error of a parameter is small enough: rounded to f32 it is then within 0.5 + 2⁻⁴ ulp.
const PRECISE: f64 = 1.0 / (1_u64 << 28) as f64;

/// a t² − 2 b t + c = 0, of the points o + t d at distance r from the center: with f = o − center it is a = d·d,
/// b = −f·d, c = f·f − r² and the discriminant b² − a c = a r² − |f × d|².
///
/// The second form of the discriminant does not lose its digits where the sphere is small and far away (Haines, Günther
/// and Akenine-Möller 2019, *Precision Improvements for Ray/Sphere Intersection*, Ray Tracing Gems ch. 7, have it as
/// the distance of the center from the line). It is computed in f64 with a bound on its error, and exactly only where
/// that bound does not settle the matter: for rays within about 10⁻¹⁵ |f| of a tangent, and for origins within about
/// 10⁻⁶ r of the part of the surface that the ray meets. There the equation is solved from expansions, whose signs are
/// exact.
pub(super) struct Quadratic {
    a: f64,
    b: Bounded,
    c: Bounded,
    discriminant: Bounded,
}

/// A number that is wrong by at most `error`.
#[derive(Clone, Copy)]
struct Bounded {
    value: f64,
    error: f64,
}

/// A point of the line on the sphere.
pub(super) struct Point {
    /// Where, but for `error` and one rounding.
    pub(super) p: DVec3,
    /// A bound on the distance from the exact point, on each axis.
    pub(super) error: f64,
    /// From the center to the point, correct to a few ulp of the radius.
    pub(super) from_center: DVec3,
}

impl Bounded {
    fn is_positive(self) -> bool {
        self.value > self.error
    }

    fn is_negative(self) -> bool {
        self.value < -self.error
    }
}

impl Quadratic {
    /// Both parameters, in order, at which the line meets the sphere; twice the same for a tangent, and for nothing
    /// else.
    ///
    /// The decision is exact, and so are the signs. A parameter that is not negative is correct to [`PRECISE`]. `None`
    /// too where both are negative. Exact means: of the f64 ray, whose components are zero or at least 2⁻²⁰⁰.
    #[inline]
    pub(super) fn parameters(sphere: &Sphere, ray: &TraversalRay) -> Option<[f64; 2]> {
        let (equation, _) = Self::in_f64(sphere, ray);
        if equation.discriminant.is_negative() || equation.c.is_positive() && equation.b.is_negative() {
            return None;
        }
        if equation.is_precise() { equation.roots() } else { Exact::new(sphere, ray).equation().roots() }
    }

    /// The equation in f64, and f × d.
    ///
    /// With u = 2⁻⁵³ and to first order: a component of f is wrong by u of itself, one of f × d by 3u of its size
    /// Mᵢ = |fⱼ dₖ| + |fₖ dⱼ|. Then a is wrong by 3u a; b by 4u Σ |fᵢ dᵢ|; c by 5u f·f + u r² and u c of its own;
    /// |f × d|² by 6u Σ |f × d|ᵢ Mᵢ from its components, 9u² Σ Mᵢ² ≤ 18u² (f·f) a of second order, and 3u of its own;
    /// a r² by 4u; the difference by u of both. The bounds below have at least one u more of everything, for terms of
    /// higher order and for their own roundings. Underflow adds at most 2⁻¹⁰⁷³ a term; a r² is at least 2⁻⁵⁹⁶.
    #[inline]
    fn in_f64(sphere: &Sphere, ray: &TraversalRay) -> (Self, DVec3) {
        let (f, d) = (ray.origin64() - sphere.center.as_dvec3(), ray.direction64());
        let r2 = f64::from(sphere.radius) * f64::from(sphere.radius);
        let (a, ff) = (d.dot(d), f.dot(f));
        let (products, left, right) = (f * d, turned(f) * turned_twice(d), turned_twice(f) * turned(d));
        let (cross, size) = (left - right, left.abs() + right.abs());
        let (b, c) = (-(products.x + products.y + products.z), ff - r2);
        let discriminant = a * r2 - cross.dot(cross);
        let equation = Self {
            a,
            b: Bounded { value: b, error: 6.0 * U * products.abs().element_sum() },
            c: Bounded { value: c, error: 8.0 * U * (ff + r2) },
            discriminant: Bounded {
                value: discriminant,
                error: 12.0 * U * (a * r2 + cross.abs().dot(size)) + 32.0 * U * U * (ff * a),
            },
        };
        (equation, cross)
    }

    /// Whether [`roots`](Self::roots) are as good as promised. They are q/a and c/q with q = ±(|b| + √D): |q| is wrong
    /// by at most δb + δD/√D, and the root that uses c has the sign of c q, hence does not matter where that is
    /// negative.
    #[inline]
    fn is_precise(&self) -> bool {
        let Self { b, c, discriminant, .. } = self;
        let root = discriminant.value.max(0.0).sqrt();
        let q_is_precise = b.error * root + discriminant.error <= 0.25 * PRECISE * root * (b.value.abs() + root);
        let c_is_precise = c.error <= 0.25 * PRECISE * c.value.abs();
        discriminant.is_positive() && q_is_precise && (c_is_precise || c.is_negative() && b.is_positive())
    }

    #[inline]
    fn roots(&self) -> Option<[f64; 2]> {
        let (b, d) = (self.b.value, self.discriminant.value);
        if d < 0.0 {
            return None;
        }
        if d == 0.0 {
            return Some([b / self.a; 2]);
        }
        let q = b + d.sqrt().copysign(b);
        let (t0, t1) = (self.c.value / q, q / self.a);
        let (t0, t1) = if t0 <= t1 { (t0, t1) } else { (t1, t0) };
        // Two hits remain two, even where f64 cannot tell them apart.
        Some([t0, if t0 == t1 { t1.next_up() } else { t1 }])
    }

    /// The first or the second point of the line on the sphere: from the center by the foot of the perpendicular,
    /// d × (f × d) / a, and by √D d / a along the line from there. Both are at most r long, however far away the ray
    /// began.
    ///
    /// f × d is wrong by 3u |M| ≤ 3u √(2 (f·f) a), the foot by 5u |f| from that and 8u r of its own; √D by δD/√D, its
    /// term by 6u r of its own; the sum by u r: together at most 5u |f| + 15u r + δD / √(a D). Where f32 might see
    /// that, the equation is set up exactly: foot and term are then rounded from exact values, to 9u r each. And then o
    /// + t d is the better point where it is near to the origin of the ray, beside the radius: t is correct to 10u.
    pub(super) fn point(sphere: &Sphere, ray: &TraversalRay, second: bool) -> Point {
        let (center, o, d) = (sphere.center.as_dvec3(), ray.origin64(), ray.direction64());
        let (r, sign) = (f64::from(sphere.radius), if second { 1.0 } else { -1.0 });
        let (equation, cross) = Self::in_f64(sphere, ray);
        let Self { a, discriminant, .. } = equation;
        if discriminant.is_positive() {
            let root = discriminant.value.sqrt();
            let from_center = d.cross(cross) / a + d * (sign * (root / a));
            let error = 8.0 * U * (o - center).length() + 20.0 * U * r + discriminant.error / (root * a.sqrt());
            let p = center + from_center;
            if error <= 0.25 * PRECISE * p.abs().max_element() {
                return Point { p, error, from_center };
            }
        }
        let exact = Exact::new(sphere, ray);
        let equation = exact.equation();
        let root = equation.discriminant.value.max(0.0).sqrt();
        let from_center = exact.foot() + d * (sign * (root / equation.a));
        let t = equation.roots().map_or(f64::INFINITY, |roots| roots[usize::from(second)]);
        let error_along = 12.0 * U * (t.abs() * d.length());
        let error = 32.0 * U * r;
        if error_along < error {
            Point { p: o + d * t, error: error_along, from_center }
        } else {
            Point { p: center + from_center, error, from_center }
        }
    }
}

/// The terms of the equation without any rounding.
struct Exact {
    f: [Expansion; 3],
    d: [Expansion; 3],
    a: Expansion,
    b: Expansion,
    c: Expansion,
}

impl Exact {
    fn new(sphere: &Sphere, ray: &TraversalRay) -> Self {
        let axes = [0, 1, 2];
        let f = axes.map(|i| Expansion::difference(ray.origin64()[i], sphere.center[i].into()));
        let d = axes.map(|i| Expansion::from_float(ray.direction64()[i]));
        let r = Expansion::from_float(sphere.radius.into());
        let [mut a, mut b, mut c] = [const { Expansion::ZERO }; 3];
        c.add_product(-1.0, &r, &r);
        for i in axes {
            a.add_product(1.0, &d[i], &d[i]);
            b.add_product(-1.0, &f[i], &d[i]);
            c.add_product(1.0, &f[i], &f[i]);
        }
        Self { f, d, a, b, c }
    }

    /// Rounded, with an exact sign of everything.
    fn equation(&self) -> Quadratic {
        let mut discriminant = Expansion::ZERO;
        discriminant.add_product(1.0, &self.b, &self.b);
        discriminant.add_product(-1.0, &self.a, &self.c);
        let rounded = |x: &Expansion| Bounded { value: x.estimate(), error: 4.0 * U * x.estimate().abs() };
        let (b, c, discriminant) = (rounded(&self.b), rounded(&self.c), rounded(&discriminant));
        Quadratic { a: self.a.estimate(), b, c, discriminant }
    }

    /// f + (b/a) d, the foot of the perpendicular: a f + b d is exact.
    fn foot(&self) -> DVec3 {
        let a = self.a.estimate();
        DVec3::from_array([0, 1, 2].map(|i| {
            let mut times_a = Expansion::ZERO;
            times_a.add_product(1.0, &self.a, &self.f[i]);
            times_a.add_product(1.0, &self.b, &self.d[i]);
            times_a.estimate() / a
        }))
    }
}

fn turned(v: DVec3) -> DVec3 {
    DVec3::new(v.y, v.z, v.x)
}

fn turned_twice(v: DVec3) -> DVec3 {
    DVec3::new(v.z, v.x, v.y)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::Ray;

    /// Rays of every kind, aimed at the rim: axis-parallel ones on a lattice, and random ones from near and far.
    fn hard_cases() -> Vec<(Sphere, TraversalRay)> {
        let mut state = 1_u64;
        let mut signed = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1 << 23) as f32 - 1.0
        };
        let mut vector = move || Vec3::new(signed(), signed(), signed());
        let mut cases = Vec::new();
        for i in 0..20_000 {
            let (center, radius) = match i % 4 {
                0 => (Vec3::new(1.0, -2.0, 3.0), 2.0),
                1 => (1e6 * vector(), 1e-3 + vector().x.abs()),
                2 => (vector() * 2.0_f32.powi(i % 120 - 60), 2.0_f32.powi(i % 77 - 40)),
                _ => (Vec3::ZERO, 6.4e6),
            };
            let (d, side) = match i % 3 {
                0 => (Vec3::AXES[i as usize % 3], Vec3::AXES[(i as usize + 1) % 3]),
                _ => (vector(), vector().any_orthonormal_vector()),
            };
            let rim = center + radius * (1.0 + 2.0_f32.powi(i % 30 - 40) * vector().x) * side;
            let o = rim - d * [0.0, 1.0, radius, 1e7 * radius][i as usize % 4];
            let sphere = Sphere::new(center, radius).expect("valid");
            cases
                .extend(TraversalRay::new(&Ray::new(o, if i % 5 == 0 { rim - o } else { d })).map(|ray| (sphere, ray)));
        }
        cases
    }

    /// The bounds of f64 hold, and its decisions and values are those of the exact equation, the naive way.
    #[test]
    fn f64_agrees_with_the_exact_equation_wherever_it_decides() {
        let mut decided = 0;
        for (sphere, ray) in hard_cases() {
            let exact = Exact::new(&sphere, &ray).equation();
            let (fast, _) = Quadratic::in_f64(&sphere, &ray);
            for (fast, exact) in [(fast.b, exact.b), (fast.c, exact.c), (fast.discriminant, exact.discriminant)] {
                let distance = (fast.value - exact.value).abs();
                assert!(distance <= fast.error + exact.error, "{sphere:?} {ray:?}: {distance:e} > {:e}", fast.error);
            }
            decided += usize::from(fast.is_precise() || fast.discriminant.is_negative());
            let (fast, exact) = (Quadratic::parameters(&sphere, &ray), exact.roots());
            match (fast, exact) {
                (None, exact) => assert!(exact.is_none_or(|t| t[1] < 0.0), "{sphere:?} {ray:?}: {exact:?}"),
                (Some(fast), Some(exact)) => {
                    assert_eq!(fast[0] == fast[1], exact[0] == exact[1], "{sphere:?} {ray:?}");
                    for (t, exact) in fast.into_iter().zip(exact) {
                        assert!(exact < 0.0 && t < 0.0 || (t - exact).abs() <= PRECISE * exact, "{t} {exact}");
                    }
                }
                (Some(_), None) => panic!("{sphere:?} {ray:?}: {fast:?}"),
            }
        }
        assert!(decided > 5_000, "{decided}");
    }

    #[test]
    fn points_agree_with_the_exact_ones_within_their_bounds() {
        let mut compared = 0;
        for (sphere, ray) in hard_cases() {
            let Some(roots) = Quadratic::parameters(&sphere, &ray) else { continue };
            let exact = Exact::new(&sphere, &ray);
            let equation = exact.equation();
            let root = equation.discriminant.value.sqrt() / equation.a;
            for (second, t) in [(false, roots[0]), (true, roots[1])] {
                let at = Quadratic::point(&sphere, &ray, second);
                let wanted = exact.foot() + ray.direction64() * if second { root } else { -root };
                let r = f64::from(sphere.radius);
                assert!((at.from_center - wanted).length() <= at.error + 64.0 * U * r, "{sphere:?} {ray:?}: {t}");
                assert!((at.from_center.length() - r).abs() <= 2.0 * at.error + 64.0 * U * r);
                compared += 1;
            }
        }
        assert!(compared > 5_000, "{compared}");
    }
}
