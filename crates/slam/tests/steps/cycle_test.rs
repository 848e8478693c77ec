//! A loop must agree with the path between its visits.

use geometry::{SO3, Vec3};
use optim::Inconsistency;

use super::*;
use crate::scene::{chain, line, on_circle, params};

#[test]
fn uncertainty_grows_with_length_angle_and_the_number_of_edges() {
    let motion = SE3::new(SO3::exp(&Vec3::new(0.0, 0.2, 0.0)), Vec3::new(0.0, 0.0, 3.0));
    let camera = CameraParams { drift_sigma: 0.02, unit: 1.0, ..params().camera };
    let edge = drift_model(&camera).edge(4, 5, motion, 2.0);
    assert_eq!((edge.a, edge.b, edge.kind), (4, 5, CycleEdgeKind::Odometry));
    // 1 cm and 2 % of 3 m, twice; 1 mrad, 0.05 mrad per meter and 5 mrad per radian, twice.
    assert!((edge.sigma_m - (0.01 + 2.0 * 0.06)).abs() < 1e-12);
    assert!((edge.sigma_rad - (1e-3 + 2.0 * (1.5e-4 + 1e-3))).abs() < 1e-12);
    // Where a meter has the length 0.1, the same motion is ten times as long in meters.
    let edge = drift_model(&CameraParams { unit: 0.1, ..camera }).edge(4, 5, motion, 2.0);
    assert!((edge.sigma_m - (0.001 + 2.0 * 0.06)).abs() < 1e-12);
    assert!((edge.sigma_rad - (1e-3 + 2.0 * (1.5e-3 + 1e-3))).abs() < 1e-12);
    let edge = candidate(1, 2, motion, 0.1);
    assert!((edge.sigma_m - 0.01).abs() < 1e-12 && (edge.sigma_rad - 5e-3).abs() < 1e-12);
    assert_eq!(edge.kind, CycleEdgeKind::Candidate);
}

#[test]
fn the_path_leads_over_the_last_common_ancestor() {
    let mut map = chain(&line(6, 1.0), 4);
    let scene = crate::scene::Scene::wall(4);
    for parent in [2, 6] {
        let pose = SE3::identity();
        let under = map::Parent::Under(KeyframeId(parent));
        crate::scene::add_under(&mut map, scene.whole(9, &pose), &pose, &[], &[], under);
    }
    let graph = EssentialGraph::new(&map, KeyframeId(0), 100);
    let length = |a, b| path_length(&graph, &map, a, b);
    assert_eq!([length(5, 0), length(0, 5), length(3, 3)], [5, 5, 0]);
    assert_eq!([length(5, 6), length(5, 7), length(7, 1)], [4, 5, 3]);
}

/// Verdict on a loop from the last to the first keyframe of a circle, `off` from what the map says.
fn verdict(off: &SE3) -> LoopVerdict {
    let poses: Vec<SE3> = (0..12).map(|k| on_circle(k, 12, 2.0)).collect();
    let map = chain(&poses, 16);
    let graph = EssentialGraph::new(&map, KeyframeId(0), 100);
    let here_from_there = *off * poses[11] * poses[0].inverse();
    test(&graph, &map, KeyframeId(11), KeyframeId(0), &here_from_there, &params()).unwrap()
}

fn shift(x: f64) -> SE3 {
    SE3::new(SO3::identity(), Vec3::new(x, 0.0, 0.0))
}

fn turn(degrees: f64) -> SE3 {
    SE3::new(SO3::exp(&Vec3::new(0.0, degrees.to_radians(), 0.0)), Vec3::zeros())
}

#[test]
fn drift_is_allowed_and_more_is_not() {
    assert!(verdict(&SE3::identity()).is_consistent());
    assert!(verdict(&shift(0.3)).is_consistent());
    assert!(verdict(&turn(1.0)).is_consistent());
    let refused = |off: SE3| match verdict(&off) {
        LoopVerdict::Inconsistent { reason, .. } => reason,
        other => panic!("{other:?}"),
    };
    assert!(matches!(refused(shift(3.0)), Inconsistency::Translation { .. }));
    assert!(matches!(refused(turn(12.0)), Inconsistency::Rotation { .. }));
}

#[test]
fn the_direction_of_the_loop_matters() {
    // The motion from here to there instead of there to here.
    let poses: Vec<SE3> = (0..12).map(|k| on_circle(k, 12, 2.0)).collect();
    let map = chain(&poses, 16);
    let graph = EssentialGraph::new(&map, KeyframeId(0), 100);
    let there_from_here = poses[0] * poses[11].inverse();
    let verdict = test(&graph, &map, KeyframeId(11), KeyframeId(0), &there_from_here, &params());
    assert!(matches!(verdict, Some(LoopVerdict::Inconsistent { .. })), "{verdict:?}");
}

#[test]
fn keyframes_of_two_sub_maps_cannot_be_tested() {
    let map = chain(&line(3, 1.0), 4);
    let graph = EssentialGraph::new(&map, KeyframeId(0), 100);
    let verdict = test(&graph, &map, KeyframeId(2), KeyframeId(7), &SE3::identity(), &params());
    assert_eq!(verdict, None);
}
