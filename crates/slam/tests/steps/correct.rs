//! From a verified loop to new poses: pose graph, scale, or the motion of a whole sub-map.

use geometry::{SO3, Vec3};
use map::PointId;

use super::*;
use crate::CameraParams;
use crate::scene::{Scene, add_under, at, chain, gap, on_circle, params};

const N: u32 = 16;

fn truth(k: u32) -> SE3 {
    on_circle(k, N, 8.0)
}

/// Poses of a round whose every step is wrong by `step_error`, lengths growing by `growth` per step.
fn drifted(step_error: &SE3, growth: f64) -> Vec<SE3> {
    let mut poses = vec![truth(0)];
    let mut scale = 1.0;
    for k in 1..N {
        let mut motion = *step_error * truth(k) * truth(k - 1).inverse();
        scale *= growth;
        motion.translation *= scale;
        poses.push(motion * poses[k as usize - 1]);
    }
    poses
}

fn verified(cam_from_world: SE3, scale: f64, matches: Vec<(u32, PointId)>) -> Verified {
    Verified { matched: KeyframeId(0), cam_from_world, scale, matches, earlier_points: vec![PointId(0)] }
}

/// Largest distance of the keyframes' centers from the truth.
fn worst(keyframes: &[KeyframeCorrection]) -> f64 {
    let error = |k: &KeyframeCorrection| (k.cam_from_world.center() - truth(k.keyframe.0).center()).norm();
    keyframes.iter().map(error).fold(0.0, f64::max)
}

#[test]
fn a_rigid_loop_spreads_the_drift_over_the_round() {
    let error = SE3::new(SO3::exp(&Vec3::new(0.0, 0.004, 0.0)), Vec3::new(0.01, 0.0, 0.01));
    let poses = drifted(&error, 1.0);
    let before = (poses[15].center() - truth(15).center()).norm();
    let map = chain(&poses, 16);
    let found =
        correct(KeyframeId(15), &verified(truth(15), 1.0, Vec::new()), &map, &params(), None).unwrap();
    let keyframes = &found.correction.keyframes;
    assert_eq!(keyframes.len(), 16);
    assert!(gap(&keyframes[0].cam_from_world, &poses[0]) < 1e-12, "the root stays");
    assert!(keyframes.iter().all(|k| k.scale == 1.0));
    assert!(before > 0.3 && worst(keyframes) < 0.25 * before, "{before} m, now {} m", worst(keyframes));
    let last = (keyframes[15].cam_from_world.center() - truth(15).center()).norm();
    assert!(last < 0.1 * before, "{last} m where the loop says it is");
    assert!((found.moved_m - before).abs() < 1e-9 && found.turned_deg > 2.0, "{found:?}");
    assert_eq!((found.keyframe, found.matched, found.joins_submaps), (KeyframeId(15), KeyframeId(0), false));
    assert_eq!(found.correction.loop_edges, vec![(KeyframeId(0), KeyframeId(15))]);
    assert_eq!(found.correction.seen_revision, map.revision());
}

#[test]
fn one_camera_takes_back_the_drift_of_its_scale() {
    let poses = drifted(&SE3::identity(), 1.02);
    let map = chain(&poses, 16);
    let mut mono = crate::Params::of(CameraParams::mono(10.0));
    mono.camera.unit = 1.0;
    let scale = 1.02_f64.powi(15);
    let before = (poses[15].center() - truth(15).center()).norm();
    let found = correct(KeyframeId(15), &verified(truth(15), scale, Vec::new()), &map, &mono, None).unwrap();
    let keyframes = &found.correction.keyframes;
    let last = &keyframes[15];
    // What was `scale` long around the last keyframe is 1 long again.
    assert!((last.scale * scale - 1.0).abs() < 0.03, "{} instead of {}", last.scale, 1.0 / scale);
    assert!((keyframes[8].scale * 1.02_f64.powi(8) - 1.0).abs() < 0.04, "{}", keyframes[8].scale);
    assert!(worst(keyframes) < 0.3 * before, "{before} m, now {} m", worst(keyframes));
}

#[test]
fn a_pose_with_a_scale_becomes_a_pose_and_the_factor_of_lengths() {
    let rotation = SO3::exp(&Vec3::new(0.1, 0.2, 0.3));
    let sim = Sim3::new(rotation, Vec3::new(2.0, 4.0, 6.0), 2.0);
    let corrected = corrected(KeyframeId(3), &sim);
    assert_eq!(corrected.scale, 0.5);
    assert!(gap(&corrected.cam_from_world, &SE3::new(rotation, Vec3::new(1.0, 2.0, 3.0))) < 1e-12);
}

