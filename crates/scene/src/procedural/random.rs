//! Random numbers that are the same on every platform and in every version.

use geometry::glam::DVec3;
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;

/// A sequence of random numbers: PCG-XSH-RR 64/32 (O'Neill 2014, *PCG: A Family of Simple Fast Space-Efficient
/// Statistically Good Algorithms for Random Number Generation*), whose words become numbers here and nowhere else, by
/// operations that round the same everywhere.
#[derive(Clone, Debug)]
pub(crate) struct Random(Pcg32);

impl Random {
    /// The sequence of `seed` and `stream`. Both are scrambled first, since PCG's neighbouring seeds and streams are
    /// correlated.
    pub(crate) fn new(seed: u64, stream: u64) -> Self {
        Self(Pcg32::new(scramble(seed), scramble(stream)))
    }

    /// Uniform over the multiples of 2⁻³² in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        f64::from(self.0.next_u32()) / TWO_POW_32
    }

    /// Uniform over [low, high), up to rounding.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A whole number below `count`, which is at least 1; its bias is below `count` · 2⁻³².
    pub(crate) fn below(&mut self, count: u32) -> u32 {
        ((u64::from(self.0.next_u32()) * u64::from(count)) >> 32) as u32
    }

    /// Uniform over the unit ball without its center, by rejection: no sine is needed.
    pub(crate) fn in_ball(&mut self) -> DVec3 {
        loop {
            let p = DVec3::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(-1.0, 1.0));
            if p.length_squared() <= 1.0 && p != DVec3::ZERO {
                return p;
            }
        }
    }

    /// A unit vector, uniform over the sphere.
    pub(crate) fn direction(&mut self) -> DVec3 {
        self.in_ball().normalize()
    }
}

pub(crate) const TWO_POW_32: f64 = (1_u64 << 32) as f64;

/// The finaliser of SplitMix64 (Steele, Lea and Flood 2014, *Fast Splittable Pseudorandom Number Generators*): a
/// bijection under which neighbours have nothing in common.
pub(crate) fn scramble(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ x >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The scenes and ray sets of a seed are the same for ever: these words may not change.
    #[test]
    fn the_sequence_is_fixed() {
        // SplitMix64's published first output for the seed 0.
        assert_eq!(scramble(0), 0xe220_a839_7b1d_cdaf);
        let mut random = Random::new(0, 0);
        let words: Vec<u32> = (0..4).map(|_| random.0.next_u32()).collect();
        assert_eq!(words, [2_991_164_808, 1_268_443_235, 1_601_055_435, 3_338_596_885]);
    }

    #[test]
    fn numbers_stay_in_their_range_and_have_its_mean() {
        let mut random = Random::new(7, 1);
        let mut sum = 0.0;
        let mut directions = DVec3::ZERO;
        for _ in 0..10_000 {
            let x = random.between(-2.0, 4.0);
            assert!((-2.0..4.0).contains(&x));
            sum += x;
            let d = random.direction();
            assert!((d.length() - 1.0).abs() < 1e-14);
            directions += d;
            assert!(random.below(3) < 3);
        }
        // Six standard deviations of the mean: 6 · √3 / 100, and 6 · 1/√3 / 100 for each coordinate.
        assert!((sum / 1e4 - 1.0).abs() < 0.11);
        assert!((directions / 1e4).abs().max_element() < 0.035);
    }

    #[test]
    fn seeds_and_streams_differ() {
        let first = |seed, stream| Random::new(seed, stream).unit();
        assert_ne!(first(0, 0), first(1, 0));
        assert_ne!(first(0, 0), first(0, 1));
    }
}
