//! The inner loop of texturing: bilinear look-ups along a parabola through a texture, summed over taps, for up to 16 positions.
//!
//! A vectorised path (AVX2) is chosen at run time; the plain one gives the same numbers and stands beside it for all other machines.
#![allow(unsafe_code)]

use simd::Simd;

use crate::texture::Plane;

/// Positions per call.
pub(crate) const LANES: usize = 16;

/// A parabola in 16.16 texels: position k is `start + k step + k (k - 1) / 2 bend` in u and v; taps lie at `tap_first + i tap_step`
/// from it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Walk {
    pub(crate) start: [i32; 2],
    pub(crate) step: [i32; 2],
    pub(crate) bend: [i32; 2],
    pub(crate) tap_first: [i32; 2],
    pub(crate) tap_step: [i32; 2],
}

impl Walk {
    /// Texture coordinates of position `k`.
    #[inline(always)]
    pub(crate) fn at(&self, k: i32) -> [i32; 2] {
        let triangle = k.wrapping_mul(k - 1) / 2;
        [0, 1].map(|i| {
            let bent = self.bend[i].wrapping_mul(triangle);
            self.start[i].wrapping_add(self.step[i].wrapping_mul(k)).wrapping_add(bent)
        })
    }
}

/// Sums of `taps` look-ups (value times 256) at positions 0..n of a walk; later entries are arbitrary.
#[inline]
pub(crate) fn sums(plane: Plane<'_>, walk: &Walk, taps: usize, n: usize) -> [i32; LANES] {
    #[cfg(target_arch = "x86_64")]
    if Simd::detect().avx2().is_some() {
        // SAFETY: the processor has AVX2.
        return unsafe { avx2::sums(plane, walk, taps, n) };
    }
    sums_plain(plane, walk, taps, n)
}

