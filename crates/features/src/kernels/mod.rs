//! The inner loops on pixels: each has a scalar form and, where the processor has it, an AVX2 form with equal bits.

pub(crate) mod blur;
pub(crate) mod brief;
pub(crate) mod dispatch;
pub(crate) mod fast;
pub(crate) mod moments;
pub(crate) mod resize;

/// Which form of the kernels runs; only [`Simd::detect`] makes one that permits AVX2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Simd {
    avx2: bool,
}

impl Simd {
    /// The fastest form that this processor can run.
    pub(crate) fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        let avx2 = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("popcnt");
        #[cfg(not(target_arch = "x86_64"))]
        let avx2 = false;
        Self { avx2 }
    }

    /// The scalar form, for comparison.
    #[cfg(test)]
    pub(crate) fn scalar() -> Self {
        Self { avx2: false }
    }

    /// Whether AVX2 and the population count instruction may be used.
    #[inline]
    pub(crate) fn has_avx2(self) -> bool {
        self.avx2
    }
}
