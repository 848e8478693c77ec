//! Costs of a patch along a row, two rows of 16 pixels per vector.

use super::{load, store};
use crate::kernels::sad::{HEIGHT, Scratch, WIDTH};
use simd::Avx2;
use std::arch::x86_64::*;

/// See `kernels::sad::costs_along_row`; the rows begin at the first pixel of the patch and of the strip.
pub(crate) fn costs(
    _: Avx2,
    patch: &[&[u8]; HEIGHT],
    strip: &[&[u8]; HEIGHT],
    n: usize,
    scratch: &mut Scratch,
    costs: &mut Vec<u16>,
) {
    // Whole vectors of 16 places are written.
    let padded = n.next_multiple_of(16);
    assert!(patch.iter().all(|row| row.len() >= WIDTH) && strip.iter().all(|row| row.len() >= padded + 32));
    scratch.columns.resize(padded + 32, 0);
    for bias in &mut scratch.biases {
        bias.resize(padded, 0);
    }
    costs.resize(n, 0);
    // SAFETY: the lengths are as stated at the functions.
    unsafe {
        sum_columns(strip, padded + 16, &mut scratch.columns);
        find_biases(patch, padded, scratch);
        sum_differences(patch, strip, scratch, costs);
    }
}

/// # Safety
/// `n` is a multiple of 16; rows and sums have that length.
#[target_feature(enable = "avx2")]
unsafe fn sum_columns(strip: &[&[u8]; HEIGHT], n: usize, columns: &mut [u16]) {
    for at in (0..n).step_by(16) {
        let mut sum = _mm256_setzero_si256();
        for row in strip {
            // SAFETY: the caller's.
            let pixels = unsafe { _mm_loadu_si128(row.as_ptr().add(at).cast()) };
            sum = _mm256_add_epi16(sum, _mm256_cvtepu8_epi16(pixels));
        }
        // SAFETY: the caller's.
        unsafe { store(columns.as_mut_ptr().add(at), sum) };
    }
}

/// # Safety
/// `n` is a multiple of 16; biases have that length, column sums 16 more, rows of the patch 16.
#[target_feature(enable = "avx2")]
unsafe fn find_biases(patch: &[&[u8]; HEIGHT], n: usize, scratch: &mut Scratch) {
    let mut eight = _mm_setzero_si128();
    for row in patch {
        // SAFETY: the caller's.
        let pixels = unsafe { _mm_loadu_si128(row.as_ptr().cast()) };
        eight = _mm_add_epi32(eight, _mm_sad_epu8(pixels, _mm_setzero_si128()));
    }
    let patch_sum = _mm_cvtsi128_si32(_mm_add_epi32(eight, _mm_unpackhi_epi64(eight, eight)));
    // Sums of 128 bytes fit 16 bits with a sign.
    let rounded = _mm256_set1_epi16((patch_sum + 64) as i16);
    let zero = _mm256_setzero_si256();
    for at in (0..n).step_by(16) {
        let mut sum = zero;
        for i in 0..WIDTH {
            // SAFETY: the caller's.
            sum = _mm256_add_epi16(sum, unsafe { load(scratch.columns.as_ptr().add(at + i)) });
        }
        let bias = _mm256_srai_epi16(_mm256_sub_epi16(rounded, sum), 7);
        let both = _mm256_packus_epi16(bias, _mm256_sub_epi16(zero, bias));
        let both = _mm256_permute4x64_epi64(both, 0b11_01_10_00);
        // SAFETY: the caller's.
        unsafe {
            _mm_storeu_si128(scratch.biases[0].as_mut_ptr().add(at).cast(), _mm256_castsi256_si128(both));
            _mm_storeu_si128(
                scratch.biases[1].as_mut_ptr().add(at).cast(),
                _mm256_extracti128_si256(both, 1),
            );
        }
    }
}

/// # Safety
/// Rows of the strip have 16 more than the number of costs, those of the patch 16, biases the number of costs.
#[target_feature(enable = "avx2")]
unsafe fn sum_differences(
    patch: &[&[u8]; HEIGHT],
    strip: &[&[u8]; HEIGHT],
    scratch: &Scratch,
    costs: &mut [u16],
) {
    // SAFETY: the caller's.
    let two_rows = |rows: &[&[u8]; HEIGHT], i: usize, at: usize| unsafe {
        let low = _mm_loadu_si128(rows[2 * i].as_ptr().add(at).cast());
        let high = _mm_loadu_si128(rows[2 * i + 1].as_ptr().add(at).cast());
        _mm256_inserti128_si256(_mm256_castsi128_si256(low), high, 1)
    };
    let patch = [two_rows(patch, 0, 0), two_rows(patch, 1, 0), two_rows(patch, 2, 0), two_rows(patch, 3, 0)];
    for (at, cost) in costs.iter_mut().enumerate() {
        let less = _mm256_set1_epi8(scratch.biases[0][at] as i8);
        let more = _mm256_set1_epi8(scratch.biases[1][at] as i8);
        let mut sum = _mm256_setzero_si256();
        for (i, &pixels) in patch.iter().enumerate() {
            let moved = _mm256_adds_epu8(_mm256_subs_epu8(pixels, less), more);
            sum = _mm256_add_epi32(sum, _mm256_sad_epu8(moved, two_rows(strip, i, at)));
        }
        let two = _mm_add_epi32(_mm256_castsi256_si128(sum), _mm256_extracti128_si256(sum, 1));
        let one = _mm_add_epi32(two, _mm_unpackhi_epi64(two, two));
        *cost = _mm_cvtsi128_si32(one) as u16;
    }
}
