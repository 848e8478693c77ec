//! An estimator that is simple enough to test the robust estimation with: point sets that differ by a similarity.

use dsslam_geometry::{Estimator, Sim3, Vec3, align_umeyama};

/// Estimates `dst_from_src` by Umeyama's method; errors are squared distances in the target frame.
#[derive(Clone, Debug)]
pub(crate) struct AlignmentEstimator<'a> {
    src: &'a [Vec3],
    dst: &'a [Vec3],
    with_scale: bool,
    threshold_sq: f64,
}

impl<'a> AlignmentEstimator<'a> {
    /// Matches in a sample.
    pub(crate) const SAMPLE_SIZE: usize = 3;

    /// Matched points, whether the scale is free, and the squared threshold in square meters of the target frame.
    pub(crate) fn new(src: &'a [Vec3], dst: &'a [Vec3], with_scale: bool, threshold_sq: f64) -> Self {
        assert_eq!(src.len(), dst.len(), "points come in pairs");
        Self { src, dst, with_scale, threshold_sq }
    }
}

impl Estimator for AlignmentEstimator<'_> {
    type Model = Sim3;

    fn n_items(&self) -> usize {
        self.src.len()
    }

    fn fit(&self, sample: &[usize]) -> Vec<Sim3> {
        align_umeyama(&pick(self.src, sample), &pick(self.dst, sample), None, self.with_scale)
            .into_iter()
            .collect()
    }

    fn error_sq(&self, dst_from_src: &Sim3, item: usize) -> f64 {
        (dst_from_src * self.src[item] - self.dst[item]).norm_squared()
    }

    fn threshold_sq(&self) -> f64 {
        self.threshold_sq
    }

    fn refit(&self, _: &Sim3, inliers: &[usize], weights: &[f64]) -> Option<Sim3> {
        let (src, dst) = (pick(self.src, inliers), pick(self.dst, inliers));
        align_umeyama(
            &src,
            &dst,
            Some(&inliers.iter().map(|&i| weights[i]).collect::<Vec<_>>()),
            self.with_scale,
        )
    }
}

/// The chosen elements, in the order of the indices.
fn pick(all: &[Vec3], indices: &[usize]) -> Vec<Vec3> {
    indices.iter().map(|&i| all[i]).collect()
}
