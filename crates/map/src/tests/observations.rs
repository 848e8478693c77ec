//! `link`, `unlink`, `merge_points`, `remove_point`, `count`.

use super::world::*;
use crate::{FIRST_BELIEF, KeyframeId, MAX_BELIEF, Map, MapError, PointCount, PointFate, PointId};

/// Points 0 (keyframes 0, 1), 1 (keyframes 1, 2), 2 (keyframe 0), 3 (keyframes 0, 1); features by point number.
fn small_map() -> Map {
    let mut map = Map::new();
    add(&mut map, &[], &[&[(0, 0)]]);
    add(&mut map, &[(0, 0)], &[&[(1, 1)], &[(0, 2)], &[(0, 3), (1, 3)]]);
    add(&mut map, &[(1, 1)], &[]);
    assert_eq!(map.check(), Ok(()));
    map
}

fn weight(map: &Map, a: u32, b: u32) -> u32 {
    map.keyframe(KeyframeId(a)).unwrap().shared_points(KeyframeId(b))
}

#[test]
fn a_link_exists_on_both_sides_and_counts_for_covisibility() {
    let mut map = small_map();
    map.link(PointId(0), at(2, 5)).unwrap();
    assert_eq!(map.point(PointId(0)).unwrap().observations(), [at(0, 0), at(1, 0), at(2, 5)]);
    assert_eq!(map.keyframe(KeyframeId(2)).unwrap().point_at(5), Some(PointId(0)));
    assert_eq!([weight(&map, 0, 2), weight(&map, 1, 2), weight(&map, 0, 1)], [1, 2, 2]);
    assert_eq!(map.check(), Ok(()));
}

#[test]
fn unlink_undoes_link_to_the_bit() {
    let mut map = small_map();
    let before = (map.digest(), map.revision());
    map.link(PointId(0), at(2, 5)).unwrap();
    assert_ne!(map.digest(), before.0);
    assert_eq!(map.unlink(PointId(0), KeyframeId(2)), Ok(PointFate::Kept));
    assert_eq!((map.digest(), map.revision()), (before.0, before.1 + 2));
}

#[test]
fn the_reference_passes_to_the_first_remaining_observer() {
    let mut map = small_map();
    assert_eq!(map.point(PointId(3)).unwrap().reference, KeyframeId(1));
    map.link(PointId(3), at(2, 6)).unwrap();
    map.unlink(PointId(3), KeyframeId(1)).unwrap();
    assert_eq!(map.point(PointId(3)).unwrap().reference, KeyframeId(0));
    map.unlink(PointId(3), KeyframeId(2)).unwrap();
    assert_eq!(map.point(PointId(3)).unwrap().reference, KeyframeId(0));
    assert_eq!(map.check(), Ok(()));
}

#[test]
fn a_young_point_may_keep_one_observation_and_an_old_one_may_not() {
    let mut map = small_map();
    assert_eq!(map.unlink(PointId(3), KeyframeId(1)), Ok(PointFate::Kept));
    assert_eq!(map.unlink(PointId(3), KeyframeId(0)), Ok(PointFate::Removed));
    assert_eq!(map.resolve(PointId(3)), None);
    add(&mut map, &[], &[]);
    assert_eq!(map.unlink(PointId(0), KeyframeId(0)), Ok(PointFate::Removed));
    assert_eq!((weight(&map, 0, 1), map.check()), (0, Ok(())));
}

#[test]
fn merging_moves_observations_where_free_and_ends_the_others() {
    let mut map = small_map();
    map.count(&[PointCount { point: PointId(0), seen: 3, found: 2, evidence: 500 }]).unwrap();
    map.count(&[PointCount { point: PointId(1), seen: 10, found: u32::MAX, evidence: -1700 }]).unwrap();
    map.merge_points(PointId(0), PointId(1)).unwrap();
    let p = map.point(PointId(0)).unwrap();
    assert_eq!(p.observations(), [at(0, 0), at(1, 0), at(2, 1)]);
    assert_eq!((p.seen, p.found, p.reference), (13, u32::MAX, KeyframeId(0)));
    assert_eq!(p.belief, FIRST_BELIEF + 500 - 1700);
    assert_eq!(map.keyframe(KeyframeId(1)).unwrap().point_at(1), None);
    assert_eq!([weight(&map, 0, 1), weight(&map, 0, 2), weight(&map, 1, 2)], [2, 1, 1]);
    assert!(map.point(PointId(1)).is_none());
    assert_eq!(map.check(), Ok(()));
}

