//! First moments of the brightness in a disc, for the orientation of a corner (Rosin's intensity centroid).

#[cfg(target_arch = "x86_64")]
use crate::kernels::avx2;
use simd::Simd;

/// Radius of the disc in pixels.
pub(crate) const RADIUS: usize = 15;
/// Half width of the disc in each row, from the center outwards (OpenCV's table).
pub(crate) const HALF_WIDTH: [usize; RADIUS + 1] =
    [15, 15, 15, 15, 14, 14, 14, 13, 13, 12, 11, 10, 9, 8, 6, 3];

/// `(sum of dx * value, sum of dy * value)` over the disc centered at `offset` in `data`; one value more behind
/// each row must exist.
pub(crate) fn moments(simd: Simd, data: &[u8], stride: usize, offset: usize) -> (i32, i32) {
    #[cfg(target_arch = "x86_64")]
    if let Some(token) = simd.avx2() {
        return avx2::moments::moments(token, data, stride, offset);
    }
    let _ = simd;
    let (mut m10, mut m01) = (0, 0);
    for row in 0..=2 * RADIUS {
        let dy = row as i32 - RADIUS as i32;
        let half = HALF_WIDTH[dy.unsigned_abs() as usize];
        let start = offset + row * stride - RADIUS * stride - half;
        let mut sum = 0;
        for (i, value) in data[start..=start + 2 * half].iter().enumerate() {
            sum += i32::from(*value);
            m10 += (i as i32 - half as i32) * i32::from(*value);
        }
        m01 += dy * sum;
    }
    (m10, m01)
}
