//! Relative pose error: how well the motion between two frames is known, a fixed delta apart
//! (Sturm et al., IROS 2012).

use anyhow::{Result, anyhow, ensure};
use geometry::SE3;

use crate::alignment::check_matched;
use crate::drift::path_lengths;
use crate::statistics::Statistics;

/// Unit of the distance between the two frames of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum DeltaUnit {
    /// Frames.
    Frames,
    /// Meters along the path.
    Meters,
}

/// Which pairs are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum PairMode {
    /// Each pair starts where the one before it ends.
    Consecutive,
    /// A pair starts at every frame.
    All,
}

/// Choice of the pairs of a relative pose error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RpeOptions {
    /// Distance between the frames of a pair, in `unit`.
    pub delta: f64,
    /// Unit of `delta`.
    pub unit: DeltaUnit,
    /// Consecutive pairs or all.
    pub pairs: PairMode,
    /// All pairs by meters: a pair counts when its distance differs from `delta` by at most this part of it.
    pub relative_tolerance: f64,
    /// Distances along the ground truth instead of the estimate.
    pub pairs_from_ground_truth: bool,
}

impl Default for RpeOptions {
    /// One frame, consecutive.
    fn default() -> Self {
        RpeOptions {
            delta: 1.0,
            unit: DeltaUnit::Frames,
            pairs: PairMode::Consecutive,
            relative_tolerance: 0.1,
            pairs_from_ground_truth: false,
        }
    }
}

/// Relative pose error over all pairs.
#[derive(Clone, Debug, PartialEq)]
pub struct RpeReport {
    /// Translation part, meters.
    pub translation: Statistics,
    /// Rotation angle, degrees.
    pub rotation_deg: Statistics,
    /// First and last index of each pair.
    pub pairs: Vec<(usize, usize)>,
    /// Translation error of each pair, meters.
    pub translation_errors: Vec<f64>,
}

/// Relative pose error of matched poses `world_from_cam`: of `(gt_i^-1 gt_j)^-1 (est_i^-1 est_j)`.
///
/// Align first ([`crate::apply_alignment`]) where the scale is unknown; rigid motions do not change the result.
///
/// # Errors
/// Different lengths, a delta that is not positive (or no whole number of frames), or no pair that far apart.
pub fn rpe(est: &[SE3], gt: &[SE3], options: &RpeOptions) -> Result<RpeReport> {
    check_matched(est, gt)?;
    let traveled = path_lengths(if options.pairs_from_ground_truth { gt } else { est });
    let pairs = select_pairs(&traveled, options)?;
    let mut translation_errors = Vec::with_capacity(pairs.len());
    let mut rotation_errors = Vec::with_capacity(pairs.len());
    for &(i, j) in &pairs {
        let gt_i_from_j = gt[i].inverse() * gt[j];
        let est_i_from_j = est[i].inverse() * est[j];
        let error = gt_i_from_j.inverse() * est_i_from_j;
        translation_errors.push(error.translation.norm());
        rotation_errors.push(error.rotation.angle().to_degrees());
    }
    let too_short = || {
        let unit = if options.unit == DeltaUnit::Frames { "frames" } else { "m" };
        anyhow!(
            "no two poses are {} {unit} apart: {} poses, {:.3} m",
            options.delta,
            est.len(),
            traveled[est.len() - 1]
        )
    };
    Ok(RpeReport {
        translation: Statistics::of(&translation_errors).ok_or_else(too_short)?,
        rotation_deg: Statistics::of(&rotation_errors).ok_or_else(too_short)?,
        pairs,
        translation_errors,
    })
}

fn select_pairs(traveled: &[f64], options: &RpeOptions) -> Result<Vec<(usize, usize)>> {
    let delta = options.delta;
    ensure!(delta.is_finite() && delta > 0.0, "the delta must be positive, found {delta}");
    match options.unit {
        DeltaUnit::Frames => {
            ensure!(delta.fract() == 0.0, "a delta in frames must be a whole number, found {delta}");
            let (step, n) = (delta as usize, traveled.len());
            let starts = 0..n.saturating_sub(step);
            Ok(match options.pairs {
                PairMode::All => starts.map(|i| (i, i + step)).collect(),
                PairMode::Consecutive => starts.step_by(step).map(|i| (i, i + step)).collect(),
            })
        }
        DeltaUnit::Meters => Ok(match options.pairs {
            PairMode::Consecutive => consecutive_by_path(traveled, delta),
            PairMode::All => all_by_path(traveled, delta, options.relative_tolerance * delta),
        }),
    }
}

