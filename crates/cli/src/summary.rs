//! The numbers of a run as `summary.json` holds them.

use std::collections::BTreeMap;

use dsslam::trajectories::own_pose;
use dsslam::{Error, Verdict, scale_against_truth};
use eval::Evaluation;
use runtime::{FrameRecord, RunOutcome, Timings};
use serde::{Serialize, Serializer};

use crate::clock;
use crate::job::Job;

/// Everything that a script may want to know of a run. Keys are never renamed; what is not defined is `null`.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Summary {
    /// Version of the program.
    pub(crate) version: &'static str,
    /// Name of the sequence.
    pub(crate) sequence: String,
    /// Which images a frame has.
    pub(crate) sensor: io::Sensor,
    /// How tracking and mapping were interleaved.
    pub(crate) schedule: &'static str,
    /// The stage that ended the run by a bug, with its message; `null` if none did.
    pub(crate) failure: Option<String>,
    /// Whether the run was ended before its last frame.
    pub(crate) interrupted: bool,
    /// Frames that were read.
    pub(crate) frames: usize,
    /// Of those: with a pose of their own.
    pub(crate) tracked: usize,
    /// Of those: readable, but before the map could be started.
    pub(crate) not_ready: usize,
    /// Of those: after the start of the map, but without a pose.
    pub(crate) lost: usize,
    /// Of those: with images that could not be used.
    pub(crate) dropped: usize,
    /// Keyframes in the map.
    pub(crate) keyframes: usize,
    /// Points in the map.
    pub(crate) points: usize,
    /// Sub-maps that the map consists of.
    pub(crate) submaps: usize,
    /// Loops closed.
    pub(crate) loops: usize,
    /// Of those: taken back later, as loops that contradict them were found.
    pub(crate) loops_taken_back: usize,
    /// Loops looked at closely and rejected.
    pub(crate) loops_rejected: usize,
    /// Sub-maps joined to another one by a loop.
    pub(crate) submaps_joined: usize,
    /// Times that a lost camera, or one in a map from a file, found its place again.
    pub(crate) relocalizations: usize,
    /// How far the poses are to be trusted, from 0 to 1; `null` without a pose.
    pub(crate) quality: Option<QualityFigures>,
    /// Global bundle adjustments applied.
    pub(crate) global_adjustments: usize,
    /// Disparity offset in force, pixels.
    pub(crate) disparity_offset_px: f64,
    /// Errors of the given calibration that the images told, each with its standard deviation; `null`: it was left as it is.
    pub(crate) calibration_errors: Option<BTreeMap<&'static str, [f64; 2]>>,
    /// Where frames have poses in several sub-maps: the figures of each, the largest first. All others are those of the largest.
    pub(crate) per_submap: Vec<SubmapFigures>,
    /// What was aligned before the absolute error was taken: `SE3` or `Sim3`.
    pub(crate) alignment: Option<String>,
    /// Absolute trajectory error, root mean square over all frames with a pose, meters.
    pub(crate) ate_rmse_m: Option<f64>,
    /// Frames compared for it.
    pub(crate) ate_frames: Option<usize>,
    /// Estimated over true lengths; `null` for a single camera, without ground truth, and where the path is too short to tell.
    pub(crate) scale_against_truth: Option<f64>,
    /// KITTI's translation error, percent; frames without a pose continue the last relative motion.
    pub(crate) t_rel_percent: Option<f64>,
    /// KITTI's rotation error, degrees per 100 m.
    pub(crate) r_rel_deg_per_100m: Option<f64>,
    /// Frames that were filled so.
    pub(crate) t_rel_filled_frames: Option<usize>,
    /// Length of the true path, meters.
    pub(crate) path_m: Option<f64>,
    /// Error of the last position seen from the first pose, in percent of the path.
    pub(crate) end_error_percent: Option<f64>,
    /// Why there is no error although there is ground truth.
    pub(crate) evaluation_problem: Option<String>,
    /// Times of each stage, milliseconds, in the order in which the stages first ended.
    #[serde(serialize_with = "as_object")]
    pub(crate) stages: Vec<(&'static str, runtime::Summary)>,
    /// Median time from decoded images to pose, milliseconds.
    pub(crate) track_ms_median: Option<f64>,
    /// Time by the clock from the start of the command to this summary, seconds.
    pub(crate) wall_s: f64,
    /// Processor time of all threads, seconds.
    pub(crate) cpu_s: Option<f64>,
    /// Largest resident memory, 10^6 bytes.
    pub(crate) peak_rss_mb: Option<f64>,
    /// SHA-256 of `trajectory.kitti.txt`; `null` if it could not be written.
    pub(crate) trajectory_sha256: Option<String>,
    /// A 64-bit number for the whole map, hexadecimal: equal maps have equal ones.
    pub(crate) map_digest: String,
    /// SHA-256 of the map's file, if one was written.
    pub(crate) map_sha256: Option<String>,
    /// Seed of all random numbers.
    pub(crate) seed: u64,
    /// Each frame without a pose of its own, with the reason.
    pub(crate) without_pose: Vec<WithoutPose>,
    /// The built-in configuration that the layout of the sequence has chosen; `null` where there is none or another was given.
    pub(crate) preset: Option<&'static str>,
    /// What the person was told, doubts included.
    pub(crate) notices: Vec<String>,
    /// What the run rests on, in words, by name.
    #[serde(serialize_with = "as_object")]
    pub(crate) figures: Vec<(&'static str, String)>,
    /// Rules that found a figure of before the run implausible; the words stand in `notices`.
    pub(crate) doubts: Vec<&'static str>,
    /// Why frames have no pose, with the number of frames, the most frequent reason first.
    #[serde(serialize_with = "as_object")]
    pub(crate) causes: Vec<(&'static str, usize)>,
}

/// Quality of the frames that have a pose, from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct QualityFigures {
    /// Median.
    pub(crate) median: f64,
    /// The lowest.
    pub(crate) least: f64,
    /// Share of these frames below one half.
    pub(crate) below_half: f64,
}

impl QualityFigures {
    fn of(records: &[FrameRecord]) -> Option<Self> {
        let tracked = records.iter().filter(|record| record.status.has_pose());
        let mut values: Vec<f64> = tracked.map(|record| record.assessment.quality).collect();
        let least = values.iter().copied().min_by(f64::total_cmp)?;
        let n_below = values.iter().filter(|quality| **quality < 0.5).count();
        let below_half = n_below as f64 / values.len() as f64;
        Some(Self { median: geometry::median(&mut values)?, least, below_half })
    }
}

/// Figures of one of several sub-maps.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct SubmapFigures {
    /// Its name, as in `frames.csv`.
    pub(crate) submap: String,
    /// Frames with a pose in it.
    pub(crate) tracked: usize,
    /// The first of them.
    pub(crate) first_frame: Option<u32>,
    /// The last of them.
    pub(crate) last_frame: Option<u32>,
    /// Absolute trajectory error of its own alignment, root mean square, meters.
    pub(crate) ate_rmse_m: Option<f64>,
    /// Length of the true path from its first to its last frame, meters.
    pub(crate) path_m: Option<f64>,
    /// Why there is no error although there is ground truth.
    pub(crate) evaluation_problem: Option<String>,
}

