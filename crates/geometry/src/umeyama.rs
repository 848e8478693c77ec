//! The similarity or rigid motion that best maps one point set onto another (Umeyama 1991; Horn 1987 for the rigid case).

use crate::aliases::{Mat3, Vec3};
use crate::sim3::Sim3;
use crate::so3::SO3;
use crate::svd::RotationSvd;

/// Second singular value over the first below which the points count as lying on one line.
const MIN_SPREAD_RATIO: f64 = 1e-9;

/// `dst_from_src`, which minimizes `sum_i w_i |dst_i - (s R src_i + t)|^2`; the scale is 1 unless `with_scale`.
///
/// Weights default to one. `None` when the lengths differ, fewer than three points have a weight, the points lie on a line (the
/// rotation is then not determined), or a number is not finite or a weight negative.
pub fn align_umeyama(src: &[Vec3], dst: &[Vec3], weights: Option<&[f64]>, with_scale: bool) -> Option<Sim3> {
    if src.len() != dst.len() || weights.is_some_and(|w| w.len() != src.len()) {
        return None;
    }
    let weight = |i: usize| weights.map_or(1.0, |w| w[i]);
    let total: f64 = (0..src.len()).map(weight).sum();
    let valid = (0..src.len()).all(|i| weight(i) >= 0.0) && total.is_finite() && total > 0.0;
    if !valid || (0..src.len()).filter(|&i| weight(i) > 0.0).count() < 3 {
        return None;
    }
    let mean = |points: &[Vec3]| points.iter().enumerate().map(|(i, p)| p * weight(i)).sum::<Vec3>() / total;
    let (mean_src, mean_dst) = (mean(src), mean(dst));
    let mut covariance = Mat3::zeros();
    let mut variance_src = 0.0;
    for (i, (s, d)) in src.iter().zip(dst).enumerate() {
        let (s, d) = (s - mean_src, d - mean_dst);
        covariance += (d * s.transpose()) * (weight(i) / total);
        variance_src += s.norm_squared() * (weight(i) / total);
    }
    let RotationSvd { u, values, v } = RotationSvd::new(&covariance)?;
    if values[1] <= MIN_SPREAD_RATIO * values[0] {
        return None;
    }
    // Umeyama's S is the sign inside the third singular value: the answer is never a reflection.
    let rotation = SO3::from_matrix_unchecked(u * v.transpose());
    let scale = if with_scale { values.sum() / variance_src } else { 1.0 };
    let similarity = Sim3::new(rotation, mean_dst - scale * (rotation * mean_src), scale);
    similarity.is_valid().then_some(similarity)
}
