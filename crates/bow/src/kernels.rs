//! Distances of descriptors, for loops that run with the population count instruction where the processor has it.

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

/// Bits of an index in the key of [`nearest`].
const INDEX_BITS: u32 = 16;

/// Index of the nearest of at most 65 536 `centers`, the first of equally near ones; 0 without any.
#[inline(always)]
pub(crate) fn nearest(centers: &[Bits], bits: &Bits) -> usize {
    // Distance and index in one number: its least value needs no branch that the processor could not foresee.
    let key = |(i, center)| (distance(center, bits) << INDEX_BITS) | i as u32;
    let least = centers.iter().enumerate().map(key).fold(u32::MAX << INDEX_BITS, u32::min);
    (least & ((1 << INDEX_BITS) - 1)) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use simd::{Task, run_counting};

    struct Nearest<'a>(&'a [Bits], &'a Bits);

    impl Task for Nearest<'_> {
        type Output = usize;
        #[inline(always)]
        fn run(self) -> usize {
            nearest(self.0, self.1)
        }
    }

    proptest! {
        #[test]
        fn both_forms_agree_with_counting_bits(centers: Vec<Bits>, bits: Bits) {
            let by_bit = |c: &Bits| (0..256).filter(|i| (c[i / 64] ^ bits[i / 64]) >> (i % 64) & 1 == 1).count();
            let expected = (0..centers.len()).min_by_key(|&i| by_bit(&centers[i])).unwrap_or(0);
            prop_assert_eq!(Nearest(&centers, &bits).run(), expected);
            prop_assert_eq!(run_counting(Nearest(&centers, &bits)), expected);
            prop_assert!(centers.iter().all(|center| distance(center, &bits) as usize == by_bit(center)));
        }
    }

    #[test]
    fn the_first_of_equals_is_nearest() {
        assert_eq!(nearest(&[[3, 0, 0, 0], [2, 0, 0, 0], [0, 4, 0, 0]], &[0; 4]), 1);
        assert_eq!(nearest(&[[u64::MAX; 4], [u64::MAX; 4]], &[0; 4]), 0);
        assert_eq!(nearest(&[], &[0; 4]), 0);
    }
}
