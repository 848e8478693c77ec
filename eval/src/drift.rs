//! KITTI odometry drift, t_rel and r_rel: the definition of the benchmark's official devkit (Geiger et al., CVPR 2012).

use anyhow::{Result, ensure};
use geometry::SE3;
use nalgebra::Matrix4;
use serde::{Deserialize, Serialize};

use crate::alignment::check_matched;
use crate::statistics::Statistics;

/// Segment lengths of the KITTI odometry benchmark, meters.
pub const KITTI_LENGTHS_M: [f64; 8] = [100.0, 200.0, 300.0, 400.0, 500.0, 600.0, 700.0, 800.0];
/// A segment starts at every tenth frame.
const START_STEP: usize = 10;

/// Drift over one segment of the ground truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Index of the first frame.
    pub first: usize,
    /// Index of the last frame.
    pub last: usize,
    /// Nominal length, meters.
    pub length_m: f64,
    /// Translation error divided by the nominal length (no unit).
    pub t_err: f64,
    /// Rotation error divided by the nominal length, rad/m.
    pub r_err: f64,
}

/// Mean drift of the segments of one length, or of one range of speeds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DriftBin {
    /// Segment length in meters, or speed in km/h (middle of the range).
    pub at: f64,
    /// Number of segments.
    pub n: usize,
    /// Mean translation error, percent.
    pub t_rel_percent: f64,
    /// Mean rotation error, degrees per 100 m.
    pub r_rel_deg_per_100m: f64,
}

/// Drift of one sequence.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drift {
    /// Mean translation error of all segments, percent; `None` when no segment is long enough.
    pub t_rel_percent: Option<f64>,
    /// Mean rotation error of all segments, degrees per 100 m.
    pub r_rel_deg_per_100m: Option<f64>,
    /// Root mean square of the translation errors, percent.
    pub rms: Option<f64>,
    /// Standard deviation (population) of the translation errors, percent.
    pub std: Option<f64>,
    /// Mean per segment length, lengths without a segment left out.
    pub per_length: Vec<DriftBin>,
    /// Number of segments.
    pub n_segments: usize,
    /// Segments left out because the estimate lacks a pose at one of their ends.
    pub n_without_estimate: usize,
    /// All segments: by start frame, then length.
    pub segments: Vec<Segment>,
}

impl Drift {
    /// Summary of `segments`.
    pub fn from_segments(segments: Vec<Segment>, n_without_estimate: usize) -> Drift {
        let t_percent: Vec<f64> = segments.iter().map(|s| s.t_err * 100.0).collect();
        let stats = Statistics::of(&t_percent);
        let lengths = distinct(segments.iter().map(|s| s.length_m));
        Drift {
            t_rel_percent: stats.map(|s| s.mean),
            r_rel_deg_per_100m: mean_r_rel(&segments),
            rms: stats.map(|s| s.rmse),
            std: stats.map(|s| s.std),
            per_length: lengths.iter().filter_map(|&l| bin(&segments, l, |s| s.length_m == l)).collect(),
            n_segments: segments.len(),
            n_without_estimate,
            segments,
        }
    }

    /// Mean drift per range of speeds (km/h), `times_s` being the time of each frame. The speed of a segment is its nominal
    /// length over the time between its end frames; ranges are 10 km/h wide for cars, narrower below 30 km/h.
    pub fn per_speed(&self, times_s: &[f64]) -> Vec<DriftBin> {
        let speed = |s: &Segment| s.length_m / (times_s[s.last] - times_s[s.first]).max(f64::EPSILON) * 3.6;
        let fastest = self.segments.iter().map(speed).fold(0.0, f64::max);
        let width = if fastest > 30.0 {
            10.0
        } else if fastest > 6.0 {
            2.0
        } else {
            0.5
        };
        let range_of = |s: &Segment| (speed(s) / width).floor();
        distinct(self.segments.iter().map(range_of))
            .iter()
            .filter_map(|&range| bin(&self.segments, (range + 0.5) * width, |s| range_of(s) == range))
            .collect()
    }
}

