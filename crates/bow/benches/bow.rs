//! Time of an image's transformation, of a query over 2000 keyframes, of guided matching, and of loading either format.

#![allow(missing_docs)]

use criterion::{Criterion, criterion_group, criterion_main};
use dsslam_bow::tool::{self, Format};
use dsslam_bow::{BowVector, MatchOptions, MatchSide, PlaceIndex, Vocabulary, match_by_node};
use features::Descriptor;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

fn vocabulary() -> Vocabulary {
    Vocabulary::built_in().expect("a whole vocabulary")
}

/// Descriptors as an image has them: near words, 20 wrong bits each.
fn image(vocabulary: &Vocabulary, n: usize, seed: u64) -> Vec<Descriptor> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let words = 1..vocabulary.n_nodes();
    let near = |_| {
        let mut descriptor = vocabulary.median(random.random_range(words.clone())).expect("a node");
        for _ in 0..20 {
            let bit = random.random_range(0..256);
            descriptor.0[bit / 64] ^= 1 << (bit % 64);
        }
        descriptor
    };
    (0..n).map(near).collect()
}

fn transform(criterion: &mut Criterion) {
    let vocabulary = vocabulary();
    for n in [1000, 2000] {
        let descriptors = image(&vocabulary, n, 1);
        criterion.bench_function(&format!("transform {n} descriptors"), |b| {
            b.iter(|| vocabulary.transform(&descriptors, None));
        });
    }
}

fn matching(criterion: &mut Criterion) {
    let vocabulary = vocabulary();
    let [a, b] = [2, 3].map(|seed| image(&vocabulary, 2000, seed));
    let [direct_a, direct_b] = [&a, &b].map(|image| vocabulary.transform(image, None).direct);
    let side_a = MatchSide { descriptors: &a, direct: &direct_a, keypoints: None, eligible: None };
    let side_b = MatchSide { descriptors: &b, direct: &direct_b, keypoints: None, eligible: None };
    criterion.bench_function("match_by_node 2000 x 2000 descriptors", |bencher| {
        bencher.iter(|| match_by_node(&side_a, &side_b, &MatchOptions::default()));
    });
}

/// 2000 keyframes of 1500 words: the words of images are drawn from 20 000 common ones, so that lists are long.
fn keyframe(random: &mut ChaCha8Rng) -> BowVector {
    let word = |_| (random.random_range(0..20_000u32) * 5, random.random_range(3.0f32..8.0));
    BowVector::from_weights((0..1500).map(word).collect())
}

fn query(criterion: &mut Criterion) {
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let mut index = PlaceIndex::default();
    for id in 0..2000 {
        index.add(id, Arc::new(keyframe(&mut random))).expect("a new keyframe");
    }
    let vector = keyframe(&mut random);
    criterion
        .bench_function("query over 2000 keyframes", |b| b.iter(|| index.query(&vector, |id| id > 1990)));
    criterion.bench_function("snapshot of an index of 2000 keyframes", |b| b.iter(|| index.clone()));
    criterion.bench_function("add a keyframe to 2000, and the snapshot before", |b| {
        b.iter(|| {
            let mut next = index.clone();
            next.add(2000, Arc::new(vector.clone())).expect("a new keyframe");
            next
        });
    });
}

fn load(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let vocabulary = vocabulary();
    for (name, format) in [("orb.dbow", Format::Binary), ("orb.txt", Format::Text)] {
        let path = folder.path().join(name);
        tool::save(&vocabulary, &path, format).expect("a file");
        criterion.bench_function(&format!("load {name}"), |b| b.iter(|| tool::open(&path)));
    }
    criterion.bench_function("load the built-in vocabulary", |b| b.iter(Vocabulary::built_in));
}

criterion_group!(benches, transform, matching, query, load);
criterion_main!(benches);