#[test]
fn variances_follow_length_and_angle() {
    let motion = SE3::new(SO3::exp(&Vec3::new(0.1, 0.0, 0.0)), Vec3::new(0.0, 2.0, 0.0));
    let v = variances(&motion, 1.0);
    assert!((v[0].sqrt() - (0.005 + 0.02)).abs() < 1e-12 && v[0] == v[2]);
    assert!((v[3].sqrt() - (5e-4 + 2e-4 + 1e-3)).abs() < 1e-12 && v[3] == v[5]);
    assert!((v[6].sqrt() - 0.01).abs() < 1e-12);
    let v = variances(&motion, 0.1);
    assert!((v[0].sqrt() - (0.0005 + 0.02)).abs() < 1e-12);
    assert!((v[3].sqrt() - (5e-4 + 2e-3 + 1e-3)).abs() < 1e-12);
}

#[test]
fn lengths_that_differ_threefold_are_not_drift() {
    let map = chain(&(0..N).map(truth).collect::<Vec<_>>(), 16);
    for scale in [3.01, 0.332, f64::NAN, -1.0] {
        let result = correct(KeyframeId(15), &verified(truth(15), scale, Vec::new()), &map, &params(), None);
        assert!(matches!(result, Err(NoLoop::Scale { limit: 3.0, .. })), "{scale}");
    }
    assert!(correct(KeyframeId(15), &verified(truth(15), 1.0, Vec::new()), &map, &params(), None).is_ok());
}

#[test]
fn a_loop_against_the_path_is_refused() {
    let map = chain(&(0..N).map(truth).collect::<Vec<_>>(), 16);
    let wrong = at(6.0, 0.0, 0.0) * truth(15);
    let result = correct(KeyframeId(15), &verified(wrong, 1.0, Vec::new()), &map, &params(), None);
    assert!(matches!(result, Err(NoLoop::Inconsistent { .. })));
}

#[test]
fn matched_points_of_both_visits_are_merged_the_earlier_one_stays() {
    let map = chain(&(0..N).map(truth).collect::<Vec<_>>(), 16);
    let here = map.keyframe(KeyframeId(15)).unwrap();
    let own = here.point_at(3).unwrap();
    // Feature 4 shows the earlier point already.
    let matches = vec![(3, PointId(1)), (4, here.point_at(4).unwrap())];
    let found = correct(KeyframeId(15), &verified(truth(15), 1.0, matches), &map, &params(), None).unwrap();
    assert_eq!(found.correction.merged, vec![(PointId(1), own)]);
    assert_eq!((found.inliers, found.earlier_points.len()), (2, 1));
}

/// Two sub-maps: a chain of four, and a single keyframe at `pose` in coordinates of its own.
fn two_submaps(pose: &SE3) -> Map {
    let mut map = chain(&(0..4).map(truth).collect::<Vec<_>>(), 16);
    let scene = Scene::wall(20);
    add_under(&mut map, scene.whole(9, pose), pose, &[], &[(0, scene.landmarks[0])], map::Parent::NewSubmap);
    map
}

#[test]
fn the_younger_sub_map_moves_as_a_whole_to_where_the_loop_puts_it() {
    let map = two_submaps(&at(3.0, 1.0, 2.0));
    // The newest keyframe saw keyframe 0's place from `placed`, in lengths twice as long.
    let placed = at(0.5, 0.0, 0.3);
    let found = correct(KeyframeId(4), &verified(placed, 2.0, Vec::new()), &map, &params(), None).unwrap();
    assert!(found.joins_submaps);
    assert_eq!(found.correction.joined, vec![(KeyframeId(4), KeyframeId(0))]);
    let [moved] = &found.correction.keyframes[..] else { panic!("{:?}", found.correction.keyframes) };
    assert_eq!(moved.keyframe, KeyframeId(4));
    assert!(gap(&moved.cam_from_world, &placed) < 1e-9);
    assert!((moved.scale - 0.5).abs() < 1e-12, "{}", moved.scale);
    let mut joined = map.clone();
    joined.apply_correction(&found.correction).unwrap();
    assert_eq!(joined.roots(), [KeyframeId(0)]);
}

#[test]
fn the_older_sub_map_stays_even_if_it_saw_the_younger_one_again() {
    let pose = at(3.0, 1.0, 2.0);
    let map = two_submaps(&pose);
    // Keyframe 3 of the older sub-map sees the place of keyframe 4 from `placed` in its coordinates.
    let placed = at(3.5, 1.0, 2.0);
    let again = Verified { matched: KeyframeId(4), ..verified(placed, 1.0, Vec::new()) };
    let found = correct(KeyframeId(3), &again, &map, &params(), None).unwrap();
    assert_eq!(found.correction.joined, vec![(KeyframeId(4), KeyframeId(3))]);
    let [moved] = &found.correction.keyframes[..] else { panic!("{:?}", found.correction.keyframes) };
    // Seen from keyframe 3 the younger keyframe stays where the loop says it is.
    let expected = pose * placed.inverse() * truth(3);
    assert!(gap(&moved.cam_from_world, &expected) < 1e-9);
}
