//! Numbers m · 2^e, in which sums, differences and products of floats are exact.

use std::cmp::Ordering;
use std::ops::{Add, Mul, Neg, Sub};

use crate::integer::Integer;

/// The number `mantissa · 2^exponent`. Every finite float is one, and so is every sum, difference and product of them:
/// the predicates of this crate need no division.
#[derive(Clone, Debug)]
pub(crate) struct Dyadic {
    mantissa: Integer,
    exponent: i32,
}

impl Dyadic {
    pub(crate) const ZERO: Self = Self { mantissa: Integer::ZERO, exponent: 0 };
    pub(crate) const ONE: Self = Self { mantissa: Integer::Small(1), exponent: 0 };

    /// The value of a finite float; of NaN and infinity zero, which callers rule out.
    pub(crate) fn from_f64(x: f64) -> Self {
        let bits = x.to_bits();
        let biased = (bits >> 52 & 0x7ff) as i32;
        let fraction = (bits & ((1 << 52) - 1)) as i128;
        let (magnitude, exponent) = match biased {
            0 => (fraction, -1074),
            0x7ff => (0, 0),
            _ => (fraction | 1 << 52, biased - 1075),
        };
        if magnitude == 0 {
            return Self::ZERO;
        }
        // Odd mantissas stay short: those of f32 within 24 bits.
        let zeros = magnitude.trailing_zeros();
        let odd = magnitude >> zeros;
        Self {
            mantissa: Integer::Small(if x.is_sign_negative() { -odd } else { odd }),
            exponent: exponent + zeros as i32,
        }
    }

    #[cfg(test)]
    pub(crate) fn from_integer(mantissa: num_bigint::BigInt) -> Self {
        Self { mantissa: Integer::Big(mantissa), exponent: 0 }
    }

    pub(crate) fn power_of_two(exponent: i32) -> Self {
        Self { mantissa: Integer::Small(1), exponent }
    }

    /// −1, 0 or 1.
    pub(crate) fn signum(&self) -> i32 {
        self.mantissa.signum()
    }

    pub(crate) fn is_zero(&self) -> bool {
        self.signum() == 0
    }

    pub(crate) fn square(&self) -> Self {
        self * self
    }

    /// The value with a relative error of at most 2⁻⁵²; beyond the range of f64 infinite, below its normal range with
    /// an absolute error of at most 2⁻¹⁰⁷⁴.
    pub(crate) fn to_f64(&self) -> f64 {
        let (f, e) = self.mantissa.to_f64_parts();
        times_power_of_two(f, self.exponent.saturating_add(e))
    }
}

/// `x · 2^e`, rounded once at most.
fn times_power_of_two(mut x: f64, mut e: i32) -> f64 {
    const STEP: i32 = 900;
    let (up, down) = (2.0_f64.powi(STEP), 2.0_f64.powi(-STEP));
    while e > STEP && x.is_finite() && x != 0.0 {
        (x, e) = (x * up, e - STEP);
    }
    // |x| < 2¹²⁸ at first, so that only the last of these steps can leave the normal range.
    while e < -STEP && x.abs() > 2.0_f64.powi(-120) {
        (x, e) = (x * down, e + STEP);
    }
    if e < -STEP { x * down * down } else { x * 2.0_f64.powi(e.clamp(-STEP, STEP)) }
}

impl Add for &Dyadic {
    type Output = Dyadic;

    fn add(self, other: &Dyadic) -> Dyadic {
        if self.is_zero() {
            return other.clone();
        }
        if other.is_zero() {
            return self.clone();
        }
        let (high, low) = if self.exponent >= other.exponent { (self, other) } else { (other, self) };
        let aligned = high.mantissa.shifted_left(high.exponent.abs_diff(low.exponent));
        Dyadic { mantissa: aligned.plus(&low.mantissa), exponent: low.exponent }
    }
}

impl Sub for &Dyadic {
    type Output = Dyadic;

    fn sub(self, other: &Dyadic) -> Dyadic {
        self + &-other
    }
}

impl Mul for &Dyadic {
    type Output = Dyadic;

    fn mul(self, other: &Dyadic) -> Dyadic {
        let mantissa = self.mantissa.times(&other.mantissa);
        let exponent = if mantissa.signum() == 0 { 0 } else { self.exponent + other.exponent };
        Dyadic { mantissa, exponent }
    }
}

impl Neg for &Dyadic {
    type Output = Dyadic;

    fn neg(self) -> Dyadic {
        Dyadic { mantissa: self.mantissa.negated(), exponent: self.exponent }
    }
}

impl PartialEq for Dyadic {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Dyadic {}

impl PartialOrd for Dyadic {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Dyadic {
    fn cmp(&self, other: &Self) -> Ordering {
        match self.signum().cmp(&other.signum()) {
            Ordering::Equal => (self - other).signum().cmp(&0),
            decided => decided,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLOATS: [f64; 14] = [
        0.0,
        -0.0,
        1.0,
        -1.5,
        0.1,
        -3.0e-7,
        1e300,
        -1e300,
        f64::MAX,
        f64::MIN_POSITIVE,
        5e-324,
        -5e-324,
        1.0 + f64::EPSILON,
        4503599627370497.5,
    ];

    #[test]
    fn floats_come_back() {
        for x in FLOATS {
            assert_eq!(Dyadic::from_f64(x).to_f64(), x);
            assert_eq!((-&Dyadic::from_f64(x)).to_f64(), -x);
        }
        let huge = Dyadic::from_f64(f64::MAX);
        assert_eq!((&huge * &huge).to_f64(), f64::INFINITY);
        assert_eq!(Dyadic::power_of_two(-3000).to_f64(), 0.0);
        assert_eq!(Dyadic::power_of_two(-1074).to_f64(), 5e-324);
    }

    #[test]
    fn order_is_that_of_floats() {
        for a in FLOATS {
            for b in FLOATS {
                let order = Dyadic::from_f64(a).cmp(&Dyadic::from_f64(b));
                assert_eq!(Some(order), a.partial_cmp(&b), "{a} {b}");
            }
        }
    }

    /// Nothing is lost: what floats cannot hold together can be taken apart again.
    #[test]
    fn arithmetic_is_exact() {
        for a in FLOATS.map(Dyadic::from_f64) {
            for b in FLOATS.map(Dyadic::from_f64) {
                assert_eq!(&(&a + &b) - &b, a);
                for c in FLOATS.map(Dyadic::from_f64) {
                    assert_eq!(&(&a + &b) * &c, &(&a * &c) + &(&b * &c));
                }
            }
        }
        let x = Dyadic::from_f64(0.1);
        assert!((&x * &Dyadic::from_f64(10.0)) > Dyadic::ONE, "0.1 in binary is above 1/10");
    }
}
