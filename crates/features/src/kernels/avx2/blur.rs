//! The two passes of the 7 x 7 Gaussian, 32 pixels at a time.

use super::{load, store};
use crate::kernels::blur::{ROUND, WEIGHTS};
use simd::Avx2;
use std::arch::x86_64::*;

/// All weights, and a zero so that they make four pairs.
const W: [i32; 8] = [WEIGHTS[0], WEIGHTS[1], WEIGHTS[2], WEIGHTS[3], WEIGHTS[2], WEIGHTS[1], WEIGHTS[0], 0];

/// See `kernels::blur::blur_down`.
pub(crate) fn blur_down(_: Avx2, rows: &[&[u8]; 7], width: usize, line: &mut [i16]) {
    assert!(rows.iter().all(|r| r.len() >= width + 32) && line.len() >= width + 32);
    // SAFETY: blocks of 32 start before `width`, all slices are that much longer.
    unsafe { sum_down(rows.map(<[u8]>::as_ptr), width, line.as_mut_ptr()) }
}

#[target_feature(enable = "avx2")]
unsafe fn sum_down(rows: [*const u8; 7], width: usize, line: *mut i16) {
    let mut weights = [_mm256_setzero_si256(); 4];
    for (i, weight) in weights.iter_mut().enumerate() {
        *weight = _mm256_set1_epi16((W[2 * i] | W[2 * i + 1] << 8) as i16);
    }
    let offset = _mm256_set1_epi16(i16::MIN);
    for x in (0..width).step_by(32) {
        // SAFETY: see `blur_down`.
        let value = |i: usize| if i < 7 { unsafe { load(rows[i].add(x)) } } else { _mm256_setzero_si256() };
        let (mut low, mut high) = (offset, offset);
        for (i, &weight) in weights.iter().enumerate() {
            let (a, b) = (value(2 * i), value(2 * i + 1));
            low = _mm256_add_epi16(low, _mm256_maddubs_epi16(_mm256_unpacklo_epi8(a, b), weight));
            high = _mm256_add_epi16(high, _mm256_maddubs_epi16(_mm256_unpackhi_epi8(a, b), weight));
        }
        // SAFETY: see `blur_down`.
        unsafe {
            store(line.add(x), _mm256_permute2x128_si256(low, high, 0x20));
            store(line.add(x + 16), _mm256_permute2x128_si256(low, high, 0x31));
        }
    }
}

/// See `kernels::blur::blur_across`.
pub(crate) fn blur_across(_: Avx2, line: &[i16], width: usize, row: &mut [u8]) {
    assert!(line.len() >= width + 40 && row.len() >= width + 32);
    // SAFETY: blocks of 32 start before `width`; the line is read up to 39 places behind the start of a block.
    unsafe { sum_across(line.as_ptr(), width, row.as_mut_ptr()) }
}

#[target_feature(enable = "avx2")]
unsafe fn sum_across(line: *const i16, width: usize, row: *mut u8) {
    let mut weights = [_mm256_setzero_si256(); 4];
    for (i, weight) in weights.iter_mut().enumerate() {
        *weight = _mm256_set1_epi32(W[2 * i] | W[2 * i + 1] << 16);
    }
    let round = _mm256_set1_epi32(ROUND);
    for x in (0..width).step_by(32) {
        // Sums of every second pixel, the first one at `start`.
        let sums = |start: usize| {
            let mut sum = round;
            for (i, &weight) in weights.iter().enumerate() {
                // SAFETY: see `blur_across`.
                let pairs = unsafe { load(line.add(start + 2 * i)) };
                sum = _mm256_add_epi32(sum, _mm256_madd_epi16(pairs, weight));
            }
            sum
        };
        let sixteen = |start: usize| {
            let even = _mm256_srli_epi32(sums(start), 16);
            _mm256_blend_epi16(even, sums(start + 1), 0b1010_1010)
        };
        let bytes = _mm256_packus_epi16(sixteen(x), sixteen(x + 16));
        // SAFETY: see `blur_across`.
        unsafe { store(row.add(x), _mm256_permute4x64_epi64(bytes, 0b11_01_10_00)) };
    }
}
