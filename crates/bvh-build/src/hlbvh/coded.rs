//! A Morton code with a number, in one whole number that sorts by the code.

use std::fmt::Debug;

use bytemuck::{Pod, Zeroable};

/// A code, and behind it the number of what has it: of equal codes the smaller number comes first.
pub(super) trait Coded: Pod + Debug + Ord + Send + Sync {
    /// How many bits a code may have.
    const CODE_BITS: u32;

    /// How many bits a number may have.
    const NUMBER_BITS: u32;

    fn new(code: u64, number: u32) -> Self;

    fn code(self) -> u64;

    fn number(self) -> u32;
}

/// A code above a number of so many bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Pod, Zeroable)]
#[repr(transparent)]
pub(super) struct Packed<const NUMBER_BITS: u32>(u64);

impl<const NUMBER_BITS: u32> Coded for Packed<NUMBER_BITS> {
    const CODE_BITS: u32 = u64::BITS - NUMBER_BITS;
    const NUMBER_BITS: u32 = NUMBER_BITS;

    fn new(code: u64, number: u32) -> Self {
        Self(code << NUMBER_BITS | u64::from(number))
    }

    fn code(self) -> u64 {
        self.0 >> NUMBER_BITS
    }

    fn number(self) -> u32 {
        (self.0 & ((1 << NUMBER_BITS) - 1)) as u32
    }
}

impl Coded for u128 {
    const CODE_BITS: u32 = 64;
    const NUMBER_BITS: u32 = u32::BITS;

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
