//! Bag-of-words vectors and their L1 score.

/// How often each word occurs in an image, weighted by TF-IDF; the weights add up to one. Sorted by word.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BowVector {
    words: Vec<u32>,
    weights: Vec<f32>,
}

impl BowVector {
    /// The normalized vector of these (word, weight) pairs, in any order, words may repeat.
    ///
    /// Weights of equal words are added in the order given; words whose weight is not positive and finite are skipped.
    pub fn from_weights(mut pairs: Vec<(u32, f32)>) -> Self {
        pairs.retain(|&(_, weight)| weight > 0.0 && weight.is_finite());
        pairs.sort_by_key(|&(word, _)| word);
        let groups = || pairs.chunk_by(|a, b| a.0 == b.0);
        let sum_of = |group: &[(u32, f32)]| group.iter().map(|&(_, weight)| f64::from(weight)).sum::<f64>();
        let total: f64 = groups().map(sum_of).sum();
        let mut vector = Self::default();
        for group in groups() {
            let weight = (sum_of(group) / total) as f32;
            if weight > 0.0 {
                vector.words.push(group[0].0);
                vector.weights.push(weight);
            }
        }
        vector
    }

    /// Words, ascending.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// Weight of each word, above zero.
    pub fn weights(&self) -> &[f32] {
        &self.weights
    }

    /// Number of different words.
    pub fn len(&self) -> usize {
        self.words.len()
    }

    /// Whether there is no word at all.
    pub fn is_empty(&self) -> bool {
        self.words.is_empty()
    }

    /// (word, weight), ascending words.
    pub fn iter(&self) -> impl Iterator<Item = (u32, f32)> + '_ {
        self.words.iter().copied().zip(self.weights.iter().copied())
    }

    /// L1 score `1 - |a - b| / 2`, from 0 (no word in common) to 1 (equal); 0 when one is empty.
    ///
    /// For vectors whose weights add up to one this is the sum of the smaller weights of the shared words
    /// (Nister and Stewenius, CVPR 2006, section 4).
    pub fn score(&self, other: &Self) -> f64 {
        self.overlap(other).1
    }

    /// Number of shared words, and the L1 score.
    pub(crate) fn overlap(&self, other: &Self) -> (u32, f64) {
        let (mut shared_words, mut sum) = (0, 0.0);
        let (mut i, mut j) = (0, 0);
        while i < self.words.len() && j < other.words.len() {
            let (a, b) = (self.words[i], other.words[j]);
            if a == b {
                shared_words += 1;
                sum += f64::from(self.weights[i].min(other.weights[j]));
            }
            i += usize::from(a <= b);
            j += usize::from(b <= a);
        }
        (shared_words, to_score(sum))
    }
}

/// The score of a sum of smaller weights: rounding may bring it just above one.
#[inline]
pub(crate) fn to_score(sum: f64) -> f64 {
    sum.min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn pairs() -> impl Strategy<Value = Vec<(u32, f32)>> {
        prop::collection::vec((0u32..60, 0.01f32..10.0), 0..80)
    }

    fn l1_distance(a: &BowVector, b: &BowVector) -> f64 {
        let weight_in =
            |vector: &BowVector, word| vector.iter().find(|&(w, _)| w == word).map_or(0.0, |p| p.1);
        (0..60).map(|word| f64::from((weight_in(a, word) - weight_in(b, word)).abs())).sum()
    }

    proptest! {
        #[test]
        fn score_is_symmetric_and_that_of_the_definition(a in pairs(), b in pairs()) {
            let (a, b) = (BowVector::from_weights(a), BowVector::from_weights(b));
            prop_assert_eq!(a.score(&b).to_bits(), b.score(&a).to_bits());
            prop_assert!((0.0..=1.0).contains(&a.score(&b)));
            if !a.is_empty() && !b.is_empty() {
                prop_assert!((a.score(&b) - (1.0 - 0.5 * l1_distance(&a, &b))).abs() < 1e-6);
                prop_assert!((a.score(&a) - 1.0).abs() < 1e-6);
            }
        }

        #[test]
        fn vectors_are_sorted_and_normalized(pairs in pairs()) {
            let vector = BowVector::from_weights(pairs.clone());
            prop_assert!(vector.words().windows(2).all(|w| w[0] < w[1]));
            let sum: f64 = vector.weights().iter().map(|&w| f64::from(w)).sum();
            prop_assert!(pairs.is_empty() || (sum - 1.0).abs() < 1e-6);
            let doubled = BowVector::from_weights(pairs.iter().map(|&(w, v)| (w, 2.0 * v)).collect());
            prop_assert_eq!(doubled, vector);
        }
    }

    #[test]
    fn a_known_score() {
        let a = BowVector::from_weights(vec![(7, 1.0), (3, 1.0), (7, 2.0)]);
        assert_eq!((a.words(), a.weights()), (&[3, 7][..], &[0.25, 0.75][..]));
        let b = BowVector::from_weights(vec![(7, 1.0), (9, 1.0)]);
        assert_eq!(a.score(&b), 0.5);
        assert_eq!(a.score(&a), 1.0);
    }

    #[test]
    fn words_without_a_proper_weight_do_not_count() {
        let vector =
            BowVector::from_weights(vec![(1, f32::NAN), (2, -1.0), (3, 0.0), (4, f32::INFINITY), (5, 2.0)]);
        assert_eq!((vector.words(), vector.weights()), (&[5][..], &[1.0][..]));
        assert_eq!(BowVector::default().score(&vector), 0.0);
        assert!(BowVector::from_weights(vec![(1, 0.0)]).is_empty());
    }
}
