//! Errors of a run against ground truth, by the metrics of `eval`.

use std::borrow::Cow;

use anyhow::Result;
use dsslam::trajectories::{body_records, of_left_camera, own_pose, tracked_poses};
use eval::{Alignment, Association, AteReport, Coverage, Drift, KITTI_LENGTHS_M, TIMESTAMP_TOLERANCE_S};
use geometry::{SE3, Vec3};
use io::{Sensor, StampedPose, Trajectory};
use runtime::FrameRecord;

/// How far a run is from the truth.
#[derive(Clone, Debug)]
pub(crate) struct Evaluation {
    /// Absolute trajectory error of all frames with a pose.
    pub(crate) ate: AteReport,
    /// Relative errors over segments of 100 to 800 m, frames without a pose filled with the last relative motion.
    pub(crate) drift: Drift,
    /// How many frames were filled for the relative errors.
    pub(crate) coverage: Coverage,
    /// Length of the true path over the frames of the run, metres.
    pub(crate) path_m: f64,
    /// Distance from the true to the estimated last position when the first poses are laid on each other, metres.
    pub(crate) end_error_m: f64,
}

impl Evaluation {
    /// [`Evaluation::end_error_m`] in percent of the path; `None` for a camera that stood still.
    pub(crate) fn end_error_percent(&self) -> Option<f64> {
        (self.path_m > 0.0).then(|| 100.0 * self.end_error_m / self.path_m)
    }
}

/// What is aligned before comparing: scale only where one camera cannot know it.
pub(crate) fn alignment_of(sensor: Sensor) -> Alignment {
    match sensor {
        Sensor::Stereo | Sensor::Rgbd => Alignment::Se3,
        Sensor::Mono => Alignment::Sim3,
    }
}

/// Estimate and truth of one and the same thing: the body, or the left camera where the way to the body has no scale.
#[derive(Clone, Debug)]
pub(crate) struct Compared<'a> {
    /// The frames of the run.
    pub(crate) records: Cow<'a, [FrameRecord]>,
    /// True poses.
    pub(crate) truth: Cow<'a, Trajectory>,
}

impl<'a> Compared<'a> {
    /// From the records of the left camera and true poses of the body.
    pub(crate) fn new(
        records: &'a [FrameRecord],
        truth: &'a Trajectory,
        sensor: Sensor,
        body_from_left: &SE3,
    ) -> Self {
        if let Some(body) = body_records(records, sensor, body_from_left) {
            return Compared { records: Cow::Owned(body), truth: Cow::Borrowed(truth) };
        }
        let truth = if *body_from_left == SE3::identity() {
            Cow::Borrowed(truth)
        } else {
            Cow::Owned(of_left_camera(truth, body_from_left))
        };
        Compared { records: Cow::Borrowed(records), truth }
    }

    /// See [`evaluate`].
    ///
    /// # Errors
    /// Those of [`evaluate`].
    pub(crate) fn evaluate(&self, sensor: Sensor) -> Result<Evaluation> {
        evaluate(&self.records, &self.truth, sensor)
    }
}

/// Compares a run with the ground truth, frames matched by their times.
///
/// # Errors
/// When no time matches, or when fewer than three frames have a pose.
fn evaluate(records: &[FrameRecord], truth: &Trajectory, sensor: Sensor) -> Result<Evaluation> {
    let by_time = Association::Timestamp { tolerance_s: TIMESTAMP_TOLERANCE_S };
    let pairs = eval::associate(&tracked_poses(records), truth, by_time)?;
    let ate = eval::ate(&pairs.est, &pairs.gt, alignment_of(sensor))?;
    let (filled, coverage) = eval::fill_lost(&records.iter().map(own_pose).collect::<Vec<_>>())?;
    let (est, gt) = per_frame(records, &filled, truth)?;
    let drift = eval::kitti_drift(&ate.aligned(&est), &gt, &KITTI_LENGTHS_M)?;
    let path_m = gt.windows(2).map(|pair| (pair[1].translation - pair[0].translation).norm()).sum();
    let end_error_m = end_error(&ate.aligned(&pairs.est), &pairs.gt);
    Ok(Evaluation { ate, drift, coverage, path_m, end_error_m })
}

