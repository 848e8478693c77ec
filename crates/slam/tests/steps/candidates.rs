//! Which keyframes may show the same place, from scores, groups and positions.

use geometry::SE3;

use super::*;
use crate::scene::{Scene, Shot, add, at, chain, described, line, params, shot};

fn alike(list: &[(u32, u32, f64)]) -> Vec<Alike> {
    let alike = |&(id, shared_words, score): &(u32, u32, f64)| Alike {
        keyframe: KeyframeId(id),
        shared_words,
        score,
    };
    list.iter().map(alike).collect()
}

fn strongest(list: &[(u32, u32, f64)], min_score: f64) -> Vec<u32> {
    let map = chain(&line(12, 1.0), 16);
    strongest_groups(&map, &alike(list), min_score).iter().map(|id| id.0).collect()
}

#[test]
fn a_candidate_shares_more_than_four_fifths_of_the_most_words() {
    assert_eq!(strongest(&[(2, 100, 0.5), (6, 81, 0.5), (10, 80, 0.9)], 0.0), vec![2, 6]);
}

#[test]
fn groups_are_scored_as_a_whole_and_shown_by_their_best_member() {
    // 2 and 3 are neighbors: together 0.9, so that a lone keyframe needs more than 0.675.
    assert_eq!(strongest(&[(2, 9, 0.4), (3, 9, 0.5), (8, 9, 0.67)], 0.0), vec![3]);
    assert_eq!(strongest(&[(2, 9, 0.4), (3, 9, 0.5), (8, 9, 0.68)], 0.0), vec![3, 8]);
    assert_eq!(strongest(&[(2, 9, 0.4), (3, 9, 0.5), (8, 9, 0.95)], 0.0), vec![8, 3], "the best group first");
}

#[test]
fn what_is_below_the_least_score_heads_no_group_but_counts_in_it() {
    assert_eq!(strongest(&[(2, 9, 0.5), (3, 9, 0.3), (8, 9, 0.59)], 0.35), vec![2]);
    assert_eq!(strongest(&[(3, 9, 0.3), (8, 9, 0.34)], 0.35), Vec::<u32>::new());
    assert_eq!(strongest(&[(3, 9, 0.3), (8, 9, 0.35)], 0.35), vec![8]);
}

#[test]
fn removed_keyframes_are_no_candidates() {
    let mut map = chain(&line(12, 1.0), 16);
    map.remove_keyframe(KeyframeId(6)).unwrap();
    assert_eq!(strongest_groups(&map, &alike(&[(6, 9, 0.9)]), 0.0), Vec::<KeyframeId>::new());
}

/// Candidates of the last of twelve keyframes that all look the same, a meter apart, with a margin of the prior.
fn found(prior_margin_m: f64) -> Vec<u32> {
    let world = described(chain(&line(12, 1.0), 16));
    let mut params = params();
    params.camera.prior_margin_m = prior_margin_m;
    find(KeyframeId(11), &world, &params, &mut Familiarity::default())
        .unwrap()
        .iter()
        .map(|id| id.0)
        .collect()
}

#[test]
fn what_is_too_far_away_is_no_candidate_however_alike() {
    // 3 m and 5 % of the way: 8 is 3 m away, 7 is 4 m away; 10 is covisible.
    assert_eq!(found(3.0), vec![8, 9]);
}

#[test]
fn near_keyframes_join_the_strongest_groups() {
    // The groups at both ends have two members instead of three, too few; 9 is the nearest.
    assert_eq!(found(100.0), vec![1, 2, 3, 4, 5, 6, 7, 8, 9]);
}

/// Candidates of a keyframe that sees 60 landmarks, after one that sees the same and shares points with it, and after
/// `n` more that share none and see `n_same` of the landmarks, 1 m, 2 m... away.
fn nearby(n: u32, n_same: usize) -> Result<Vec<KeyframeId>, NoLoop> {
    let scene = Scene::wall(120);
    let mut map = Map::new();
    let shots: Vec<Shot> = (60 - n_same..120 - n_same).map(shot).collect();
    for k in 0..n {
        let pose = at(f64::from(k + 1), 0.0, 0.0);
        let frame = scene.frame(k, &SE3::identity(), &shots);
        add(&mut map, frame, &pose, &[], &[(0, scene.landmarks[0])]);
    }
    let all: Vec<Shot> = (0..60).map(shot).collect();
    let new: Vec<(u32, geometry::Vec3)> = (0..20).map(|i| (i, scene.landmarks[i as usize])).collect();
    let next = map.next_point_id().0;
    add(&mut map, scene.frame(n, &SE3::identity(), &all), &SE3::identity(), &[], &new);
    let matches: Vec<(u32, u32)> = (0..20).map(|i| (i, next + i)).collect();
    let current = add(&mut map, scene.frame(n + 1, &SE3::identity(), &all), &SE3::identity(), &matches, &[]);
    find(current, &described(map), &params(), &mut Familiarity::default())
}

#[test]
fn half_the_score_is_enough_for_a_near_keyframe() {
    assert_eq!(nearby(1, 45), Ok(vec![KeyframeId(0)]));
    let Err(NoLoop::Alone { best_score, min_score }) = nearby(1, 15) else { panic!("{:?}", nearby(1, 15)) };
    assert!(
        (min_score - 1.0).abs() < 1e-6 && best_score > 0.1 && best_score < 0.5,
        "{best_score} {min_score}"
    );
}

#[test]
fn the_two_nearest_are_enough() {
    assert_eq!(nearby(3, 45), Ok(vec![KeyframeId(0), KeyframeId(1)]));
}

#[test]
fn without_a_description_no_place_is_recognized() {
    let map = chain(&[SE3::identity()], 16);
    let world = World { map, ..World::default() };
    assert_eq!(find(KeyframeId(0), &world, &params(), &mut Familiarity::default()), Err(NoLoop::NoPlaces));
}

#[test]
fn the_most_familiar_keyframe_is_a_candidate_if_it_stands_out() {
    let map = chain(&line(12, 1.0), 16);
    let mut familiarity = Familiarity::default();
    let mut of = |list: &[(u32, f64)]| {
        let list: Vec<(u32, u32, f64)> = list.iter().map(|&(id, score)| (id, 9, score)).collect();
        most_familiar(&map, &alike(&list), &mut familiarity)
    };
    // 2, 3 and 4 are neighbors in turn; 8, 11 and 6 are not.
    assert_eq!(of(&[(2, 0.2), (8, 0.21)]), None, "one keyframe tells little");
    assert_eq!(of(&[(3, 0.2), (11, 0.35)]), None, "0.38 against 0.35");
    assert_eq!(of(&[(4, 0.2), (6, 0.3)]), Some(KeyframeId(4)), "0.54 against 0.3");
    assert_eq!(of(&[(4, 0.2)]), None, "there is nothing else to compare with");
}
