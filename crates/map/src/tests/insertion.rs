//! `insert`: ids, parents, probation, derived data, refusals.

use features::Descriptor;
use geometry::{Mat3, SE3, SO3, Vec3};

use super::world::*;
use crate::{Batch, KeyframeId, Map, MapError, NewKeyframe, NewPoint, Parent, PointId, PoseDefect};

#[test]
fn ids_are_dense_and_the_caller_can_predict_them() {
    let mut map = Map::new();
    assert_eq!((map.next_keyframe_id(), map.next_point_id()), (KeyframeId(0), PointId(0)));
    let keyframe = Some(new_keyframe(&map, &[]));
    let points = vec![new_point(&[(0, 3)]), new_point(&[(0, 5)])];
    let inserted = map.insert(Batch { keyframe, points }).unwrap();
    assert_eq!(inserted.keyframe, Some(KeyframeId(0)));
    assert_eq!(inserted.points, [PointId(0), PointId(1)]);
    assert_eq!((map.next_keyframe_id(), map.next_point_id()), (KeyframeId(1), PointId(2)));
    assert_eq!((map.n_keyframes(), map.n_points(), map.revision()), (1, 2, 1));
    let k = map.keyframe(KeyframeId(0)).unwrap();
    assert_eq!((k.point_at(3), k.point_at(4), k.point_at(999)), (Some(PointId(0)), None, None));
    assert_eq!((k.points().iter().flatten().count(), k.inserted_at), (2, 1));
    let seen: Vec<(u32, PointId)> = map.points_of(KeyframeId(0)).map(|(f, p)| (f, p.id)).collect();
    assert_eq!(seen, [(3, PointId(0)), (5, PointId(1))]);
}

#[test]
fn the_first_keyframe_is_the_root_and_others_hang_on_the_best_covisible() {
    let mut map = Map::new();
    add(&mut map, &[], &[&[(0, 0)], &[(0, 1)], &[(0, 2)]]);
    add(&mut map, &[(0, 0)], &[&[(1, 1)]]);
    add(&mut map, &[(0, 0), (1, 1), (2, 3)], &[]);
    let k = |i| map.keyframe(KeyframeId(i)).unwrap();
    assert_eq!(map.roots(), [KeyframeId(0)]);
    assert_eq!([k(0).parent(), k(1).parent()], [None, Some(KeyframeId(0))]);
    // Two points shared with each of 0 and 1: the smaller id.
    assert_eq!(k(2).covisible(), [(KeyframeId(0), 2), (KeyframeId(1), 2)]);
    assert_eq!(k(2).parent(), Some(KeyframeId(0)));
    assert_eq!(k(0).children(), ids(&[1, 2]));
    assert_eq!(k(0).covisible(), [(KeyframeId(2), 2), (KeyframeId(1), 1)]);
    assert_eq!(k(0).best_covisible(1), [(KeyframeId(2), 2)]);
    assert_eq!(k(0).best_covisible(9).len(), 2);
    assert_eq!(k(0).covisible_at_least(2), [(KeyframeId(2), 2)]);
    assert_eq!(k(0).covisible_at_least(3), []);
    // All weights above the limit: all are returned.
    assert_eq!(k(0).covisible_at_least(1).len(), 2);
    assert_eq!((k(0).shared_points(KeyframeId(1)), k(0).shared_points(KeyframeId(0))), (1, 0));
}

#[test]
fn a_parent_can_be_given_and_is_the_newest_if_nothing_is_shared() {
    let mut map = row_of_keyframes(3);
    let lonely = add(&mut map, &[], &[]);
    assert_eq!(map.keyframe(lonely).unwrap().parent(), Some(KeyframeId(2)));
    let keyframe =
        Some(NewKeyframe { parent: Parent::Under(KeyframeId(1)), ..new_keyframe(&map, &[(0, 9)]) });
    let given = map.insert(Batch { keyframe, points: vec![] }).unwrap().keyframe.unwrap();
    assert_eq!(map.keyframe(given).unwrap().parent(), Some(KeyframeId(1)));
    assert_eq!(map.check(), Ok(()));
}

#[test]
fn points_seen_once_are_removed_when_three_newer_keyframes_are_there() {
    let mut map = Map::new();
    add(&mut map, &[], &[&[(0, 0)], &[(0, 1)]]);
    add(&mut map, &[], &[]);
    add(&mut map, &[], &[]);
    assert!(map.is_young(map.point(PointId(1)).unwrap()));
    let keyframe = Some(new_keyframe(&map, &[(7, 0)]));
    map.insert(Batch { keyframe, points: vec![] }).unwrap();
    assert!(!map.is_young(map.point(PointId(0)).unwrap()));
    assert_eq!((map.resolve(PointId(0)), map.resolve(PointId(1))), (Some(PointId(0)), None));
    assert_eq!(map.keyframe(KeyframeId(0)).unwrap().point_at(1), None);
    assert_eq!(map.check(), Ok(()));
}

