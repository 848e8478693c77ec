//! Sub-maps: where they start, what they are called, how they are joined.

use super::world::*;
use crate::{Batch, Correction, KeyframeCorrection, KeyframeId, Map, MapError, NewKeyframe, Parent};

const K: fn(u32) -> KeyframeId = KeyframeId;

fn start_submap(map: &mut Map) -> KeyframeId {
    let keyframe = NewKeyframe { parent: Parent::NewSubmap, ..new_keyframe(map, &[]) };
    let id = map.next_keyframe_id().0;
    let points = vec![new_point(&[(id, 0)]), new_point(&[(id, 1)])];
    map.insert(Batch { keyframe: Some(keyframe), points }).unwrap().keyframe.unwrap()
}

fn add_under(map: &mut Map, parent: u32) -> KeyframeId {
    let keyframe = NewKeyframe { parent: Parent::Under(K(parent)), ..new_keyframe(map, &[]) };
    map.insert(Batch { keyframe: Some(keyframe), points: vec![] }).unwrap().keyframe.unwrap()
}

/// Sub-map of K0 in a row to K3; of K4: K4 - K5 - K6 and K5 - K7; of K8: K8 - K9.
fn three_submaps() -> Map {
    let mut map = row_of_keyframes(4);
    start_submap(&mut map);
    [4, 5, 5].into_iter().for_each(|parent| _ = add_under(&mut map, parent));
    start_submap(&mut map);
    add_under(&mut map, 8);
    assert_eq!(map.check(), Ok(()));
    map
}

fn join(map: &mut Map, pairs: &[(u32, u32)]) -> Result<(), MapError> {
    let joined = pairs.iter().map(|&(a, b)| (K(a), K(b))).collect();
    map.apply_correction(&Correction { joined, ..Correction::default() })
}

fn parents(map: &Map) -> Vec<Option<u32>> {
    map.keyframes().map(|k| k.parent().map(|p| p.0)).collect()
}

#[test]
fn a_keyframe_that_starts_a_submap_is_a_root() {
    let map = three_submaps();
    assert_eq!(map.roots(), ids(&[0, 4, 8]));
    let submaps: Vec<u32> = (0..10).map(|k| map.submap_of(K(k)).unwrap().0).collect();
    assert_eq!(submaps, [0, 0, 0, 0, 4, 4, 4, 4, 8, 8]);
    assert_eq!(map.submap_of(K(10)), None);
    // In an empty map every keyframe without a given parent is one.
    assert!(Map::new().roots().is_empty());
    let mut map = Map::new();
    start_submap(&mut map);
    assert_eq!((map.roots(), map.check()), (&ids(&[0])[..], Ok(())));
}

#[test]
fn a_keyframe_without_shared_points_stays_in_the_newest_submap() {
    let mut map = three_submaps();
    let lonely = add(&mut map, &[], &[]);
    assert_eq!(map.submap_of(lonely), Some(K(8)));
}

#[test]
fn the_first_keyframe_of_a_submap_shares_no_point_with_older_ones() {
    let mut map = row_of_keyframes(3);
    let first = |map: &Map, matches: &[(u32, u32)]| {
        Some(NewKeyframe { parent: Parent::NewSubmap, ..new_keyframe(map, matches) })
    };
    let matched = Batch { keyframe: first(&map, &[(0, 9)]), points: vec![] };
    let sharing = Batch { keyframe: first(&map, &[]), points: vec![new_point(&[(3, 0), (1, 30)])] };
    for batch in [matched, sharing] {
        let error = refused(&mut map, |m| m.insert(batch));
        assert_eq!(error, MapError::SubmapMatched { keyframe: K(3) });
    }
    // Points of others in the same batch do not concern the new one.
    let points = vec![new_point(&[(3, 0)]), new_point(&[(1, 30), (2, 30)])];
    let keyframe = first(&map, &[]);
    map.insert(Batch { keyframe, points }).unwrap();
    assert_eq!((map.roots(), map.check()), (&ids(&[0, 3])[..], Ok(())));
}

