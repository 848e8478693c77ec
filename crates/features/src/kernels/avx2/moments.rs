//! Moments of a disc, a row of 32 pixels at a time.

use super::load;
use crate::kernels::moments::{HALF_WIDTH, RADIUS};
use simd::Avx2;
use std::arch::x86_64::*;

/// Factors of the pixels of each row, from 15 left of the center to 16 right of it: dx, and dy; 0 outside of the disc.
static FACTORS: [[[i8; 32]; 2]; 2 * RADIUS + 1] = factors();

const fn factors() -> [[[i8; 32]; 2]; 2 * RADIUS + 1] {
    let mut factors = [[[0; 32]; 2]; 2 * RADIUS + 1];
    let mut row = 0;
    while row <= 2 * RADIUS {
        let half = HALF_WIDTH[row.abs_diff(RADIUS)];
        let mut column = RADIUS - half;
        while column <= RADIUS + half {
            factors[row][0][column] = column as i8 - RADIUS as i8;
            factors[row][1][column] = row as i8 - RADIUS as i8;
            column += 1;
        }
        row += 1;
    }
    factors
}

/// See `kernels::moments::moments`.
pub(crate) fn moments(_: Avx2, data: &[u8], stride: usize, offset: usize) -> (i32, i32) {
    let reach = RADIUS * stride + RADIUS;
    assert!(offset >= reach && offset + reach + 2 <= data.len());
    // SAFETY: the 31 rows of 32 bytes begin at `offset - reach` and end at `offset + reach + 2`.
    unsafe { sum(data.as_ptr().add(offset - reach), stride) }
}

#[target_feature(enable = "avx2")]
unsafe fn sum(first: *const u8, stride: usize) -> (i32, i32) {
    let ones = _mm256_set1_epi16(1);
    let mut sums = [_mm256_setzero_si256(); 2];
    for (row, factors) in FACTORS.iter().enumerate() {
        // SAFETY: see `moments`; the factors have 32 bytes.
        let (pixels, factors) = unsafe {
            (load(first.add(row * stride)), [load(factors[0].as_ptr()), load(factors[1].as_ptr())])
        };
        for (sum, factor) in sums.iter_mut().zip(factors) {
            *sum = _mm256_add_epi32(*sum, _mm256_madd_epi16(_mm256_maddubs_epi16(pixels, factor), ones));
        }
    }
    (total(sums[0]), total(sums[1]))
}

#[inline]
#[target_feature(enable = "avx2")]
fn total(sums: __m256i) -> i32 {
    let four = _mm_add_epi32(_mm256_castsi256_si128(sums), _mm256_extracti128_si256(sums, 1));
    let two = _mm_add_epi32(four, _mm_shuffle_epi32(four, 0b00_00_11_10));
    _mm_cvtsi128_si32(_mm_add_epi32(two, _mm_shuffle_epi32(two, 0b00_00_00_01)))
}
