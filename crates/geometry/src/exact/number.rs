//! What exact arithmetic needs of its numbers, and floats as integers.

use std::cmp::Ordering;

/// An integer that holds every intermediate result of the determinants it is used for.
pub(super) trait Number: Sized {
    /// `mantissa · 2^shift`.
    fn new(mantissa: i64, shift: u32) -> Self;
    fn plus(&self, other: &Self) -> Self;
    fn minus(&self, other: &Self) -> Self;
    fn times(&self, other: &Self) -> Self;
    /// −1, 0 or 1.
    fn signum(&self) -> i32;
    /// The order of `a · b` and `c · d`, which need not fit.
    fn cmp_products(a: &Self, b: &Self, c: &Self, d: &Self) -> Ordering;
    /// `(m, e)` with m 2ᵉ within 2⁻⁵² of the number, relatively. m is neither tiny nor huge.
    fn scientific(&self) -> (f64, i32);
}

impl Number for i128 {
    #[inline]
    fn new(mantissa: i64, shift: u32) -> Self {
        Self::from(mantissa) << shift
    }

    #[inline]
    fn plus(&self, other: &Self) -> Self {
        self + other
    }

    #[inline]
    fn minus(&self, other: &Self) -> Self {
        self - other
    }

    #[inline]
    fn times(&self, other: &Self) -> Self {
        self * other
    }

    #[inline]
    fn signum(&self) -> i32 {
        i128::signum(*self) as i32
    }

    fn cmp_products(a: &Self, b: &Self, c: &Self, d: &Self) -> Ordering {
        let signs = (i128::signum(*a) * i128::signum(*b), i128::signum(*c) * i128::signum(*d));
        let product = |a: &Self, b: &Self| wide_product(a.unsigned_abs(), b.unsigned_abs());
        match signs.0.cmp(&signs.1) {
            Ordering::Equal if signs.0 < 0 => product(c, d).cmp(&product(a, b)),
            Ordering::Equal => product(a, b).cmp(&product(c, d)),
            order => order,
        }
    }

    fn scientific(&self) -> (f64, i32) {
        (*self as f64, 0)
    }
}

/// The upper and the lower half of the product, by halves of the factors.
fn wide_product(a: u128, b: u128) -> (u128, u128) {
    const LOW: u128 = (1 << 64) - 1;
    let (a1, a0, b1, b0) = (a >> 64, a & LOW, b >> 64, b & LOW);
    let low = a0 * b0;
    // Each at most (2⁶⁴ − 1)² + 2⁶⁴ − 1: neither overflows.
    let middle = a1 * b0 + (low >> 64);
    let other = a0 * b1 + (middle & LOW);
    (a1 * b1 + (middle >> 64) + (other >> 64), other << 64 | low & LOW)
}

/// A finite float as `mantissa · 2^exponent`, the mantissa odd or zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Parts {
    mantissa: i64,
    exponent: i32,
}

impl Parts {
    pub(super) fn of(x: f64) -> Self {
        let bits = x.to_bits();
        let (fraction, biased) = ((bits & ((1 << 52) - 1)) as i64, (bits >> 52) as i32 & 0x7ff);
        let magnitude = if biased == 0 { fraction } else { fraction | 1 << 52 };
        if magnitude == 0 {
            return Self { mantissa: 0, exponent: 0 };
        }
        let zeros = magnitude.trailing_zeros();
        let magnitude = magnitude >> zeros;
        let mantissa = if x.is_sign_negative() { -magnitude } else { magnitude };
        Self { mantissa, exponent: biased.max(1) - 1075 + zeros as i32 }
    }

    pub(super) fn exponent(self) -> i32 {
        self.exponent
    }

    /// The mantissa itself, in units of two to its exponent.
    pub(super) fn mantissa<T: Number>(self, shift: u32) -> T {
        T::new(self.mantissa, shift)
    }
}

/// The coarsest grid that a set of numbers lies on: they are integers in units of 2^`unit`, below 2^`width`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Grid {
    pub(super) unit: i32,
    pub(super) width: u32,
}

impl Grid {
    pub(super) fn around<'a>(numbers: impl Iterator<Item = &'a Parts>) -> Self {
        let (mut unit, mut top) = (i32::MAX, i32::MIN);
        for parts in numbers.filter(|parts| parts.mantissa != 0) {
            unit = unit.min(parts.exponent);
            top = top.max(parts.exponent + 64 - parts.mantissa.unsigned_abs().leading_zeros() as i32);
        }
        if unit > top { Self { unit: 0, width: 0 } } else { Self { unit, width: (top - unit) as u32 } }
    }

    /// A number of the set, as an integer in units of this grid.
    #[inline]
    pub(super) fn place<T: Number>(self, parts: Parts) -> T {
        let shift = if parts.mantissa == 0 { 0 } else { (parts.exponent - self.unit) as u32 };
        T::new(parts.mantissa, shift)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floats_are_their_parts() {
        let numbers = [1.0, -1.0, 0.1, -3.5e-310, 5e-324, f64::MAX, 1e-45_f32.into(), f64::MIN_POSITIVE, 1_048_576.0];
        for x in numbers {
            let p = Parts::of(x);
            assert_eq!(p.mantissa & 1, 1);
            // In two steps, for the powers that no f64 is.
            let half = p.exponent / 2;
            assert_eq!(p.mantissa as f64 * 2.0_f64.powi(half) * 2.0_f64.powi(p.exponent - half), x);
        }
        assert_eq!(Parts::of(-0.0).mantissa, 0);
        let parts = [0.75, 0.0, -40.0].map(Parts::of);
        let grid = Grid::around(parts.iter());
        assert_eq!(grid, Grid { unit: -2, width: 8 });
        assert_eq!(parts.map(|p| grid.place::<i128>(p)), [3, 0, -160]);
        assert_eq!(Grid::around([].iter()), Grid { unit: 0, width: 0 });
    }

    #[test]
    fn products_of_128_bits_are_compared() {
        let numbers = [0, 1, -1, 7, -(1 << 100), (1 << 100) + 1, i128::MAX, -i128::MAX, (1 << 64) - 1, 1 << 64];
        for a in numbers {
            for b in numbers {
                assert_eq!(i128::cmp_products(&a, &b, &b, &a), Ordering::Equal);
                assert_eq!(i128::cmp_products(&a, &1, &b, &1), a.cmp(&b));
                assert_eq!(i128::cmp_products(&a, &i128::MAX, &b, &i128::MAX), a.cmp(&b));
                assert_eq!(i128::cmp_products(&a, &-i128::MAX, &b, &-i128::MAX), b.cmp(&a));
            }
        }
        // (2¹⁰⁰ + 1)(2¹⁰⁰ − 1) = 2²⁰⁰ − 1.
        let x: i128 = 1 << 100;
        assert_eq!(i128::cmp_products(&(x + 1), &(x - 1), &x, &x), Ordering::Less);
        assert_eq!(wide_product(u128::MAX, u128::MAX), (u128::MAX - 1, 1));
    }
}
