//! Lanes of AVX2 with FMA.
//!
//! Every method is one or a few instructions. They are only ever compiled into a [`Kernel`](super::Kernel) behind
//! [`SimdWidth::run`](super::SimdWidth::run), which proves that the processor has them: that is the argument for each
//! `op!`.

use std::arch::x86_64::*;
use std::mem::MaybeUninit;

use super::x86::{common_lanes, halves, keys, lane_of_least, op};
use super::{LANES, LEAF_NUMBERS, Lanes};

#[derive(Clone, Copy)]
pub(super) struct Avx2;

/// For each mask the lanes that it selects, one in each byte from the lowest on.
static TO_FRONT: [u64; 256] = {
    let mut table = [0; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut n) = (0, 0);
        while lane < LANES as u64 {
            if mask >> lane & 1 == 1 {
                table[mask] |= lane << (8 * n);
                n += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    table
};

#[inline(always)]
fn to_front(mask: u32) -> __m256i {
    op!(_mm256_cvtepu8_epi32(_mm_cvtsi64_si128(TO_FRONT[mask as usize & 0xff] as i64)))
}

/// All bits in the lanes of a mask.
#[inline(always)]
fn lanes_of(mask: u32) -> __m256i {
    op!({
        let bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
        _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(mask as i32), bits), bits)
    })
}

impl Lanes for Avx2 {
    common_lanes!();

    #[inline(always)]
    fn lt(a: __m256, b: __m256) -> u32 {
        op!(_mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(a, b)) as u32)
    }
    #[inline(always)]
    fn le(a: __m256, b: __m256) -> u32 {
        op!(_mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(a, b)) as u32)
    }
    #[inline(always)]
    fn le_or_negative(a: __m256, b: __m256) -> u32 {
        op!({
            let greater = _mm256_cmpgt_epi32(_mm256_castps_si256(a), _mm256_castps_si256(b));
            !_mm256_movemask_ps(_mm256_castsi256_ps(greater)) as u32 & 0xff
        })
    }
    #[inline(always)]
    fn least_met(a: __m256, met: u32) -> usize {
        op!({
            let key = keys(a);
            let key = _mm256_blendv_epi8(_mm256_set1_epi32(-1), key, lanes_of(met));
            lane_of_least(key)
        })
    }
    #[inline(always)]
    fn select(mask: u32, a: __m256, b: __m256) -> __m256 {
        op!(_mm256_blendv_ps(b, a, _mm256_castsi256_ps(lanes_of(mask))))
    }
    #[inline(always)]
    fn eq_u32(a: __m256i, b: __m256i) -> u32 {
        op!(_mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(a, b))) as u32)
    }
    #[inline(always)]
    fn compress(x: __m256, mask: u32, to: &mut [MaybeUninit<f32>; LANES]) {
        op!(_mm256_storeu_ps(to.as_mut_ptr().cast(), _mm256_permutevar8x32_ps(x, to_front(mask))))
    }
    #[inline(always)]
    fn compress_u32(x: __m256i, mask: u32, to: &mut [MaybeUninit<u32>; LANES]) {
        op!(_mm256_storeu_si256(to.as_mut_ptr().cast(), _mm256_permutevar8x32_epi32(x, to_front(mask))))
    }
}
