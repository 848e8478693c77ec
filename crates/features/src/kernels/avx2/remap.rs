//! Bilinear sampling by a table: eight pixels from two gathers of four bytes each.

use super::load;
use crate::kernels::remap::{FRACTION_BITS, remap_scalar};
use geometry::GrayImage;
use simd::Avx2;
use std::arch::x86_64::*;

/// Pixels of one step.
const STEP: usize = 32;

/// See `kernels::remap::remap_pixels`.
pub(crate) fn remap_pixels(
    _: Avx2,
    source: &GrayImage,
    offsets: &[u32],
    weights: &[[u8; 4]],
    target: &mut [u8],
) {
    assert!(offsets.len() == target.len() && weights.len() == target.len());
    let width = source.width;
    // A gather reads four bytes, of which two are used; near the end of the image that would be too far.
    let readable = source.data.len().saturating_sub(width + 3).min(i32::MAX as usize - width);
    let steps = offsets.chunks(STEP).zip(weights.chunks(STEP)).zip(target.chunks_mut(STEP));
    for ((offsets, weights), target) in steps {
        let is_inside = offsets.iter().fold(0, |most, &offset| most.max(offset)) < readable as u32;
        if is_inside && target.len() == STEP {
            // SAFETY: all three slices have STEP entries; every offset is below `readable`, so that four bytes at it and a row
            // further lie inside the source.
            unsafe { step(&source.data, width as i32, offsets, weights, target) };
        } else {
            remap_scalar(source, offsets, weights, target);
        }
    }
}

#[target_feature(enable = "avx2")]
unsafe fn step(source: &[u8], width: i32, offsets: &[u32], weights: &[[u8; 4]], target: &mut [u8]) {
    let eight = |first: usize| {
        // SAFETY: see `remap_pixels`.
        let (upper, lower, weights) = unsafe {
            let places = load(offsets.as_ptr().add(first));
            let row_below = _mm256_add_epi32(places, _mm256_set1_epi32(width));
            let base = source.as_ptr().cast();
            (
                _mm256_i32gather_epi32::<1>(base, places),
                _mm256_i32gather_epi32::<1>(base, row_below),
                load(weights.as_ptr().add(first)),
            )
        };
        // Left and right are added with their weights; the two bytes behind them get none.
        let across = _mm256_and_si256(weights, _mm256_set1_epi32(0xffff));
        let (upper, lower) = (_mm256_maddubs_epi16(upper, across), _mm256_maddubs_epi16(lower, across));
        // The upper sum in the lower half of each lane, the lower one in the upper half, like their weights.
        let sums = _mm256_or_si256(upper, _mm256_slli_epi32::<16>(lower));
        let down = _mm256_srli_epi32::<16>(weights);
        let down = _mm256_or_si256(
            _mm256_and_si256(down, _mm256_set1_epi32(0xff)),
            _mm256_slli_epi32::<8>(_mm256_and_si256(down, _mm256_set1_epi32(0xff00))),
        );
        let half = _mm256_set1_epi32(1 << (2 * FRACTION_BITS - 1));
        _mm256_srli_epi32::<10>(_mm256_add_epi32(_mm256_madd_epi16(sums, down), half))
    };
    let first = _mm256_packus_epi32(eight(0), eight(8));
    let second = _mm256_packus_epi32(eight(16), eight(24));
    let bytes = _mm256_packus_epi16(first, second);
    // Packing works on halves of 128 bits: groups of four pixels come as 0 2 4 6 1 3 5 7.
    let order = _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7);
    let bytes = _mm256_permutevar8x32_epi32(bytes, order);
    // SAFETY: `target` has STEP bytes.
    unsafe { super::store(target.as_mut_ptr(), bytes) };
}
