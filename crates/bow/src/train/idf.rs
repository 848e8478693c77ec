//! Inverse document frequencies: words that occur in most images say little.

use crate::vocabulary::Vocabulary;
use features::Descriptor;
use rayon::prelude::*;

/// `ln(N / n_i)` for every word, `n_i` being the number of the `N` images that have it; zero for inner nodes.
///
/// A word that no image has counts as if one had it (DBoW2 would ignore it for ever).
pub(crate) fn weights(vocabulary: &Vocabulary, images: &[Vec<Descriptor>]) -> Vec<f32> {
    let words_of = |image: &Vec<Descriptor>| {
        let mut words = vocabulary.words_of(image);
        words.sort_unstable();
        words.dedup();
        words
    };
    let mut n_with = vec![0u32; vocabulary.n_nodes() as usize];
    for words in images.par_iter().map(words_of).collect::<Vec<_>>() {
        for word in words {
            n_with[word as usize] += 1;
        }
    }
    let tree = vocabulary.tree();
    let n_images = images.len() as f64;
    let weight = |(node, &n): (usize, &u32)| {
        if tree.children(node).is_empty() { (n_images / f64::from(n.max(1))).ln() as f32 } else { 0.0 }
    };
    n_with.iter().enumerate().map(weight).collect()
}
