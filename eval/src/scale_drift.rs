//! Scale drift: how the ratio of true to estimated size changes along the path (monocular runs; near 1 for stereo).

use anyhow::{Result, ensure};
use geometry::{SE3, Vec3};

use crate::alignment::{check_matched, positions};
use crate::drift::path_lengths;

/// Scale drift of matched poses, in windows of `window_m` meters of the ground truth: slope of the logarithm of scale by least
/// squares over all windows, percent per 100 m.
///
/// The scale of a window is the ratio of the two point sets' spreads about their centroids (Horn, JOSA 1987, the
/// symmetric solution): it needs no rotation, so that straight windows have one too.
///
/// # Errors
/// Different lengths, a window that is not positive, fewer than two windows, or an estimate that stands still in one.
pub fn scale_drift(est: &[SE3], gt: &[SE3], window_m: f64) -> Result<f64> {
    check_matched(est, gt)?;
    ensure!(window_m.is_finite() && window_m > 0.0, "the window must be positive, found {window_m} m");
    let traveled = path_lengths(gt);
    let (est, gt) = (positions(est), positions(gt));
    let mut windows = Vec::new();
    let mut start = 0;
    for end in 0..traveled.len() {
        if traveled[end] - traveled[start] < window_m {
            continue;
        }
        let (true_spread, spread) = (spread(&gt[start..=end]), spread(&est[start..=end]));
        ensure!(spread > 0.0, "the estimate stands still from pose {start} to {end}: it has no scale there");
        windows.push((0.5 * (traveled[start] + traveled[end]), (true_spread / spread).ln()));
        start = end;
    }
    ensure!(
        windows.len() >= 2,
        "scale drift needs two windows of {window_m} m, the path has {:.1} m",
        traveled[traveled.len() - 1]
    );
    Ok(100.0 * ((100.0 * slope(&windows)).exp() - 1.0))
}

/// Root mean square distance from the centroid, meters.
fn spread(points: &[Vec3]) -> f64 {
    let n = points.len() as f64;
    let center = points.iter().sum::<Vec3>() / n;
    (points.iter().map(|p| (p - center).norm_squared()).sum::<f64>() / n).sqrt()
}

/// Slope of the line through points `(x, y)` by least squares.
fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let mean_x = points.iter().map(|(x, _)| x).sum::<f64>() / n;
    let mean_y = points.iter().map(|(_, y)| y).sum::<f64>() / n;
    let xy: f64 = points.iter().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    let xx: f64 = points.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
    xy / xx
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::SO3;

    fn straight(steps: impl Iterator<Item = f64>) -> Vec<SE3> {
        let mut z = 0.0;
        steps
            .map(|step| {
                z += step;
                SE3::new(SO3::identity(), Vec3::new(0.0, 0.0, z))
            })
            .collect()
    }

    #[test]
    fn a_constant_scale_does_not_drift() {
        let gt = straight((0..500).map(|_| 1.0));
        let est = straight((0..500).map(|_| 0.25));
        let drift = scale_drift(&est, &gt, 50.0).unwrap();
        assert!(drift.abs() < 1e-9);
    }

    #[test]
    fn an_exponential_drift_is_recovered() {
        // The estimate's steps shrink by 2 % per 100 m, so that its scale grows by 1/0.98.
        let gt = straight((0..2000).map(|_| 0.5));
        let est = straight((0..2000).map(|i| 0.5 * 0.98_f64.powf(f64::from(i) * 0.5 / 100.0)));
        let drift = scale_drift(&est, &gt, 20.0).unwrap();
        assert!((drift - 100.0 * (1.0 / 0.98 - 1.0)).abs() < 1e-3, "{drift}");
    }

    #[test]
    fn messages() {
        let gt = straight((0..50).map(|_| 1.0));
        let still = straight((0..50).map(|_| 0.0));
        let message = scale_drift(&gt, &gt, 30.0).unwrap_err().to_string();
        assert_eq!(message, "scale drift needs two windows of 30 m, the path has 49.0 m");
        let message = scale_drift(&still, &gt, 10.0).unwrap_err().to_string();
        assert_eq!(message, "the estimate stands still from pose 0 to 10: it has no scale there");
    }
}
