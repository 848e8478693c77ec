//! The bitwise median of many descriptors.

use crate::kernels::Bits;

/// Bits of the fast counters: one less than this many descriptors are added before the counts are carried over.
const PLANES: usize = 8;

/// Counts, for each of 256 bits, in how many descriptors it is set.
#[derive(Clone, Debug)]
pub(crate) struct BitCounts {
    /// Bit-sliced counters: bit `i` of plane `p` is bit `p` of the count of bit `i`.
    planes: [Bits; PLANES],
    /// Descriptors in the planes.
    n_pending: usize,
    counts: [u32; 256],
    n: u32,
}

impl Default for BitCounts {
    fn default() -> Self {
        Self { planes: [[0; 4]; PLANES], n_pending: 0, counts: [0; 256], n: 0 }
    }
}

impl BitCounts {
    /// Counts one descriptor.
    #[inline(always)]
    pub(crate) fn add(&mut self, bits: &Bits) {
        let mut carry = *bits;
        for plane in &mut self.planes {
            for (word, carry) in plane.iter_mut().zip(&mut carry) {
                let both = *word & *carry;
                *word ^= *carry;
                *carry = both;
            }
        }
        self.n += 1;
        self.n_pending += 1;
        if self.n_pending == (1 << PLANES) - 1 {
            self.flush();
        }
    }

    /// Moves the counts from the planes to the sums.
    pub(crate) fn flush(&mut self) {
        for (i, count) in self.counts.iter_mut().enumerate() {
            for (p, plane) in self.planes.iter().enumerate() {
                *count += ((plane[i / 64] >> (i % 64) & 1) as u32) << p;
            }
        }
        self.planes = [[0; 4]; PLANES];
        self.n_pending = 0;
    }

    /// Adds the counts of `other`; both must be flushed.
    pub(crate) fn merge(&mut self, other: &Self) {
        self.n += other.n;
        for (count, more) in self.counts.iter_mut().zip(&other.counts) {
            *count += more;
        }
    }

    /// The bits that most have, after a flush; where as many have a bit as not, that of `tie` stays. `tie` when empty.
    pub(crate) fn median(&self, tie: &Bits) -> Bits {
        let mut median = *tie;
        for (i, &count) in self.counts.iter().enumerate() {
            let mask = 1 << (i % 64);
            if 2 * u64::from(count) > u64::from(self.n) {
                median[i / 64] |= mask;
            } else if 2 * u64::from(count) < u64::from(self.n) {
                median[i / 64] &= !mask;
            }
        }
        median
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::distance;
    use proptest::prelude::*;

    fn median_of(all: &[Bits], tie: &Bits) -> Bits {
        let mut counts = BitCounts::default();
        all.iter().for_each(|bits| counts.add(bits));
        counts.flush();
        counts.median(tie)
    }

    proptest! {
        #[test]
        fn median_has_the_least_sum_of_distances(all in prop::collection::vec(any::<Bits>(), 1..40), other: Bits, tie: Bits) {
            let sum = |center: &Bits| all.iter().map(|bits| distance(bits, center)).sum::<u32>();
            prop_assert!(sum(&median_of(&all, &tie)) <= sum(&other));
        }

        #[test]
        fn parts_add_up(all in prop::collection::vec(any::<Bits>(), 0..40), cut in 0usize..40) {
            let (a, b) = all.split_at(cut.min(all.len()));
            let mut sum = BitCounts::default();
            for part in [a, b] {
                let mut counts = BitCounts::default();
                part.iter().for_each(|bits| counts.add(bits));
                counts.flush();
                sum.merge(&counts);
            }
            prop_assert_eq!(sum.median(&[7; 4]), median_of(&all, &[7; 4]));
        }
    }

    #[test]
    fn many_descriptors_do_not_overflow_the_planes() {
        // 700 with a bit, 699 without it: more than one filling of the planes, the majority by one.
        let mut all = vec![[1, 0, 0, 1 << 63]; 700];
        all.extend([[2, 0, 0, 0]; 699]);
        assert_eq!(median_of(&all, &[0; 4]), [1, 0, 0, 1 << 63]);
    }

    #[test]
    fn ties_keep_the_bit_they_had() {
        let all = [[0b0011, 0, 0, 0], [0b0101, 0, 0, 0]];
        assert_eq!(median_of(&all, &[0b0100, 0, 0, 0]), [0b0101, 0, 0, 0]);
        assert_eq!(median_of(&all, &[0b1010, 0, 0, 0]), [0b0011, 0, 0, 0]);
        assert_eq!(median_of(&[], &[9; 4]), [9; 4]);
    }
}
