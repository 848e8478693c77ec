//! `apply_correction`: who moves, who follows, what is joined, what is refused.

use geometry::{SE3, SO3, Vec3};

use super::world::*;
use crate::{Correction, KeyframeCorrection, KeyframeId, Map, MapError, PointId, PoseDefect};

/// Every keyframe of the map moved by one motion, points unlisted.
fn rigid(map: &Map, new_from_old: &SE3) -> Correction {
    let keyframes = map
        .keyframes()
        .map(|k| KeyframeCorrection::rigid(k.id, k.cam_from_world * new_from_old.inverse()))
        .collect();
    Correction { keyframes, seen_revision: map.revision(), ..Correction::default() }
}

/// Relations of a map without its numbers.
fn relations(map: &Map) -> Vec<String> {
    let keyframes = map.keyframes().map(|k| {
        format!("{:?}", (k.id, k.points(), k.covisible(), k.parent(), k.children(), k.loop_edges()))
    });
    let points = map.points().map(|p| format!("{:?}", (p.id, p.observations(), p.reference, p.descriptor)));
    keyframes.chain(points).collect()
}

#[test]
fn a_rigid_motion_moves_everything_and_keeps_every_relation() {
    let mut map = row_of_keyframes(8);
    let before = map.clone();
    let new_from_old = random_pose(&mut generator(2));
    map.apply_correction(&rigid(&before, &new_from_old)).unwrap();
    assert_eq!(map.check(), Ok(()));
    assert_eq!(relations(&map), relations(&before));
    assert!(largest_gap(&before, &map) > 0.1, "the map moved");
    for (old, new) in before.points().zip(map.points()) {
        assert!((new_from_old * old.position - new.position).norm() < 1e-11);
        assert!((new_from_old.rotation * old.normal - new.normal).norm() < 1e-11);
        assert!((old.max_distance_m - new.max_distance_m).abs() < 1e-11 * old.max_distance_m);
    }
    // And back.
    map.apply_correction(&rigid(&map.clone(), &new_from_old.inverse())).unwrap();
    assert!(largest_gap(&before, &map) < 1e-11);
}

#[test]
fn later_keyframes_and_their_points_follow_a_motion_of_the_older_ones() {
    let old = row_of_keyframes(5);
    let mut map = old.clone();
    for _ in 0..3 {
        let k = map.next_keyframe_id().0;
        add(&mut map, &[(9, 4 * k - 1)], &[&[(k, 0)], &[(k, 1), (1, 20 + k)], &[(k, 2)], &[(k, 3)]]);
    }
    let before = map.clone();
    let new_from_old = random_pose(&mut generator(7));
    map.apply_correction(&rigid(&old, &new_from_old)).unwrap();
    assert_eq!(map.check(), Ok(()));
    assert_eq!(relations(&map), relations(&before));
    for (a, b) in before.keyframes().zip(map.keyframes()) {
        assert!((new_from_old * a.center() - b.center()).norm() < 1e-11);
    }
    for (a, b) in before.points().zip(map.points()) {
        assert!((new_from_old * a.position - b.position).norm() < 1e-11);
    }
}

#[test]
fn a_later_keyframe_follows_its_parent_even_if_the_parent_has_the_larger_id() {
    let mut map = Map::new();
    add(&mut map, &[], &[&[(0, 0)], &[(0, 1)]]);
    let seen_revision = map.revision();
    add(&mut map, &[(0, 0), (1, 1)], &[&[(1, 2)], &[(1, 3)], &[(1, 4)]]); // parent 0
    add(&mut map, &[(0, 2), (1, 3)], &[]); // parent 1
    add(&mut map, &[(0, 2), (1, 3), (2, 4), (3, 0)], &[]); // parent 1
    map.remove_keyframe(KeyframeId(1)).unwrap();
    assert_eq!(map.keyframe(KeyframeId(2)).unwrap().parent(), Some(KeyframeId(3)), "the case to test");
    let before = map.clone();
    let new_from_old = random_pose(&mut generator(9));
    let root = KeyframeId(0);
    let pose = map.keyframe(root).unwrap().cam_from_world * new_from_old.inverse();
    let correction = Correction {
        keyframes: vec![KeyframeCorrection::rigid(root, pose)],
        seen_revision,
        ..Correction::default()
    };
    map.apply_correction(&correction).unwrap();
    for (a, b) in before.keyframes().zip(map.keyframes()) {
        assert!((new_from_old * a.center() - b.center()).norm() < 1e-11);
    }
    assert_eq!(map.check(), Ok(()));
}

