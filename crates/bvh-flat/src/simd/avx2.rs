//! Lanes of AVX2 with FMA.
//!
//! Every method is one or a few instructions. They are only ever compiled into a [`Kernel`](super::Kernel) behind
//! [`SimdWidth::run`](super::SimdWidth::run), which proves that the processor has them: that is the argument for each `op!`.

use std::arch::x86_64::*;
use std::mem::MaybeUninit;

use super::{LANES, LEAF_NUMBERS, Lanes};

#[derive(Clone, Copy)]
pub(super) struct Avx2;

/// An expression of intrinsics.
macro_rules! op {
    ($e:expr) => {
        // SAFETY: the processor has the instructions (see above); those that access memory need no alignment, and do so
        // through references to eight numbers, in `load_row` to 64 from one of the places
        // 0, 8 … 56 on, or in `load_vertices` to 144, of which the last read
        // is 1 + (3 · 2 + 3) · 15 + 7 = 143 at most.
        unsafe { $e }
    };
}

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

impl Lanes for Avx2 {
    type F32 = __m256;
    type U32 = __m256i;
    const FUSED: bool = true;

    #[inline(always)]
    fn splat(x: f32) -> __m256 {
        op!(_mm256_set1_ps(x))
    }
    #[inline(always)]
    fn load(x: &[f32; LANES]) -> __m256 {
        op!(_mm256_loadu_ps(x.as_ptr()))
    }
    #[inline(always)]
    fn load_row(rows: &[f32; 64], at: usize) -> __m256 {
        op!(_mm256_loadu_ps(rows.as_ptr().add(at & 56)))
    }
    #[inline(always)]
    fn load_vertices(leaf: &[f32; LEAF_NUMBERS], count: usize, axis: usize) -> [__m256; 3] {
        let (count, axis) = (count & 15, axis & 3);
        let at = 1 + axis * count;
        op!({
            let from = leaf.as_ptr().add(at);
            [_mm256_loadu_ps(from), _mm256_loadu_ps(from.add(3 * count)), _mm256_loadu_ps(from.add(6 * count))]
        })
    }
    #[inline(always)]
    fn load_u32(x: &[u32; LANES]) -> __m256i {
        op!(_mm256_loadu_si256(x.as_ptr().cast()))
    }
    #[inline(always)]
    fn to_array(x: __m256) -> [f32; LANES] {
        op!({
            let mut to = [0.0; LANES];
            _mm256_storeu_ps(to.as_mut_ptr(), x);
            to
        })
    }
    #[inline(always)]
    fn add(a: __m256, b: __m256) -> __m256 {
        op!(_mm256_add_ps(a, b))
    }
    #[inline(always)]
    fn sub(a: __m256, b: __m256) -> __m256 {
        op!(_mm256_sub_ps(a, b))
    }
    #[inline(always)]
    fn mul(a: __m256, b: __m256) -> __m256 {
        op!(_mm256_mul_ps(a, b))
    }
    #[inline(always)]
    fn div(a: __m256, b: __m256) -> __m256 {
        op!(_mm256_div_ps(a, b))
    }
    #[inline(always)]
    fn mul_add(a: __m256, b: __m256, c: __m256) -> __m256 {
        op!(_mm256_fmadd_ps(a, b, c))
    }
    #[inline(always)]
    fn mul_sub(a: __m256, b: __m256, c: __m256) -> __m256 {
        op!(_mm256_fmsub_ps(a, b, c))
    }
    #[inline(always)]
    fn abs(a: __m256) -> __m256 {
        op!(_mm256_andnot_ps(_mm256_set1_ps(-0.0), a))
    }
    #[inline(always)]
    fn neg(a: __m256) -> __m256 {
        op!(_mm256_xor_ps(_mm256_set1_ps(-0.0), a))
    }
    #[inline(always)]
    fn min(a: __m256, b: __m256) -> __m256 {
        op!(_mm256_min_ps(a, b))
    }
    #[inline(always)]
    fn max(a: __m256, b: __m256) -> __m256 {
        op!(_mm256_max_ps(a, b))
    }
    #[inline(always)]
    fn lt(a: __m256, b: __m256) -> u32 {
        op!(_mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(a, b)) as u32)
    }
    #[inline(always)]
    fn le(a: __m256, b: __m256) -> u32 {
        op!(_mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(a, b)) as u32)
    }
    #[inline(always)]
    fn min_or_negative(a: __m256, b: __m256) -> __m256 {
        op!(_mm256_castsi256_ps(_mm256_min_epi32(_mm256_castps_si256(a), _mm256_castps_si256(b))))
    }
    #[inline(always)]
    fn max_or_negative(a: __m256, b: __m256) -> __m256 {
        op!(_mm256_castsi256_ps(_mm256_max_epi32(_mm256_castps_si256(a), _mm256_castps_si256(b))))
    }
    #[inline(always)]
    fn le_or_negative(a: __m256, b: __m256) -> u32 {
        op!({
            let greater = _mm256_cmpgt_epi32(_mm256_castps_si256(a), _mm256_castps_si256(b));
            !_mm256_movemask_ps(_mm256_castsi256_ps(greater)) as u32 & 0xff
        })
    }
    #[inline(always)]
    fn least_met(a: __m256, b: __m256, _met: u32) -> usize {
        op!({
            let key = _mm256_or_si256(
                _mm256_andnot_si256(_mm256_set1_epi32(7), _mm256_castps_si256(a)),
                _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7),
            );
            let key = _mm256_or_si256(key, _mm256_castps_si256(_mm256_cmp_ps::<_CMP_NLE_UQ>(a, b)));
            let least = _mm_min_epu32(_mm256_castsi256_si128(key), _mm256_extracti128_si256::<1>(key));
            let least = _mm_min_epu32(least, _mm_shuffle_epi32::<0b01_00_11_10>(least));
            let least = _mm_min_epu32(least, _mm_shuffle_epi32::<0b10_11_00_01>(least));
            (_mm_cvtsi128_si32(least) & 7) as usize
        })
    }
    #[inline(always)]
    fn splat_u32(x: u32) -> __m256i {
        op!(_mm256_set1_epi32(x as i32))
    }
    #[inline(always)]
    fn eq_u32(a: __m256i, b: __m256i) -> u32 {
        op!(_mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(a, b))) as u32)
    }
    #[inline(always)]
    fn permute(x: __m256, order: __m256i, shift: u32) -> __m256 {
        op!(_mm256_permutevar8x32_ps(x, _mm256_srl_epi32(order, _mm_cvtsi32_si128(shift as i32))))
    }
    #[inline(always)]
    fn permute_u32(x: __m256i, order: __m256i, shift: u32) -> __m256i {
        op!(_mm256_permutevar8x32_epi32(x, _mm256_srl_epi32(order, _mm_cvtsi32_si128(shift as i32))))
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
