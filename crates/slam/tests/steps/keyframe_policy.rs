//! When a frame becomes a keyframe: the decision from counts, and the counts from a map.

use geometry::SE3;
use map::{KeyframeId, PointId};

use super::*;
use crate::Params;
use crate::scene::{Scene, Shot, add, at, chain, line, params, shot};

const QUIET: Counts = Counts {
    frames_since_keyframe: 3,
    max_gap: 10,
    mapper_idle: false,
    monocular: false,
    n_keyframes: 5,
    reference_points: 400,
    inliers: 350,
    close_tracked: 200,
    close_untracked: 200,
    ratio: 0.75,
    close_tracked_min: 100,
    close_untracked_max: 70,
};

#[test]
fn a_well_tracked_frame_is_no_keyframe() {
    assert_eq!(decide(&QUIET), None);
    assert_eq!(decide(&Counts { mapper_idle: true, frames_since_keyframe: 10, ..QUIET }), None);
}

#[test]
fn few_shared_points_wait_for_the_mapper_or_the_gap() {
    let few = Counts { inliers: 299, ..QUIET };
    assert_eq!(decide(&few), None);
    assert_eq!(decide(&Counts { mapper_idle: true, ..few }), Some(KeyframeReason::FewShared));
    assert_eq!(decide(&Counts { frames_since_keyframe: 10, ..few }), Some(KeyframeReason::FewShared));
    assert_eq!(decide(&Counts { inliers: 300, mapper_idle: true, ..few }), None);
}

#[test]
fn weak_tracking_waits_for_nobody() {
    assert_eq!(decide(&Counts { inliers: 99, ..QUIET }), Some(KeyframeReason::FewShared));
    assert_eq!(decide(&Counts { inliers: 100, ..QUIET }), None);
    assert_eq!(
        decide(&Counts { close_tracked: 99, close_untracked: 71, ..QUIET }),
        Some(KeyframeReason::FewClose)
    );
    assert_eq!(decide(&Counts { close_tracked: 99, close_untracked: 70, ..QUIET }), None);
    assert_eq!(decide(&Counts { close_tracked: 100, close_untracked: 71, ..QUIET }), None);
}

#[test]
fn a_frame_that_is_nearly_lost_becomes_a_keyframe_while_it_can() {
    let nearly = Counts { inliers: 49, reference_points: 50, close_untracked: 71, ..QUIET };
    assert_eq!(decide(&nearly), Some(KeyframeReason::FewClose));
    assert_eq!(decide(&Counts { inliers: 50, ..nearly }), None);
    assert_eq!(decide(&Counts { close_untracked: 70, ..nearly }), None, "it would have nothing to give");
}

#[test]
fn one_camera_waits_for_the_mapper_however_weak() {
    let weak = Counts { inliers: 99, monocular: true, close_untracked: 0, ..QUIET };
    assert_eq!(decide(&weak), None);
    assert_eq!(decide(&Counts { mapper_idle: true, ..weak }), Some(KeyframeReason::FewShared));
}

#[test]
fn too_few_inliers_are_not_worth_a_keyframe() {
    assert_eq!(decide(&Counts { inliers: 15, ..QUIET }), None);
    assert_eq!(decide(&Counts { inliers: 16, ..QUIET }), Some(KeyframeReason::FewClose));
}

#[test]
fn a_map_of_one_keyframe_is_content_with_less() {
    let young = Counts { n_keyframes: 1, mapper_idle: true, ..QUIET };
    assert_eq!(decide(&Counts { inliers: 160, ..young }), None);
    assert_eq!(decide(&Counts { inliers: 159, ..young }), Some(KeyframeReason::FewShared));
}

#[test]
fn an_observation_with_depth_counts_twice() {
    let scene = Scene::wall(4);
    let mut map = scene.map(&[SE3::identity()]);
    let shots: Vec<Shot> = (0..4).map(|i| Shot { stereo: i < 2, ..shot(i) }).collect();
    let pose = at(0.2, 0.0, 0.0);
    add(&mut map, scene.frame(1, &pose, &shots), &pose, &[(1, 1), (2, 2)], &[]);
    let count = |id| stereo_observations(&map, map.point(PointId(id)).unwrap());
    assert_eq!([count(0), count(1), count(2)], [2, 4, 3]);
}

/// The decision for a frame that shows all 40 points of the newest of `n_keyframes` keyframes and matches `n_matched`.
fn decided(
    n_keyframes: u32,
    n_matched: u32,
    params: &Params,
    change: impl Fn(&mut Tracker),
) -> Option<KeyframeReason> {
    let map = chain(&line(n_keyframes, 1.0), 20);
    let reference = KeyframeId(n_keyframes - 1);
    let frame = map.keyframe(reference).unwrap().frame.clone();
    let matches: Vec<(u32, PointId)> = (0..n_matched).map(|i| (i, PointId(i))).collect();
    let local = LocallyTracked {
        cam_from_world: SE3::identity(),
        reference,
        cam_from_reference: SE3::identity(),
        matched: matches.clone(),
        matches,
        counts: Vec::new(),
        stats: super::super::TrackStats::default(),
        aligned: None,
        shifts: Vec::new(),
    };
    let mut tracker = Tracker::new(params.clone());
    tracker.last_keyframe_index = frame.index;
    change(&mut tracker);
    tracker.decide_keyframe(&frame, &map, &local, true)
}

#[test]
fn the_reference_counts_points_with_three_observations() {
    // Of the last keyframe 20 points have four observations (two keyframes, stereo), 20 have two. In a map of three
    // keyframes only the former count: 0.75 of them are 15; with two keyframes all 40 do: 30.
    let mut relaxed = params();
    relaxed.tracking.close_untracked_max = 100_000;
    assert_eq!(decided(3, 19, &relaxed, |_| {}), None);
    assert_eq!(decided(2, 29, &relaxed, |_| {}), Some(KeyframeReason::FewShared));
    assert_eq!(decided(2, 30, &relaxed, |_| {}), None);
    relaxed.tracking.keyframe_ratio = Some(0.96);
    assert_eq!(decided(3, 19, &relaxed, |_| {}), Some(KeyframeReason::FewShared));
}

#[test]
fn close_features_are_those_nearer_than_the_limit() {
    // 20 matched, 20 not; all are 8 to 12 m away. Limits are those of 2000 features, a fiftieth of them holds for 40.
    let with = |close_depth_m: f64, close_untracked_max: usize| {
        let mut params = params();
        params.camera.close_depth_m = close_depth_m;
        params.tracking.close_untracked_max = close_untracked_max;
        decided(3, 20, &params, |_| {})
    };
    assert_eq!(with(20.0, 950), Some(KeyframeReason::FewClose));
    assert_eq!(with(20.0, 1000), None);
    assert_eq!(with(7.0, 0), None, "none is close");
}

#[test]
fn a_map_that_is_only_read_gets_no_keyframe() {
    let mut only = params();
    only.tracking.close_untracked_max = 0;
    assert!(decided(3, 20, &only, |_| {}).is_some());
    only.tracking.localize_only = true;
    assert_eq!(decided(3, 20, &only, |_| {}), None);
}
