//! Compiles a whole search loop twice, with and without AVX2 and the population count instruction.
#![allow(unsafe_code)]

use crate::kernels::Simd;

/// A computation whose `run` must be `#[inline(always)]`, so that it takes on the features of its caller.
pub(crate) trait Task {
    /// What it computes.
    type Output;
    /// Computes it.
    fn run(self) -> Self::Output;
}

/// Runs the form of the task that fits the processor.
#[inline]
pub(crate) fn dispatch<T: Task>(simd: Simd, task: T) -> T::Output {
    #[cfg(target_arch = "x86_64")]
    if simd.avx2().is_some() {
        // SAFETY: the token exists only where both features were detected.
        return unsafe { run_avx2(task) };
    }
    let _ = simd;
    task.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,popcnt")]
fn run_avx2<T: Task>(task: T) -> T::Output {
    task.run()
}
