//! Closed-form least-squares similarity between matched points (Umeyama, TPAMI 1991, equations 38 to 43).

use geometry::{Mat3, SO3, Sim3, Vec3};

/// The similarity `dst_from_src` of least squared distances; `None` when the points lie in one place.
pub(crate) fn align_umeyama(
    src: &[Vec3],
    dst: &[Vec3],
    _weights: Option<&[f64]>,
    with_scale: bool,
) -> Option<Sim3> {
    let n = src.len() as f64;
    let mean = |points: &[Vec3]| points.iter().sum::<Vec3>() / n;
    let (src_mean, dst_mean) = (mean(src), mean(dst));
    let mut covariance = Mat3::zeros();
    let mut src_variance = 0.0;
    for (s, d) in src.iter().zip(dst) {
        let (s, d) = (s - src_mean, d - dst_mean);
        covariance += d * s.transpose() / n;
        src_variance += s.norm_squared() / n;
    }
    let svd = covariance.svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    if svd.singular_values[0] <= f64::EPSILON {
        return None;
    }
    let sign = Vec3::new(1.0, 1.0, (u.determinant() * v_t.determinant()).signum());
    let rotation = SO3::from_matrix_unchecked(u * Mat3::from_diagonal(&sign) * v_t);
    let scale = if with_scale { svd.singular_values.dot(&sign) / src_variance } else { 1.0 };
    Some(Sim3::new(rotation, dst_mean - scale * (rotation * src_mean), scale))
}
