//! Errors of a run against ground truth, by the metrics of `eval`.

use anyhow::Result;
use eval::{Alignment, Association, AteReport, Drift, KITTI_LENGTHS_M, TIMESTAMP_TOLERANCE_S};
use geometry::{SE3, Vec3};
use io::{Sensor, StampedPose, Trajectory};
use runtime::FrameRecord;

use crate::trajectories::{own_pose, tracked_poses};

/// How far a run is from the truth.
#[derive(Clone, Debug)]
pub(crate) struct Evaluation {
    /// Absolute trajectory error of all frames with a pose.
    pub(crate) ate: AteReport,
    /// Relative errors over segments of 100 to 800 m.
    pub(crate) drift: Drift,
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

/// Compares a run with the ground truth, frames matched by their times.
///
/// # Errors
/// When no time matches, or when fewer than three frames have a pose.
pub(crate) fn evaluate(records: &[FrameRecord], truth: &Trajectory, sensor: Sensor) -> Result<Evaluation> {
    let by_time = Association::Timestamp { tolerance_s: TIMESTAMP_TOLERANCE_S };
    let pairs = eval::associate(&tracked_poses(records), truth, by_time)?;
    let ate = eval::ate(&pairs.est, &pairs.gt, alignment_of(sensor))?;
    let (est, gt) = per_frame(records, truth)?;
    let aligned: Vec<Option<SE3>> =
        est.iter().map(|pose| pose.and_then(|pose| ate.aligned(&[pose]).first().copied())).collect();
    let drift = eval::kitti_drift_sparse(&aligned, &gt, &KITTI_LENGTHS_M)?;
    let path_m = gt.windows(2).map(|pair| (pair[1].translation - pair[0].translation).norm()).sum();
    let end_error_m = end_error(&ate.aligned(&pairs.est), &pairs.gt);
    Ok(Evaluation { ate, drift, path_m, end_error_m })
}

/// The run's frames that have a true pose: the estimate, where there is one, and the truth.
fn per_frame(records: &[FrameRecord], truth: &Trajectory) -> Result<(Vec<Option<SE3>>, Vec<SE3>)> {
    let stamped =
        |r: &FrameRecord| StampedPose { timestamp_s: r.timestamp_s, world_from_cam: SE3::identity() };
    let times = Trajectory { poses: records.iter().map(stamped).collect() };
    let pairs =
        eval::associate(&times, truth, Association::Timestamp { tolerance_s: TIMESTAMP_TOLERANCE_S })?;
    let est = pairs.est_indices.iter().map(|&i| own_pose(&records[i])).collect();
    Ok((est, pairs.gt))
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
    use crate::trajectories::tests::record;
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
        records[40] = record(40, None);
        let evaluation = evaluate(&records, &truth(150), Sensor::Stereo).unwrap();
        assert_eq!(evaluation.ate.n, 149);
        assert!(evaluation.ate.rmse < 1e-9 && evaluation.end_error_m < 1e-9);
        assert!(evaluation.drift.t_rel_percent.is_some_and(|t| t < 1e-9), "100 m fit into the path");
        assert!(evaluation.path_m > 149.0);
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
    fn two_poses_are_too_few() {
        assert!(evaluate(&perfect(2), &truth(2), Sensor::Stereo).is_err());
    }
}
