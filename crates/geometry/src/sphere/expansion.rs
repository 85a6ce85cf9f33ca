//! Exact sums of floats.

/// A real number as a sum of f64, exactly: none of them zero, the larger ones last, no two of them next to each other
/// in their bits (*nonadjacent*). Zero is the empty sum.
///
/// Shewchuk 1997, *Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates*: growing by one
/// float at a time keeps expansions nonadjacent (theorem 10). Without fused multiply-adds, so that every machine does
/// the same. Exact as long as no product overflows and none has a bit below 2⁻¹⁰⁷⁴.
#[derive(Clone, Debug)]
pub(super) struct Expansion(Vec<f64>);

impl Expansion {
    /// The empty sum.
    pub(super) const ZERO: Self = Self(Vec::new());

    /// `x`.
    pub(super) fn from_float(x: f64) -> Self {
        let mut sum = Self::ZERO;
        sum.grow(x);
        sum
    }

    /// `x − y`.
    pub(super) fn difference(x: f64, y: f64) -> Self {
        let mut sum = Self::from_float(x);
        sum.grow(-y);
        sum
    }

    /// Adds a float.
    fn grow(&mut self, x: f64) {
        let mut carry = x;
        let mut kept = 0;
        for i in 0..self.0.len() {
            let (sum, tail) = two_sum(carry, self.0[i]);
            carry = sum;
            if tail != 0.0 {
                self.0[kept] = tail;
                kept += 1;
            }
        }
        self.0.truncate(kept);
        if carry != 0.0 {
            self.0.push(carry);
        }
    }

    /// Adds `factor · x · y`, of a `factor` of 1 or −1.
    pub(super) fn add_product(&mut self, factor: f64, x: &Self, y: &Self) {
        for &a in &x.0 {
            for &b in &y.0 {
                let (product, tail) = two_product(factor * a, b);
                self.grow(tail);
                self.grow(product);
            }
        }
    }

    /// The nearest float but for a relative error of 4u, u = 2⁻⁵³; its sign is exact.
    ///
    /// Nonadjacent terms fall by a factor of 4 at least, so the partial sums from below add up to at most twice the
    /// last term, and this is at most twice the total: the roundings add up to at most 4u of it.
    pub(super) fn estimate(&self) -> f64 {
        self.0.iter().sum()
    }
}

/// `x + y` rounded, and what the rounding left out (Knuth).
pub(super) fn two_sum(x: f64, y: f64) -> (f64, f64) {
    let sum = x + y;
    let y_part = sum - x;
    (sum, (x - (sum - y_part)) + (y - y_part))
}

/// `x · y` rounded, and what the rounding left out (Dekker 1971, with Veltkamp's splitting into halves of 26 bits).
fn two_product(x: f64, y: f64) -> (f64, f64) {
    let product = x * y;
    let ([xh, xl], [yh, yl]) = (split(x), split(y));
    (product, xl * yl - (((product - xh * yh) - xl * yh) - xh * yl))
}

fn split(x: f64) -> [f64; 2] {
    let scaled = x * 134_217_729.0; // 2²⁷ + 1
    let high = scaled - (scaled - x);
    [high, x - high]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whole numbers of up to 2¹²⁰, against those of i128, added at random and multiplied.
    #[test]
    fn sums_and_products_are_exact() {
        let mut state = 1_u64;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as i64 >> ((state >> 3) % 53)
        };
        for _ in 0..20_000 {
            let (mut exact, mut sum) = (0_i128, Expansion::ZERO);
            for i in 0..8 {
                let (x, y) = (random() - (1 << 40), random() / 2);
                let (a, b) = (Expansion::from_float(x as f64), Expansion::from_float(y as f64));
                sum.add_product(if i % 2 == 0 { 1.0 } else { -1.0 }, &a, &b);
                let product = (x as f64) as i128 * (y as f64) as i128;
                exact += if i % 2 == 0 { product } else { -product };
            }
            assert_eq!(sum.0.iter().map(|&x| x as i128).sum::<i128>(), exact);
            assert!((sum.estimate() - exact as f64).abs() <= 3.0 * f64::EPSILON * (exact as f64).abs());
            assert_eq!(sum.estimate() > 0.0, exact > 0);
        }
    }

    #[test]
    fn what_cancels_leaves_nothing_or_the_rest() {
        let [large, small] = [2.0_f64.powi(500), 2.0_f64.powi(-500)];
        let mut sum = Expansion::difference(large, small);
        sum.grow(-large);
        assert_eq!(sum.estimate(), -small);
        sum.grow(small);
        assert!(sum.0.is_empty() && sum.estimate() == 0.0);
        let third = Expansion::from_float(1.0 / 3.0);
        let mut square = Expansion::ZERO;
        square.add_product(1.0, &third, &third);
        assert_eq!(square.estimate(), (1.0 / 3.0) * (1.0 / 3.0));
        square.grow(-square.estimate());
        assert!(square.estimate() != 0.0, "the product needs two floats");
    }
}
