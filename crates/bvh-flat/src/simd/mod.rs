//! Eight lanes at once: the only place with `unsafe` code.
//!
//! What an instruction set offers is a type that implements [`Lanes`]; a [`Kernel`] is written once over them. Which
//! set the processor has is found out once, at run time, and a [`SimdWidth`] is the proof of it: [`SimdWidth::run`] is
//! the one function boundary behind which the kernel is compiled for that set. Nothing depends on `target-cpu`.

#![allow(unsafe_code)]

use std::mem::MaybeUninit;

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod portable;
mod stack;
mod width;
#[cfg(target_arch = "x86_64")]
mod x86;

pub(crate) use stack::Stack;
pub use width::SimdWidth;

/// How many lanes there are.
pub(crate) const LANES: usize = 8;

/// How many numbers can be read from the beginning of a leaf.
pub(crate) const LEAF_NUMBERS: usize = 144;

// What `Lanes::load_vertices` reads.
const _: () = assert!(1 + (3 * 2 + 3) * 15 + LANES <= LEAF_NUMBERS);

/// Eight numbers of 32 bits and what can be done with them. Masks have a bit for each lane.
///
/// All methods are compiled in place into the kernel that uses them, behind the boundary of [`SimdWidth::run`].
pub(crate) trait Lanes: Copy {
    /// Eight f32.
    type F32: Copy;
    /// Eight u32.
    type U32: Copy;
    /// Whether [`mul_add`](Self::mul_add) rounds once; where not, it rounds the product too.
    const FUSED: bool;

    fn splat(x: f32) -> Self::F32;
    fn load(x: &[f32; LANES]) -> Self::F32;
    /// Row `at / 8` of eight rows; `at` is taken modulo 64, and down to a multiple of eight.
    fn load_row(rows: &[f32; 64], at: usize) -> Self::F32;
    /// Row `at / 8` of six rows of bytes, as numbers; `at` is taken down to a multiple of eight, 40 at most.
    fn load_bytes(rows: &[u8; 48], at: usize) -> Self::F32;
    /// Of `count` triangles, as a leaf of a wide tree has them, one coordinate of the first, second and third vertices:
    /// the numbers from 1 + (3 vertex + axis) count on. `count` is taken modulo 16 and `axis` modulo 4.
    fn load_vertices(leaf: &[f32; LEAF_NUMBERS], count: usize, axis: usize) -> [Self::F32; 3];
    /// The eight columns of eight rows.
    fn load_columns(rows: [&[f32; LANES]; LANES]) -> [Self::F32; LANES];
    fn load_u32(x: &[u32; LANES]) -> Self::U32;
    fn to_array(x: Self::F32) -> [f32; LANES];

    fn add(a: Self::F32, b: Self::F32) -> Self::F32;
    fn sub(a: Self::F32, b: Self::F32) -> Self::F32;
    fn mul(a: Self::F32, b: Self::F32) -> Self::F32;
    fn div(a: Self::F32, b: Self::F32) -> Self::F32;
    /// a b + c.
    fn mul_add(a: Self::F32, b: Self::F32, c: Self::F32) -> Self::F32;
    /// a b − c.
    fn mul_sub(a: Self::F32, b: Self::F32, c: Self::F32) -> Self::F32;
    fn abs(a: Self::F32) -> Self::F32;
    fn neg(a: Self::F32) -> Self::F32;

    /// `if a < b { a } else { b }`: where either is NaN, b.
    fn min(a: Self::F32, b: Self::F32) -> Self::F32;
    /// `if a > b { a } else { b }`: where either is NaN, b.
    fn max(a: Self::F32, b: Self::F32) -> Self::F32;
    /// The lanes where a < b; not where either is NaN.
    fn lt(a: Self::F32, b: Self::F32) -> u32;
    /// The lanes where a <= b; not where either is NaN.
    fn le(a: Self::F32, b: Self::F32) -> u32;

    /// The smaller, if at least one of them is not negative and neither is NaN; else some negative number. One cycle
    /// where [`min`](Self::min) takes four, on processors that compare integers faster than floats.
    fn min_or_negative(a: Self::F32, b: Self::F32) -> Self::F32;
    /// The larger, under the same condition.
    fn max_or_negative(a: Self::F32, b: Self::F32) -> Self::F32;
    /// The lanes where a <= b, if b is negative or a is not, and neither is NaN.
    fn le_or_negative(a: Self::F32, b: Self::F32) -> u32;

