//! Descriptor matching without knowledge of positions.

use crate::descriptor::Descriptor;
use rayon::prelude::*;
use simd::{Simd, Task};

/// Pairs `(index in a, index in b)` that are each other's nearest, of equals the lowest index, with a distance of at most
/// `max_distance` that is below `ratio` times the distance to the second nearest in `b`; sorted by the first index.
pub fn match_brute_force(
    a: &[Descriptor],
    b: &[Descriptor],
    max_distance: u32,
    ratio: f32,
) -> Vec<(u32, u32)> {
    let simd = Simd::detect();
    let matched = a.par_iter().with_min_len(32).enumerate().map(|(i, descriptor)| {
        let (j, best, second) = simd.run(TwoNearest { query: descriptor, among: b })?;
        let distinct = best <= max_distance && second.is_none_or(|s| (best as f32) < ratio * s as f32);
        if !distinct {
            return None;
        }
        let (back, ..) = simd.run(TwoNearest { query: &b[j], among: a })?;
        (back == i).then_some((i as u32, j as u32))
    });
    matched.collect::<Vec<_>>().into_iter().flatten().collect()
}

/// Index and distance of the nearest and the distance of the second nearest.
struct TwoNearest<'a> {
    query: &'a Descriptor,
    among: &'a [Descriptor],
}

impl Task for TwoNearest<'_> {
    type Output = Option<(usize, u32, Option<u32>)>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let (mut nearest, mut best, mut second) = (0, u32::MAX, u32::MAX);
        for (i, other) in self.among.iter().enumerate() {
            let distance = self.query.distance(other);
            if distance < best {
                (nearest, second, best) = (i, best, distance);
            } else if distance < second {
                second = distance;
            }
        }
        (best != u32::MAX).then_some((nearest, best, (second != u32::MAX).then_some(second)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn finds_permuted_noisy_descriptors() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let a: Vec<Descriptor> = (0..200).map(|_| Descriptor(rng.random())).collect();
        let b: Vec<Descriptor> =
            a.iter().rev().map(|d| Descriptor([d.0[0] ^ 0b1011, d.0[1], d.0[2], d.0[3]])).collect();
        let pairs = match_brute_force(&a, &b, 50, 0.8);
        assert_eq!(pairs.len(), 200);
        assert!(pairs.iter().all(|&(i, j)| i + j == 199));
    }

    #[test]
    fn ambiguous_and_distant_pairs_are_refused() {
        let zero = Descriptor([0; 4]);
        let near = Descriptor([1, 0, 0, 0]);
        assert_eq!(match_brute_force(&[zero], &[near], 50, 0.8), [(0, 0)]);
        assert!(match_brute_force(&[zero], &[near, near], 50, 0.8).is_empty());
        assert!(match_brute_force(&[zero], &[Descriptor([u64::MAX; 4])], 50, 0.8).is_empty());
        assert!(match_brute_force(&[], &[near], 50, 0.8).is_empty());
        assert!(match_brute_force(&[near], &[], 50, 0.8).is_empty());
    }

    #[test]
    fn matches_are_mutual() {
        let [zero, near] = [Descriptor([0; 4]), Descriptor([3, 0, 0, 0])];
        // Both of `a` want the only one of `b`; it wants the second.
        assert_eq!(match_brute_force(&[near, zero], &[zero], 50, 0.8), [(1, 0)]);
    }
}