/// The run's frames that have a true pose: the estimate out of `filled`, a pose per record, and the truth.
fn per_frame(records: &[FrameRecord], filled: &[SE3], truth: &Trajectory) -> Result<(Vec<SE3>, Vec<SE3>)> {
    let stamped = |(record, pose): (&FrameRecord, &SE3)| StampedPose {
        timestamp_s: record.timestamp_s,
        world_from_cam: *pose,
    };
    let est = Trajectory { poses: records.iter().zip(filled).map(stamped).collect() };
    let by_time = Association::Timestamp { tolerance_s: TIMESTAMP_TOLERANCE_S };
    let pairs = eval::associate(&est, truth, by_time)?;
    Ok((pairs.est, pairs.gt))
}

/// Distance between the last positions, each seen from its own first pose.
fn end_error(est: &[SE3], gt: &[SE3]) -> f64 {
    let last_seen_from_first = |poses: &[SE3]| match (poses.first(), poses.last()) {
        (Some(first), Some(last)) => first.inverse() * last.translation,
        _ => Vec3::zeros(),
    };
    (last_seen_from_first(est) - last_seen_from_first(gt)).norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::tests::record;
    use geometry::SO3;

    fn truth(n: u32) -> Trajectory {
        let pose = |i: u32| StampedPose {
            timestamp_s: f64::from(i) * 0.1,
            world_from_cam: SE3::new(SO3::identity(), Vec3::new(5.0, f64::from(i * i) * 0.01, f64::from(i))),
        };
        Trajectory { poses: (0..n).map(pose).collect() }
    }

    /// Records on the true path moved as a whole, which no metric may notice.
    fn perfect(n: u32) -> Vec<FrameRecord> {
        let moved = SE3::new(SO3::exp(&Vec3::new(0.1, -0.4, 0.2)), Vec3::new(-3.0, 1.0, 7.0));
        let mut records: Vec<FrameRecord> = (0..n).map(|i| record(i, Some(0.0))).collect();
        for (record, pose) in records.iter_mut().zip(truth(n).poses) {
            record.world_from_cam = Some(moved * pose.world_from_cam);
        }
        records
    }

    #[test]
    fn a_perfect_run_in_another_frame_has_no_error() {
        let mut records = perfect(150);
        // No segment starts or ends there.
        records[41] = record(41, None);
        let evaluation = evaluate(&records, &truth(150), Sensor::Stereo).unwrap();
        assert_eq!(evaluation.ate.n, 149);
        assert!(evaluation.ate.rmse < 1e-9 && evaluation.end_error_m < 1e-9);
        assert!(evaluation.drift.t_rel_percent.is_some_and(|t| t < 1e-9), "100 m fit into the path");
        assert!(evaluation.path_m > 149.0);
    }

    /// Drives of 1 m per frame along an arc that, from frame 120 to 180, turns by `turn` radians per frame.
    fn arc(n: u32, turn: f64) -> (Vec<FrameRecord>, Trajectory) {
        let mut pose = SE3::identity();
        let mut records: Vec<FrameRecord> = (0..n).map(|i| record(i, Some(0.0))).collect();
        for record in &mut records {
            record.world_from_cam = Some(pose);
            let turn = if (120..180).contains(&record.index) { turn } else { 0.005 };
            pose = pose * SE3::new(SO3::exp(&Vec3::new(0.0, turn, 0.0)), Vec3::new(0.0, 0.0, 1.0));
        }
        let poses = records.iter().filter_map(|r| {
            Some(StampedPose { timestamp_s: r.timestamp_s, world_from_cam: r.world_from_cam? })
        });
        let truth = Trajectory { poses: poses.collect() };
        (records, truth)
    }

    #[test]
    fn lost_frames_go_on_with_the_last_motion_and_count_in_t_rel() {
        let evaluated = |turn: f64, lost: std::ops::Range<u32>| {
            let (mut records, truth) = arc(300, turn);
            lost.for_each(|i| records[i as usize] = record(i, None));
            evaluate(&records, &truth, Sensor::Stereo).unwrap()
        };
        let complete = evaluated(0.005, 0..0);
        assert_eq!((complete.coverage.n_lost, complete.drift.n_segments), (0, 20 + 10));
        // The motion goes on as it was: the fill is exact, and no segment is left out.
        let steady = evaluated(0.005, 130..170);
        assert_eq!((steady.coverage.n_lost, steady.coverage.longest_gap, steady.ate.n), (40, 40, 260));
        assert_eq!(steady.drift.n_segments, complete.drift.n_segments);
        assert!(steady.drift.t_rel_percent.is_some_and(|t| t < 1e-6));
        // The car turns while it is lost: every pose that there is is right, yet the gap costs.
        let turning = evaluated(-0.01, 110..170);
        assert!(turning.ate.rmse < 1e-9, "{}", turning.ate.rmse);
        assert!(turning.drift.t_rel_percent.is_some_and(|t| t > 1.0), "{:?}", turning.drift.t_rel_percent);
    }

    #[test]
    fn the_end_error_is_seen_from_the_first_pose() {
        let mut records = perfect(50);
        let last = records[49].world_from_cam.as_mut().unwrap();
        last.translation += Vec3::new(0.0, 2.0, 0.0);
        let evaluation = evaluate(&records, &truth(50), Sensor::Stereo).unwrap();
        assert!((evaluation.end_error_m - 2.0).abs() < 1e-9);
        assert!((evaluation.end_error_percent().unwrap() - 200.0 / evaluation.path_m).abs() < 1e-9);
        assert!(evaluation.drift.t_rel_percent.is_none(), "no segment of 100 m");
    }

    #[test]
    fn scale_is_aligned_for_one_camera_only() {
        let mut records = perfect(50);
        for record in &mut records {
            record.world_from_cam.as_mut().unwrap().translation *= 0.5;
        }
        assert!(evaluate(&records, &truth(50), Sensor::Mono).unwrap().ate.rmse < 1e-9);
        assert!(evaluate(&records, &truth(50), Sensor::Stereo).unwrap().ate.rmse > 1.0);
    }

    #[test]
    fn a_body_beside_the_camera_is_compared_with_itself() {
        let lever = SE3::new(SO3::exp(&Vec3::new(0.3, 0.2, -1.5)), Vec3::new(0.4, -0.7, 0.2));
        let (mut camera, body) = arc(60, 0.005);
        for record in &mut camera {
            record.world_from_cam = record.world_from_cam.map(|world_from_body| world_from_body * lever);
        }
        let rmse = |records: &[FrameRecord], sensor: Sensor, body_from_left: &SE3| {
            Compared::new(records, &body, sensor, body_from_left).evaluate(sensor).unwrap().ate.rmse
        };
        assert!(rmse(&camera, Sensor::Stereo, &lever) < 1e-9);
        assert!(rmse(&camera, Sensor::Stereo, &SE3::identity()) > 1e-3, "the arc turns");
        // In a map of another scale the lever is as long as before, which no alignment of the body could undo.
        for record in &mut camera {
            record.world_from_cam.as_mut().unwrap().translation *= 0.25;
        }
        assert!(rmse(&camera, Sensor::Mono, &lever) < 1e-9);
        assert!(body_records(&camera, Sensor::Mono, &lever).is_none());
    }

    #[test]
    fn two_poses_are_too_few() {
        assert!(evaluate(&perfect(2), &truth(2), Sensor::Stereo).is_err());
    }
}