fn sums_plain(plane: Plane<'_>, walk: &Walk, taps: usize, n: usize) -> [i32; LANES] {
    let mut out = [0; LANES];
    for (k, out) in out.iter_mut().enumerate().take(n) {
        let [mut u, mut v] = [0, 1].map(|i| walk.at(k as i32)[i].wrapping_add(walk.tap_first[i]));
        for _ in 0..taps {
            *out += plane.bilinear(u, v);
            (u, v) = (u.wrapping_add(walk.tap_step[0]), v.wrapping_add(walk.tap_step[1]));
        }
    }
    out
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::{LANES, Plane, Walk};
    use std::arch::x86_64::*;

    /// As `sums_plain`, eight positions at a time.
    ///
    /// # Safety
    /// The processor must have AVX2.
    #[target_feature(enable = "avx2")]
    pub(super) unsafe fn sums(plane: Plane<'_>, walk: &Walk, taps: usize, n: usize) -> [i32; LANES] {
        let mut out = [0; LANES];
        let mut first = 0;
        while first < n.min(LANES) {
            let k =
                _mm256_add_epi32(_mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7), _mm256_set1_epi32(first as i32));
            let one_less = _mm256_sub_epi32(k, _mm256_set1_epi32(1));
            let triangle = _mm256_srai_epi32::<1>(_mm256_mullo_epi32(k, one_less));
            let position = |i: usize| {
                let straight = _mm256_mullo_epi32(_mm256_set1_epi32(walk.step[i]), k);
                let bent = _mm256_mullo_epi32(_mm256_set1_epi32(walk.bend[i]), triangle);
                let start = _mm256_set1_epi32(walk.start[i].wrapping_add(walk.tap_first[i]));
                _mm256_add_epi32(_mm256_add_epi32(start, straight), bent)
            };
            let (mut u, mut v) = (position(0), position(1));
            let mut sum = _mm256_setzero_si256();
            for _ in 0..taps {
                // SAFETY: the processor has AVX2 (this function's condition).
                sum = _mm256_add_epi32(sum, unsafe { bilinear(plane, u, v) });
                u = _mm256_add_epi32(u, _mm256_set1_epi32(walk.tap_step[0]));
                v = _mm256_add_epi32(v, _mm256_set1_epi32(walk.tap_step[1]));
            }
            let Some(eight) = out.get_mut(first..first + 8) else { break };
            // SAFETY: `eight` has room for eight 32-bit numbers; the store needs no alignment.
            unsafe { _mm256_storeu_si256(eight.as_mut_ptr().cast(), sum) };
            first += 8;
        }
        out
    }

    /// As `Plane::bilinear`, for eight positions.
    ///
    /// # Safety
    /// The processor must have AVX2.
    #[target_feature(enable = "avx2")]
    #[inline]
    unsafe fn bilinear(plane: Plane<'_>, u: __m256i, v: __m256i) -> __m256i {
        let shift = _mm_cvtsi32_si128(plane.shift as i32);
        let half = _mm256_set1_epi32(0x8000);
        let u = _mm256_sub_epi32(_mm256_sra_epi32(u, shift), half);
        let v = _mm256_sub_epi32(_mm256_sra_epi32(v, shift), half);
        let byte = _mm256_set1_epi32(0xff);
        let (fu, fv) = (
            _mm256_and_si256(_mm256_srai_epi32::<8>(u), byte),
            _mm256_and_si256(_mm256_srai_epi32::<8>(v), byte),
        );
        let x = _mm256_and_si256(_mm256_srai_epi32::<16>(u), _mm256_set1_epi32(plane.width_mask));
        let y = _mm256_and_si256(_mm256_srai_epi32::<16>(v), _mm256_set1_epi32(plane.height_mask));
        let stride = _mm256_set1_epi32(plane.stride);
        let upper = _mm256_add_epi32(_mm256_mullo_epi32(y, stride), x);
        let lower = _mm256_add_epi32(upper, stride);
        let data = plane.texels().as_ptr().cast::<i32>();
        // SAFETY: x and y are masked to the plane's size, whose rows and columns are followed by one more, and `Plane` holds at least
        // four bytes from every such index on.
        let (ab, cd) =
            unsafe { (_mm256_i32gather_epi32::<1>(data, upper), _mm256_i32gather_epi32::<1>(data, lower)) };
        // Upper row in the low halves, lower row in the high halves, as in the plain path.
        let low = |g: __m256i| _mm256_and_si256(g, byte);
        let left = _mm256_or_si256(low(ab), _mm256_slli_epi32::<16>(low(cd)));
        let second = |g: __m256i| _mm256_and_si256(_mm256_srli_epi32::<8>(g), byte);
        let right = _mm256_or_si256(second(ab), _mm256_slli_epi32::<16>(second(cd)));
        let fu_both = _mm256_or_si256(fu, _mm256_slli_epi32::<16>(fu));
        let rest = _mm256_sub_epi16(_mm256_set1_epi16(256), fu_both);
        let rows = _mm256_add_epi16(_mm256_mullo_epi16(left, rest), _mm256_mullo_epi16(right, fu_both));
        let top = _mm256_and_si256(rows, _mm256_set1_epi32(0xffff));
        let bottom = _mm256_srli_epi32::<16>(rows);
        let rest = _mm256_sub_epi32(_mm256_set1_epi32(256), fv);
        let blend = _mm256_add_epi32(_mm256_mullo_epi32(top, rest), _mm256_mullo_epi32(bottom, fv));
        _mm256_srai_epi32::<8>(blend)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::Texture;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn both_paths_give_the_same_numbers() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for (width, height) in [(64, 16), (1, 8), (256, 256)] {
            let texture = Texture::cut_out(width, height, |x, y| {
                [((x * 31 + y * 17) % 256) as f32, ((x * 7 + y * 3) % 256) as f32]
            });
            for _ in 0..300 {
                let level = &texture.levels[rng.random_range(0..texture.levels.len())];
                let mut two = || [rng.random::<i32>() >> 3, rng.random::<i32>() >> 3];
                let small = |v: [i32; 2]| v.map(|v| v >> 10);
                let walk = Walk {
                    start: two(),
                    step: small(two()),
                    bend: small(two()),
                    tap_first: two(),
                    tap_step: two(),
                };
                let (taps, n) = (rng.random_range(1..5), rng.random_range(1..=LANES));
                for plane in [level.gray(), level.alpha()] {
                    let (fast, plain) = (sums(plane, &walk, taps, n), sums_plain(plane, &walk, taps, n));
                    assert_eq!(fast[..n], plain[..n]);
                }
            }
        }
    }
}