#[test]
fn a_new_point_is_created_by_the_newest_keyframe_and_refers_to_it_if_seen_there() {
    let mut map = row_of_keyframes(3);
    let points = vec![new_point(&[(2, 30), (0, 30)]), new_point(&[(1, 31), (0, 31)])];
    let inserted = map.insert(Batch { keyframe: None, points }).unwrap();
    let p = |i: usize| map.point(inserted.points[i]).unwrap();
    assert_eq!(p(0).observations(), [at(0, 30), at(2, 30)]);
    assert_eq!((p(0).created_by, p(0).reference), (KeyframeId(2), KeyframeId(2)));
    assert_eq!((p(1).created_by, p(1).reference), (KeyframeId(2), KeyframeId(0)));
    assert_eq!((p(0).feature_in(KeyframeId(2)), p(0).feature_in(KeyframeId(1))), (Some(30), None));
    assert_eq!((inserted.keyframe, map.check()), (None, Ok(())));
}

#[test]
fn derived_data_have_the_values_of_their_definition() {
    let descriptors = [Descriptor([0; 4]), Descriptor([0xff, 0, 0, 0]), Descriptor([0x0f, 0, 0, 0])];
    let centers = [Vec3::new(0.0, 0.0, 0.0), Vec3::new(6.0, 0.0, 0.0), Vec3::new(0.0, 8.0, 0.0)];
    let mut map = Map::new();
    for i in 0..3 {
        let frame = frame_of(0, &[(3, descriptors[i])]);
        let cam_from_world = SE3::new(SO3::identity(), -centers[i]);
        let matches = if i == 0 { vec![] } else { vec![(0, PointId(0))] };
        let keyframe = Some(NewKeyframe { frame, cam_from_world, matches, parent: Parent::Closest });
        let point = NewPoint { position: Vec3::new(0.0, 0.0, 8.0), observations: vec![at(0, 0)] };
        let points = if i == 0 { vec![point] } else { vec![] };
        map.insert(Batch { keyframe, points }).unwrap();
    }
    let p = map.point(PointId(0)).unwrap();
    // Distances 0-1: 8, 0-2: 4, 1-2: 4, so all lower medians are 4 and the smallest id wins.
    assert_eq!(p.descriptor, descriptors[0]);
    assert!((p.max_distance_m - 8.0 * 1.2_f64.powi(3)).abs() < 1e-5);
    assert!((p.min_distance_m - 8.0 * 1.2_f64.powi(3 - 7)).abs() < 1e-5);
    let half = 0.5_f64.sqrt();
    let sum = Vec3::new(0.0, 0.0, 1.0) + Vec3::new(-0.6, 0.0, 0.8) + Vec3::new(0.0, -half, half);
    assert!((p.normal - sum.normalize()).norm() < 1e-12);
}

#[test]
fn the_representative_descriptor_is_the_middle_one() {
    let mut map = Map::new();
    // Numbers of set bits: distances are their differences.
    for (i, bits) in [0_u32, 30, 12, 10, 20].into_iter().enumerate() {
        let frame = frame_of(0, &[(0, Descriptor([(1 << bits) - 1, 0, 0, 0]))]);
        let matches = if i == 0 { vec![] } else { vec![(0, PointId(0))] };
        let keyframe = Some(NewKeyframe { frame, matches, ..new_keyframe(&map, &[]) });
        let points = if i == 0 { vec![new_point(&[(0, 0)])] } else { vec![] };
        map.insert(Batch { keyframe, points }).unwrap();
    }
    // Lower median of the distances to the four others: 0 -> 12, 30 -> 18, 12 -> 8, 10 -> 10, 20 -> 10.
    assert_eq!(map.point(PointId(0)).unwrap().descriptor, Descriptor([(1 << 12) - 1, 0, 0, 0]));
    // Without it: 0 -> 20, 30 -> 20, 10 -> 10, 20 -> 10: the smaller id.
    map.unlink(PointId(0), KeyframeId(2)).unwrap();
    assert_eq!(map.point(PointId(0)).unwrap().descriptor, Descriptor([(1 << 10) - 1, 0, 0, 0]));
}

#[test]
fn a_camera_in_the_point_or_cameras_around_it_leave_a_finite_normal() {
    let mut map = Map::new();
    add(&mut map, &[], &[]);
    let pose = map.keyframe(KeyframeId(0)).unwrap().cam_from_world;
    let points = vec![NewPoint { position: pose.center(), observations: vec![at(0, 0)] }];
    map.insert(Batch { keyframe: None, points }).unwrap();
    let p = map.point(PointId(0)).unwrap();
    assert!((p.normal.norm() - 1.0).abs() < 1e-12 && p.max_distance_m.abs() < 1e-12);
    assert_eq!(map.check(), Ok(()));
}

fn refused_batch(map: &mut Map, keyframe: Option<NewKeyframe>, points: &[&[(u32, u32)]]) -> MapError {
    let points = points.iter().map(|o| new_point(o)).collect();
    refused(map, |m| m.insert(Batch { keyframe, points }))
}

