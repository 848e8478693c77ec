//! Gaussian blur, 7 x 7, sigma 2 px, in integers, equal to OpenCV's 8-bit `GaussianBlur` bit for bit.

#[cfg(target_arch = "x86_64")]
use crate::kernels::avx2;
use crate::plane::{Plane, SLACK, reflect};
use simd::Simd;

/// The kernel in units of 1/256, from the outside to the center (rounded so that the sum is exactly one).
pub(crate) const WEIGHTS: [i32; 4] = [18, 34, 48, 56];
/// What is subtracted from the sums down the column.
const OFFSET: i32 = 1 << 15;
/// What makes up for it in the whole sum, and half a unit.
pub(crate) const ROUND: i32 = OFFSET * 256 + (1 << 15);
/// Free places before the first value of a line.
const MARGIN: usize = 16;

/// Writes the blurred `source` to `target`; borders are mirrored.
pub(crate) fn gaussian(simd: Simd, source: &Plane, line: &mut Vec<i16>, target: &mut Plane) {
    let (width, height) = (source.width(), source.height());
    target.resize(width, height);
    line.resize(width + MARGIN + SLACK, 0);
    for y in 0..height {
        let rows: [&[u8]; 7] =
            std::array::from_fn(|i| source.row(reflect(y as isize + i as isize - 3, height)));
        blur_down(simd, &rows, width, &mut line[MARGIN..]);
        for i in 1..=3 {
            line[MARGIN - i] = line[MARGIN + reflect(-(i as isize), width)];
            line[MARGIN + width - 1 + i] = line[MARGIN + reflect((width - 1 + i) as isize, width)];
        }
        blur_across(simd, &line[MARGIN - 3..], width, target.row_mut(y));
    }
}

/// Sum down the column in units of 1/256, less 32768 so that it fits 16 bits with a sign.
fn blur_down(simd: Simd, rows: &[&[u8]; 7], width: usize, line: &mut [i16]) {
    #[cfg(target_arch = "x86_64")]
    if let Some(token) = simd.avx2() {
        return avx2::blur::blur_down(token, rows, width, line);
    }
    let _ = simd;
    for (x, value) in line[..width].iter_mut().enumerate() {
        let pair = |i: usize| i32::from(rows[i][x]) + i32::from(rows[6 - i][x]);
        let center = WEIGHTS[3] * i32::from(rows[3][x]);
        let sum = WEIGHTS[0] * pair(0) + WEIGHTS[1] * pair(1) + WEIGHTS[2] * pair(2) + center;
        *value = (sum - OFFSET) as i16;
    }
}

/// Sum along the line (`line[x + 3]` belongs to `row[x]`), rounded to whole values.
fn blur_across(simd: Simd, line: &[i16], width: usize, row: &mut [u8]) {
    #[cfg(target_arch = "x86_64")]
    if let Some(token) = simd.avx2() {
        return avx2::blur::blur_across(token, line, width, row);
    }
    let _ = simd;
    for (x, pixel) in row[..width].iter_mut().enumerate() {
        let at = |i: usize| i32::from(line[x + i]);
        let pair = |i: usize| at(i) + at(6 - i);
        let sum = WEIGHTS[0] * pair(0) + WEIGHTS[1] * pair(1) + WEIGHTS[2] * pair(2) + WEIGHTS[3] * at(3);
        *pixel = ((sum + ROUND) >> 16) as u8;
    }
}
