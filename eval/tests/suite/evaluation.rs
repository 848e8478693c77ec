//! The one evaluator: lost frames, lengths, the end of the path, scale.

use dsslam_eval::{Alignment, Estimate, Evaluation, EvaluationOptions, LostFrames};
use geometry::{SE3, SO3, Vec3};
use io::{StampedPose, Trajectory};

/// A drive of 1 m per frame along an arc that, from frame 120 to 180, turns by `turn` radians per frame; ten frames a second.
fn arc(n: u32, turn: f64) -> Trajectory {
    let mut pose = SE3::identity();
    let stamped = |i: u32| {
        let here = StampedPose { timestamp_s: f64::from(i) * 0.1, world_from_cam: pose };
        let turn = if (120..180).contains(&i) { turn } else { 0.005 };
        pose = pose * SE3::new(SO3::exp(&Vec3::new(0.0, turn, 0.0)), Vec3::new(0.0, 0.0, 1.0));
        here
    };
    Trajectory { poses: (0..n).map(stamped).collect() }
}

/// The true path moved as a whole, which no metric may notice, without the frames of `lost`.
fn perfect(truth: &Trajectory, lost: std::ops::Range<usize>) -> Estimate {
    let moved = SE3::new(SO3::exp(&Vec3::new(0.1, -0.4, 0.2)), Vec3::new(-3.0, 1.0, 7.0));
    let frame = |(i, pose): (usize, &StampedPose)| {
        (pose.timestamp_s, (!lost.contains(&i)).then(|| moved * pose.world_from_cam))
    };
    Estimate::new(truth.poses.iter().enumerate().map(frame))
}

fn evaluate(estimate: &Estimate, truth: &Trajectory, alignment: Alignment) -> Evaluation {
    let options = EvaluationOptions { alignment, ..EvaluationOptions::default() };
    Evaluation::of(estimate, truth, &options).unwrap()
}

#[test]
fn a_perfect_run_in_another_frame_has_no_error() {
    let truth = arc(150, 0.005);
    // No segment starts or ends there.
    let found = evaluate(&perfect(&truth, 41..42), &truth, Alignment::Se3);
    assert_eq!((found.ate_m.n, found.n_used, found.n_est, found.n_gt), (149, 149, 149, 150));
    assert!(found.ate_m.rmse < 1e-9 && found.end_error_m < 1e-9);
    assert!(found.t_rel_percent.is_some_and(|t| t < 1e-9), "100 m fit into the path");
    assert!((found.path_m - 149.0).abs() < 1e-9);
    assert!(found.longest_gap_s.is_some_and(|gap| (gap - 0.2).abs() < 1e-9));
    let (est, gt) = (found.matched.est[7].unwrap(), found.matched.gt[7]);
    assert!((found.aligned(&est.translation) - gt.translation).norm() < 1e-9);
}

#[test]
fn lost_frames_go_on_with_the_last_motion_and_count_in_t_rel() {
    let evaluated = |turn: f64, lost: std::ops::Range<usize>| {
        let truth = arc(300, turn);
        evaluate(&perfect(&truth, lost), &truth, Alignment::Se3)
    };
    let complete = evaluated(0.005, 0..0);
    assert_eq!((complete.coverage.n_lost, complete.n_segments), (0, 20 + 10));
    // The motion goes on as it was: the fill is exact, and no segment is left out.
    let steady = evaluated(0.005, 130..170);
    assert_eq!((steady.coverage.n_lost, steady.coverage.longest_gap, steady.ate_m.n), (40, 40, 260));
    assert_eq!(steady.n_segments, complete.n_segments);
    assert!(steady.t_rel_percent.is_some_and(|t| t < 1e-6));
    // The car turns while it is lost: every pose that there is is right, yet the gap costs.
    let turning = evaluated(-0.01, 110..170);
    assert!(turning.ate_m.rmse < 1e-9, "{}", turning.ate_m.rmse);
    assert!(turning.t_rel_percent.is_some_and(|t| t > 1.0), "{:?}", turning.t_rel_percent);
}

#[test]
fn segments_at_lost_frames_can_be_left_out() {
    let truth = arc(300, -0.01);
    let options = EvaluationOptions { lost: LostFrames::Skip, ..EvaluationOptions::default() };
    let found = Evaluation::of(&perfect(&truth, 110..170), &truth, &options).unwrap();
    assert!(found.n_segments_skipped > 0 && found.t_rel_percent.is_some_and(|t| t < 1e-6));
}

#[test]
fn frames_without_a_true_pose_count_as_lost_but_not_in_the_path() {
    let whole = arc(60, 0.005);
    let truth = Trajectory { poses: whole.poses[..40].to_vec() };
    let found = evaluate(&perfect(&whole, 30..35), &truth, Alignment::Se3);
    assert_eq!((found.n_est, found.n_used, found.n_unmatched), (55, 35, 20));
    assert_eq!((found.coverage.n_frames, found.coverage.n_lost), (60, 5));
    assert!((found.path_m - 39.0).abs() < 1e-9);
}

#[test]
fn the_end_error_is_seen_from_the_first_pose() {
    let truth = arc(50, 0.005);
    let mut estimate = perfect(&truth, 0..0);
    estimate.poses[49].as_mut().unwrap().translation += Vec3::new(0.0, 2.0, 0.0);
    let found = evaluate(&estimate, &truth, Alignment::Se3);
    assert!((found.end_error_m - 2.0).abs() < 1e-9);
    assert!((found.end_error_percent().unwrap() - 200.0 / found.path_m).abs() < 1e-9);
    assert!(found.t_rel_percent.is_none(), "no segment of 100 m");
}

#[test]
fn scale_is_aligned_only_where_it_is_asked_for() {
    let truth = arc(150, 0.005);
    let mut estimate = perfect(&truth, 0..0);
    estimate.poses.iter_mut().flatten().for_each(|pose| pose.translation *= 0.5);
    let free = evaluate(&estimate, &truth, Alignment::Sim3);
    assert!(free.ate_m.rmse < 1e-9 && (free.scale - 2.0).abs() < 1e-9 && free.end_error_m < 1e-9);
    assert!(free.t_rel_percent.is_some_and(|t| t < 1e-9));
    let (est, gt) = (free.matched.est[7].unwrap(), free.matched.gt[7]);
    assert!((free.aligned(&est.translation) - gt.translation).norm() < 1e-9);
    assert!(evaluate(&estimate, &truth, Alignment::Se3).ate_m.rmse > 1.0);
}
