//! Alignment of an estimated trajectory to its ground truth (Umeyama, TPAMI 1991), before ATE, RPE and plots.

use std::fmt;

use anyhow::{Result, anyhow, ensure};
use geometry::{SE3, Sim3, Vec3, align_umeyama};
use serde::{Deserialize, Serialize};

/// What may be moved before the estimate is compared with the ground truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Alignment {
    /// Nothing: both files are read in the same world frame.
    None,
    /// Rotation and translation (6 degrees of freedom): stereo and RGB-D.
    Se3,
    /// Rotation, translation and scale (7 degrees of freedom): monocular.
    Sim3,
}

impl fmt::Display for Alignment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Alignment::None => "none",
            Alignment::Se3 => "SE3",
            Alignment::Sim3 => "Sim3",
        })
    }
}

/// The transformation `gt_from_est` that brings the estimated positions closest to the true ones (least squares).
///
/// `est` and `gt` are matched poses `world_from_cam`, element by element.
///
/// # Errors
/// Different lengths, fewer than three poses, or positions that do not determine the alignment (all on one line).
pub fn estimate_alignment(est: &[SE3], gt: &[SE3], alignment: Alignment) -> Result<Sim3> {
    check_matched(est, gt)?;
    let with_scale = match alignment {
        Alignment::None => return Ok(Sim3::from(SE3::identity())),
        Alignment::Se3 => false,
        Alignment::Sim3 => true,
    };
    ensure!(est.len() >= 3, "alignment {alignment} needs at least 3 matched poses, found {}", est.len());
    align_umeyama(&positions(est), &positions(gt), None, with_scale).ok_or_else(|| {
        anyhow!(
            "alignment {alignment} is not determined: the {} positions lie on a line or at a single point",
            est.len()
        )
    })
}

/// Poses moved by `gt_from_est`: rotations are turned, positions turned, scaled and shifted.
pub fn apply_alignment(gt_from_est: &Sim3, est: &[SE3]) -> Vec<SE3> {
    let rotation = gt_from_est.rotation;
    est.iter()
        .map(|pose| {
            let position = gt_from_est.scale * (rotation * pose.translation) + gt_from_est.translation;
            SE3::new(rotation * pose.rotation, position)
        })
        .collect()
}

/// Positions of the camera in the world, meters.
pub fn positions(poses: &[SE3]) -> Vec<Vec3> {
    poses.iter().map(|pose| pose.translation).collect()
}

/// The same number of poses on both sides, at least one.
pub(crate) fn check_matched(est: &[SE3], gt: &[SE3]) -> Result<()> {
    ensure!(
        est.len() == gt.len(),
        "the estimate has {} poses but the ground truth has {}: match them first, by index or by timestamp",
        est.len(),
        gt.len()
    );
    ensure!(!est.is_empty(), "no poses to compare: both trajectories are empty");
    Ok(())
}
