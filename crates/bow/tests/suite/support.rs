//! Small vocabularies and images for the tests.

use dsslam_bow::{TrainOptions, Vocabulary, train};
use features::Descriptor;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub(crate) fn random(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

pub(crate) fn random_descriptor(random: &mut ChaCha8Rng) -> Descriptor {
    Descriptor(random.random())
}

/// The descriptor with this many randomly chosen bits flipped (some perhaps twice).
pub(crate) fn noisy(descriptor: &Descriptor, n_flips: usize, random: &mut ChaCha8Rng) -> Descriptor {
    let mut noisy = *descriptor;
    for _ in 0..n_flips {
        let bit = random.random_range(0..256);
        noisy.0[bit / 64] ^= 1 << (bit % 64);
    }
    noisy
}

/// Images that show some of `n_things` things, each descriptor being a noisy view of a thing.
pub(crate) fn images(n_images: usize, n_features: usize, n_things: usize, seed: u64) -> Vec<Vec<Descriptor>> {
    let mut random = random(seed);
    let things: Vec<_> = (0..n_things).map(|_| random_descriptor(&mut random)).collect();
    let mut image = |_| {
        let mut view = |_| {
            let thing = random.random_range(0..n_things);
            noisy(&things[thing], 12, &mut random)
        };
        (0..n_features).map(&mut view).collect()
    };
    (0..n_images).map(&mut image).collect()
}

pub(crate) fn options(branching: u32, levels: u32) -> TrainOptions {
    TrainOptions { branching, levels, min_descriptors: 4, ..TrainOptions::default() }
}

/// A vocabulary of a few dozen words with leaves on several levels.
pub(crate) fn small_vocabulary() -> Vocabulary {
    train(&images(6, 60, 40, 1), &options(4, 3)).unwrap()
}