#[test]
fn unlisted_keyframes_of_the_revision_stay_to_the_bit() {
    let mut map = row_of_keyframes(6);
    let before = map.clone();
    let pose = random_pose(&mut generator(4));
    let keyframes = vec![KeyframeCorrection::rigid(KeyframeId(2), pose)];
    let points = vec![(PointId(8), Vec3::new(1.0, 2.0, 3.0))];
    let seen_revision = map.revision();
    map.apply_correction(&Correction { keyframes, points, seen_revision, ..Correction::default() }).unwrap();
    for (a, b) in before.keyframes().zip(map.keyframes()) {
        assert_eq!(a.cam_from_world == b.cam_from_world, a.id != KeyframeId(2));
    }
    // Points 8 to 11 refer to keyframe 2: the listed one takes its position, the others follow.
    let old_pose = before.keyframe(KeyframeId(2)).unwrap().cam_from_world;
    for (a, b) in before.points().zip(map.points()) {
        match a.id.0 {
            8 => assert_eq!(b.position, Vec3::new(1.0, 2.0, 3.0)),
            9..=11 => assert!((old_pose * a.position - pose * b.position).norm() < 1e-12),
            _ => assert_eq!(a.position, b.position),
        }
    }
    assert_eq!(map.check(), Ok(()));
}

#[test]
fn what_was_removed_or_merged_meanwhile_is_passed_over_or_resolved() {
    let mut map = row_of_keyframes(8);
    let seen = map.clone();
    map.remove_keyframe(KeyframeId(6)).unwrap();
    map.remove_point(PointId(0)).unwrap();
    map.merge_points(PointId(9), PointId(1)).unwrap();
    let mut correction = rigid(&seen, &random_pose(&mut generator(1)));
    let p = PointId;
    correction.points = vec![(p(0), Vec3::zeros()), (p(1), Vec3::zeros()), (p(9), Vec3::x())];
    // 1 is 9 by now; 0 is gone; 9 and 17 become one, then 1 and 17 are the same.
    correction.merged = vec![(p(0), p(5)), (p(17), p(1)), (p(1), p(9))];
    let (a, b) = (KeyframeId(6), KeyframeId(1));
    correction.loop_edges = vec![(a, b), (b, KeyframeId(0)), (KeyframeId(0), b)];
    let (alive, _) = map.resolve_keyframe(a).unwrap();
    let follower = map.point(p(17)).unwrap().position;
    map.apply_correction(&correction).unwrap();
    assert_eq!(map.check(), Ok(()));
    assert_eq!(
        [map.resolve(p(1)), map.resolve(p(9)), map.resolve(p(5))],
        [Some(p(17)), Some(p(17)), Some(p(5))]
    );
    assert_ne!(map.point(p(17)).unwrap().position, follower, "it followed its reference");
    assert_eq!(map.keyframe(b).unwrap().loop_edges(), [KeyframeId(0), alive]);
    assert_eq!(map.keyframe(alive).unwrap().loop_edges(), [b]);
}