#[test]
fn belief_adds_up_and_leaves_room_for_doubt() {
    let mut map = small_map();
    let mut told = |evidence: i32| {
        map.count(&[PointCount { point: PointId(0), seen: 1, found: 1, evidence }]).unwrap();
        map.point(PointId(0)).unwrap().clone()
    };
    assert!((told(-FIRST_BELIEF).trust() - 0.5).abs() < 1e-12);
    assert_eq!(told(i32::MAX).belief, MAX_BELIEF);
    assert!(told(0).trust() > 0.997 && told(-2 * MAX_BELIEF).trust() < 0.003);
    assert_eq!(told(i32::MIN).belief, -MAX_BELIEF);
}

#[test]
fn resolve_follows_chains_of_merges_to_what_lives() {
    let mut map = small_map();
    map.merge_points(PointId(2), PointId(3)).unwrap();
    map.merge_points(PointId(1), PointId(2)).unwrap();
    map.merge_points(PointId(0), PointId(1)).unwrap();
    for p in 0..4 {
        assert_eq!(map.resolve(PointId(p)), Some(PointId(0)));
    }
    assert_eq!(map.resolve(PointId(4)), None);
    let matches = [(1, PointId(3)), (2, PointId(9)), (3, PointId(0)), (4, PointId(1))];
    assert_eq!(map.resolve_matches(&matches), [(1, PointId(0))]);
    // Statistics of a merged point go to the one that it became.
    map.count(&[PointCount { point: PointId(3), seen: 7, found: 5, evidence: 0 }]).unwrap();
    assert_eq!((map.point(PointId(0)).unwrap().seen, map.check()), (7, Ok(())));
    map.remove_point(PointId(0)).unwrap();
    for p in 0..4 {
        assert_eq!(map.resolve(PointId(p)), None);
    }
    let before = map.digest();
    map.count(&[PointCount { point: PointId(3), seen: 7, found: 5, evidence: 0 }]).unwrap();
    assert_eq!(map.digest(), before, "numbers of a removed point are passed over");
    assert_eq!(map.next_point_id(), PointId(4), "ids are not reused");
}

#[test]
fn a_removed_point_leaves_no_trace() {
    let mut map = small_map();
    map.remove_point(PointId(3)).unwrap();
    assert_eq!(map.keyframe(KeyframeId(0)).unwrap().point_at(3), None);
    assert_eq!((weight(&map, 0, 1), map.check()), (1, Ok(())));
}

#[test]
fn impossible_changes_are_refused() {
    let mut map = small_map();
    let no_point = MapError::NoPoint { point: PointId(4), next: PointId(4) };
    let no_keyframe = MapError::NoKeyframe { keyframe: KeyframeId(3), next: KeyframeId(3) };
    assert_eq!(refused(&mut map, |m| m.link(PointId(4), at(0, 9))), no_point);
    assert_eq!(refused(&mut map, |m| m.link(PointId(0), at(3, 9))), no_keyframe);
    assert_eq!(refused(&mut map, |m| m.unlink(PointId(4), KeyframeId(0))), no_point);
    assert_eq!(refused(&mut map, |m| m.unlink(PointId(0), KeyframeId(3))), no_keyframe);
    assert_eq!(refused(&mut map, |m| m.merge_points(PointId(0), PointId(4))), no_point);
    assert_eq!(refused(&mut map, |m| m.merge_points(PointId(4), PointId(0))), no_point);
    assert_eq!(refused(&mut map, |m| m.remove_point(PointId(4))), no_point);
    let known = PointCount { point: PointId(0), seen: 1, found: 1, evidence: 0 };
    let unknown = PointCount { point: PointId(4), ..known };
    assert_eq!(refused(&mut map, |m| m.count(&[known, unknown])), no_point);
    assert_eq!(
        refused(&mut map, |m| m.merge_points(PointId(1), PointId(1))),
        MapError::MergeWithItself { point: PointId(1) }
    );
    assert_eq!(
        refused(&mut map, |m| m.link(PointId(0), at(2, 40))),
        MapError::NoFeature { keyframe: KeyframeId(2), feature: 40, n_features: 40 }
    );
    assert_eq!(
        refused(&mut map, |m| m.link(PointId(0), at(2, 1))),
        MapError::FeatureTaken { keyframe: KeyframeId(2), feature: 1, holder: PointId(1) }
    );
    let already = MapError::AlreadyObserved { point: PointId(0), keyframe: KeyframeId(1), feature: 0 };
    assert_eq!(refused(&mut map, |m| m.link(PointId(0), at(1, 9))), already);
    assert_eq!(already.to_string(), "point P0 is already observed by keyframe K1, at feature 0");
    assert_eq!(
        refused(&mut map, |m| m.unlink(PointId(0), KeyframeId(2))),
        MapError::NotObserved { point: PointId(0), keyframe: KeyframeId(2) }
    );
}
