//! How much of a sequence was tracked: lost frames are filled for the metrics that need them, and counted.

use anyhow::{Result, ensure};
use geometry::SE3;
use serde::{Deserialize, Serialize};

/// Tracked and lost frames of one run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Coverage {
    /// Frames of the sequence.
    pub n_frames: usize,
    /// Frames without a pose of their own.
    pub n_lost: usize,
    /// Longest run of frames without a pose.
    pub longest_gap: usize,
}

impl Coverage {
    /// Counts the frames of `tracked`: whether each frame of the sequence has a pose.
    pub fn of(tracked: &[bool]) -> Coverage {
        let (mut gap, mut longest_gap) = (0, 0);
        for &has_pose in tracked {
            gap = if has_pose { 0 } else { gap + 1 };
            longest_gap = longest_gap.max(gap);
        }
        let n_lost = tracked.iter().filter(|&&has_pose| !has_pose).count();
        Coverage { n_frames: tracked.len(), n_lost, longest_gap }
    }

    /// Tracked frames in percent of all; 0 without frames.
    pub fn percent(&self) -> f64 {
        if self.n_frames == 0 {
            return 0.0;
        }
        100.0 * (self.n_frames - self.n_lost) as f64 / self.n_frames as f64
    }
}

/// A complete trajectory out of one with gaps: a lost frame continues the last relative motion,
/// frames before the first pose repeat it. The coverage says how many were filled.
///
/// # Errors
/// No frame has a pose.
pub fn fill_lost(est: &[Option<SE3>]) -> Result<(Vec<SE3>, Coverage)> {
    let first = est.iter().flatten().next().copied();
    ensure!(first.is_some(), "none of the {} frames has a pose", est.len());
    let mut filled: Vec<SE3> = Vec::with_capacity(est.len());
    let mut motion = SE3::identity();
    for (i, pose) in est.iter().enumerate() {
        let previous = filled.last().copied();
        let next = match (pose, previous) {
            (Some(pose), _) => *pose,
            (None, Some(previous)) => (previous * motion).normalized(),
            (None, None) => first.unwrap_or_default(),
        };
        let measured = pose.is_some() && i > 0 && est[i - 1].is_some();
        if let (true, Some(previous)) = (measured, previous) {
            motion = previous.inverse() * next;
        }
        filled.push(next);
    }
    let tracked: Vec<bool> = est.iter().map(Option::is_some).collect();
    Ok((filled, Coverage::of(&tracked)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{SO3, Vec3};

    fn at(x: f64) -> SE3 {
        SE3::new(SO3::identity(), Vec3::new(x, 0.0, 0.0))
    }

    #[test]
    fn lost_frames_go_on_with_the_last_motion_and_are_counted() {
        let est = [None, Some(at(1.0)), Some(at(3.0)), None, None, Some(at(6.0)), None];
        let (filled, coverage) = fill_lost(&est).unwrap();
        let x: Vec<f64> = filled.iter().map(|p| p.translation.x).collect();
        assert_eq!(x, [1.0, 1.0, 3.0, 5.0, 7.0, 6.0, 8.0]);
        assert_eq!(coverage, Coverage { n_frames: 7, n_lost: 4, longest_gap: 2 });
        assert!((coverage.percent() - 300.0 / 7.0).abs() < 1e-12);
    }

    #[test]
    fn nothing_tracked_is_an_error() {
        let message = fill_lost(&[None, None]).unwrap_err().to_string();
        assert_eq!(message, "none of the 2 frames has a pose");
        assert_eq!(Coverage::of(&[]).percent(), 0.0);
    }
}
