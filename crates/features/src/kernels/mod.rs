//! The inner loops on pixels: each has a scalar form and, where the processor has it, an AVX2 form with equal bits.

#[cfg(target_arch = "x86_64")]
mod avx2;
pub(crate) mod blur;
pub(crate) mod brief;
pub(crate) mod fast;
pub(crate) mod minimum;
pub(crate) mod moments;
pub(crate) mod normal;
pub(crate) mod remap;
pub(crate) mod resize;
pub(crate) mod sad;

#[cfg(test)]
mod tests;
