//! Integers as large as the determinants of any ray and triangle.

use std::cmp::Ordering;

use super::number::Number;

/// A number of at most 64 `LIMBS` bits: sign and magnitude. Of the limbs, the least first, all from `len` on are zero,
/// and the one before is not.
pub(super) struct Integer<const LIMBS: usize> {
    negative: bool,
    len: usize,
    limbs: [u64; LIMBS],
}

impl<const LIMBS: usize> Integer<LIMBS> {
    const ZERO: Self = Self { negative: false, len: 0, limbs: [0; LIMBS] };

    fn magnitude(&self) -> &[u64] {
        &self.limbs[..self.len]
    }

    fn cmp_magnitude(&self, other: &Self) -> Ordering {
        let by_limbs = || self.magnitude().iter().rev().cmp(other.magnitude().iter().rev());
        self.len.cmp(&other.len).then_with(by_limbs)
    }

    /// Shortens the length to what is not zero.
    fn trim(&mut self) {
        while self.len > 0 && self.limbs[self.len - 1] == 0 {
            self.len -= 1;
        }
    }

    /// `self + other`, or `self − other`.
    fn plus_or_minus(&self, other: &Self, minus: bool) -> Self {
        let other_negative = other.negative != minus;
        let swap = self.cmp_magnitude(other).is_lt();
        let (large, small) = if swap { (other, self) } else { (self, other) };
        let mut result = Self { negative: if swap { other_negative } else { self.negative }, ..Self::ZERO };
        let add = self.negative == other_negative;
        let mut carry = false;
        for i in 0..large.len {
            // At most one of the two steps carries.
            let (first, second);
            if add {
                (result.limbs[i], first) = large.limbs[i].overflowing_add(small.limbs[i]);
                (result.limbs[i], second) = result.limbs[i].overflowing_add(carry.into());
            } else {
                (result.limbs[i], first) = large.limbs[i].overflowing_sub(small.limbs[i]);
                (result.limbs[i], second) = result.limbs[i].overflowing_sub(carry.into());
            }
            carry = first | second;
        }
        result.len = large.len;
        if carry {
            // Only of a sum: the smaller is subtracted from the larger.
            result.limbs[large.len] = 1;
            result.len += 1;
        }
        result.trim();
        result
    }

    #[cfg(test)]
    fn bits(&self) -> u32 {
        self.magnitude().last().map_or(0, |last| 64 * self.len as u32 - last.leading_zeros())
    }
}

impl<const LIMBS: usize> Number for Integer<LIMBS> {
    fn new(mantissa: i64, shift: u32) -> Self {
        let mut result = Self { negative: mantissa < 0, ..Self::ZERO };
        let (limb, bit) = ((shift / 64) as usize, shift % 64);
        let shifted = u128::from(mantissa.unsigned_abs()) << bit;
        result.limbs[limb] = shifted as u64;
        if shifted >> 64 != 0 {
            result.limbs[limb + 1] = (shifted >> 64) as u64;
        }
        result.len = (limb + 2).min(LIMBS);
        result.trim();
        result
    }

    fn plus(&self, other: &Self) -> Self {
        self.plus_or_minus(other, false)
    }

    fn minus(&self, other: &Self) -> Self {
        self.plus_or_minus(other, true)
    }

    fn times(&self, other: &Self) -> Self {
        let mut result = Self { negative: self.negative != other.negative, ..Self::ZERO };
        for (i, &a) in self.magnitude().iter().enumerate().filter(|(_, limb)| **limb != 0) {
            let mut carry = 0_u128;
            for (j, &b) in other.magnitude().iter().enumerate() {
                carry += u128::from(result.limbs[i + j]) + u128::from(a) * u128::from(b);
                result.limbs[i + j] = carry as u64;
                carry >>= 64;
            }
            result.limbs[i + other.len] = carry as u64;
        }
        result.len = self.len + other.len;
        result.trim();
        result
    }

    fn signum(&self) -> i32 {
        match (self.len, self.negative) {
            (0, _) => 0,
            (_, true) => -1,
            (_, false) => 1,
        }
    }

    fn cmp_products(a: &Self, b: &Self, c: &Self, d: &Self) -> Ordering {
        a.times(b).minus(&c.times(d)).signum().cmp(&0)
    }

    fn scientific(&self) -> (f64, i32) {
        let at = |i: usize| i.checked_sub(1).map_or(0, |i| self.limbs[i]);
        // The upper 128 bits, so that at least 65 are significant.
        let top = u128::from(at(self.len)) << 64 | u128::from(at(self.len.saturating_sub(1)));
        let magnitude = top as f64;
        (if self.negative { -magnitude } else { magnitude }, 64 * (self.len as i32 - 2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Large = Integer<116>;

    /// A small generator: the crate has no random numbers.
    fn numbers(count: usize) -> Vec<(i64, u32)> {
        let mut state = 1_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            state >> 11
        };
        (0..count).map(|_| ((next() as i64 - (1 << 52)) >> (next() % 53), (next() % 1_150) as u32)).collect()
    }

    #[test]
    fn small_ones_compute_as_i128_does() {
        let small: Vec<(i64, u32)> = numbers(60).into_iter().map(|(m, s)| (m, s % 8)).collect();
        for &(m, s) in &small {
            for &(n, r) in &small {
                let (a, b) = (<i128 as Number>::new(m, s), <i128 as Number>::new(n, r));
                let (x, y) = (Large::new(m, s), Large::new(n, r));
                for (i, integer) in [(a + b, x.plus(&y)), (a - b, x.minus(&y)), (a * b, x.times(&y))] {
                    assert_eq!(i.signum() as i32, integer.signum());
                    let (value, exponent) = integer.scientific();
                    assert_eq!(value * 2.0_f64.powi(exponent), i as f64);
                    assert_eq!(Large::cmp_products(&x, &y, &y, &x), Ordering::Equal);
                    assert_eq!(Large::cmp_products(&x, &x, &y, &y), (a * a).cmp(&(b * b)));
                }
            }
        }
    }

    /// (a + b)(a − b) = a² − b², and differences cancel to nothing.
    #[test]
    fn large_ones_obey_algebra() {
        let all: Vec<Large> = numbers(40).chunks(2).map(sum).collect();
        for a in &all {
            for b in &all {
                let left = a.plus(b).times(&a.minus(b));
                let right = a.times(a).minus(&b.times(b));
                assert_eq!(left.minus(&right).signum(), 0);
                assert_eq!(a.plus(b).minus(b).minus(a).bits(), 0);
                assert_eq!(a.minus(b).signum(), -b.minus(a).signum());
            }
        }
    }

    fn sum(parts: &[(i64, u32)]) -> Large {
        parts.iter().fold(Large::ZERO, |sum, &(m, s)| sum.plus(&Large::new(m, s)))
    }

    #[test]
    fn the_largest_products_fit() {
        let largest = Large::new(1, 3612);
        let product = largest.plus(&largest.minus(&Large::new(1, 0))).times(&largest);
        assert_eq!((product.bits(), product.len), (7_225, 113));
        assert_eq!(Large::new(i64::MIN, 7_360).bits(), 7_424);
    }

    #[test]
    fn carries_run_through() {
        let ones = Large::new(1, 640).minus(&Large::new(1, 0));
        assert_eq!((ones.bits(), ones.plus(&Large::new(1, 0)).bits()), (640, 641));
        assert_eq!(ones.times(&ones).minus(&Large::new(1, 1280)).plus(&Large::new(1, 641)).signum(), 1);
    }
}
