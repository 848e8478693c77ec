//! All metrics of one estimate against its ground truth, as the program prints them and stores them beside a run.

use anyhow::{Result, bail};
use geometry::{SE3, Sim3};
use serde::{Deserialize, Serialize};

use crate::alignment::Alignment;
use crate::association::{Association, associate};
use crate::ate::ate;
use crate::coverage::{Coverage, fill_lost};
use crate::drift::{Drift, DriftBin, KITTI_LENGTHS_M, kitti_drift, kitti_drift_sparse};
use crate::read::{Format, TrajectoryFile};
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
    /// Alignment before ATE, and before drift and RPE if it has a scale.
    pub alignment: Alignment,
    /// Segment lengths of the drift, metres.
    pub lengths_m: Vec<f64>,
    /// Pairs of the relative pose error.
    pub rpe: RpeOptions,
    /// Window of the scale drift, metres.
    pub scale_window_m: f64,
    /// Frames per second of files without times, for drift by speed.
    pub frame_rate_hz: f64,
    /// Drift at lost frames.
    pub lost: LostFrames,
}

impl Default for EvaluationOptions {
    /// Stereo on KITTI.
    fn default() -> Self {
        EvaluationOptions {
            alignment: Alignment::Se3,
            lengths_m: KITTI_LENGTHS_M.to_vec(),
            rpe: RpeOptions::default(),
            scale_window_m: 50.0,
            frame_rate_hz: 10.0,
            lost: LostFrames::Fill,
        }
    }
}

/// An estimate laid out over the poses of its ground truth.
#[derive(Clone, Debug)]
pub struct Matched {
    /// Estimated pose `world_from_cam` of each pose of `gt`; `None` where the frame was lost.
    pub est: Vec<Option<SE3>>,
    /// Ground truth `world_from_cam`.
    pub gt: Vec<SE3>,
    /// Time of each pose of `gt`, seconds; `None` for KITTI files, which count frames.
    pub times_s: Option<Vec<f64>>,
    /// How they were matched, in words.
    pub association: String,
    /// Poses in the estimate's file.
    pub n_est: usize,
    /// Poses in the ground truth's file.
    pub n_gt: usize,
}

impl Matched {
    /// Matches two files. KITTI by frame: every true pose is kept. By time: the true poses that have a partner.
    ///
    /// # Errors
    /// As [`associate`]; or a KITTI file against a file with times and no `association` to say how.
    pub fn new(est: &TrajectoryFile, gt: &TrajectoryFile, association: Association) -> Result<Matched> {
        let by_frame = est.format == Format::Kitti && gt.format == Format::Kitti;
        if association == Association::Index && by_frame && est.has_frame_numbers {
            return Matched::by_frame_number(est, gt);
        }
        let times_differ = (est.format == Format::Kitti) != (gt.format == Format::Kitti);
        if times_differ && association != Association::Index {
            bail!(
                "a KITTI file has no timestamps: match by index, or give both files in a format with times"
            );
        }
        let pairs = associate(&est.trajectory, &gt.trajectory, association)?;
        Ok(Matched {
            est: pairs.est.iter().copied().map(Some).collect(),
            gt: pairs.gt,
            times_s: (est.format != Format::Kitti).then_some(pairs.timestamps_s),
            association: association.to_string(),
            n_est: pairs.n_est,
            n_gt: pairs.n_gt,
        })
    }

    fn by_frame_number(est: &TrajectoryFile, gt: &TrajectoryFile) -> Result<Matched> {
        let n_gt = gt.trajectory.poses.len();
        let mut sparse = vec![None; n_gt];
        for pose in &est.trajectory.poses {
            let frame = pose.timestamp_s as usize;
            match sparse.get_mut(frame) {
                Some(slot) => *slot = Some(pose.world_from_cam),
                None => {
                    bail!("the estimate has a frame {frame}, the ground truth ends at frame {}", n_gt - 1)
                }
            }
        }
        Ok(Matched {
            est: sparse,
            gt: gt.trajectory.poses.iter().map(|p| p.world_from_cam).collect(),
            times_s: None,
            association: "by frame number".to_owned(),
            n_est: est.trajectory.poses.len(),
            n_gt,
        })
    }

    /// Frames with a pose, and the true poses there.
    pub fn tracked(&self) -> (Vec<SE3>, Vec<SE3>) {
        self.est.iter().zip(&self.gt).filter_map(|(e, g)| e.map(|e| (e, *g))).unzip()
    }

    /// Whether each true pose has an estimate.
    pub fn coverage(&self) -> Coverage {
        Coverage::of(&self.est.iter().map(Option::is_some).collect::<Vec<_>>())
    }
}

