//! One body, compiled twice: for the target's baseline and for AVX2, chosen at run time.
//!
//! No fused multiply-add and no re-ordering: both give the same bits, only more lanes at once.

#![allow(unsafe_code)]

/// A computation whose body shall be compiled for the wider instruction set; `run` must be `#[inline(always)]`.
pub(crate) trait Kernel {
    /// What it returns.
    type Output;
    /// The computation.
    fn run(self) -> Self::Output;
}

/// The instruction set to compile for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lanes {
    /// Whatever the target guarantees.
    Baseline,
    /// Four f64 per register.
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2Token),
}

/// Proof that this processor has AVX2.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Avx2Token(());

impl Lanes {
    /// The widest that this processor has.
    pub(crate) fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") {
            return Self::Avx2(Avx2Token(()));
        }
        Self::Baseline
    }

    /// Runs the kernel with these instructions.
    pub(crate) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self {
            Self::Baseline => kernel.run(),
            #[cfg(target_arch = "x86_64")]
            // SAFETY: a token exists only where `detect` has found AVX2.
            Self::Avx2(_) => unsafe { run_avx2(kernel) },
        }
    }
}

/// # Safety
/// The processor must have AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
unsafe fn run_avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bundle::refine_bundle_with;
    use crate::common::{StreetOptions, displaced, frame, random, rig, small_motion, street};
    use crate::pose::refine_pose_with;
    use crate::{BundleOptions, PoseOptions};

    /// On a processor without AVX2 both are the same; the comparison says so.
    #[test]
    fn wide_and_baseline_instructions_give_equal_bits() {
        if Lanes::detect() == Lanes::Baseline {
            println!("no wider instructions on this processor");
        }
        for seed in 0..5 {
            let (truth, observations) = frame(seed, 203, 1.0, 0.3, 0.4);
            let initial = small_motion(&mut random(seed), 0.1, 0.01) * truth;
            let pose =
                |lanes| refine_pose_with(&rig(), initial, &observations, &PoseOptions::default(), lanes);
            assert_eq!(pose(Lanes::detect()), pose(Lanes::Baseline));
        }
        let options =
            StreetOptions { seed: 9, cameras: 9, points: 300, max_track: 6, noise_px: 0.7, mono_share: 0.3 };
        let mut problem = displaced(&street(&options), 10, 0.03, 0.003, 0.1);
        problem.fixed[0] = true;
        for robust in [false, true] {
            let options = BundleOptions { robust, ..Default::default() };
            let bundle = |lanes| refine_bundle_with(&problem, &options, lanes);
            assert_eq!(bundle(Lanes::detect()), bundle(Lanes::Baseline));
        }
    }
}