#[test]
fn a_join_turns_the_path_to_the_old_root_around() {
    let mut map = three_submaps();
    let before = parents(&map);
    join(&mut map, &[(6, 2)]).unwrap();
    assert_eq!(map.check(), Ok(()));
    let expected = [(4, Some(5)), (5, Some(6)), (6, Some(2))];
    for (k, parent) in parents(&map).into_iter().enumerate() {
        let changed = expected.iter().find(|e| e.0 == k).map(|e| e.1);
        assert_eq!(parent, changed.unwrap_or(before[k]), "keyframe {k}");
    }
    assert_eq!(map.keyframe(K(5)).unwrap().children(), ids(&[4, 7]));
    assert_eq!(map.roots(), ids(&[0, 8]));
    assert!((4..8).all(|k| map.submap_of(K(k)) == Some(K(0))));
    // The old root is a keyframe like others now, the remaining roots are not.
    map.remove_keyframe(K(4)).unwrap();
    for root in [0, 8] {
        let error = refused(&mut map, |m| m.remove_keyframe(K(root)));
        assert_eq!(error, MapError::RemoveRoot { keyframe: K(root) });
    }
}

#[test]
fn the_oldest_submap_can_be_joined_under_a_newer_one() {
    let mut map = three_submaps();
    join(&mut map, &[(0, 7)]).unwrap();
    assert_eq!(map.roots(), ids(&[4, 8]));
    assert_eq!(map.keyframe(K(0)).unwrap().parent(), Some(K(7)));
    map.remove_keyframe(K(0)).unwrap();
    assert_eq!((map.submap_of(K(0)), map.check()), (Some(K(4)), Ok(())));
}

#[test]
fn a_removed_keyframe_stands_for_the_one_that_carries_it() {
    let mut map = three_submaps();
    map.remove_keyframe(K(5)).unwrap();
    map.remove_keyframe(K(2)).unwrap();
    assert_eq!([map.submap_of(K(5)), map.submap_of(K(2))], [Some(K(4)), Some(K(0))]);
    join(&mut map, &[(5, 2)]).unwrap();
    assert_eq!(map.keyframe(K(4)).unwrap().parent(), Some(K(1)));
    assert_eq!((map.roots(), map.check()), (&ids(&[0, 8])[..], Ok(())));
}

#[test]
fn several_joins_count_one_after_the_other() {
    let mut map = three_submaps();
    let mut other = map.clone();
    join(&mut map, &[(9, 7), (6, 1)]).unwrap();
    assert_eq!((map.roots(), map.check()), (&ids(&[0])[..], Ok(())));
    join(&mut other, &[(9, 7)]).unwrap();
    join(&mut other, &[(6, 1)]).unwrap();
    assert_eq!(map.digest(), other.digest());
}

#[test]
fn keyframes_of_one_submap_cannot_be_joined() {
    let mut map = three_submaps();
    let same = |a, b| MapError::SameSubmap { keyframe: K(a), parent: K(b) };
    let cases: [(&[(u32, u32)], MapError); 5] = [
        (&[(5, 7)], same(5, 7)),
        (&[(5, 5)], same(5, 5)),
        (&[(5, 1), (2, 6)], same(2, 6)),
        (&[(5, 1), (8, 6), (1, 9)], same(1, 9)),
        (&[(5, 10)], MapError::NoKeyframe { keyframe: K(10), next: K(10) }),
    ];
    for (pairs, expected) in cases {
        assert_eq!(refused(&mut map, |m| join(m, pairs)), expected);
    }
    let message = "keyframes K5 and K7 cannot be joined: they are in the same sub-map";
    assert_eq!(same(5, 7).to_string(), message);
}

#[test]
fn later_keyframes_of_a_joined_submap_follow_their_parents_of_before() {
    let mut map = three_submaps();
    let seen = map.clone();
    let below_joined = add_under(&mut map, 6); // hangs under the keyframe that will be joined
    let below_root = add_under(&mut map, 4); // under one whose parent will change
    let before = map.clone();
    let new_from_old = random_pose(&mut generator(8));
    let moved = seen.keyframes().filter(|k| seen.submap_of(k.id) == Some(K(4)));
    let keyframes =
        moved.map(|k| KeyframeCorrection::rigid(k.id, k.cam_from_world * new_from_old.inverse())).collect();
    let (seen_revision, joined) = (seen.revision(), vec![(K(6), K(2))]);
    map.apply_correction(&Correction { keyframes, seen_revision, joined, ..Correction::default() }).unwrap();
    assert_eq!((map.roots(), map.check()), (&ids(&[0, 8])[..], Ok(())));
    for (old, new) in before.keyframes().zip(map.keyframes()) {
        let moves = before.submap_of(old.id) == Some(K(4));
        let expected = if moves { new_from_old * old.center() } else { old.center() };
        assert!((expected - new.center()).norm() < 1e-11, "keyframe {}", old.id);
    }
    assert_eq!(map.submap_of(below_joined), Some(K(0)));
    assert_eq!(map.submap_of(below_root), Some(K(0)));
}
