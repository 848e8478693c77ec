//! Descriptor: eight comparisons at a time, the pixels fetched by gathers.

use super::store;
use crate::descriptor::Descriptor;
use crate::kernels::brief::REACH;
use crate::pattern::BIT_PATTERN;
use simd::Avx2;
use std::arch::x86_64::*;

/// The pattern by coordinate: x1, y1, x2, y2 of all comparisons.
static COORDINATES: [[f32; 256]; 4] = {
    let mut coordinates = [[0.0; 256]; 4];
    let mut i = 0;
    while i < 256 {
        let mut k = 0;
        while k < 4 {
            coordinates[k][i] = BIT_PATTERN[i][k] as f32;
            k += 1;
        }
        i += 1;
    }
    coordinates
};

/// See `kernels::brief::describe`.
pub(crate) fn describe(_: Avx2, data: &[u8], stride: usize, offset: usize, cos: f32, sin: f32) -> Descriptor {
    let reach = REACH * stride + REACH;
    // Longest pattern point: 13 * sqrt(2) = 18.4, so that coordinates round to 18 at most if this is a rotation.
    let is_rotation = (cos * cos + sin * sin - 1.0).abs() < 1e-3;
    assert!(is_rotation && offset >= reach && offset + reach + 4 <= data.len() && stride < 1 << 24);
    // SAFETY: all places within REACH rows and columns are inside, and four bytes from each of them.
    unsafe { compare(data.as_ptr().add(offset), stride as i32, cos, sin) }
}

#[target_feature(enable = "avx2")]
unsafe fn compare(center: *const u8, stride: i32, cos: f32, sin: f32) -> Descriptor {
    let (cos, sin, stride) = (_mm256_set1_ps(cos), _mm256_set1_ps(sin), _mm256_set1_epi32(stride));
    let places = |k: usize, i: usize| {
        // SAFETY: `i + 8 <= 256`.
        let (x, y) = unsafe {
            (
                _mm256_loadu_ps(COORDINATES[k].as_ptr().add(i)),
                _mm256_loadu_ps(COORDINATES[k + 1].as_ptr().add(i)),
            )
        };
        let turned_x = _mm256_sub_ps(_mm256_mul_ps(x, cos), _mm256_mul_ps(y, sin));
        let turned_y = _mm256_add_ps(_mm256_mul_ps(x, sin), _mm256_mul_ps(y, cos));
        let row = _mm256_mullo_epi32(_mm256_cvtps_epi32(turned_y), stride);
        _mm256_add_epi32(row, _mm256_cvtps_epi32(turned_x))
    };
    let mut words = [0; 4];
    for (n, word) in words.iter_mut().enumerate() {
        let (mut first, mut second) = ([0i32; 64], [0i32; 64]);
        for i in (0..64).step_by(8) {
            // SAFETY: `i + 8 <= 64`.
            unsafe {
                store(first.as_mut_ptr().add(i), places(0, 64 * n + i));
                store(second.as_mut_ptr().add(i), places(2, 64 * n + i));
            }
        }
        for i in 0..64 {
            // SAFETY: see `describe`.
            let (a, b) = unsafe { (*center.offset(first[i] as isize), *center.offset(second[i] as isize)) };
            *word |= u64::from(a < b) << i;
        }
    }
    Descriptor(words)
}