impl SubmapFigures {
    /// The figures of the frames of one sub-map, which begin and end with a pose in it.
    pub(crate) fn new(
        name: &str,
        frames: &[FrameRecord],
        evaluation: Option<&Result<Evaluation, Error>>,
    ) -> Self {
        let errors = evaluation.and_then(|evaluation| evaluation.as_ref().ok());
        Self {
            submap: name.to_owned(),
            tracked: frames.iter().filter(|frame| own_pose(frame).is_some()).count(),
            first_frame: frames.first().map(|frame| frame.index),
            last_frame: frames.last().map(|frame| frame.index),
            ate_rmse_m: errors.map(|e| e.ate_m.rmse),
            path_m: errors.map(|e| e.path_m),
            evaluation_problem: evaluation.and_then(|e| e.as_ref().err()).map(ToString::to_string),
        }
    }
}

/// A frame that has no pose of its own.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct WithoutPose {
    /// Number of the frame in its sequence.
    pub(crate) frame: u32,
    /// `not_ready`, `lost` or `dropped`.
    pub(crate) state: &'static str,
    /// Why, with numbers.
    pub(crate) reason: String,
}

impl Summary {
    /// Puts the numbers together. `notices` is what the person was told, doubts included; `evaluation` is `None` without ground
    /// truth; SHA-256 are those of `trajectory.kitti.txt` and of the map's file, where they were written.
    pub(crate) fn new(
        job: &Job,
        notices: Vec<String>,
        outcome: &RunOutcome,
        evaluation: Option<&Result<Evaluation, Error>>,
        per_submap: Vec<SubmapFigures>,
        [trajectory_sha256, map_sha256]: [Option<String>; 2],
    ) -> Self {
        let sequence = job.sequence();
        let without_pose = frames_without_pose(&outcome.frames);
        let count = |state: &str| without_pose.iter().filter(|frame| frame.state == state).count();
        let errors = evaluation.and_then(|evaluation| evaluation.as_ref().ok());
        let statistics = outcome.statistics;
        Self {
            version: env!("CARGO_PKG_VERSION"),
            sensor: sequence.sensor,
            schedule: job.schedule(),
            failure: outcome.failure.as_ref().map(ToString::to_string),
            interrupted: outcome.interrupted,
            frames: outcome.frames.len(),
            tracked: outcome.frames.len() - without_pose.len(),
            not_ready: count("not_ready"),
            lost: count("lost"),
            dropped: count("dropped"),
            keyframes: outcome.map.n_keyframes(),
            points: outcome.map.n_points(),
            submaps: outcome.map.roots().len(),
            loops: statistics.loops_closed,
            loops_taken_back: statistics.loops_taken_back,
            loops_rejected: statistics.loops_rejected,
            submaps_joined: statistics.submaps_joined,
            relocalizations: statistics.relocalizations,
            quality: QualityFigures::of(&outcome.frames),
            global_adjustments: statistics.globals_adopted,
            disparity_offset_px: outcome.disparity_offset_px
                + outcome.calibration.as_ref().map_or(0.0, |found| found.errors[4]),
            calibration_errors: outcome.calibration.as_ref().map(|found| found.named().collect()),
            per_submap,
            alignment: errors.map(|e| e.alignment.to_string()),
            ate_rmse_m: errors.map(|e| e.ate_m.rmse),
            ate_frames: errors.map(|e| e.ate_m.n),
            scale_against_truth: errors.and_then(scale_against_truth).map(|scale| scale.ratio),
            t_rel_percent: errors.and_then(|e| e.t_rel_percent),
            r_rel_deg_per_100m: errors.and_then(|e| e.r_rel_deg_per_100m),
            t_rel_filled_frames: errors.map(|e| e.coverage.n_lost),
            path_m: errors.map(|e| e.path_m),
            end_error_percent: errors.and_then(Evaluation::end_error_percent),
            evaluation_problem: evaluation.and_then(|e| e.as_ref().err()).map(ToString::to_string),
            stages: stage_times(&outcome.timings),
            track_ms_median: outcome.timings.summary("track").map(|track| track.median),
            wall_s: job.watch.seconds(),
            cpu_s: clock::cpu_seconds(),
            peak_rss_mb: clock::peak_rss_mb(),
            trajectory_sha256,
            map_digest: format!("{:016x}", outcome.map.digest()),
            map_sha256,
            sequence: sequence.name.clone(),
            seed: job.session.setup().slam.seed,
            without_pose,
            preset: job.wishes.preset,
            notices,
            doubts: job.figures.doubts.iter().map(|doubt| doubt.rule).collect(),
            figures: job.figures.lines.iter().map(|figure| (figure.name, figure.text.clone())).collect(),
            causes: Verdict::of(&outcome.frames).causes,
        }
    }
}

