//! The local map: who votes, who is around, and what is found in it.

use features::Candidate;

use super::*;
use crate::scene::{Scene, Shot, add, add_under, at, chain, gap, line, params, shot};

fn gathered(map: &Map, points: &[u32], max: usize) -> LocalMap {
    let matches: Vec<(u32, PointId)> = (0..).zip(points.iter().map(|&p| PointId(p))).collect();
    let params = TrackingParams { max_local_keyframes: max, ..params().tracking };
    LocalMap::gather(map, &matches, KeyframeId(99), &params)
}

#[test]
fn the_keyframe_with_most_votes_is_the_reference_of_equals_the_older() {
    // Keyframe k makes points 8 k to 8 k + 7 and shows those of k - 1.
    let map = chain(&line(6, 1.0), 8);
    assert_eq!(gathered(&map, &[16, 17, 18, 24], 80).reference, KeyframeId(3), "2 has three votes, 3 four");
    assert_eq!(gathered(&map, &[16, 17], 80).reference, KeyframeId(2));
    assert_eq!(gathered(&map, &[], 80).reference, KeyframeId(99));
    // With room for one keyframe it is the one with most votes.
    assert_eq!(gathered(&map, &[16, 17, 24], 1).points, (16..32).map(PointId).collect::<Vec<_>>());
}

fn neighbors(map: &Map, voters: &[u32], max: usize) -> Vec<u32> {
    let mut keyframes: Vec<KeyframeId> = voters.iter().map(|&id| KeyframeId(id)).collect();
    extend_with_neighbors(map, &mut keyframes, max);
    keyframes.iter().map(|id| id.0).collect()
}

#[test]
fn each_voter_adds_one_covisible_one_child_and_its_parent() {
    // Below 2: its child 3, and 6 and 7, which share nothing with it.
    let mut map = chain(&line(6, 1.0), 8);
    for _ in 0..2 {
        let pose = at(0.0, 1.0, 0.0);
        let under = map::Parent::Under(KeyframeId(2));
        add_under(&mut map, Scene::wall(4).whole(9, &pose), &pose, &[], &[], under);
    }
    // Covisible 1 (of equals the older), child 3, the parent is 1 already.
    assert_eq!(neighbors(&map, &[2], 80), vec![2, 1, 3]);
    // For 2: 1 by covisibility, child 6 since 3 is there; for 3: 4 by covisibility.
    assert_eq!(neighbors(&map, &[2, 3], 80), vec![2, 3, 1, 6, 4]);
    assert_eq!(neighbors(&map, &[7], 80), vec![7, 2], "its parent");
    assert_eq!(neighbors(&map, &[2, 5], 2), vec![2, 5], "no more than wanted");
}

#[test]
fn its_points_are_those_of_all_local_keyframes() {
    let map = chain(&line(6, 1.0), 8);
    // Point 40 is shown by 5 only, which adds 4.
    let local = gathered(&map, &[40], 80);
    assert_eq!(local.points, (24..48).map(PointId).collect::<Vec<_>>());
    let local = gathered(&map, &[40], 1);
    assert_eq!(local.points, (32..48).map(PointId).collect::<Vec<_>>());
}

/// A wall of landmarks seen by two keyframes, and a frame of these shots tracked in it from a pose that is `off`, `n_given`
/// points matched before.
fn tracked(shots: &[Shot], off: &SE3, attempt: Attempt, n_given: u32) -> LocallyTracked {
    let scene = Scene::wall(60);
    let map = scene.map(&[SE3::identity(), at(0.3, 0.0, 0.0)]);
    let frame = scene.frame(2, &truth(), shots);
    let matches: Vec<(u32, PointId)> = (0..n_given).map(|i| (i, PointId(i))).collect();
    let predicted = Prediction { cam_from_world: *off * truth(), matches, attempt, after_loss: false };
    gathered(&map, &[0, 1, 2], 80).track(&frame, &map, &predicted, &params())
}

fn truth() -> SE3 {
    at(0.5, 0.1, 0.2)
}

fn all() -> Vec<Shot> {
    (0..60).map(shot).collect()
}

#[test]
fn the_other_points_are_found_and_the_pose_rests_on_all() {
    let off = SE3::new(geometry::SO3::identity(), geometry::Vec3::new(0.02, 0.0, 0.0));
    let local = tracked(&all(), &off, Attempt::Motion, 10);
    assert!(gap(&local.cam_from_world, &truth()) < 1e-3);
    assert_eq!((local.matches.len(), local.matched.len(), local.stats.local_points), (60, 60, 60));
    assert_eq!(local.counts.len(), 60);
    assert!(local.counts.iter().all(|c| c.seen == 1 && c.found == 1));
    assert_eq!(local.reference, KeyframeId(0));
    assert!(gap(&local.cam_from_reference, &truth()) < 1e-3, "the reference is at the origin");
}

