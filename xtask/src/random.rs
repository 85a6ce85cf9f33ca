//! Random numbers of a pixel: the same picture on every machine and for every number of threads.

use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;

/// A stream of numbers in [0, 1).
pub struct Random(Pcg32);

impl Random {
    /// The stream with this number.
    pub fn new(seed: u64, stream: u64) -> Self {
        Self(Pcg32::new(seed, stream))
    }

    /// The next number: the upper 24 bits of a word, exact in f32.
    pub fn next(&mut self) -> f32 {
        (self.0.next_u32() >> 8) as f32 * (1.0 / 16_777_216.0)
    }
}
