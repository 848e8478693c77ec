//! The inner loops on pixels: each has a scalar form and, where the processor has it, an AVX2 form with equal bits.

#[cfg(target_arch = "x86_64")]
mod avx2;
pub(crate) mod blur;
pub(crate) mod brief;
pub(crate) mod dispatch;
pub(crate) mod fast;
pub(crate) mod minimum;
pub(crate) mod moments;
pub(crate) mod normal;
pub(crate) mod remap;
pub(crate) mod resize;
pub(crate) mod sad;

#[cfg(test)]
mod tests;

/// Which form of the kernels runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Simd {
    avx2: Option<Avx2>,
}

/// Proof that the processor has AVX2 and the population count instruction; only [`Simd::detect`] makes one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Avx2(());

impl Simd {
    /// The fastest form that this processor can run.
    #[inline]
    pub(crate) fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        let found = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("popcnt");
        #[cfg(not(target_arch = "x86_64"))]
        let found = false;
        Self { avx2: found.then_some(Avx2(())) }
    }

    /// The scalar form, for comparison.
    #[cfg(test)]
    pub(crate) fn scalar() -> Self {
        Self { avx2: None }
    }

    /// The permission to use AVX2, where there is one.
    #[inline]
    pub(crate) fn avx2(self) -> Option<Avx2> {
        self.avx2
    }
}
