//! The rotated comparisons of the ORB descriptor on a blurred image.

use crate::descriptor::Descriptor;
#[cfg(target_arch = "x86_64")]
use crate::kernels::avx2;
use crate::pattern::BIT_PATTERN;
use simd::Simd;

/// Largest distance in rows or columns of a rotated, rounded pattern point from the center.
pub(crate) const REACH: usize = 19;

/// The descriptor at `offset` in `data` with the pattern turned by the angle of this cosine and sine; coordinates are
/// rounded half to even. All values within [`REACH`] rows and columns must exist, and three more behind the last.
pub(crate) fn describe(
    simd: Simd,
    data: &[u8],
    stride: usize,
    offset: usize,
    cos: f32,
    sin: f32,
) -> Descriptor {
    #[cfg(target_arch = "x86_64")]
    if let Some(token) = simd.avx2() {
        return avx2::brief::describe(token, data, stride, offset, cos, sin);
    }
    let _ = simd;
    let value = |x: i8, y: i8| {
        let (x, y) = (f32::from(x), f32::from(y));
        let dx = (x * cos - y * sin).round_ties_even() as isize;
        let dy = (x * sin + y * cos).round_ties_even() as isize;
        data[(offset as isize + dy * stride as isize + dx) as usize]
    };
    let mut words = [0; 4];
    for (i, [x1, y1, x2, y2]) in BIT_PATTERN.into_iter().enumerate() {
        words[i / 64] |= u64::from(value(x1, y1) < value(x2, y2)) << (i % 64);
    }
    Descriptor(words)
}