fn stage_times(timings: &Timings) -> Vec<(&'static str, runtime::Summary)> {
    timings.stages().into_iter().filter_map(|stage| Some((stage, timings.summary(stage)?))).collect()
}

/// Pairs as one JSON object that keeps their order.
fn as_object<T: Serialize, S: Serializer>(pairs: &[(&'static str, T)], to: S) -> Result<S::Ok, S::Error> {
    to.collect_map(pairs.iter().map(|(name, value)| (name, value)))
}

/// The frames that have no pose of their own, in order, each with its reason.
fn frames_without_pose(records: &[FrameRecord]) -> Vec<WithoutPose> {
    let without = |record: &FrameRecord| {
        let reason = record.status.reason()?;
        let state = record.status.state().key();
        Some(WithoutPose { frame: record.index, state, reason })
    };
    records.iter().filter_map(without).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::tests::record;

    #[test]
    fn quality_is_that_of_the_frames_with_a_pose() {
        let of = |quality: f64| {
            let mut record = record(3, Some(0.0));
            record.assessment.quality = quality;
            record
        };
        let records = [of(0.9), record(4, None), of(0.25), of(0.5)];
        let found = QualityFigures::of(&records).unwrap();
        assert_eq!((found.median, found.least), (0.5, 0.25));
        assert!((found.below_half - 1.0 / 3.0).abs() < 1e-12);
        assert_eq!(QualityFigures::of(&[record(4, None)]), None);
    }

    #[test]
    fn frames_without_a_pose_are_named_with_their_reason() {
        let records = [record(3, Some(0.0)), record(4, None), record(5, Some(1.0))];
        let expected =
            WithoutPose { frame: 4, state: "dropped", reason: "the left image is missing".to_owned() };
        assert_eq!(frames_without_pose(&records), [expected]);
    }
}
