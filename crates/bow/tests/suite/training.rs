//! Training: the same bytes for any number of threads, a proper tree, the right weights.

use super::support::{images, noisy, options, random, random_descriptor};
use dsslam_bow::{TrainError, TrainOptions, Vocabulary, train};
use features::Descriptor;

#[test]
fn equal_bytes_for_any_number_of_threads() {
    // More descriptors than one task takes at a time.
    let images = images(40, 600, 300, 4);
    let with_threads = |n| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        pool.install(|| train(&images, &options(6, 4)).unwrap())
    };
    let one = with_threads(1);
    for n in [2, 3, 8] {
        assert_eq!(with_threads(n).as_bytes(), one.as_bytes(), "{n} threads");
    }
}

#[test]
fn the_seed_decides() {
    let images = images(5, 100, 50, 4);
    let with_seed = |seed| train(&images, &TrainOptions { seed, ..options(5, 3) }).unwrap();
    assert_eq!(with_seed(1), with_seed(1));
    let median = |vocabulary: &Vocabulary| vocabulary.median(1);
    assert!((2..10).any(|seed| median(&with_seed(seed)) != median(&with_seed(1))));
}

#[test]
fn separate_things_become_words_of_their_own() {
    let mut random = random(11);
    let things: Vec<Descriptor> = (0..8).map(|_| random_descriptor(&mut random)).collect();
    let image: Vec<Descriptor> = (0..400).map(|i| noisy(&things[i % 8], 4, &mut random)).collect();
    // All 50 views of a thing in one word whose median is the thing, each thing in a word of its own.
    let is_separated = |seed: &u64| {
        let vocabulary =
            train(std::slice::from_ref(&image), &TrainOptions { seed: *seed, ..options(8, 1) }).unwrap();
        let words = vocabulary.words_of(&image);
        let mut different = words.clone();
        different.sort_unstable();
        different.dedup();
        different.len() == 8
            && words.iter().enumerate().all(|(i, word)| *word == words[i % 8])
            && things.iter().zip(&words).all(|(thing, &word)| vocabulary.median(word) == Some(*thing))
    };
    // Seeding misses a thing with a probability of about 6 %.
    assert!((0..20).filter(is_separated).count() >= 15);
}

#[test]
fn weights_are_inverse_document_frequencies() {
    let images = images(20, 30, 40, 6);
    let vocabulary = train(&images, &options(4, 3)).unwrap();
    for word in (0..vocabulary.n_nodes()).filter(|&node| vocabulary.children(node).unwrap().is_empty()) {
        let n = images.iter().filter(|image| vocabulary.words_of(image).contains(&word)).count();
        assert!(n > 0, "every word has a descriptor it was made of");
        assert_eq!(vocabulary.weight(word), Some((20.0 / n as f64).ln() as f32));
    }
    assert_eq!(vocabulary.weight(0), Some(0.0));
    assert_eq!(vocabulary.origin().n_images, 20);
    assert_eq!(vocabulary.origin().n_descriptors, 600);
}

#[test]
fn branching_levels_and_least_number_are_kept() {
    let images = images(4, 250, 500, 2);
    for (branching, levels) in [(2, 1), (2, 5), (7, 2), (30, 3)] {
        let vocabulary = train(&images, &options(branching, levels)).unwrap();
        assert_eq!((vocabulary.branching(), vocabulary.levels()), (branching, levels));
        assert!(vocabulary.n_words() > 1 && vocabulary.n_words() <= branching.pow(levels));
    }
    let coarse = train(&images, &TrainOptions { min_descriptors: 1000, ..options(5, 4) }).unwrap();
    assert_eq!(coarse.n_words(), 5, "only the root has a thousand descriptors");
}

#[test]
fn what_cannot_be_trained() {
    let images = images(2, 10, 10, 1);
    let error = |options: TrainOptions| train(&images, &options).unwrap_err().to_string();
    assert_eq!(error(options(1, 3)), "branching is 1, expected 2 to 1000");
    assert_eq!(error(options(10, 17)), "levels is 17, expected 1 to 16");
    let many = TrainOptions { min_descriptors: 21, ..options(10, 3) };
    assert_eq!(error(many), "20 descriptors in 2 images, expected at least 21, not all equal");
    let equal = vec![vec![Descriptor([5; 4]); 100]];
    let refused = train(&equal, &options(10, 3)).unwrap_err();
    assert_eq!(refused, TrainError::TooFewDescriptors { found: 100, n_images: 1, needed: 4 });
    assert!(train(&[], &options(10, 3)).is_err());
}
