//! All metrics of one estimate against its ground truth: what a run stores as `evaluation.json`, and `eval traj` prints.

use anyhow::{Result, bail, ensure};
use geometry::{SE3, SO3, Sim3, Vec3};
use io::{Stamps, Trajectory, TrajectoryFile};
use nalgebra::Matrix3x4;
use serde::{Deserialize, Serialize};

use crate::alignment::{Alignment, apply_alignment};
use crate::association::{Association, TIMESTAMP_TOLERANCE_S, match_stamps};
use crate::ate::ate;
use crate::coverage::{Coverage, fill_lost};
use crate::drift::{DriftBin, KITTI_LENGTHS_M, kitti_drift, kitti_drift_sparse, path_lengths};
use crate::rpe::{RpeOptions, rpe};
use crate::scale_drift::scale_drift;
use crate::statistics::Statistics;

/// What drift does at frames without a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum LostFrames {
    /// Fill them with the last relative motion: the benchmark's rule.
    Fill,
    /// Leave out the segments that begin or end there, as some monocular tables do.
    Skip,
}

/// Choices of an evaluation.
#[derive(Clone, Debug)]
pub struct EvaluationOptions {
    /// How poses are matched.
    pub association: Association,
    /// Alignment before ATE, and before drift and RPE if it has a scale.
    pub alignment: Alignment,
    /// Segment lengths of the drift, meters.
    pub lengths_m: Vec<f64>,
    /// Pairs of the relative pose error.
    pub rpe: RpeOptions,
    /// Window of the scale drift, meters.
    pub scale_window_m: f64,
    /// Frames per second of an estimate without times, for drift by speed.
    pub frame_rate_hz: f64,
    /// Drift at lost frames.
    pub lost: LostFrames,
}

impl Default for EvaluationOptions {
    /// Stereo: by timestamp, SE3, KITTI's segments.
    fn default() -> Self {
        EvaluationOptions {
            association: Association::Timestamp { tolerance_s: TIMESTAMP_TOLERANCE_S },
            alignment: Alignment::Se3,
            lengths_m: KITTI_LENGTHS_M.to_vec(),
            rpe: RpeOptions::default(),
            scale_window_m: 50.0,
            frame_rate_hz: 10.0,
            lost: LostFrames::Fill,
        }
    }
}

/// An estimated trajectory, frame by frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Time of each frame, seconds; its number where there are no times. Increasing.
    pub stamps: Vec<f64>,
    /// Whether `stamps` are times.
    pub has_times: bool,
    /// Pose `world_from_cam` of each frame; `None` where the frame was lost.
    pub poses: Vec<Option<SE3>>,
}

impl Estimate {
    /// Frames with their times, seconds, and their poses `world_from_cam`, `None` where a frame was lost.
    pub fn new(frames: impl IntoIterator<Item = (f64, Option<SE3>)>) -> Estimate {
        let (stamps, poses) = frames.into_iter().unzip();
        Estimate { stamps, has_times: true, poses }
    }

    /// A file: a frame per pose.
    pub fn of_file(file: &TrajectoryFile) -> Estimate {
        let poses = &file.trajectory.poses;
        let all = Estimate::new(poses.iter().map(|p| (p.timestamp_s, Some(p.world_from_cam))));
        Estimate { has_times: file.stamps == Stamps::Times, ..all }
    }

    /// A file with frame numbers: the frames of `truth`, lost where the file has no pose.
    ///
    /// # Errors
    /// A frame that `truth` does not have.
    pub fn of_numbered_file(file: &TrajectoryFile, truth: &Trajectory) -> Result<Estimate> {
        let stamps: Vec<f64> = truth.poses.iter().map(|pose| pose.timestamp_s).collect();
        let mut poses = vec![None; stamps.len()];
        for pose in &file.trajectory.poses {
            let frame = pose.timestamp_s;
            match stamps.binary_search_by(|stamp| stamp.total_cmp(&frame)) {
                Ok(at) => poses[at] = Some(pose.world_from_cam),
                Err(_) => bail!(
                    "the estimate has a frame {frame} that the ground truth, which ends at frame {}, does not have",
                    stamps.last().copied().unwrap_or_default()
                ),
            }
        }
        Ok(Estimate { stamps, has_times: false, poses })
    }
}

/// Whose poses a trajectory holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Subject {
    /// The left camera.
    LeftCamera,
    /// The body that the ground truth describes.
    Body,
}

