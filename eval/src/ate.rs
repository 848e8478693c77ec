//! Absolute trajectory error: distance between estimated and true positions after alignment (Sturm et al., IROS 2012).

use anyhow::{Result, anyhow};
use geometry::{SE3, Sim3};

use crate::alignment::{Alignment, apply_alignment, estimate_alignment};
use crate::statistics::Statistics;

/// Absolute trajectory error.
#[derive(Clone, Debug)]
pub struct AteReport {
    /// Distances, meters; their root mean square is what papers call ATE.
    pub error_m: Statistics,
    /// The alignment found: ground-truth world from estimate's world.
    pub gt_from_est: Sim3,
}

/// Absolute trajectory error of matched poses `world_from_cam`.
///
/// # Errors
/// Different lengths, no poses, or an alignment that the positions do not determine.
pub fn ate(est: &[SE3], gt: &[SE3], alignment: Alignment) -> Result<AteReport> {
    let gt_from_est = estimate_alignment(est, gt, alignment)?;
    let aligned = apply_alignment(&gt_from_est, est);
    let errors: Vec<f64> =
        aligned.iter().zip(gt).map(|(e, g)| (e.translation - g.translation).norm()).collect();
    let error_m = Statistics::of(&errors).ok_or_else(|| anyhow!("no poses to compare"))?;
    Ok(AteReport { error_m, gt_from_est })
}
