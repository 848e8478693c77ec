//! `set_estimates`: writes what is valid, refuses the rest whole.

use geometry::{Mat3, SE3, SO3, Vec3};

use super::world::*;
use crate::{KeyframeId, MapError, PointId, PoseDefect};

#[test]
fn poses_and_positions_are_written_and_everything_that_follows_is_renewed() {
    let mut map = row_of_keyframes(5);
    let mut random = generator(3);
    let pose = random_pose(&mut random);
    let position = random_position(&mut random);
    let (untouched, watched) = (PointId(16), PointId(4));
    let before = map.clone();
    map.set_estimates(&[(KeyframeId(1), pose)], &[(PointId(0), position)]).unwrap();
    assert_eq!(map.keyframe(KeyframeId(1)).unwrap().cam_from_world, pose);
    assert_eq!(map.point(PointId(0)).unwrap().position, position);
    // Point 4 is not listed, but keyframe 1 observes it and is its reference.
    let (old, new) = (before.point(watched).unwrap(), map.point(watched).unwrap());
    assert_eq!(old.position, new.position);
    assert_ne!(old.normal, new.normal);
    assert_ne!(old.max_distance_m, new.max_distance_m);
    assert_eq!(before.point(untouched).unwrap().normal, map.point(untouched).unwrap().normal);
    assert_eq!(map.revision(), before.revision() + 1);
    assert_eq!(map.check(), Ok(()));
}

#[test]
fn writing_what_is_there_changes_nothing() {
    let mut map = row_of_keyframes(5);
    let before = map.digest();
    let poses: Vec<_> = map.keyframes().map(|k| (k.id, k.cam_from_world)).collect();
    let positions: Vec<_> = map.points().map(|p| (p.id, p.position)).collect();
    map.set_estimates(&poses, &positions).unwrap();
    assert_eq!(map.digest(), before);
}

#[test]
fn moving_the_world_keeps_distances_and_turns_normals() {
    let mut map = row_of_keyframes(6);
    let before = map.clone();
    let new_from_old = random_pose(&mut generator(11));
    let poses: Vec<_> = map.keyframes().map(|k| (k.id, k.cam_from_world * new_from_old.inverse())).collect();
    let positions: Vec<_> = map.points().map(|p| (p.id, new_from_old * p.position)).collect();
    map.set_estimates(&poses, &positions).unwrap();
    assert!(largest_gap(&before, &map) > 0.1, "the world moved");
    for (old, new) in before.points().zip(map.points()) {
        assert!((old.max_distance_m - new.max_distance_m).abs() < 1e-10 * old.max_distance_m);
        assert!((old.min_distance_m - new.min_distance_m).abs() < 1e-10 * old.max_distance_m);
        assert!((new_from_old.rotation * old.normal - new.normal).norm() < 1e-10);
        assert_eq!((old.descriptor, old.reference), (new.descriptor, new.reference));
    }
    assert_eq!(map.check(), Ok(()));
}

#[test]
fn one_bad_entry_refuses_the_whole_solution() {
    let mut map = row_of_keyframes(3);
    let good_pose = (KeyframeId(1), random_pose(&mut generator(1)));
    let good = (PointId(2), Vec3::zeros());
    let (keyframe, point) = (KeyframeId(2), PointId(5));

    let no_keyframe = MapError::NoKeyframe { keyframe: KeyframeId(3), next: KeyframeId(3) };
    let poses = [good_pose, (KeyframeId(3), SE3::identity())];
    assert_eq!(refused(&mut map, |m| m.set_estimates(&poses, &[good])), no_keyframe);
    let no_point = MapError::NoPoint { point: PointId(12), next: PointId(12) };
    let positions = [good, (PointId(12), Vec3::zeros())];
    assert_eq!(refused(&mut map, |m| m.set_estimates(&[good_pose], &positions)), no_point);

    let bad = SE3::new(SO3::from_matrix_unchecked(Mat3::identity() * 2.0), Vec3::zeros());
    let error = refused(&mut map, |m| m.set_estimates(&[good_pose, (keyframe, bad)], &[good]));
    assert_eq!(error, MapError::Pose { keyframe, defect: PoseDefect::NotRotation { deviation: 3.0 } });
    let bad = Vec3::new(0.0, 0.0, f64::INFINITY);
    let error = refused(&mut map, |m| m.set_estimates(&[good_pose], &[good, (point, bad)]));
    assert_eq!(error, MapError::Position { point });

    let error = refused(&mut map, |m| m.set_estimates(&[good_pose, good_pose], &[]));
    assert_eq!(error, MapError::KeyframeTwice { keyframe: KeyframeId(1) });
    let error = refused(&mut map, |m| m.set_estimates(&[], &[good, (point, Vec3::zeros()), good]));
    assert_eq!(error, MapError::PointTwice { point: PointId(2) });
}