    /// Of the lanes of the mask the one with the least number, none being negative, up to its three lowest bits; any
    /// lane where there is none.
    fn least_met(a: Self::F32, met: u32) -> usize;

    /// In the lanes of the mask a, in the others b: their bits, whatever these mean.
    fn select(mask: u32, a: Self::F32, b: Self::F32) -> Self::F32;

    fn splat_u32(x: u32) -> Self::U32;
    fn eq_u32(a: Self::U32, b: Self::U32) -> u32;

    /// Lane i takes lane `order[i] >> shift` (of it the lowest three bits).
    fn permute(x: Self::F32, order: Self::U32, shift: u32) -> Self::F32;
    /// Lane i takes lane `order[i] >> shift` (of it the lowest three bits).
    fn permute_u32(x: Self::U32, order: Self::U32, shift: u32) -> Self::U32;
    /// Moves the lanes of the mask to the front, in their order, into `to`; what comes after them is arbitrary.
    fn compress(x: Self::F32, mask: u32, to: &mut [MaybeUninit<f32>; LANES]);
    /// Moves the lanes of the mask to the front, in their order, into `to`; what comes after them is arbitrary.
    fn compress_u32(x: Self::U32, mask: u32, to: &mut [MaybeUninit<u32>; LANES]);
}

/// The lanes of a mask, from the lowest on.
pub(crate) struct LanesOf(pub(crate) u32);

impl Iterator for LanesOf {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        if self.0 == 0 {
            return None;
        }
        let lane = self.0.trailing_zeros() as usize & 7;
        self.0 &= self.0 - 1;
        Some(lane)
    }
}

/// Something that is computed with lanes, written once and compiled for each kind of them.
pub(crate) trait Kernel {
    /// What comes out.
    type Output;

    /// Computes it. To be marked `#[inline(always)]`, like all that it calls with lanes: what is not compiled in place
    /// is not compiled for the instruction set.
    fn run<L: Lanes>(self) -> Self::Output;
}

/// Of the triangle in a lane of a leaf of `count`, whose numbers lie as blocks have them, the coordinates of the
/// vertices along three axes. (The three numbers are taken modulo 8, 16 and 4, all of which are in range.)
#[inline(always)]
pub(crate) fn load_triangle(leaf: &[f32; LEAF_NUMBERS], lane: usize, count: usize, axes: [usize; 3]) -> [[f32; 3]; 3] {
    let (lane, count) = (lane & 7, count & 15);
    let [x, y, z] = [(axes[0] & 3) * count, (axes[1] & 3) * count, (axes[2] & 3) * count];
    let vertex = |i: usize| {
        let first = 1 + 3 * i * count + lane;
        // SAFETY: it is at most 1 + (3 · 2 + 3) · 15 + 7 = 143, the last of 144. (Nine masks in place of three take a
        // twelfth of what the values of a hit do.) Volatile, since for AVX-512 the compiler would make one gather with
        // 64-bit multiplications of all nine loads, which costs 6 % of a primary ray.
        let number = |along: usize| unsafe { leaf.as_ptr().add(first + along).read_volatile() };
        [number(x), number(y), number(z)]
    };
    [vertex(0), vertex(1), vertex(2)]
}

/// Asks for the cache line at `x`, if there is anything to ask.
#[inline(always)]
pub(crate) fn prefetch<T>(x: &T) {
    prefetch_from::<1, T>(std::slice::from_ref(x), 0);
}

/// Asks for the cache lines at `N` numbers of `x` from `first` on, whether or not they are there.
#[inline(always)]
pub(crate) fn prefetch_from<const N: usize, T>(x: &[T], first: usize) {
    #[cfg(target_arch = "x86_64")]
    for i in 0..N {
        // SAFETY: SSE is part of x86-64; a prefetch accesses memory in no observable way, at any address.
        unsafe {
            let at = x.as_ptr().wrapping_add(first).wrapping_add(i);
            std::arch::x86_64::_mm_prefetch::<{ std::arch::x86_64::_MM_HINT_T0 }>(at.cast());
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (x, first);
}
