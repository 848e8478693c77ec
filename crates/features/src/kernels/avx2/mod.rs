//! AVX2 forms of the kernels. Each entry point takes the token that proves AVX2 and checks the lengths of its slices once.
#![allow(unsafe_code)]

pub(crate) mod blur;
pub(crate) mod brief;
pub(crate) mod fast;
pub(crate) mod moments;
pub(crate) mod normal;
pub(crate) mod remap;
pub(crate) mod resize;
pub(crate) mod sad;

use std::arch::x86_64::{__m256i, _mm256_loadu_si256, _mm256_storeu_si256};

/// Loads 32 bytes from any address.
///
/// # Safety
/// They must be readable.
#[inline]
#[target_feature(enable = "avx2")]
unsafe fn load<T>(place: *const T) -> __m256i {
    // SAFETY: the caller's.
    unsafe { _mm256_loadu_si256(place.cast()) }
}

/// Stores 32 bytes to any address.
///
/// # Safety
/// They must be writable.
#[inline]
#[target_feature(enable = "avx2")]
unsafe fn store<T>(place: *mut T, value: __m256i) {
    // SAFETY: the caller's.
    unsafe { _mm256_storeu_si256(place.cast(), value) }
}