#[test]
fn an_outlier_is_matched_but_not_found() {
    let mut shots = all();
    // 3.4 px at octave 2: within the window of 2.5 px * 1.44, beyond the gate of 2.8 * 0.7 px * 1.44.
    shots[20].shift_px = [0.0, 3.4];
    let local = tracked(&shots, &SE3::identity(), Attempt::Motion, 10);
    let is_20 = |m: &&(u32, PointId)| m.0 == 20;
    assert_eq!(
        (local.matched.iter().filter(is_20).count(), local.matches.iter().filter(is_20).count()),
        (1, 0)
    );
    let count = local.counts.iter().find(|c| c.point == PointId(20)).unwrap();
    assert_eq!((count.seen, count.found), (1, 0));
}

#[test]
fn windows_are_wide_after_a_prediction_without_motion_model() {
    // 0.2 m at 10 m are 10 px: beyond 4 * 1.73, within five times that.
    let off = SE3::new(geometry::SO3::identity(), geometry::Vec3::new(0.2, 0.0, 0.0));
    let matched = |attempt| tracked(&all(), &off, attempt, 3).matched.len();
    assert_eq!(matched(Attempt::Motion), 3, "the given ones, too few to mend the pose");
    assert_eq!(matched(Attempt::ReferenceKeyframe), 60);
}

fn find(best: (u32, u8), second: Option<(u32, u8)>) -> WindowMatch {
    let candidate = |(distance, octave)| Candidate { feature: 0, distance, octave };
    WindowMatch { best: candidate(best), second: second.map(candidate) }
}

#[test]
fn a_find_is_similar_and_clearer_than_the_next_of_its_octave() {
    assert!(is_clear(&find((100, 2), None)) && !is_clear(&find((101, 2), None)));
    assert!(is_clear(&find((40, 2), Some((50, 2)))), "four fifths");
    assert!(!is_clear(&find((41, 2), Some((50, 2)))));
    assert!(is_clear(&find((41, 2), Some((50, 3)))), "another octave");
}

#[test]
fn points_seen_head_on_have_narrow_windows() {
    // Two keyframes on either side of a landmark: its normal points straight ahead.
    let scene = Scene::at(vec![geometry::Vec3::new(0.0, 0.0, 10.0)]);
    let map = scene.map(&[at(0.5, 0.0, 0.0), at(-0.5, 0.0, 0.0)]);
    let found = |x: f64, shift: f64| {
        let frame = scene.frame(2, &at(x, 0.0, 0.0), &[Shot { shift_px: [0.0, shift], ..shot(0) }]);
        let start = Prediction {
            cam_from_world: at(x, 0.0, 0.0),
            matches: Vec::new(),
            attempt: Attempt::Motion,
            after_loss: false,
        };
        let local = LocalMap { reference: KeyframeId(0), points: vec![PointId(0)] };
        !local.search_and_refine(&frame, &map, &start, 1.0, &params()).0.matches.is_empty()
    };
    // Octave 2 or 3: 2.5 px become 3.6 or 4.3, 4 px become 5.8 or 6.9. Head-on is up to 3.6 degrees, 0.63 m aside.
    assert!(found(0.0, 3.5) && !found(0.0, 4.6));
    assert!(found(0.6, 3.5) && !found(0.6, 4.6));
    assert!(found(0.7, 4.6) && !found(0.7, 7.2));
}

#[test]
fn counts_name_each_point_once() {
    let counts = count(
        &[PointId(5), PointId(2)],
        &[(0, PointId(7)), (1, PointId(8))],
        &[(0, PointId(7)), (3, PointId(5))],
    );
    let expected = [(2, 0), (5, 1), (7, 1), (8, 0)];
    assert_eq!(counts.iter().map(|c| (c.point.0, c.found)).collect::<Vec<_>>(), expected);
    assert!(counts.iter().all(|c| c.seen == 1));
    let mut map = Scene::wall(9).map(&[SE3::identity()]);
    add(&mut map, Scene::wall(9).whole(1, &SE3::identity()), &SE3::identity(), &[(0, 0)], &[]);
    map.count(&counts).unwrap();
    assert_eq!(map.point(PointId(5)).map(|p| (p.seen, p.found)), Some((1, 1)));
}
