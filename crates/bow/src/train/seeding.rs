//! First centers for k-medians: k-means++ (Arthur and Vassilvitskii, SODA 2007) with Hamming distances.

use crate::kernels::{Bits, distance};
use crate::train::cluster::CHUNK;
use geometry::mix_seed;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use simd::{Task, run_counting};

/// Purpose of the random numbers in [`mix_seed`].
const SEEDING: u64 = 0x5eed;

/// Up to `n` different descriptors: the first at random, each further one with a probability that grows with the squared
/// distance to the nearest one chosen. Fewer when there are no more different ones.
pub(crate) fn choose(descriptors: &[Bits], n: usize, seed: u64) -> Vec<Bits> {
    let mut random = ChaCha8Rng::seed_from_u64(mix_seed(seed, 0, SEEDING));
    let mut centers = vec![descriptors[random.random_range(0..descriptors.len())]];
    let mut cost_sq = vec![u32::MAX; descriptors.len()];
    while centers.len() < n {
        let center = centers[centers.len() - 1];
        // Integers: the sum is the same in any order.
        let chunks = cost_sq.par_chunks_mut(CHUNK).zip(descriptors.par_chunks(CHUNK));
        let sums: Vec<u64> =
            chunks.map(|(cost_sq, part)| run_counting(Approach { center, part, cost_sq })).collect();
        let total: u64 = sums.iter().sum();
        if total == 0 {
            break;
        }
        let index = locate(&cost_sq, &sums, random.random_range(0..total));
        centers.push(descriptors[index]);
    }
    centers
}

/// The first index at which the running sum of costs exceeds `target`, which is below the sum of all.
fn locate(cost_sq: &[u32], chunk_sums: &[u64], target: u64) -> usize {
    let mut left = target;
    let mut chunk = 0;
    while left >= chunk_sums[chunk] {
        left -= chunk_sums[chunk];
        chunk += 1;
    }
    let mut index = chunk * CHUNK;
    while left >= u64::from(cost_sq[index]) {
        left -= u64::from(cost_sq[index]);
        index += 1;
    }
    index
}

/// Lowers the squared distances to those to a new center; gives their sum.
struct Approach<'a> {
    center: Bits,
    part: &'a [Bits],
    cost_sq: &'a mut [u32],
}

impl Task for Approach<'_> {
    type Output = u64;

    #[inline(always)]
    fn run(self) -> u64 {
        let mut sum = 0;
        for (cost_sq, bits) in self.cost_sq.iter_mut().zip(self.part) {
            *cost_sq = distance(bits, &self.center).pow(2).min(*cost_sq);
            sum += u64::from(*cost_sq);
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_different_descriptors_are_chosen_when_there_are_few() {
        let descriptors: Vec<Bits> = (0..300).map(|i| [i % 3, 0, 0, 0]).collect();
        let mut centers = choose(&descriptors, 8, 1);
        centers.sort_unstable();
        assert_eq!(centers, [[0, 0, 0, 0], [1, 0, 0, 0], [2, 0, 0, 0]]);
    }

    #[test]
    fn far_groups_are_each_found() {
        // Three groups 128 bits apart, members differ in one bit: of 50 seeds nearly all must hit every group.
        let bases = [[0, 0, 0, 0], [u64::MAX, u64::MAX, 0, 0], [0, u64::MAX, u64::MAX, 0]];
        let member = |i: usize| {
            let mut bits = bases[i % 3];
            bits[3] = 1 << (i % 64);
            bits
        };
        let descriptors: Vec<Bits> = (0..600).map(member).collect();
        let hits = (0..50).filter(|&seed| {
            let centers = choose(&descriptors, 3, seed);
            bases.iter().all(|base| centers.iter().any(|center| center[..3] == base[..3]))
        });
        assert!(hits.count() >= 48);
    }

    #[test]
    fn a_target_finds_its_place() {
        let cost_sq = [0, 2, 0, 3];
        let places: Vec<usize> = (0..5).map(|target| locate(&cost_sq, &[5], target)).collect();
        assert_eq!(places, [1, 1, 3, 3, 3]);
    }
}
