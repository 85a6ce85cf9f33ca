//! Real numbers that are known exactly: the `t` of a hit, and the coordinates of a hit point.

use std::cmp::Ordering;

use crate::dyadic::Dyadic;

/// The real number `(a + b √q) / r`, exactly, with dyadic `a`, `b`, `q >= 0` and `r > 0`.
///
/// The `t` of a hit on a triangle is a ratio of two determinants (`b = 0`), that on a sphere the root of a quadratic
/// equation. Both, and the coordinates of the points, are compared with each other and with floats without any
/// approximation: a sum of square roots has the sign that squaring tells.
#[derive(Clone, Debug)]
pub struct ExactReal {
    a: Dyadic,
    b: Dyadic,
    q: Dyadic,
    r: Dyadic,
}

impl ExactReal {
    /// `n / d`; `d` is not zero.
    pub(crate) fn ratio(n: Dyadic, d: Dyadic) -> Self {
        Self::quadratic(n, Dyadic::ZERO, Dyadic::ZERO, d)
    }

    /// `(a + b √q) / r`; `q` is not negative and `r` not zero.
    pub(crate) fn quadratic(a: Dyadic, b: Dyadic, q: Dyadic, r: Dyadic) -> Self {
        if r.signum() < 0 { Self { a: -&a, b: -&b, q, r: -&r } } else { Self { a, b, q, r } }
    }

    /// The value of a finite float; of any other zero.
    pub fn from_f64(x: f64) -> Self {
        Self::ratio(Dyadic::from_f64(x), Dyadic::ONE)
    }

    /// `origin + direction · self`, of finite floats.
    pub fn along(&self, origin: f64, direction: f64) -> Self {
        let (o, d) = (Dyadic::from_f64(origin), Dyadic::from_f64(direction));
        let a = &(&self.a * &d) + &(&self.r * &o);
        Self { a, b: &self.b * &d, q: self.q.clone(), r: self.r.clone() }
    }

    /// `self − x`, of a finite float.
    pub fn minus(&self, x: f64) -> Self {
        self.along(-x, 1.0)
    }

    /// The absolute value.
    #[must_use]
    pub fn abs(&self) -> Self {
        if self.signum() < 0 { self.along(0.0, -1.0) } else { self.clone() }
    }

    /// −1, 0 or 1.
    pub fn signum(&self) -> i32 {
        sign_with_root(&self.a, &self.b, &self.q)
    }

    /// The order of this number and a float. Infinities are beyond every number; NaN is above all, as in
    /// [`f64::total_cmp`].
    pub fn cmp_f64(&self, x: f64) -> Ordering {
        if x.is_finite() {
            sign_with_root(&(&self.a - &(&self.r * &Dyadic::from_f64(x))), &self.b, &self.q).cmp(&0)
        } else if x == f64::NEG_INFINITY {
            Ordering::Greater
        } else {
            Ordering::Less
        }
    }

    /// Whether `|x − self| <= bound`, decided exactly. False where `x` or `bound` is NaN, or `x` infinite.
    pub fn is_within(&self, x: f64, bound: f64) -> bool {
        x.is_finite() && !bound.is_nan() && self.minus(x).abs().cmp_f64(bound).is_le()
    }

    /// The order of this number and a dyadic one.
    pub(crate) fn cmp_dyadic(&self, x: &Dyadic) -> Ordering {
        sign_with_root(&(&self.a - &(&self.r * x)), &self.b, &self.q).cmp(&0)
    }

    /// The value in f64 arithmetic: the place where a search for its neighbours starts. May be NaN.
    pub(crate) fn estimate(&self) -> f64 {
        let root = if self.b.is_zero() { 0.0 } else { self.b.to_f64() * self.q.to_f64().sqrt() };
        (self.a.to_f64() + root) / self.r.to_f64()
    }
}

/// The sign of `a + b √q`.
fn sign_with_root(a: &Dyadic, b: &Dyadic, q: &Dyadic) -> i32 {
    let (sign, root_sign) = (a.signum(), b.signum() * q.signum());
    if sign * root_sign >= 0 {
        return if sign != 0 { sign } else { root_sign };
    }
    // Of opposite signs: the larger square wins.
    sign * (&a.square() - &(&b.square() * q)).signum()
}