#[test]
fn a_batch_with_a_bad_id_or_feature_is_refused_whole() {
    let mut map = row_of_keyframes(3);
    let with = |map: &Map, matches: &[(u32, u32)]| Some(new_keyframe(map, matches));
    let (keyframe, point) = (KeyframeId(3), PointId(12));
    let k = with(&map, &[(0, 1), (1, 12)]);
    assert_eq!(refused_batch(&mut map, k, &[]), MapError::NoPoint { point, next: point });
    let k = with(&map, &[(40, 1)]);
    let no_feature = MapError::NoFeature { keyframe, feature: 40, n_features: 40 };
    assert_eq!(refused_batch(&mut map, k, &[]), no_feature);
    let k = with(&map, &[(0, 1), (2, 1)]);
    assert_eq!(refused_batch(&mut map, k, &[]), MapError::PointTwice { point: PointId(1) });
    let k = with(&map, &[(0, 1), (0, 2)]);
    assert_eq!(refused_batch(&mut map, k, &[]), MapError::FeatureTwice { keyframe, feature: 0 });
    let k = with(&map, &[(0, 1)]);
    let error = refused_batch(&mut map, k, &[&[(3, 1), (2, 30)], &[(3, 0)]]);
    assert_eq!(error, MapError::FeatureTwice { keyframe, feature: 0 });
    let k = with(&map, &[]).map(|k| NewKeyframe { parent: Parent::Under(keyframe), ..k });
    assert_eq!(refused_batch(&mut map, k, &[]), MapError::NoKeyframe { keyframe, next: keyframe });
    let k = with(&map, &[]);
    assert_eq!(
        refused_batch(&mut map, k, &[&[(3, 41)]]),
        MapError::NoFeature { keyframe, feature: 41, n_features: 40 }
    );
}

#[test]
fn a_new_point_with_bad_observations_is_refused() {
    let mut map = row_of_keyframes(3);
    let next = KeyframeId(3);
    let no_keyframe = MapError::NoKeyframe { keyframe: next, next };
    assert_eq!(refused_batch(&mut map, None, &[&[(2, 30)], &[(3, 1)]]), no_keyframe);
    let taken = MapError::FeatureTaken { keyframe: KeyframeId(2), feature: 1, holder: PointId(9) };
    assert_eq!(refused_batch(&mut map, None, &[&[(2, 1)]]), taken);
    let twice = MapError::NewPointObservedTwice { index: 1, keyframe: KeyframeId(2) };
    assert_eq!(refused_batch(&mut map, None, &[&[(1, 30)], &[(2, 30), (2, 31)]]), twice);
    assert_eq!(refused_batch(&mut map, None, &[&[]]), MapError::NewPointUnobserved { index: 0 });
    let nan = NewPoint { position: Vec3::new(0.0, f64::NAN, 0.0), observations: vec![at(2, 30)] };
    let error = refused(&mut map, |m| m.insert(Batch { keyframe: None, points: vec![nan] }));
    assert_eq!(error, MapError::NewPointPosition { index: 0 });
    assert_eq!(error.to_string(), "position of new point number 0 of the batch is not finite");
    assert_eq!(
        refused_batch(&mut Map::new(), None, &[&[(0, 0)]]),
        MapError::NoKeyframe { keyframe: KeyframeId(0), next: KeyframeId(0) }
    );
}

#[test]
fn a_keyframe_with_a_bad_pose_is_refused() {
    let mut map = row_of_keyframes(2);
    let keyframe = KeyframeId(2);
    let mut try_pose = |cam_from_world| {
        let k = Some(NewKeyframe { cam_from_world, ..new_keyframe(&map, &[]) });
        refused_batch(&mut map, k, &[])
    };
    let not_finite = MapError::Pose { keyframe, defect: PoseDefect::NotFinite };
    assert_eq!(try_pose(SE3::new(SO3::identity(), Vec3::new(f64::NAN, 0.0, 0.0))), not_finite);
    assert_eq!(try_pose(SE3::new(SO3::identity(), Vec3::new(1e300, 0.0, 0.0))), not_finite);
    let nan = SO3::from_matrix_unchecked(Mat3::from_element(f64::NAN));
    assert_eq!(try_pose(SE3::new(nan, Vec3::zeros())), not_finite);
    let mirror = SO3::from_matrix_unchecked(Mat3::from_diagonal(&Vec3::new(1.0, 1.0, -1.0)));
    let defect = PoseDefect::NotRotation { deviation: 2.0 };
    assert_eq!(try_pose(SE3::new(mirror, Vec3::zeros())), MapError::Pose { keyframe, defect });
    let stretched = SO3::from_matrix_unchecked(Mat3::identity() * 1.001);
    let error = try_pose(SE3::new(stretched, Vec3::zeros()));
    assert_eq!(error.to_string(), "pose of keyframe K2 has no rotation (deviation 2.0e-3)");
}
