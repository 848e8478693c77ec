//! Bilinear sampling at places given by a table, in integers: weights of five bits each way, rounded half up at the end.

#[cfg(target_arch = "x86_64")]
use crate::kernels::avx2;
use geometry::GrayImage;
use simd::Simd;

/// Bits of a weight.
pub(crate) const FRACTION_BITS: u32 = 5;
/// Weight of a whole pixel.
pub(crate) const ONE: u8 = 1 << FRACTION_BITS;

/// The pixels at these places: `offsets` names the upper left one of four source pixels, `weights` are those of left, right,
/// upper and lower, each pair with the sum [`ONE`] or, for black, zero.
///
/// # Panics
/// When lengths differ or a place lies outside of the source, which must have two rows and columns.
pub(crate) fn remap_pixels(
    simd: Simd,
    source: &GrayImage,
    offsets: &[u32],
    weights: &[[u8; 4]],
    target: &mut [u8],
) {
    assert!(offsets.len() == target.len() && weights.len() == target.len());
    #[cfg(target_arch = "x86_64")]
    if let Some(token) = simd.avx2() {
        return avx2::remap::remap_pixels(token, source, offsets, weights, target);
    }
    let _ = simd;
    remap_scalar(source, offsets, weights, target);
}

/// See [`remap_pixels`].
pub(crate) fn remap_scalar(source: &GrayImage, offsets: &[u32], weights: &[[u8; 4]], target: &mut [u8]) {
    let width = source.width;
    for ((&offset, weights), pixel) in offsets.iter().zip(weights).zip(target) {
        let place = offset as usize;
        let [left, right, upper, lower] = weights.map(u32::from);
        let across = |row: &[u8]| u32::from(row[0]) * left + u32::from(row[1]) * right;
        let sum = across(&source.data[place..place + 2]) * upper
            + across(&source.data[place + width..place + width + 2]) * lower;
        *pixel = ((sum + (1 << (2 * FRACTION_BITS - 1))) >> (2 * FRACTION_BITS)) as u8;
    }
}