#[test]
fn merged_points_share_their_observations_and_the_covisibility_follows() {
    let mut map = row_of_keyframes(9);
    let weight = |m: &Map| m.keyframe(KeyframeId(0)).unwrap().shared_points(KeyframeId(8));
    assert_eq!(weight(&map), 0);
    let merged = (0..4).map(|i| (PointId(i), PointId(28 + i))).collect();
    map.apply_correction(&Correction { merged, ..Correction::default() }).unwrap();
    assert_eq!(weight(&map), 4);
    assert_eq!(map.check(), Ok(()));
}

#[test]
fn one_bad_entry_refuses_the_whole_correction() {
    let mut map = row_of_keyframes(4);
    let good = rigid(&map, &random_pose(&mut generator(3)));
    let (keyframe, point) = (KeyframeId(4), PointId(16));
    let mut try_with = |change: &dyn Fn(&mut Correction)| {
        let mut correction = good.clone();
        change(&mut correction);
        refused(&mut map, |m| m.apply_correction(&correction))
    };
    let no_keyframe = MapError::NoKeyframe { keyframe, next: keyframe };
    let no_point = MapError::NoPoint { point, next: point };
    let (k, p) = (KeyframeId(1), PointId(1));

    assert_eq!(try_with(&|c| c.seen_revision = 5), MapError::RevisionAhead { seen: 5, now: 4 });
    let not_seen = MapError::NotSeen { keyframe: KeyframeId(3), inserted_at: 4, seen: 3 };
    assert_eq!(try_with(&|c| c.seen_revision = 3), not_seen);
    assert_eq!(
        try_with(&|c| c.keyframes.push(KeyframeCorrection::rigid(keyframe, SE3::identity()))),
        no_keyframe
    );
    assert_eq!(try_with(&|c| c.points.push((point, Vec3::zeros()))), no_point);
    assert_eq!(try_with(&|c| c.keyframes.push(c.keyframes[1])), MapError::KeyframeTwice { keyframe: k });
    assert_eq!(try_with(&|c| c.points = vec![(p, Vec3::x()); 2]), MapError::PointTwice { point: p });
    let nan = Vec3::new(f64::NAN, 0.0, 0.0);
    assert_eq!(try_with(&|c| c.points.push((p, nan))), MapError::Position { point: p });
    let defect = PoseDefect::NotFinite;
    let bad_pose = SE3::new(SO3::identity(), nan);
    assert_eq!(
        try_with(&|c| c.keyframes[1].cam_from_world = bad_pose),
        MapError::Pose { keyframe: k, defect }
    );
    assert_eq!(try_with(&|c| c.merged = vec![(p, point)]), no_point);
    assert_eq!(try_with(&|c| c.merged = vec![(point, p)]), no_point);
    assert_eq!(try_with(&|c| c.merged = vec![(p, p)]), MapError::MergeWithItself { point: p });
    assert_eq!(try_with(&|c| c.loop_edges = vec![(k, keyframe)]), no_keyframe);
    assert_eq!(try_with(&|c| c.loop_edges = vec![(keyframe, k)]), no_keyframe);
    assert_eq!(try_with(&|c| c.loop_edges = vec![(k, k)]), MapError::LoopToItself { keyframe: k });
}

#[test]
fn a_follower_thrown_out_of_range_refuses_the_correction() {
    let mut map = row_of_keyframes(2);
    let far = |x: f64| SE3::new(SO3::identity(), Vec3::new(x, 0.0, 0.0));
    map.set_estimates(&[(KeyframeId(0), far(0.0))], &[]).unwrap();
    let seen_revision = map.revision();
    add(&mut map, &[], &[]);
    map.set_estimates(&[(KeyframeId(1), far(0.0)), (KeyframeId(2), far(9e11))], &[]).unwrap();
    let keyframes = vec![KeyframeCorrection::rigid(KeyframeId(1), far(9e11))];
    let correction = Correction { keyframes, seen_revision, ..Correction::default() };
    let error = refused(&mut map, |m| m.apply_correction(&correction));
    assert_eq!(error, MapError::Pose { keyframe: KeyframeId(2), defect: PoseDefect::NotFinite });
}
