//! One division of a node: k-medians, that is Lloyd's rounds with Hamming distances and bitwise medians.

use crate::kernels::{Bits, nearest};
use crate::train::majority::BitCounts;
use crate::train::{TrainOptions, seeding};
use rayon::prelude::*;
use simd::{Task, run_counting};

/// Descriptors that one task works on.
pub(crate) const CHUNK: usize = 8192;

/// The parts of a divided node.
pub(crate) struct Split {
    /// Center of each part.
    pub(crate) medians: Vec<Bits>,
    /// Descriptors of each part, above zero: the parts lie one behind the other.
    pub(crate) sizes: Vec<usize>,
}

/// Divides the descriptors and sorts them by part, keeping their order within a part. Every descriptor ends in the part
/// whose median is nearest (the first of equally near ones), so that it finds its way down the finished tree again.
pub(crate) fn split(descriptors: &mut [Bits], seed: u64, options: &TrainOptions) -> Split {
    let mut medians = seeding::choose(descriptors, options.branching as usize, seed);
    let mut labels = vec![u16::MAX; descriptors.len()];
    for iteration in 0.. {
        let (changed, counts) = assign(descriptors, &medians, &mut labels);
        if !changed || iteration == options.max_iterations {
            break;
        }
        for (median, counts) in medians.iter_mut().zip(&counts) {
            *median = counts.median(median);
        }
    }
    sort_by_part(descriptors, &labels, medians)
}

/// Labels each descriptor with its nearest median; whether a label changed, and the bits of each part.
fn assign(descriptors: &[Bits], medians: &[Bits], labels: &mut [u16]) -> (bool, Vec<BitCounts>) {
    let chunks = descriptors.par_chunks(CHUNK).zip(labels.par_chunks_mut(CHUNK));
    let results: Vec<_> =
        chunks.map(|(part, labels)| run_counting(Assign { part, medians, labels })).collect();
    let mut changed = false;
    let mut sums = vec![BitCounts::default(); medians.len()];
    for (part_changed, counts) in &results {
        changed |= part_changed;
        for (sum, counts) in sums.iter_mut().zip(counts) {
            sum.merge(counts);
        }
    }
    (changed, sums)
}

struct Assign<'a> {
    part: &'a [Bits],
    medians: &'a [Bits],
    labels: &'a mut [u16],
}

impl Task for Assign<'_> {
    type Output = (bool, Vec<BitCounts>);

    #[inline(always)]
    fn run(self) -> Self::Output {
        let mut changed = false;
        let mut counts = vec![BitCounts::default(); self.medians.len()];
        for (bits, label) in self.part.iter().zip(self.labels) {
            let part = nearest(self.medians, bits);
            changed |= *label != part as u16;
            *label = part as u16;
            counts[part].add(bits);
        }
        counts.iter_mut().for_each(BitCounts::flush);
        (changed, counts)
    }
}

/// Brings the descriptors of each part together (counting sort); parts without any are dropped.
fn sort_by_part(descriptors: &mut [Bits], labels: &[u16], medians: Vec<Bits>) -> Split {
    let mut sizes = vec![0; medians.len()];
    for &label in labels {
        sizes[usize::from(label)] += 1;
    }
    let mut free: Vec<usize> = sizes
        .iter()
        .scan(0, |end, size| {
            *end += size;
            Some(*end - size)
        })
        .collect();
    let unsorted = descriptors.to_vec();
    for (bits, &label) in unsorted.into_iter().zip(labels) {
        let place = &mut free[usize::from(label)];
        descriptors[*place] = bits;
        *place += 1;
    }
    let filled = medians.into_iter().zip(sizes).filter(|&(_, size)| size > 0);
    let (medians, sizes) = filled.unzip();
    Split { medians, sizes }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::distance;
    use proptest::prelude::*;

    fn options(branching: u32) -> TrainOptions {
        TrainOptions { branching, ..TrainOptions::default() }
    }

    proptest! {
        #[test]
        fn every_descriptor_lies_in_the_nearest_part(all in prop::collection::vec(any::<Bits>(), 1..200), branching in 2u32..12, seed: u64) {
            let mut sorted = all.clone();
            let Split { medians, sizes } = split(&mut sorted, seed, &options(branching));
            prop_assert!(sizes.iter().all(|&size| size > 0) && medians.len() <= branching as usize);
            let labels: Vec<usize> = sizes.iter().enumerate().flat_map(|(i, &size)| vec![i; size]).collect();
            prop_assert_eq!(labels.len(), all.len());
            for (bits, label) in sorted.iter().zip(labels) {
                prop_assert_eq!(nearest(&medians, bits), label);
            }
            let (mut before, mut after) = (all, sorted);
            before.sort_unstable();
            after.sort_unstable();
            prop_assert_eq!(before, after);
        }
    }

    #[test]
    fn separate_groups_are_found_with_their_centers() {
        let centers = [[0; 4], [u64::MAX, u64::MAX, 0, 0], [0, 0, u64::MAX, u64::MAX]];
        // Each member flips one bit of its center, each bit at most once: the median is the center.
        let member = |i: usize| {
            let mut bits: Bits = centers[i % 3];
            bits[i / 3 % 4] ^= 1 << (i / 12);
            bits
        };
        let mut descriptors: Vec<Bits> = (0..300).map(member).collect();
        let Split { mut medians, sizes } = split(&mut descriptors, 3, &options(3));
        assert_eq!(sizes, [100, 100, 100]);
        medians.sort_unstable();
        let mut expected = centers;
        expected.sort_unstable();
        assert_eq!(medians, expected);
        assert!(descriptors.chunks(100).all(|part| part.iter().all(|bits| distance(bits, &part[0]) <= 2)));
    }
}
