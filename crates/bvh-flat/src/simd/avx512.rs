//! Lanes of AVX-512, 256 bits wide.
//!
//! Every method is one or a few instructions. They are only ever compiled into a [`Kernel`](super::Kernel) behind
//! [`SimdWidth::run`](super::SimdWidth::run), which proves that the processor has them: that is the argument for each
//! `op!`.

use std::arch::x86_64::*;
use std::mem::MaybeUninit;

use super::x86::{common_lanes, halves, keys, lane_of_least, op};
use super::{LANES, LEAF_NUMBERS, Lanes};

#[derive(Clone, Copy)]
pub(super) struct Avx512;

impl Lanes for Avx512 {
    common_lanes!();

    #[inline(always)]
    fn lt(a: __m256, b: __m256) -> u32 {
        op!(u32::from(_mm256_cmp_ps_mask::<_CMP_LT_OQ>(a, b)))
    }
    #[inline(always)]
    fn le(a: __m256, b: __m256) -> u32 {
        op!(u32::from(_mm256_cmp_ps_mask::<_CMP_LE_OQ>(a, b)))
    }
    #[inline(always)]
    fn le_or_negative(a: __m256, b: __m256) -> u32 {
        op!(u32::from(_mm256_cmple_epi32_mask(_mm256_castps_si256(a), _mm256_castps_si256(b))))
    }
    #[inline(always)]
    fn least_met(a: __m256, met: u32) -> usize {
        op!({
            let key = keys(a);
            let key = _mm256_mask_mov_epi32(_mm256_set1_epi32(-1), met as u8, key);
            lane_of_least(key)
        })
    }
    #[inline(always)]
    fn select(mask: u32, a: __m256, b: __m256) -> __m256 {
        op!(_mm256_mask_blend_ps(mask as u8, b, a))
    }
    #[inline(always)]
    fn eq_u32(a: __m256i, b: __m256i) -> u32 {
        op!(u32::from(_mm256_cmpeq_epi32_mask(a, b)))
    }
    #[inline(always)]
    fn compress(x: __m256, mask: u32, to: &mut [MaybeUninit<f32>; LANES]) {
        op!(_mm256_storeu_ps(to.as_mut_ptr().cast(), _mm256_maskz_compress_ps(mask as u8, x)))
    }
    #[inline(always)]
    fn compress_u32(x: __m256i, mask: u32, to: &mut [MaybeUninit<u32>; LANES]) {
        op!(_mm256_storeu_si256(to.as_mut_ptr().cast(), _mm256_maskz_compress_epi32(mask as u8, x)))
    }
}
