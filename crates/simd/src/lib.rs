//! One body, compiled for the target's baseline and for wider instructions, chosen at run time.
//!
//! There is no fused multiply-add and no change of order: both forms give the same bits, only more lanes at once. The choice is made
//! once per call, outside of the loops.

#![allow(unsafe_code)]

/// A computation whose `run` must be `#[inline(always)]`, so that it is compiled with the instructions of its caller.
pub trait Task {
    /// What it computes.
    type Output;
    /// Computes it.
    fn run(self) -> Self::Output;
}

/// Which form of the kernels runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Simd {
    avx2: Option<Avx2>,
}

/// Proof that the processor has AVX2 and the population count instruction; only [`Simd::detect`] makes one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Avx2(());

impl Simd {
    /// The fastest form that this processor can run.
    #[inline]
    pub fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        let found = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("popcnt");
        #[cfg(not(target_arch = "x86_64"))]
        let found = false;
        Self { avx2: found.then_some(Avx2(())) }
    }

    /// The baseline form, for comparison.
    pub fn scalar() -> Self {
        Self { avx2: None }
    }

    /// The permission to use AVX2, where there is one.
    #[inline]
    pub fn avx2(self) -> Option<Avx2> {
        self.avx2
    }

    /// Runs the task with these instructions.
    #[inline]
    pub fn run<T: Task>(self, task: T) -> T::Output {
        #[cfg(target_arch = "x86_64")]
        if self.avx2.is_some() {
            // SAFETY: the token exists only where both features were detected.
            return unsafe { run_avx2(task) };
        }
        task.run()
    }
}

/// Runs a task that counts bits, with the population count instruction where the processor has it.
///
/// AVX2 is left out on purpose: compilers then count bits by table look-ups in vectors, half as fast for single distances.
#[inline]
pub fn run_counting<T: Task>(task: T) -> T::Output {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("popcnt") {
        // SAFETY: the processor has the instruction.
        return unsafe { run_popcnt(task) };
    }
    task.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,popcnt")]
fn run_avx2<T: Task>(task: T) -> T::Output {
    task.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "popcnt")]
fn run_popcnt<T: Task>(task: T) -> T::Output {
    task.run()
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Sum<'a>(&'a [f64]);

    impl Task for Sum<'_> {
        type Output = (f64, u32);
        #[inline(always)]
        fn run(self) -> (f64, u32) {
            (self.0.iter().sum(), self.0.iter().map(|x| x.to_bits().count_ones()).sum())
        }
    }

    #[test]
    fn all_forms_give_the_same_bits() {
        let numbers: Vec<f64> = (1..1000).map(|i| 1.0 / f64::from(i)).collect();
        let plain = Sum(&numbers).run();
        assert_eq!(Simd::scalar().run(Sum(&numbers)), plain);
        assert_eq!(Simd::detect().run(Sum(&numbers)), plain);
        assert_eq!(run_counting(Sum(&numbers)), plain);
    }
}