/// Figures of one estimate; `None` where one is not defined (no segment long enough, too few poses).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evaluation {
    /// Whose poses were compared; `None` for files, which do not tell.
    pub compared: Option<Subject>,
    /// What was aligned.
    pub alignment: Alignment,
    /// How poses were matched.
    pub association: String,
    /// Poses of the estimate that were compared.
    pub n_used: usize,
    /// Poses of the estimate.
    pub n_est: usize,
    /// Poses of the ground truth.
    pub n_gt: usize,
    /// Scale of the alignment (1 without).
    pub scale: f64,
    /// The alignment: ground-truth world from the estimate's, rotation times scale and translation as a 3x4 matrix, row by row.
    pub gt_from_est: [f64; 12],
    /// Absolute trajectory error, meters.
    pub ate_m: Statistics,
    /// Mean translation error of KITTI's segments, percent.
    pub t_rel_percent: Option<f64>,
    /// Mean rotation error of KITTI's segments, degrees per 100 m.
    pub r_rel_deg_per_100m: Option<f64>,
    /// Root mean square of the segments' translation errors, percent.
    pub t_rms_percent: Option<f64>,
    /// Standard deviation of the segments' translation errors, percent.
    pub t_std_percent: Option<f64>,
    /// Number of segments.
    pub n_segments: usize,
    /// Segments skipped for lack of a pose.
    pub n_segments_skipped: usize,
    /// Drift by segment length, meters.
    pub per_length: Vec<DriftBin>,
    /// Drift by speed, km/h.
    pub per_speed: Vec<DriftBin>,
    /// Relative pose error, translation, meters.
    pub rpe_m: Option<Statistics>,
    /// Relative pose error, rotation, degrees.
    pub rpe_deg: Option<Statistics>,
    /// Change of scale, percent per 100 m.
    pub scale_drift_percent_per_100m: Option<f64>,
    /// Length of the true path over the frames that were compared, meters.
    pub path_m: f64,
    /// Distance from the true to the estimated last position when the first poses are laid on each other, meters.
    pub end_error_m: f64,
    /// Tracked and lost frames (files with times do not tell of lost ones).
    pub coverage: Coverage,
    /// Poses of the estimate without a true pose.
    pub n_unmatched: usize,
    /// Estimates with times: longest time between matched poses, seconds; lost frames show here.
    pub longest_gap_s: Option<f64>,
    /// What was compared, for figures; not stored.
    #[serde(skip)]
    pub matched: Matched,
}

/// An estimate laid out over the poses of its ground truth.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Matched {
    /// Estimated pose `world_from_cam` of each pose of `gt`; `None` where the frame was lost.
    pub est: Vec<Option<SE3>>,
    /// Ground truth `world_from_cam`.
    pub gt: Vec<SE3>,
}