/// The sign of `a + b √p + c √q`.
fn sign_with_roots(a: &Dyadic, b: &Dyadic, p: &Dyadic, c: &Dyadic, q: &Dyadic) -> i32 {
    let (sign, root_sign) = (sign_with_root(a, b, p), c.signum() * q.signum());
    if sign * root_sign >= 0 {
        return if sign != 0 { sign } else { root_sign };
    }
    // (a + b √p)² − c² q = (a² + b² p − c² q) + 2 a b √p
    let rational = &(&a.square() + &(&b.square() * p)) - &(&c.square() * q);
    let irrational = &(a * b) * &Dyadic::power_of_two(1);
    sign * sign_with_root(&rational, &irrational, p)
}

impl PartialEq for ExactReal {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for ExactReal {}

impl PartialOrd for ExactReal {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for ExactReal {
    fn cmp(&self, other: &Self) -> Ordering {
        let a = &(&self.a * &other.r) - &(&other.a * &self.r);
        if self.b.is_zero() && other.b.is_zero() {
            return a.signum().cmp(&0);
        }
        let (b, c) = (&self.b * &other.r, &(-&other.b) * &self.r);
        sign_with_roots(&a, &b, &self.q, &c, &other.q).cmp(&0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn root(a: f64, b: f64, q: f64, r: f64) -> ExactReal {
        let [a, b, q, r] = [a, b, q, r].map(Dyadic::from_f64);
        ExactReal::quadratic(a, b, q, r)
    }

    /// All small quadratic numbers against f64, where f64 tells them apart; where it does not, they are equal.
    #[test]
    fn the_order_is_that_of_the_reals() {
        let mut all = Vec::new();
        for a in [-3.0, -1.0, 0.0, 2.0] {
            for b in [-2.0, -1.0, 0.0, 1.0, 3.0] {
                for q in [0.0, 1.0, 2.0, 3.0, 8.0, 9.0] {
                    for r in [-3.0, 1.0, 2.0] {
                        all.push((root(a, b, q, r), (a + b * f64::sqrt(q)) / r));
                    }
                }
            }
        }
        for (x, fx) in &all {
            for (y, fy) in &all {
                let close = (fx - fy).abs() < 1e-9;
                let expected = if close { Ordering::Equal } else { fx.total_cmp(fy) };
                assert_eq!(x.cmp(y), expected, "{x:?} {y:?}");
            }
        }
    }

    /// √2 + √3 and √(5 + 2√6) are one number; a tiny change is seen.
    #[test]
    fn nearly_equal_roots_are_told_apart() {
        let x = root(0.0, 1.0, 2.0, 1.0);
        assert_eq!(x, root(0.0, 1.0, 8.0, 2.0));
        assert!(x > root(-1e-300, 1.0, 2.0, 1.0));
        assert!(x < root(0.0, 1.0, 2.0_f64.next_up(), 1.0));
        assert_eq!(x.cmp_f64(std::f64::consts::SQRT_2), Ordering::Less);
        assert_eq!(x.cmp_f64(std::f64::consts::SQRT_2.next_down()), Ordering::Greater);
        assert_eq!(root(0.0, 1.0, 9.0, 1.0).cmp_f64(3.0), Ordering::Equal);
    }

    #[test]
    fn floats_that_are_no_numbers_have_a_place() {
        let one = ExactReal::from_f64(1.0);
        assert_eq!(one.cmp_f64(f64::INFINITY), Ordering::Less);
        assert_eq!(one.cmp_f64(f64::NEG_INFINITY), Ordering::Greater);
        assert!(!one.is_within(f64::NAN, 1.0) && !one.is_within(1.0, f64::NAN) && !one.is_within(f64::INFINITY, 9.0));
        assert!(one.is_within(2.0, f64::INFINITY));
    }

    #[test]
    fn a_bound_is_closed_and_exact() {
        let third = root(1.0, 0.0, 0.0, 3.0);
        let x = 1.0 / 3.0;
        let error = third.minus(x).abs();
        assert!(error.signum() > 0 && third.is_within(x, f64::EPSILON / 4.0) && !third.is_within(x, 1e-18));
        let point = third.along(1.0, -3.0);
        assert!(point.is_within(0.0, 0.0) && point.is_within(-0.5, 0.5) && !point.is_within(-0.5, 0.5_f64.next_down()));
    }
}
