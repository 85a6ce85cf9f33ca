//! What AVX2 and AVX-512 have in common.

use std::arch::x86_64::*;

use super::LANES;

/// An expression of intrinsics.
macro_rules! op {
    ($e:expr) => {
        // SAFETY: the processor has the instructions, as the modules that use this say. Those that access memory need
        // no alignment, and do so through references to eight numbers, of which `halves` reads four from place 0 or 4
        // on; to 64 in `load_row` and 48 in `load_bytes`, from one of the places 0, 8 … 56 (40) on; or to 144 in
        // `load_vertices`, of which the last read is 1 + (3 · 2 + 3) · 15 + 7 = 143 at most.
        unsafe { $e }
    };
}
pub(super) use op;

/// The methods of lanes that are the same for both.
macro_rules! common_lanes {
    () => {
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
        fn load_bytes(rows: &[u8; 48], at: usize) -> __m256 {
            op!({
                let bytes = _mm_loadl_epi64(rows.as_ptr().add((at & 56).min(40)).cast());
                _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(bytes))
            })
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
        fn load_columns(rows: [&[f32; LANES]; LANES]) -> [__m256; LANES] {
            // Rows i and i + 4 side by side, half a row of each; then 4 × 4 transposed in both halves.
            op!({
                let [a, b, c, d, e, f, g, h] = rows;
                let mut to = [_mm256_setzero_ps(); LANES];
                let mut first = 0;
                while first < LANES {
                    let (p, q, r, s) =
                        (halves(a, e, first), halves(b, f, first), halves(c, g, first), halves(d, h, first));
                    let (pq, rs) = (_mm256_unpacklo_ps(p, q), _mm256_unpacklo_ps(r, s));
                    let (qp, sr) = (_mm256_unpackhi_ps(p, q), _mm256_unpackhi_ps(r, s));
                    to[first] = _mm256_shuffle_ps::<0b01_00_01_00>(pq, rs);
                    to[first + 1] = _mm256_shuffle_ps::<0b11_10_11_10>(pq, rs);
                    to[first + 2] = _mm256_shuffle_ps::<0b01_00_01_00>(qp, sr);
                    to[first + 3] = _mm256_shuffle_ps::<0b11_10_11_10>(qp, sr);
                    first += 4;
                }
                to
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
        fn min_or_negative(a: __m256, b: __m256) -> __m256 {
            op!(_mm256_castsi256_ps(_mm256_min_epi32(_mm256_castps_si256(a), _mm256_castps_si256(b))))
        }
        #[inline(always)]
        fn max_or_negative(a: __m256, b: __m256) -> __m256 {
            op!(_mm256_castsi256_ps(_mm256_max_epi32(_mm256_castps_si256(a), _mm256_castps_si256(b))))
        }
        #[inline(always)]
        fn splat_u32(x: u32) -> __m256i {
            op!(_mm256_set1_epi32(x as i32))
        }
        #[inline(always)]
        fn permute(x: __m256, order: __m256i, shift: u32) -> __m256 {
            op!(_mm256_permutevar8x32_ps(x, _mm256_srl_epi32(order, _mm_cvtsi32_si128(shift as i32))))
        }
        #[inline(always)]
        fn permute_u32(x: __m256i, order: __m256i, shift: u32) -> __m256i {
            op!(_mm256_permutevar8x32_epi32(x, _mm256_srl_epi32(order, _mm_cvtsi32_si128(shift as i32))))
        }
    };
}
pub(super) use common_lanes;

/// Four numbers of each of two rows, from number 0 or 4 on.
#[inline(always)]
pub(super) fn halves(low: &[f32; LANES], high: &[f32; LANES], at: usize) -> __m256 {
    op!({
        let (low, high) = (low.as_ptr().add(at & 4), high.as_ptr().add(at & 4));
        _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(_mm_loadu_ps(low)), _mm_loadu_ps(high))
    })
}

/// The bits of numbers that are not negative, with the lane in place of the three lowest.
#[inline(always)]
pub(super) fn keys(a: __m256) -> __m256i {
    op!(_mm256_or_si256(
        _mm256_andnot_si256(_mm256_set1_epi32(7), _mm256_castps_si256(a)),
        _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7),
    ))
}

/// The lane that the least of the keys names.
#[inline(always)]
pub(super) fn lane_of_least(key: __m256i) -> usize {
    op!({
        let least = _mm_min_epu32(_mm256_castsi256_si128(key), _mm256_extracti128_si256::<1>(key));
        let least = _mm_min_epu32(least, _mm_shuffle_epi32::<0b01_00_11_10>(least));
        let least = _mm_min_epu32(least, _mm_shuffle_epi32::<0b10_11_00_01>(least));
        (_mm_cvtsi128_si32(least) & 7) as usize
    })
}