impl Evaluation {
    /// Compares an estimate with the poses `world_from_cam` of `truth`, both of the same body.
    ///
    /// ```
    /// use dsslam_eval::{Estimate, Evaluation, EvaluationOptions};
    /// # use geometry::{SE3, SO3, Vec3};
    /// # use io::{StampedPose, Trajectory};
    /// # let pose = |i: u32| SE3::new(SO3::identity(), Vec3::new(0.1 * f64::from(i * i), 0.0, f64::from(i)));
    /// # let stamped = |i: u32| StampedPose { timestamp_s: f64::from(i), world_from_cam: pose(i) };
    /// # let truth = Trajectory { poses: (0..20).map(stamped).collect() };
    /// // The third frame was lost.
    /// let estimate = Estimate::new((0..20).map(|i| (f64::from(i), (i != 2).then(|| pose(i)))));
    /// let found = Evaluation::of(&estimate, &truth, &EvaluationOptions::default())?;
    /// assert!(found.ate_m.rmse < 1e-9 && found.coverage.n_lost == 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// No frame with a pose, nothing that matches, an alignment that is not determined, or an option without a meaning (see the
    /// single metrics).
    pub fn of(estimate: &Estimate, truth: &Trajectory, options: &EvaluationOptions) -> Result<Evaluation> {
        ensure!(!estimate.poses.is_empty(), "the estimate is empty");
        let (filled, coverage) = fill_lost(&estimate.poses)?;
        let stamps: Vec<f64> = truth.poses.iter().map(|pose| pose.timestamp_s).collect();
        let pairs = match_stamps(&estimate.stamps, &stamps, options.association)?;
        let matched = Matched::new(estimate, truth, &pairs);
        let (est, gt) = matched.tracked();
        let absolute = ate(&est, &gt, options.alignment)?;
        // A rigid motion does not change drift and RPE (and is left out, so that files count as they are); a scale does.
        let has_scale = options.alignment == Alignment::Sim3;
        let moved = |poses: &[SE3]| {
            if has_scale { apply_alignment(&absolute.gt_from_est, poses) } else { poses.to_vec() }
        };
        let complete = moved(&pairs.iter().map(|&(e, _)| filled[e]).collect::<Vec<_>>());
        let drift = match options.lost {
            LostFrames::Fill => kitti_drift(&complete, &matched.gt, &options.lengths_m)?,
            LostFrames::Skip => {
                let of_frame = |(pose, found): (&SE3, &Option<SE3>)| found.map(|_| *pose);
                let sparse: Vec<Option<SE3>> = complete.iter().zip(&matched.est).map(of_frame).collect();
                kitti_drift_sparse(&sparse, &matched.gt, &options.lengths_m)?
            }
        };
        let times_s: Vec<f64> = match estimate.has_times {
            true => pairs.iter().map(|&(e, _)| estimate.stamps[e]).collect(),
            false => (0..pairs.len()).map(|frame| frame as f64 / options.frame_rate_hz).collect(),
        };
        let moved = moved(&est);
        let relative = rpe(&moved, &gt, &options.rpe).ok();
        let n_est = estimate.poses.iter().flatten().count();
        Ok(Evaluation {
            compared: None,
            alignment: options.alignment,
            association: options.association.to_string(),
            n_used: est.len(),
            n_est,
            n_gt: truth.poses.len(),
            scale: absolute.gt_from_est.scale,
            gt_from_est: rows(&absolute.gt_from_est),
            ate_m: absolute.error_m,
            t_rel_percent: drift.t_rel_percent,
            r_rel_deg_per_100m: drift.r_rel_deg_per_100m,
            t_rms_percent: drift.rms,
            t_std_percent: drift.std,
            n_segments: drift.n_segments,
            n_segments_skipped: drift.n_without_estimate,
            per_speed: drift.per_speed(&times_s),
            per_length: drift.per_length,
            rpe_m: relative.as_ref().map(|r| r.translation),
            rpe_deg: relative.as_ref().map(|r| r.rotation_deg),
            scale_drift_percent_per_100m: scale_drift(&est, &gt, options.scale_window_m).ok(),
            path_m: path_lengths(&matched.gt).last().copied().unwrap_or_default(),
            end_error_m: end_error(&moved, &gt),
            coverage,
            n_unmatched: n_est - est.len(),
            longest_gap_s: if estimate.has_times { matched.longest_gap_s(&times_s) } else { None },
            matched,
        })
    }

    /// [`Evaluation::end_error_m`] in percent of the path; `None` for a camera that stood still.
    pub fn end_error_percent(&self) -> Option<f64> {
        (self.path_m > 0.0).then(|| 100.0 * self.end_error_m / self.path_m)
    }

    /// Whether poses of the body were compared, not those of the left camera.
    pub(crate) fn compares_bodies(&self) -> bool {
        self.compared == Some(Subject::Body)
    }

    /// A position of the estimate in the ground truth's world, meters.
    pub fn aligned(&self, position: &Vec3) -> Vec3 {
        Matrix3x4::from_row_slice(&self.gt_from_est) * position.push(1.0)
    }
}

impl Matched {
    fn new(estimate: &Estimate, truth: &Trajectory, pairs: &[(usize, usize)]) -> Matched {
        Matched {
            est: pairs.iter().map(|&(e, _)| estimate.poses[e]).collect(),
            gt: pairs.iter().map(|&(_, g)| truth.poses[g].world_from_cam).collect(),
        }
    }

    /// Frames with a pose, and the true poses there.
    pub fn tracked(&self) -> (Vec<SE3>, Vec<SE3>) {
        self.est.iter().zip(&self.gt).filter_map(|(e, g)| e.map(|e| (e, *g))).unzip()
    }

    /// Longest time between frames with a pose.
    fn longest_gap_s(&self, times_s: &[f64]) -> Option<f64> {
        let tracked = self.est.iter().zip(times_s).filter_map(|(pose, time)| pose.map(|_| *time));
        let tracked: Vec<f64> = tracked.collect();
        tracked.windows(2).map(|t| t[1] - t[0]).max_by(f64::total_cmp)
    }
}

fn rows(gt_from_est: &Sim3) -> [f64; 12] {
    let scaled = gt_from_est.rotation.matrix() * gt_from_est.scale;
    SE3::new(SO3::from_matrix_unchecked(scaled), gt_from_est.translation).rows_3x4()
}

/// Distance between the last positions, each seen from its own first pose.
fn end_error(est: &[SE3], gt: &[SE3]) -> f64 {
    let last_seen_from_first = |poses: &[SE3]| match (poses.first(), poses.last()) {
        (Some(first), Some(last)) => first.inverse() * last.translation,
        _ => Vec3::zeros(),
    };
    (last_seen_from_first(est) - last_seen_from_first(gt)).norm()
}
