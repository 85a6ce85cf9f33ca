//! A Morton code with a number, in one whole number that sorts by the code.

use std::fmt::Debug;

use bytemuck::Pod;

/// A code, and behind it the number of what has it: of equal codes the smaller number comes first.
pub(super) trait Coded: Pod + Debug + Ord + Send + Sync {
    /// How many bits a code may have.
    const CODE_BITS: u32;

    fn new(code: u64, number: u32) -> Self;

    fn code(self) -> u64;

    fn number(self) -> u32;
}

impl Coded for u64 {
    const CODE_BITS: u32 = 32;

    fn new(code: u64, number: u32) -> Self {
        code << 32 | Self::from(number)
    }

    fn code(self) -> u64 {
        self >> 32
    }

    fn number(self) -> u32 {
        self as u32
    }
}

impl Coded for u128 {
    const CODE_BITS: u32 = 64;

    fn new(code: u64, number: u32) -> Self {
        Self::from(code) << 32 | Self::from(number)
    }

    fn code(self) -> u64 {
        (self >> 32) as u64
    }

    fn number(self) -> u32 {
        self as u32
    }
}
