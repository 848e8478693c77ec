//! `remove_keyframe`: observations, spanning tree, old frames.

use geometry::SE3;

use super::world::*;
use crate::{Correction, KeyframeId, Map, MapError, Parent, PointId};

fn largest_entry(a: &SE3, b: &SE3) -> f64 {
    a.rows_3x4().iter().zip(b.rows_3x4()).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

#[test]
fn points_left_with_too_few_observations_go_with_the_keyframe() {
    let mut map = row_of_keyframes(5);
    // Points 12 to 15 (keyframes 3, 4) lose one, 8 to 11 (2, 3, 4) too, and 4 to 7 (1, 2, 3).
    map.unlink(PointId(4), KeyframeId(1)).unwrap();
    let removed = map.remove_keyframe(KeyframeId(3)).unwrap();
    assert_eq!(removed.points, [PointId(4)], "old and seen once more, the others twice or young");
    assert_eq!(removed.reparented, [(KeyframeId(4), KeyframeId(2))]);
    assert!(map.keyframe(KeyframeId(3)).is_none());
    assert_eq!(map.point(PointId(12)).unwrap().reference, KeyframeId(4));
    assert_eq!(map.point(PointId(12)).unwrap().created_by, KeyframeId(3));
    assert_eq!((map.n_keyframes(), map.next_keyframe_id()), (4, KeyframeId(5)));
    assert_eq!(map.check(), Ok(()));
}

#[test]
fn children_go_to_whom_they_share_most_with_and_never_into_a_cycle() {
    let mut map = Map::new();
    add(&mut map, &[], &[&[(0, 0)], &[(0, 1)]]); // points 0, 1
    add(&mut map, &[(0, 0)], &[&[(1, 1)], &[(1, 2)], &[(1, 3)], &[(1, 4)], &[(1, 5)]]); // points 2 to 6
    add(&mut map, &[(0, 2), (1, 3), (2, 4), (3, 1)], &[]); // shares 3 with 1, 1 with 0
    add(&mut map, &[(0, 2), (1, 3), (2, 4), (3, 5), (4, 6)], &[]); // shares 5 with 1, 3 with 2
    add(&mut map, &[], &[]);
    let keyframe =
        Some(crate::NewKeyframe { parent: Parent::Under(KeyframeId(1)), ..new_keyframe(&map, &[]) });
    map.insert(crate::Batch { keyframe, points: vec![] }).unwrap(); // 5 shares nothing
    assert_eq!(map.keyframe(KeyframeId(1)).unwrap().children(), ids(&[2, 3, 5]));
    let removed = map.remove_keyframe(KeyframeId(1)).unwrap();
    // 3 shares most with 2, which has to be attached first: the pair (2, 0) is the only one at the start.
    let expected = [(2, 0), (3, 2), (5, 0)].map(|(c, p)| (KeyframeId(c), KeyframeId(p)));
    assert_eq!(removed.reparented, expected);
    assert_eq!(map.keyframe(KeyframeId(0)).unwrap().children(), ids(&[2, 5]));
    assert_eq!(map.keyframe(KeyframeId(3)).unwrap().parent(), Some(KeyframeId(2)));
    assert_eq!(map.check(), Ok(()));
}

#[test]
fn the_root_and_what_is_not_there_are_refused() {
    let mut map = row_of_keyframes(3);
    let error = refused(&mut map, |m| m.remove_keyframe(KeyframeId(0)));
    assert_eq!(error, MapError::RemoveRoot { keyframe: KeyframeId(0) });
    map.remove_keyframe(KeyframeId(1)).unwrap();
    let error = refused(&mut map, |m| m.remove_keyframe(KeyframeId(1)));
    assert_eq!(error, MapError::NoKeyframe { keyframe: KeyframeId(1), next: KeyframeId(3) });
    assert_eq!(error.to_string(), "keyframe K1 is not in the map (next id K3)");
}

#[test]
fn loop_edges_end_with_the_keyframe() {
    let mut map = row_of_keyframes(6);
    let loop_edges = vec![(KeyframeId(0), KeyframeId(4)), (KeyframeId(4), KeyframeId(1))];
    map.apply_correction(&Correction { loop_edges, ..Correction::default() }).unwrap();
    assert_eq!(map.keyframe(KeyframeId(4)).unwrap().loop_edges(), ids(&[0, 1]));
    map.remove_keyframe(KeyframeId(4)).unwrap();
    assert_eq!(map.keyframe(KeyframeId(0)).unwrap().loop_edges(), []);
    assert_eq!(map.check(), Ok(()));
}

#[test]
fn old_frames_are_expressed_through_chains_of_removed_keyframes() {
    let mut map = row_of_keyframes(8);
    let before: Vec<SE3> = map.keyframes().map(|k| k.cam_from_world).collect();
    for k in [4, 3, 5, 2] {
        map.remove_keyframe(KeyframeId(k)).unwrap();
    }
    assert_eq!(map.check(), Ok(()));
    for (k, old) in (0..8).zip(&before) {
        let (alive, removed_from_alive) = map.resolve_keyframe(KeyframeId(k)).unwrap();
        let now = removed_from_alive * map.keyframe(alive).unwrap().cam_from_world;
        assert!(largest_entry(&now, old) < 1e-12);
        assert_eq!(alive == KeyframeId(k), map.keyframe(KeyframeId(k)).is_some());
    }
    assert!(map.resolve_keyframe(KeyframeId(8)).is_none());

    // A motion of the whole map moves the removed ones along.
    let new_from_old = random_pose(&mut generator(5));
    let poses: Vec<_> = map.keyframes().map(|k| (k.id, k.cam_from_world * new_from_old.inverse())).collect();
    map.set_estimates(&poses, &[]).unwrap();
    for (k, old) in (0..8).zip(&before) {
        let (alive, removed_from_alive) = map.resolve_keyframe(KeyframeId(k)).unwrap();
        let now = removed_from_alive * map.keyframe(alive).unwrap().cam_from_world;
        assert!(largest_entry(&now, &(*old * new_from_old.inverse())) < 1e-11);
    }
}
