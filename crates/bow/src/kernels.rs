//! The distance loops, compiled twice: with and without the population count instruction, chosen at run time.
#![allow(unsafe_code)]

/// 256 bits, as in `features::Descriptor`.
pub(crate) type Bits = [u64; 4];

/// Number of differing bits.
#[inline(always)]
pub(crate) fn distance(a: &Bits, b: &Bits) -> u32 {
    (a[0] ^ b[0]).count_ones()
        + (a[1] ^ b[1]).count_ones()
        + (a[2] ^ b[2]).count_ones()
        + (a[3] ^ b[3]).count_ones()
}

/// Index of and distance to the nearest of `centres`, the first of equally near ones; `(0, u32::MAX)` without any.
#[inline(always)]
pub(crate) fn nearest(centres: &[Bits], bits: &Bits) -> (usize, u32) {
    let mut best = (0, u32::MAX);
    for (i, centre) in centres.iter().enumerate() {
        let distance = distance(centre, bits);
        if distance < best.1 {
            best = (i, distance);
        }
    }
    best
}

/// A computation whose `run` must be `#[inline(always)]`, so that it takes on the processor features of its caller.
pub(crate) trait Task {
    /// What it computes.
    type Output;
    /// Computes it.
    fn run(self) -> Self::Output;
}

/// Runs the form of the task that fits the processor; both give the same result, the work being in integers.
#[inline]
pub(crate) fn dispatch<T: Task>(task: T) -> T::Output {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("popcnt") {
        // SAFETY: the processor has both features.
        return unsafe { run_avx2(task) };
    }
    task.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,popcnt")]
fn run_avx2<T: Task>(task: T) -> T::Output {
    task.run()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    struct Nearest<'a>(&'a [Bits], &'a Bits);

    impl Task for Nearest<'_> {
        type Output = (usize, u32);
        #[inline(always)]
        fn run(self) -> Self::Output {
            nearest(self.0, self.1)
        }
    }

    proptest! {
        #[test]
        fn both_forms_agree_with_counting_bits(centres: Vec<Bits>, bits: Bits) {
            let by_bit = |c: &Bits| (0..256).filter(|i| (c[i / 64] ^ bits[i / 64]) >> (i % 64) & 1 == 1).count();
            let expected = centres.iter().map(by_bit).enumerate().min_by_key(|&(i, d)| (d, i));
            let expected = expected.map_or((0, u32::MAX), |(i, d)| (i, d as u32));
            prop_assert_eq!(Nearest(&centres, &bits).run(), expected);
            prop_assert_eq!(dispatch(Nearest(&centres, &bits)), expected);
        }
    }

    #[test]
    fn the_first_of_equals_is_nearest() {
        assert_eq!(nearest(&[[1, 0, 0, 0], [2, 0, 0, 0], [0, 4, 0, 0]], &[0; 4]), (0, 1));
    }
}
