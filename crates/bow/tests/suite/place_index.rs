//! The place index against a plain list.

use super::support::random;
use dsslam_bow::{BowVector, DuplicateKeyframe, PlaceIndex, PlaceMatch};
use proptest::prelude::*;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

fn vector(random: &mut ChaCha8Rng, n_words: u32) -> Arc<BowVector> {
    let pair = |_| (random.random_range(0..n_words), random.random_range(0.5..5.0));
    Arc::new(BowVector::from_weights((0..20).map(pair).collect()))
}

/// By the definition: each vector compared with the query.
fn expected(
    places: &[(u32, Arc<BowVector>)],
    query: &BowVector,
    exclude: impl Fn(u32) -> bool,
) -> Vec<PlaceMatch> {
    let compare = |&(keyframe, ref vector): &(u32, Arc<BowVector>)| {
        let shared_words = vector.words().iter().filter(|word| query.words().contains(word)).count() as u32;
        PlaceMatch { keyframe, shared_words, score: query.score(vector) }
    };
    let mut matches: Vec<_> = places.iter().filter(|place| !exclude(place.0)).map(compare).collect();
    matches.retain(|found| found.shared_words > 0);
    matches.sort_by(|a, b| b.score.total_cmp(&a.score).then(a.keyframe.cmp(&b.keyframe)));
    matches
}

fn check(index: &PlaceIndex, places: &[(u32, Arc<BowVector>)], query: &BowVector) {
    assert_eq!(index.len(), places.len());
    assert_eq!(index.query(query, |_| false), expected(places, query, |_| false));
    assert_eq!(index.query(query, |id| id % 3 == 0), expected(places, query, |id| id % 3 == 0));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn answers_are_those_of_a_plain_list(seed: u64, remove_percent in 0u32..70) {
        let mut random = random(seed);
        let (mut index, mut places) = (PlaceIndex::default(), Vec::new());
        for step in 0..400 {
            if random.random_range(0..100) < remove_percent && !places.is_empty() {
                let i = random.random_range(0..places.len());
                let (keyframe, _) = places.remove(i);
                prop_assert!(index.remove(keyframe));
                prop_assert!(!index.remove(keyframe));
                prop_assert!(index.vector(keyframe).is_none());
            } else {
                let vector = vector(&mut random, 3000);
                // Every other id, in no order.
                let id = 2 * ((step * 7919) % 400);
                prop_assert_eq!(index.add(id, Arc::clone(&vector)), Ok(()));
                prop_assert_eq!(index.add(id, Arc::clone(&vector)), Err(DuplicateKeyframe(id)));
                prop_assert_eq!(index.vector(id), Some(&vector));
                places.push((id, vector));
            }
            if step % 50 == 0 {
                check(&index, &places, &vector(&mut random, 3000));
            }
        }
        check(&index, &places, &vector(&mut random, 3000));
    }
}

#[test]
fn a_snapshot_stays_as_it_was() {
    let mut random = random(1);
    let (mut index, mut places) = (PlaceIndex::default(), Vec::new());
    let mut snapshots = Vec::new();
    for id in 0..300 {
        if id % 37 == 0 {
            snapshots.push((index.clone(), places.clone()));
        }
        let vector = vector(&mut random, 500);
        index.add(id, Arc::clone(&vector)).unwrap();
        places.push((id, vector));
    }
    for id in (0..300).step_by(2) {
        index.remove(id);
    }
    let query = vector(&mut random, 500);
    for (index, places) in &snapshots {
        check(index, places, &query);
    }
    places.retain(|(id, _)| id % 2 == 1);
    check(&index, &places, &query);
}

#[test]
fn thousands_of_keyframes() {
    let mut random = random(2);
    let (mut index, mut places) = (PlaceIndex::default(), Vec::new());
    for id in 0..5000 {
        let vector = vector(&mut random, 20_000);
        index.add(id, Arc::clone(&vector)).unwrap();
        places.push((id, vector));
    }
    check(&index, &places, &vector(&mut random, 20_000));
    // A keyframe finds itself first.
    for id in [0, 1234, 4999] {
        let found = index.query(&places[id as usize].1, |_| false)[0];
        assert_eq!((found.keyframe, found.shared_words), (id, places[id as usize].1.len() as u32));
        assert!(found.score > 0.999_999);
    }
}

#[test]
fn equal_scores_are_in_order_of_the_keyframes() {
    let mut index = PlaceIndex::default();
    let same = Arc::new(BowVector::from_weights(vec![(1, 1.0), (5, 2.0)]));
    for id in (0..100).rev() {
        index.add(id, Arc::clone(&same)).unwrap();
    }
    let found: Vec<u32> = index.query(&same, |_| false).iter().map(|found| found.keyframe).collect();
    assert_eq!(found, (0..100).collect::<Vec<_>>());
}

#[test]
fn empty_things() {
    let mut index = PlaceIndex::default();
    let query = BowVector::from_weights(vec![(1, 1.0)]);
    assert!(index.is_empty() && index.query(&query, |_| false).is_empty() && !index.remove(3));
    for id in 0..70 {
        index.add(id, Arc::default()).unwrap();
    }
    assert_eq!(index.len(), 70);
    assert!(index.query(&query, |_| false).is_empty());
    assert!(index.query(&BowVector::default(), |_| false).is_empty());
    for id in 0..70 {
        assert!(index.remove(id));
    }
    assert!(index.is_empty());
}