/// Each value once, ascending.
fn distinct(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// Drift of a complete estimate: one pose `world_from_cam` per frame of the ground truth, lost frames filled
/// ([`crate::fill_lost`]). `lengths_m`: [`KITTI_LENGTHS_M`], or shorter ones for short sequences.
///
/// # Errors
/// Different lengths, no poses, or a segment length that is not positive. A sequence too short for every length is
/// not an error: its figures are `None`.
pub fn kitti_drift(est: &[SE3], gt: &[SE3], lengths_m: &[f64]) -> Result<Drift> {
    check_matched(est, gt)?;
    let est: Vec<Option<SE3>> = est.iter().copied().map(Some).collect();
    kitti_drift_sparse(&est, gt, lengths_m)
}

/// Drift of an estimate that lacks poses: segments with a missing end are skipped and counted.
///
/// # Errors
/// As [`kitti_drift`].
pub fn kitti_drift_sparse(est: &[Option<SE3>], gt: &[SE3], lengths_m: &[f64]) -> Result<Drift> {
    ensure!(est.len() == gt.len(), "the estimate has {} frames, the ground truth {}", est.len(), gt.len());
    for &length in lengths_m {
        ensure!(length.is_finite() && length > 0.0, "a segment length must be positive, found {length} m");
    }
    // Plain 4x4 matrices and their general inverse: files carry 7 digits, so their rotations are not exactly
    // orthonormal, and the devkit takes them as they are.
    let traveled = path_lengths(gt);
    let gt: Vec<Matrix4<f64>> = gt.iter().map(SE3::matrix).collect();
    let est: Vec<Option<Matrix4<f64>>> = est.iter().map(|p| p.as_ref().map(SE3::matrix)).collect();
    let mut segments = Vec::new();
    let mut n_without_estimate = 0;
    for first in (0..gt.len()).step_by(START_STEP) {
        for &length_m in lengths_m {
            let Some(last) = segment_end(&traveled, first, length_m) else { continue };
            let (Some(est_first), Some(est_last)) = (&est[first], &est[last]) else {
                n_without_estimate += 1;
                continue;
            };
            let error = relative(&relative(est_first, est_last)?, &relative(&gt[first], &gt[last])?)?;
            segments.push(Segment {
                first,
                last,
                length_m,
                t_err: translation_norm(&error) / length_m,
                r_err: rotation_angle(&error) / length_m,
            });
        }
    }
    Ok(Drift::from_segments(segments, n_without_estimate))
}

/// Path length from the first position to each position, meters.
pub(crate) fn path_lengths(poses: &[SE3]) -> Vec<f64> {
    let mut total = 0.0;
    let mut lengths = Vec::with_capacity(poses.len());
    for (i, pose) in poses.iter().enumerate() {
        if i > 0 {
            total += (pose.translation - poses[i - 1].translation).norm();
        }
        lengths.push(total);
    }
    lengths
}

/// First frame whose path length exceeds the start's by more than `length_m`.
fn segment_end(traveled: &[f64], first: usize, length_m: f64) -> Option<usize> {
    let limit = traveled[first] + length_m;
    let last = first + traveled[first..].partition_point(|&d| d <= limit);
    (last < traveled.len()).then_some(last)
}

/// `a^-1 b` with the general inverse of `a`.
fn relative(a: &Matrix4<f64>, b: &Matrix4<f64>) -> Result<Matrix4<f64>> {
    match a.try_inverse() {
        Some(inverse) => Ok(inverse * b),
        None => anyhow::bail!("a pose is not a rigid motion: its matrix has no inverse"),
    }
}

fn translation_norm(error: &Matrix4<f64>) -> f64 {
    error.fixed_view::<3, 1>(0, 3).norm()
}

/// The devkit's angle: acos((trace - 1) / 2), clamped, radians.
fn rotation_angle(error: &Matrix4<f64>) -> f64 {
    let trace = error[(0, 0)] + error[(1, 1)] + error[(2, 2)];
    (0.5 * (trace - 1.0)).clamp(-1.0, 1.0).acos()
}

fn mean_r_rel(segments: &[Segment]) -> Option<f64> {
    let r: Vec<f64> = segments.iter().map(|s| s.r_err.to_degrees() * 100.0).collect();
    Statistics::of(&r).map(|s| s.mean)
}

fn bin(segments: &[Segment], at: f64, belongs: impl Fn(&Segment) -> bool) -> Option<DriftBin> {
    let chosen: Vec<Segment> = segments.iter().copied().filter(belongs).collect();
    let t: Vec<f64> = chosen.iter().map(|s| s.t_err * 100.0).collect();
    Some(DriftBin {
        at,
        n: chosen.len(),
        t_rel_percent: Statistics::of(&t)?.mean,
        r_rel_deg_per_100m: mean_r_rel(&chosen)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{SO3, Vec3};

    /// `n` poses a meter apart along z.
    fn straight(n: usize, step: f64) -> Vec<SE3> {
        (0..n).map(|i| SE3::new(SO3::identity(), Vec3::new(0.0, 0.0, step * i as f64))).collect()
    }

    #[test]
    fn a_wrong_scale_shows_as_its_percentage() {
        let drift = kitti_drift(&straight(250, 1.02), &straight(250, 1.0), &KITTI_LENGTHS_M).unwrap();
        // The end frame lies 101 and 201 m on (strictly more than the length): 2 % of that, over the nominal length.
        let t: Vec<f64> = drift.per_length.iter().map(|b| b.t_rel_percent).collect();
        assert!((t[0] - 2.0 * 1.01).abs() < 1e-9 && (t[1] - 2.0 * 1.005).abs() < 1e-9, "{t:?}");
        assert_eq!(drift.per_length.iter().map(|b| b.n).collect::<Vec<_>>(), [15, 5]);
        assert_eq!(drift.r_rel_deg_per_100m, Some(0.0));
    }

    #[test]
    fn a_sequence_too_short_has_no_figure() {
        let drift = kitti_drift(&straight(101, 1.0), &straight(101, 1.0), &KITTI_LENGTHS_M).unwrap();
        assert_eq!(drift, Drift::default());
        assert_eq!(
            kitti_drift(&straight(102, 1.0), &straight(102, 1.0), &KITTI_LENGTHS_M).unwrap().n_segments,
            1
        );
    }

    #[test]
    fn speeds_are_binned() {
        let (gt, est) = (straight(400, 1.0), straight(400, 1.01));
        let drift = kitti_drift(&est, &gt, &[100.0]).unwrap();
        let times: Vec<f64> = (0..400).map(|i| f64::from(i) * 0.1).collect();
        let bins = drift.per_speed(&times);
        // 100 m in 101 frames of 0.1 s: 35.6 km/h.
        assert_eq!(bins.iter().map(|b| (b.at, b.n)).collect::<Vec<_>>(), [(35.0, drift.n_segments)]);
    }

    #[test]
    fn messages() {
        let message = |n, lengths: &[f64]| {
            kitti_drift(&straight(n, 1.0), &straight(9, 1.0), lengths).unwrap_err().to_string()
        };
        assert_eq!(
            message(8, &KITTI_LENGTHS_M),
            "the estimate has 8 poses but the ground truth has 9: match them first, by index or by timestamp"
        );
        assert_eq!(message(9, &[100.0, -1.0]), "a segment length must be positive, found -1 m");
    }
}