/// Figures of one estimate; `None` where one is not defined (no segment long enough, too few poses).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evaluation {
    /// What was aligned.
    pub alignment: Alignment,
    /// How poses were matched.
    pub association: String,
    /// Poses of the estimate that were compared.
    pub n_used: usize,
    /// Poses in the estimate's file.
    pub n_est: usize,
    /// Poses in the ground truth's file.
    pub n_gt: usize,
    /// Scale of the alignment (1 without).
    pub scale: f64,
    /// Absolute trajectory error, metres.
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
    /// Segments left out for want of a pose.
    pub n_segments_skipped: usize,
    /// Drift by segment length, metres.
    pub per_length: Vec<DriftBin>,
    /// Drift by speed, km/h.
    pub per_speed: Vec<DriftBin>,
    /// Relative pose error, translation, metres.
    pub rpe_m: Option<Statistics>,
    /// Relative pose error, rotation, degrees.
    pub rpe_deg: Option<Statistics>,
    /// Change of scale, percent per 100 m.
    pub scale_drift_percent_per_100m: Option<f64>,
    /// Tracked and lost frames (files with times: of the matched poses only, none of which can be lost).
    pub coverage: Coverage,
    /// Files with times: poses of the estimate without a true pose in time.
    #[serde(default)]
    pub n_unmatched: usize,
    /// Files with times: longest time between matched poses, seconds; lost frames show here.
    #[serde(default)]
    pub longest_gap_s: Option<f64>,
}

/// The figures together with what plots need.
#[derive(Clone, Debug)]
pub struct Evaluated {
    /// The figures.
    pub figures: Evaluation,
    /// Alignment: ground-truth world from estimate's world.
    pub gt_from_est: Sim3,
    /// The drift with its segments.
    pub drift: Drift,
}

/// All metrics of a matched estimate.
///
/// # Errors
/// The alignment is not determined, or an option has no meaning (see the single metrics).
pub fn evaluate(matched: &Matched, options: &EvaluationOptions) -> Result<Evaluated> {
    let (est, gt) = matched.tracked();
    let absolute = ate(&est, &gt, options.alignment)?;
    // A rigid motion does not change drift and RPE (and is left out, so that files count as they are); a scale does.
    let has_scale = options.alignment == Alignment::Sim3;
    let moved = |pose: &SE3| if has_scale { absolute.aligned(&[*pose])[0] } else { *pose };
    let sparse: Vec<Option<SE3>> = matched.est.iter().map(|pose| pose.as_ref().map(moved)).collect();
    let drift = match options.lost {
        LostFrames::Fill => kitti_drift(&fill_lost(&sparse)?.0, &matched.gt, &options.lengths_m)?,
        LostFrames::Skip => kitti_drift_sparse(&sparse, &matched.gt, &options.lengths_m)?,
    };
    let seconds = matched
        .times_s
        .clone()
        .unwrap_or_else(|| (0..matched.gt.len()).map(|frame| frame as f64 / options.frame_rate_hz).collect());
    let moved_est: Vec<SE3> = est.iter().map(moved).collect();
    let relative = rpe(&moved_est, &gt, &options.rpe).ok();
    let figures = Evaluation {
        alignment: options.alignment,
        association: matched.association.clone(),
        n_used: est.len(),
        n_est: matched.n_est,
        n_gt: matched.n_gt,
        scale: absolute.gt_from_est.scale,
        ate_m: absolute.statistics(),
        t_rel_percent: drift.t_rel_percent,
        r_rel_deg_per_100m: drift.r_rel_deg_per_100m,
        t_rms_percent: drift.rms,
        t_std_percent: drift.std,
        n_segments: drift.n_segments,
        n_segments_skipped: drift.n_without_estimate,
        per_length: drift.per_length.clone(),
        per_speed: drift.per_speed(&seconds),
        rpe_m: relative.as_ref().map(|r| r.translation),
        rpe_deg: relative.as_ref().map(|r| r.rotation_deg),
        scale_drift_percent_per_100m: scale_drift(&est, &gt, options.scale_window_m)
            .ok()
            .map(|s| s.percent_per_100m),
        coverage: matched.coverage(),
        n_unmatched: matched.n_est.saturating_sub(est.len()),
        longest_gap_s: matched.times_s.as_deref().and_then(longest_gap),
    };
    Ok(Evaluated { figures, gt_from_est: absolute.gt_from_est, drift })
}

fn longest_gap(times_s: &[f64]) -> Option<f64> {
    times_s.windows(2).map(|t| t[1] - t[0]).max_by(f64::total_cmp)
}
