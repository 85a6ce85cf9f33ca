//! Random numbers: a fixed algorithm, so that a seed names a case for ever.

use geometry::Bounds3;
use geometry::glam::{DVec3, Vec3};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;

/// A seeded stream.
#[derive(Clone, Debug)]
pub struct Random(Pcg32);

impl Random {
    /// Stream `stream` of `seed`: different streams have nothing to do with each other.
    pub fn new(seed: u64, stream: u64) -> Self {
        Self(Pcg32::new(seed, stream))
    }

    /// 32 random bits.
    pub fn bits(&mut self) -> u32 {
        self.0.next_u32()
    }

    /// Uniform in [0, 1), 24 bits.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / 16_777_216.0
    }

    /// Uniform in [−1, 1).
    pub fn signed(&mut self) -> f32 {
        2.0 * self.unit() - 1.0
    }

    /// Uniform below `n`; 0 for `n` = 0.
    pub fn below(&mut self, n: usize) -> usize {
        ((u64::from(self.bits()) * n as u64) >> 32) as usize
    }

    /// Uniform in the cube [−1, 1)³.
    pub fn vector(&mut self) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed())
    }

    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> Vec3 {
        loop {
            let v = DVec3::new(self.signed().into(), self.signed().into(), self.signed().into());
            if (1e-4..=1.0).contains(&v.length_squared()) {
                return v.normalize().as_vec3();
            }
        }
    }

    /// Uniform in a box.
    pub fn point_in(&mut self, bounds: &Bounds3) -> Vec3 {
        bounds.min + bounds.diagonal() * Vec3::new(self.unit(), self.unit(), self.unit())
    }

    /// 2 to a power uniform between `low` and `high`.
    pub fn power_of_two(&mut self, low: f32, high: f32) -> f32 {
        (low + (high - low) * self.unit()).exp2()
    }
}
