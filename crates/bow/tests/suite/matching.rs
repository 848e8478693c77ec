//! Guided matching.

use super::support::{noisy, random, random_descriptor, small_vocabulary};
use dsslam_bow::{DirectIndex, MatchOptions, MatchSide, NodeMatch, match_by_node};
use features::{Descriptor, Keypoint};
use proptest::prelude::*;
use rand::seq::SliceRandom;

fn side<'a>(descriptors: &'a [Descriptor], direct: &'a DirectIndex) -> MatchSide<'a> {
    MatchSide { descriptors, direct, keypoints: None, eligible: None }
}

/// Features with these words of bits, all under one node.
fn simple(words: &[u64]) -> (Vec<Descriptor>, DirectIndex) {
    let descriptors = words.iter().map(|&word| Descriptor([word, 0, 0, 0])).collect();
    (descriptors, DirectIndex::from_nodes(&vec![1; words.len()]))
}

fn pairs(matches: &[NodeMatch]) -> Vec<(u32, u32)> {
    matches.iter().map(|m| (m.a, m.b)).collect()
}

#[test]
fn noisy_views_in_another_order_are_found() {
    let vocabulary = small_vocabulary();
    let mut random = random(3);
    let a: Vec<_> = (0..200).map(|_| random_descriptor(&mut random)).collect();
    let mut order: Vec<usize> = (0..200).collect();
    order.shuffle(&mut random);
    let b: Vec<_> = order.iter().map(|&i| noisy(&a[i], 6, &mut random)).collect();
    let [direct_a, direct_b] = [&a, &b].map(|image| vocabulary.transform_at(image, None, 1).direct);
    let matches = match_by_node(&side(&a, &direct_a), &side(&b, &direct_b), &MatchOptions::default());
    assert!(matches.len() > 150, "{} of 200", matches.len());
    for m in &matches {
        assert_eq!(order[m.b as usize], m.a as usize);
        assert_eq!(m.distance, a[m.a as usize].distance(&b[m.b as usize]));
    }
    // At the root every pair is compared: all are found.
    let [direct_a, direct_b] = [&a, &b].map(|image| vocabulary.transform_at(image, None, 0).direct);
    let all = match_by_node(&side(&a, &direct_a), &side(&b, &direct_b), &MatchOptions::default());
    assert_eq!(all.len(), 200);
}

#[test]
fn only_within_nodes() {
    let descriptors = [Descriptor([5; 4])];
    let [one, two] = [1, 2].map(|node| DirectIndex::from_nodes(&[node]));
    let options = MatchOptions::default();
    assert_eq!(match_by_node(&side(&descriptors, &one), &side(&descriptors, &one), &options).len(), 1);
    assert!(match_by_node(&side(&descriptors, &one), &side(&descriptors, &two), &options).is_empty());
}

#[test]
fn distance_and_ratio() {
    let (a, direct_a) = simple(&[0]);
    let matched = |b: &[u64], options: MatchOptions| {
        let (b, direct_b) = simple(b);
        pairs(&match_by_node(&side(&a, &direct_a), &side(&b, &direct_b), &options))
    };
    let options = MatchOptions { max_distance: 3, ratio: 0.75 };
    assert_eq!(matched(&[0b111], options), [(0, 0)]);
    assert_eq!(matched(&[0b1111], options), []);
    // 3 of 4 is not below three quarters, 3 of 5 is.
    assert_eq!(matched(&[0b1111, 0b111], options), []);
    assert_eq!(matched(&[0b1_1111, 0b111], options), [(0, 1)]);
    // Two equal ones: no way to tell them apart, unless the ratio does not ask; then the first.
    assert_eq!(matched(&[0b1, 0b10], options), []);
    assert_eq!(matched(&[0b1, 0b10], MatchOptions { max_distance: 3, ratio: 2.0 }), [(0, 0)]);
}

#[test]
fn a_wanted_feature_goes_to_the_nearest() {
    let (a, direct_a) = simple(&[0b111, 0b1, 0b10]);
    let (b, direct_b) = simple(&[0]);
    let matches = match_by_node(&side(&a, &direct_a), &side(&b, &direct_b), &MatchOptions::default());
    assert_eq!(matches, [NodeMatch { a: 1, b: 0, distance: 1 }]);
}

#[test]
fn only_eligible_features() {
    let (a, direct_a) = simple(&[0, 0xff00]);
    let (b, direct_b) = simple(&[0xff01, 1]);
    let mut sides = [side(&a, &direct_a), side(&b, &direct_b)];
    let matched =
        |sides: &[MatchSide<'_>; 2]| pairs(&match_by_node(&sides[0], &sides[1], &MatchOptions::default()));
    assert_eq!(matched(&sides), [(0, 1), (1, 0)]);
    sides[0].eligible = Some(&[false, true]);
    assert_eq!(matched(&sides), [(1, 0)]);
    sides[0].eligible = None;
    sides[1].eligible = Some(&[true, false]);
    assert_eq!(matched(&sides), [(1, 0)]);
}

#[test]
fn matches_that_turn_otherwise_are_dropped() {
    let words: Vec<u64> = (0..12).map(|i| 0xffff << (4 * i)).collect();
    let (descriptors, direct) = simple(&words);
    let keypoints = |turned: f32| -> Vec<Keypoint> {
        let angle = |i: usize| if i == 11 { 170.0 } else { 25.0 * i as f32 + turned };
        (0..12).map(|i| Keypoint { angle_deg: angle(i), ..Keypoint::default() }).collect()
    };
    let (a, b) = (keypoints(0.0), keypoints(90.0));
    let mut sides = [side(&descriptors, &direct); 2];
    assert_eq!(match_by_node(&sides[0], &sides[1], &MatchOptions::default()).len(), 12);
    sides[0].keypoints = Some(&a);
    sides[1].keypoints = Some(&b);
    let matches = match_by_node(&sides[0], &sides[1], &MatchOptions { max_distance: 50, ratio: 0.75 });
    assert!(matches.iter().all(|m| m.a == m.b));
    // Eleven agree in a turn of 90 degrees; the last one has not turned: the second bin has less than a tenth.
    assert_eq!(pairs(&matches), (0..11).map(|i| (i, i)).collect::<Vec<_>>());
}

proptest! {
    #[test]
    fn matches_are_one_to_one_and_turn_with_the_sides(seed: u64) {
        let vocabulary = small_vocabulary();
        let mut random = random(seed);
        let a: Vec<_> = (0..60).map(|_| random_descriptor(&mut random)).collect();
        let b: Vec<_> = a.iter().map(|descriptor| noisy(descriptor, 30, &mut random)).collect();
        let [direct_a, direct_b] = [&a, &b].map(|image| vocabulary.transform_at(image, None, 1).direct);
        let options = MatchOptions { max_distance: 60, ratio: 0.9 };
        let matches = match_by_node(&side(&a, &direct_a), &side(&b, &direct_b), &options);
        prop_assert!(matches.windows(2).all(|m| m[0].a < m[1].a));
        let mut partners: Vec<u32> = matches.iter().map(|m| m.b).collect();
        partners.sort_unstable();
        partners.dedup();
        prop_assert_eq!(partners.len(), matches.len());
        prop_assert!(matches.iter().all(|m| m.distance <= 60));
    }
}
