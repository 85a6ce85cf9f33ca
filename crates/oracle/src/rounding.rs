//! Exact numbers rounded to floats.

use std::cmp::Ordering;

use crate::dyadic::Dyadic;
use crate::real::ExactReal;

impl ExactReal {
    /// The nearest f64, ties to even; infinite where IEEE 754 rounds to infinity.
    pub fn to_f64(&self) -> f64 {
        let magnitude = self.abs();
        let below = magnitude.floor_f64();
        // Half the gap to the next float above; above the largest there would be one more of the same spacing.
        let gap = if below == f64::MAX { 2.0_f64.powi(971) } else { below.next_up() - below };
        let middle = &Dyadic::from_f64(below) + &(&Dyadic::from_f64(gap) * &Dyadic::power_of_two(-1));
        let nearest = match magnitude.cmp_dyadic(&middle) {
            Ordering::Less => below,
            Ordering::Equal if !is_odd(below) => below,
            _ => below.next_up(),
        };
        if self.signum() < 0 { -nearest } else { nearest }
    }

    /// The nearest f32, ties to even; infinite where IEEE 754 rounds to infinity.
    pub fn to_f32(&self) -> f32 {
        // Rounded to odd first: then no tie of the second rounding is false (Boldo and Melquiond 2008, *Emulation of
        // FMA and Correctly Rounded Sums*, IEEE Transactions on Computers 57(4)).
        let magnitude = self.abs();
        let below = magnitude.floor_f64();
        let odd = if is_odd(below) || magnitude.cmp_f64(below).is_eq() { below } else { below.next_up() };
        if self.signum() < 0 { -odd as f32 } else { odd as f32 }
    }

    /// The spacing of f32 at this number: the distance of the two floats around its magnitude (2⁻¹⁴⁹ around zero).
    pub fn ulp32(&self) -> f64 {
        let exponent = (self.abs().floor_f64().to_bits() >> 52) as i32 - 1023;
        2.0_f64.powi((exponent - 23).clamp(-149, 104))
    }

    /// Two neighbouring floats around this number, which is not negative.
    pub(crate) fn range(&self) -> [f64; 2] {
        let below = self.floor_f64();
        [below, below.next_up()]
    }

    /// The largest finite f64 that is not above this number, which is not negative.
    ///
    /// A search outward from the estimate, then between: two or three comparisons where the estimate is good, and never
    /// more than 128. The comparison is exact, so nothing depends on the estimate.
    fn floor_f64(&self) -> f64 {
        // The bits of floats that are not negative are integers in the same order.
        let is_below = |bits: u64| self.cmp_f64(f64::from_bits(bits)).is_ge();
        let most = f64::MAX.to_bits();
        let estimate = self.estimate();
        let start = if estimate > 0.0 { estimate.to_bits().min(most) } else { 0 };
        let (mut low, mut high) = (start, start);
        let mut step = 1;
        while high <= most && is_below(high) {
            low = high;
            high = high.saturating_add(step).min(most + 1);
            step *= 2;
        }
        while low > 0 && !is_below(low) {
            high = low;
            low = low.saturating_sub(step);
            step *= 2;
        }
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            if is_below(middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        f64::from_bits(low)
    }
}

/// Whether the last bit of the significand is set.
fn is_odd(x: f64) -> bool {
    x.to_bits() & 1 == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ratio(n: f64, d: f64) -> ExactReal {
        ExactReal::ratio(Dyadic::from_f64(n), Dyadic::from_f64(d))
    }

    const FLOATS: [f64; 16] = [
        1.0,
        -1.0,
        3.0,
        -7.0,
        0.1,
        1e-3,
        5e-324,
        1e-310,
        f64::MIN_POSITIVE,
        1.0 + f64::EPSILON,
        16777217.0,
        -16777219.0,
        1e30,
        3.5e38,
        1e300,
        f64::MAX,
    ];

    /// IEEE division rounds correctly: so must we.
    #[test]
    fn quotients_round_as_ieee_division_does() {
        for n in FLOATS {
            for d in FLOATS {
                assert_eq!(ratio(n, d).to_f64(), n / d, "{n} {d}");
            }
        }
        assert_eq!(ratio(0.0, 3.0).to_f64(), 0.0);
        // Ties go to the even neighbour.
        let large = 2.0_f64.powi(53);
        for (delta, nearest) in [(1.0, large), (3.0, large + 4.0), (5.0, large + 4.0)] {
            assert_eq!(ExactReal::from_f64(large).along(delta, 1.0).to_f64(), nearest);
            assert_eq!(ExactReal::from_f64(-large).along(-delta, 1.0).to_f64(), -nearest);
        }
    }

    #[test]
    fn square_roots_round_as_ieee_roots_do() {
        for q in FLOATS.into_iter().filter(|q| *q > 0.0) {
            let [zero, one, q2] = [0.0, 1.0, q].map(Dyadic::from_f64);
            let root = ExactReal::quadratic(zero, one.clone(), q2, one);
            assert_eq!(root.to_f64(), q.sqrt(), "{q}");
        }
    }

    #[test]
    fn f32_quotients_round_once() {
        let floats = FLOATS.map(|x| x as f32).into_iter().chain([1e-45, 1e-40, 2.5e-39]);
        let floats: Vec<f32> = floats.filter(|x| *x != 0.0 && x.is_finite()).collect();
        for &n in &floats {
            for &d in &floats {
                assert_eq!(ratio(n.into(), d.into()).to_f32(), n / d, "{n} {d}");
            }
        }
        // Just above the middle of two f32, by less than f64 can see.
        let tie = f64::from(1.0_f32) + f64::from(f32::EPSILON) / 2.0;
        let above = ExactReal::from_f64(tie).along(1e-30, 1.0);
        assert_eq!(ExactReal::from_f64(tie).to_f32(), 1.0);
        assert_eq!((above.to_f64() as f32, above.to_f32()), (1.0, 1.0 + f32::EPSILON));
    }

    #[test]
    fn what_no_float_holds_is_infinite_or_clamped() {
        let huge = ratio(f64::MAX, 5e-324);
        assert_eq!((huge.to_f64(), huge.floor_f64()), (f64::INFINITY, f64::MAX));
        let huge = ratio(-f64::MAX, 5e-324);
        assert_eq!((huge.to_f64(), huge.to_f32()), (f64::NEG_INFINITY, f32::NEG_INFINITY));
        assert_eq!(ratio(1e39, 1.0).to_f32(), f32::INFINITY);
    }

    #[test]
    fn ulps_of_f32() {
        let x = 1.0_f32 - f32::EPSILON / 2.0;
        for (n, d, ulp) in [
            (1.0, 1.0, f32::EPSILON),
            (-1.0, 3.0, f32::EPSILON / 4.0),
            (x.into(), 1.0, f32::EPSILON / 2.0),
            (0.0, 1.0, 1e-45),
            (1e-42, 1.0, 1e-45),
            (f32::MAX.into(), 1.0, f32::MAX - f32::MAX.next_down()),
        ] {
            assert_eq!(ratio(n, d).ulp32(), f64::from(ulp), "{n}/{d}");
        }
    }
}
