//! Sums of the normal equations, a row of 16 pixels at a time.

use super::{load, store};
use crate::kernels::normal::{IntegerSums, LANES, LIMIT, Patch, Row, SIDE, WEIGHTS};
use simd::Avx2;
use std::arch::x86_64::*;

/// See `kernels::normal::sums`.
pub(crate) fn sums(_: Avx2, patch: &Patch, rows: &[Row<'_>; SIDE], offset: i16, robust: bool) -> IntegerSums {
    assert!(rows.iter().all(|row| row.pixels.len() > LANES));
    // SAFETY: rows have 17 pixels, those of the patch and of the weights 16 values.
    unsafe { add_rows(patch, rows, offset, robust) }
}

/// Eight lanes hold the sums of two pixels each. Sums weighted by the number of rows left are made by adding up the sums so
/// far after each row. With differences below 64 gray levels and derivatives below 128 no lane overflows.
#[target_feature(enable = "avx2")]
unsafe fn add_rows(patch: &Patch, rows: &[Row<'_>; SIDE], offset: i16, robust: bool) -> IntegerSums {
    let offset = _mm256_set1_epi16(offset);
    let limit = _mm256_set1_epi16(LIMIT as i16);
    let minus_limit = _mm256_set1_epi16(-LIMIT as i16);
    let all = _mm256_set1_epi16(i16::MAX);
    let ones = _mm256_set1_epi16(1);
    let zero = _mm256_setzero_si256();
    let (mut gg, mut g, mut ge) = ([zero; 3], [zero; 2], [zero; 2]);
    let (mut one, mut sum_e, mut abs) = (zero, zero, zero);
    for (j, row) in rows.iter().enumerate() {
        // SAFETY: see `sums`.
        let (a, b, value, gradient, gauss) = unsafe {
            let first = row.pixels.as_ptr();
            (
                _mm256_cvtepu8_epi16(_mm_loadu_si128(first.cast())),
                _mm256_cvtepu8_epi16(_mm_loadu_si128(first.add(1).cast())),
                load(patch.values[j].as_ptr()),
                load(patch.gradients[j].as_ptr()),
                load(WEIGHTS[j].as_ptr()),
            )
        };
        let part = _mm256_mullo_epi16(_mm256_sub_epi16(b, a), _mm256_set1_epi16(row.fraction));
        let right = _mm256_add_epi16(_mm256_slli_epi16(a, 7), part);
        let e = _mm256_subs_epi16(_mm256_adds_epi16(right, offset), value);
        let e = _mm256_max_epi16(_mm256_min_epi16(e, limit), minus_limit);
        let trust = if robust {
            let share = _mm256_slli_epi16(e, 2);
            _mm256_subs_epi16(all, _mm256_mulhrs_epi16(share, share))
        } else {
            all
        };
        let weight = _mm256_mulhrs_epi16(trust, gauss);
        let wg = _mm256_mulhrs_epi16(weight, gradient);
        let weight = _mm256_srai_epi16(weight, 3);
        gg[0] = _mm256_add_epi32(gg[0], _mm256_madd_epi16(wg, gradient));
        gg[1] = _mm256_add_epi32(gg[1], gg[0]);
        gg[2] = _mm256_add_epi32(gg[2], gg[1]);
        g[0] = _mm256_add_epi32(g[0], _mm256_madd_epi16(wg, ones));
        g[1] = _mm256_add_epi32(g[1], g[0]);
        ge[0] = _mm256_add_epi32(ge[0], _mm256_madd_epi16(wg, e));
        ge[1] = _mm256_add_epi32(ge[1], ge[0]);
        one = _mm256_add_epi32(one, _mm256_madd_epi16(weight, ones));
        sum_e = _mm256_add_epi32(sum_e, _mm256_madd_epi16(weight, e));
        abs = _mm256_add_epi32(abs, _mm256_madd_epi16(weight, _mm256_abs_epi16(e)));
    }
    IntegerSums {
        gg: [total(gg[0]), total(gg[1]), total(gg[2])],
        g: [total(g[0]), total(g[1])],
        ge: [total(ge[0]), total(ge[1])],
        one: total(one),
        e: total(sum_e),
        abs: total(abs),
    }
}

#[inline]
#[target_feature(enable = "avx2")]
fn total(lanes: __m256i) -> i64 {
    let low = _mm256_cvtepi32_epi64(_mm256_castsi256_si128(lanes));
    let high = _mm256_cvtepi32_epi64(_mm256_extracti128_si256(lanes, 1));
    let mut four = [0i64; 4];
    // SAFETY: the array has the size of the vector.
    unsafe { store(four.as_mut_ptr(), _mm256_add_epi64(low, high)) };
    (four[0] + four[1]) + (four[2] + four[3])
}
