//! Bilinear reduction: eight pixels across from one load of 16, 32 pixels down at a time.

use super::{load, store};
use crate::kernels::resize::{Block, Blocks};
use simd::Avx2;
use std::arch::x86_64::*;

/// See `kernels::resize::resize_row`.
pub(crate) fn resize_row(_: Avx2, source: &[u8], blocks: &Blocks, line: &mut [i16]) {
    assert!(line.len() >= blocks.list().len() * 8 && source.len() >= blocks.reach());
    // SAFETY: each block reads 16 bytes at its base and writes eight values at eight times its index.
    unsafe { resize_blocks(source.as_ptr(), blocks.list(), line.as_mut_ptr()) }
}

#[target_feature(enable = "avx2")]
unsafe fn resize_blocks(source: *const u8, blocks: &[Block], line: *mut i16) {
    let half = _mm256_set1_epi32(8);
    let eight = |block: &Block| {
        // SAFETY: see `resize_row`; the arrays of a block have the size of what is loaded.
        let (pixels, shuffle, weights) = unsafe {
            let pixels = _mm_loadu_si128(source.add(block.base as usize).cast());
            (pixels, _mm_loadu_si128(block.shuffle.as_ptr().cast()), load(block.weights.as_ptr()))
        };
        let pairs = _mm256_cvtepu8_epi16(_mm_shuffle_epi8(pixels, shuffle));
        _mm256_srai_epi32(_mm256_add_epi32(_mm256_madd_epi16(pairs, weights), half), 4)
    };
    for (i, pair) in blocks.chunks_exact(2).enumerate() {
        let values = _mm256_packs_epi32(eight(&pair[0]), eight(&pair[1]));
        // SAFETY: see `resize_row`.
        unsafe { store(line.add(16 * i), _mm256_permute4x64_epi64(values, 0b11_01_10_00)) };
    }
}

/// See `kernels::resize::blend_rows`.
pub(crate) fn blend_rows(_: Avx2, lines: &[Vec<i16>; 2], weight: i16, width: usize, row: &mut [u8]) {
    assert!(lines.iter().all(|l| l.len() >= width + 32) && row.len() >= width + 32);
    // SAFETY: blocks of 32 start before `width`, all slices are that much longer.
    unsafe { blend(lines[0].as_ptr(), lines[1].as_ptr(), weight, width, row.as_mut_ptr()) }
}

#[target_feature(enable = "avx2")]
unsafe fn blend(first: *const i16, second: *const i16, weight: i16, width: usize, row: *mut u8) {
    let weight = _mm256_set1_epi16(weight);
    let half = _mm256_set1_epi16(64);
    for x in (0..width).step_by(32) {
        let sixteen = |x: usize| {
            // SAFETY: see `blend_rows`.
            let (a, b) = unsafe { (load(first.add(x)), load(second.add(x))) };
            let value = _mm256_add_epi16(a, _mm256_mulhrs_epi16(_mm256_sub_epi16(b, a), weight));
            _mm256_srai_epi16(_mm256_add_epi16(value, half), 7)
        };
        let bytes = _mm256_packus_epi16(sixteen(x), sixteen(x + 16));
        // SAFETY: see `blend_rows`.
        unsafe { store(row.add(x), _mm256_permute4x64_epi64(bytes, 0b11_01_10_00)) };
    }
}