/// The next pair ends at the first frame at least `delta` meters further on.
fn consecutive_by_path(traveled: &[f64], delta: f64) -> Vec<(usize, usize)> {
    let mut pairs = Vec::new();
    let mut start = 0;
    for (i, &distance) in traveled.iter().enumerate() {
        if distance - traveled[start] >= delta {
            pairs.push((start, i));
            start = i;
        }
    }
    pairs
}

/// From each frame to the one whose distance is nearest to `delta`, if within the tolerance; the first of equally near ones
/// (a camera that stands still).
fn all_by_path(traveled: &[f64], delta: f64, tolerance: f64) -> Vec<(usize, usize)> {
    let mut pairs = Vec::new();
    for i in 0..traveled.len().saturating_sub(1) {
        let later = &traveled[i + 1..];
        let gap = |k: usize| (later[k] - traveled[i] - delta).abs();
        let above = later.partition_point(|&d| d - traveled[i] < delta);
        let below = above.checked_sub(1).map(|k| later.partition_point(|&d| d < later[k]));
        let above = Some(above).filter(|&k| k < later.len());
        let nearest = below.into_iter().chain(above).min_by(|&a, &b| gap(a).total_cmp(&gap(b)));
        if let Some(k) = nearest.filter(|&k| gap(k) <= tolerance) {
            pairs.push((i, i + 1 + k));
        }
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{SO3, Vec3};

    /// 0, 1, 3, 6, 10, ... meters along x.
    fn accelerating(n: usize) -> Vec<SE3> {
        let x = |i: usize| (i * (i + 1) / 2) as f64;
        (0..n).map(|i| SE3::new(SO3::identity(), Vec3::new(x(i), 0.0, 0.0))).collect()
    }

    fn pairs(options: RpeOptions) -> Vec<(usize, usize)> {
        rpe(&accelerating(6), &accelerating(6), &options).unwrap().pairs
    }

    #[test]
    fn pairs_by_frames() {
        let two = RpeOptions { delta: 2.0, ..RpeOptions::default() };
        assert_eq!(pairs(two), [(0, 2), (2, 4)]);
        assert_eq!(pairs(RpeOptions { pairs: PairMode::All, ..two }), [(0, 2), (1, 3), (2, 4), (3, 5)]);
    }

    #[test]
    fn pairs_by_meters() {
        let five = RpeOptions { delta: 5.0, unit: DeltaUnit::Meters, ..RpeOptions::default() };
        assert_eq!(pairs(five), [(0, 3), (3, 5)]);
        // Distances 6, 5, 3 or 7, 4, 5: the third start has none within 10 %, the fourth needs 20 %.
        assert_eq!(pairs(RpeOptions { pairs: PairMode::All, ..five }), [(1, 3), (4, 5)]);
        let loose = RpeOptions { pairs: PairMode::All, relative_tolerance: 0.2, ..five };
        assert_eq!(pairs(loose), [(0, 3), (1, 3), (3, 4), (4, 5)]);
    }

    #[test]
    fn standing_still_takes_the_first_of_equal_distances() {
        assert_eq!(all_by_path(&[0.0, 1.0, 1.0, 1.0, 3.0], 1.2, 0.3), [(0, 1)]);
    }

    #[test]
    fn a_known_error() {
        let gt = accelerating(3);
        let mut est = gt.clone();
        est[1] = est[1] * SE3::new(SO3::exp(&Vec3::new(0.0, 0.0, 1e-7)), Vec3::new(0.0, 0.3, 0.4));
        let report = rpe(&est, &gt, &RpeOptions::default()).unwrap();
        assert!((report.translation_errors[0] - 0.5).abs() < 1e-12);
        assert!((report.rotation_deg.max - 1e-7_f64.to_degrees()).abs() < 1e-12);
    }

    #[test]
    fn messages() {
        let gt = accelerating(4);
        let message = |options: RpeOptions| rpe(&gt, &gt, &options).unwrap_err().to_string();
        let frames = RpeOptions::default();
        assert_eq!(
            message(RpeOptions { delta: 4.0, ..frames }),
            "no two poses are 4 frames apart: 4 poses, 6.000 m"
        );
        assert_eq!(
            message(RpeOptions { delta: 7.0, unit: DeltaUnit::Meters, ..frames }),
            "no two poses are 7 m apart: 4 poses, 6.000 m"
        );
        assert_eq!(
            message(RpeOptions { delta: 1.5, ..frames }),
            "a delta in frames must be a whole number, found 1.5"
        );
        assert_eq!(message(RpeOptions { delta: -1.0, ..frames }), "the delta must be positive, found -1");
    }
}
