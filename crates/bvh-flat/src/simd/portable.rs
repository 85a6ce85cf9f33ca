//! Lanes as arrays: the specification of the others, and what every processor can do.

use std::mem::MaybeUninit;

use super::{LANES, LEAF_NUMBERS, Lanes};

#[derive(Clone, Copy)]
pub(super) struct Portable;

type F = [f32; LANES];
type U = [u32; LANES];

#[inline(always)]
fn zip(a: F, b: F, f: impl Fn(f32, f32) -> f32) -> F {
    std::array::from_fn(|i| f(a[i], b[i]))
}

#[inline(always)]
fn mask(a: F, b: F, f: impl Fn(f32, f32) -> bool) -> u32 {
    (0..LANES).fold(0, |m, i| m | u32::from(f(a[i], b[i])) << i)
}

#[inline(always)]
fn compress<T: Copy>(x: [T; LANES], mask: u32, to: &mut [MaybeUninit<T>; LANES]) {
    let mut n = 0;
    for (i, x) in x.into_iter().enumerate() {
        to[n & 7] = MaybeUninit::new(x);
        n += (mask >> i & 1) as usize;
    }
}

impl Lanes for Portable {
    type F32 = F;
    type U32 = U;
    const FUSED: bool = false;

    #[inline(always)]
    fn splat(x: f32) -> F {
        [x; LANES]
    }
    #[inline(always)]
    fn load(x: &[f32; LANES]) -> F {
        *x
    }
    #[inline(always)]
    fn load_row(rows: &[f32; 64], at: usize) -> F {
        std::array::from_fn(|i| rows[(at & 56) + i])
    }
    #[inline(always)]
    fn load_bytes(rows: &[u8; 48], at: usize) -> F {
        std::array::from_fn(|i| f32::from(rows[(at & 56).min(40) + i]))
    }
    #[inline(always)]
    fn load_vertices(leaf: &[f32; LEAF_NUMBERS], count: usize, axis: usize) -> [F; 3] {
        let (count, axis) = (count & 15, axis & 3);
        [0, 1, 2].map(|vertex| {
            let at = 1 + (3 * vertex + axis) * count;
            std::array::from_fn(|lane| leaf[at + lane])
        })
    }
    #[inline(always)]
    fn load_columns(rows: [&F; LANES]) -> [F; LANES] {
        std::array::from_fn(|column| std::array::from_fn(|row| rows[row][column]))
    }
    #[inline(always)]
    fn load_u32(x: &[u32; LANES]) -> U {
        *x
    }
    #[inline(always)]
    fn to_array(x: F) -> [f32; LANES] {
        x
    }
    #[inline(always)]
    fn add(a: F, b: F) -> F {
        zip(a, b, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(a: F, b: F) -> F {
        zip(a, b, |a, b| a - b)
    }
    #[inline(always)]
    fn mul(a: F, b: F) -> F {
        zip(a, b, |a, b| a * b)
    }
    #[inline(always)]
    fn div(a: F, b: F) -> F {
        zip(a, b, |a, b| a / b)
    }
    #[inline(always)]
    fn mul_add(a: F, b: F, c: F) -> F {
        Self::add(Self::mul(a, b), c)
    }
    #[inline(always)]
    fn mul_sub(a: F, b: F, c: F) -> F {
        Self::sub(Self::mul(a, b), c)
    }
    #[inline(always)]
    fn abs(a: F) -> F {
        a.map(f32::abs)
    }
    #[inline(always)]
    fn neg(a: F) -> F {
        a.map(|x| -x)
    }
    #[inline(always)]
    fn min(a: F, b: F) -> F {
        zip(a, b, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn max(a: F, b: F) -> F {
        zip(a, b, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn lt(a: F, b: F) -> u32 {
        mask(a, b, |a, b| a < b)
    }
    #[inline(always)]
    fn le(a: F, b: F) -> u32 {
        mask(a, b, |a, b| a <= b)
    }
    #[inline(always)]
    fn min_or_negative(a: F, b: F) -> F {
        Self::min(a, b)
    }
    #[inline(always)]
    fn max_or_negative(a: F, b: F) -> F {
        Self::max(a, b)
    }
    #[inline(always)]
    fn le_or_negative(a: F, b: F) -> u32 {
        Self::le(a, b)
    }
    #[inline(always)]
    fn least_met(a: F, met: u32) -> usize {
        let mut least = (f32::INFINITY, 0);
        for (i, a) in a.into_iter().enumerate() {
            if met >> i & 1 == 1 && a < least.0 {
                least = (a, i);
            }
        }
        least.1
    }
    #[inline(always)]
    fn select(mask: u32, a: F, b: F) -> F {
        std::array::from_fn(|i| if mask >> i & 1 == 1 { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn splat_u32(x: u32) -> U {
        [x; LANES]
    }
    #[inline(always)]
    fn eq_u32(a: U, b: U) -> u32 {
        (0..LANES).fold(0, |m, i| m | u32::from(a[i] == b[i]) << i)
    }
    #[inline(always)]
    fn permute(x: F, order: U, shift: u32) -> F {
        order.map(|o| x[(o >> shift & 7) as usize])
    }
    #[inline(always)]
    fn permute_u32(x: U, order: U, shift: u32) -> U {
        order.map(|o| x[(o >> shift & 7) as usize])
    }
    #[inline(always)]
    fn compress(x: F, mask: u32, to: &mut [MaybeUninit<f32>; LANES]) {
        compress(x, mask, to);
    }
    #[inline(always)]
    fn compress_u32(x: U, mask: u32, to: &mut [MaybeUninit<u32>; LANES]) {
        compress(x, mask, to);
    }
}
