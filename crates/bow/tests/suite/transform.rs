//! Descriptors to words, vectors and direct indices.

use super::support::{images, random, random_descriptor, small_vocabulary};
use dsslam_bow::{BowVector, Vocabulary};
use features::Descriptor;
use proptest::prelude::*;

/// The path from the root by the definition: the nearest child, again and again.
fn path(vocabulary: &Vocabulary, descriptor: &Descriptor) -> Vec<u32> {
    let mut path = vec![0];
    loop {
        let children = vocabulary.children(path[path.len() - 1]).unwrap();
        let distance = |node: &u32| vocabulary.median(*node).unwrap().distance(descriptor);
        match children.min_by_key(|node| (distance(node), *node)) {
            Some(node) => path.push(node),
            None => return path,
        }
    }
}

proptest! {
    #[test]
    fn words_and_nodes_are_those_of_the_definition(seed: u64, level in 0u32..5) {
        let vocabulary = small_vocabulary();
        let mut random = random(seed);
        let image: Vec<_> = (0..50).map(|_| random_descriptor(&mut random)).collect();
        let paths: Vec<_> = image.iter().map(|descriptor| path(&vocabulary, descriptor)).collect();
        let words: Vec<u32> = paths.iter().map(|path| path[path.len() - 1]).collect();
        prop_assert_eq!(vocabulary.words_of(&image), words.clone());
        let transformed = vocabulary.transform_at(&image, None, level);
        let pairs = words.iter().map(|&word| (word, vocabulary.weight(word).unwrap()));
        prop_assert_eq!(transformed.bow, BowVector::from_weights(pairs.collect()));
        for (feature, path) in paths.iter().enumerate() {
            let node = path[(level as usize).min(path.len() - 1)];
            let mut groups = transformed.direct.iter().filter(|group| group.0 == node);
            prop_assert!(groups.any(|group| group.1.contains(&(feature as u32))));
        }
        let n_features: usize = transformed.direct.iter().map(|(_, features)| features.len()).sum();
        prop_assert_eq!(n_features, image.len());
    }

    #[test]
    fn the_order_of_features_does_not_matter_to_the_vector(seed: u64) {
        let vocabulary = small_vocabulary();
        let mut image = images(1, 80, 40, seed)[0].clone();
        let before = vocabulary.transform(&image, None).bow;
        image.reverse();
        prop_assert_eq!(vocabulary.transform(&image, None).bow, before);
    }
}

#[test]
fn activation_weighs_features() {
    let vocabulary = small_vocabulary();
    let image = &images(1, 60, 40, 5)[0];
    let plain = vocabulary.transform(image, None);
    assert_eq!(vocabulary.transform(image, Some(&[1.0; 60])), plain);
    assert_eq!(vocabulary.transform(image, Some(&[0.5; 60])).bow, plain.bow);
    // The second half switched off: as if it were not there, but still in the direct index.
    let mut weights = vec![1.0; 30];
    weights.resize(60, 0.0);
    let half = vocabulary.transform(image, Some(&weights));
    assert_eq!(half.bow, vocabulary.transform(&image[..30], None).bow);
    assert_ne!(half.bow, plain.bow);
    assert_eq!(half.direct, plain.direct);
    // Weights that are missing count as one.
    assert_eq!(vocabulary.transform(image, Some(&[])), plain);
    // One feature trusted twice counts as if it were seen twice.
    weights = vec![1.0; 60];
    weights[7] = 2.0;
    let twice = [&image[..], &image[7..8]].concat();
    let doubled = vocabulary.transform(image, Some(&weights)).bow;
    assert!((doubled.score(&vocabulary.transform(&twice, None).bow) - 1.0).abs() < 1e-6);
}

#[test]
fn nothing_gives_nothing() {
    let transformed = small_vocabulary().transform(&[], None);
    assert!(transformed.bow.is_empty() && transformed.direct.iter().next().is_none());
    assert_eq!(transformed.bow.score(&transformed.bow), 0.0);
}

#[test]
fn views_of_the_same_things_score_higher() {
    let vocabulary = Vocabulary::built_in().unwrap();
    let image = |things, seed| {
        let mut random = random(seed);
        let things = images(1, 300, 300, things)[0].clone();
        let views =
            things.iter().map(|thing| super::support::noisy(thing, 10, &mut random)).collect::<Vec<_>>();
        vocabulary.transform(&views, None).bow
    };
    let (a, b, other) = (image(1, 1), image(1, 2), image(2, 3));
    assert!(a.score(&b) > 3.0 * a.score(&other), "{} {}", a.score(&b), a.score(&other));
}
