//! The two models, side by side, and the choice between them.

use super::{CHI2_LINE, CHI2_PIXEL, TwoViewModel, Views};
use crate::aliases::Mat3;
use crate::essential::{decompose_essential, essential_from_fundamental};
use crate::estimators::{FundamentalEstimator, HomographyEstimator};
use crate::homography::{Homography, decompose_homography};
use crate::ransac::{Consensus, Estimator, RansacOptions, ransac};
use crate::se3::SE3;
use crate::seed::mix_seed;

/// The best of each kind.
pub(super) struct Models {
    homography: Option<Consensus<Homography>>,
    fundamental: Option<Consensus<Mat3>>,
}

/// A motion that a model suggests.
pub(super) struct Suggestion {
    pub(super) model: TwoViewModel,
    /// `second_from_first`, its translation of length one.
    pub(super) motion: SE3,
}

impl Models {
    /// Estimates both in parallel.
    pub(super) fn estimate(views: &Views<'_>, seed: u64) -> Self {
        let (first, second) = (views.matches.first, views.matches.second);
        let lines = FundamentalEstimator::new(first, second, CHI2_LINE * views.variance());
        let plane = HomographyEstimator::new(first, second, CHI2_PIXEL * views.variance());
        let (homography, fundamental) = rayon::join(
            || consensus(views, &plane, HomographyEstimator::SAMPLE_SIZE, mix_seed(seed, 0, 1)),
            || consensus(views, &lines, FundamentalEstimator::SAMPLE_SIZE, mix_seed(seed, 0, 2)),
        );
        Self { homography, fundamental }
    }

    /// All motions behind both models, refined: first those of the homography. `None` when there is no model at all.
    pub(super) fn motions(&self, views: &Views<'_>) -> Option<Vec<Suggestion>> {
        if self.homography.is_none() && self.fundamental.is_none() {
            return None;
        }
        let (first, second) = (&views.reconstruction.first, &views.reconstruction.second);
        let planar = self.homography.iter().filter_map(|h| decompose_homography(&h.model, first, second));
        let planar = planar.flatten().filter_map(|planar| unit(&planar.b_from_a));
        let general = self
            .fundamental
            .iter()
            .filter_map(|f| decompose_essential(&essential_from_fundamental(&f.model, first, second)));
        let suggest = |model| move |motion| Suggestion { model, motion };
        let planar = planar.map(suggest(TwoViewModel::Homography));
        Some(planar.chain(general.flatten().map(suggest(TwoViewModel::Fundamental))).collect())
    }

    /// Matches with a weight that a model explains.
    pub(super) fn n_inliers(&self, views: &Views<'_>, model: TwoViewModel) -> usize {
        let inliers = match model {
            TwoViewModel::Homography => self.homography.as_ref().map(|h| &h.inliers),
            TwoViewModel::Fundamental => self.fundamental.as_ref().map(|f| &f.inliers),
        };
        inliers.into_iter().flatten().filter(|&&i| views.weights[i] > 0.0).count()
    }
}

fn consensus<E: Estimator>(
    views: &Views<'_>,
    estimator: &E,
    sample_size: usize,
    seed: u64,
) -> Option<Consensus<E::Model>> {
    let max_iterations = views.options().max_iterations;
    let options = RansacOptions { sample_size, max_iterations, confidence: 0.999, seed };
    ransac(estimator, Some(views.weights), &options)
}

/// The motion with a translation of length one.
fn unit(motion: &SE3) -> Option<SE3> {
    let direction = motion.translation.try_normalize(f64::EPSILON)?;
    Some(SE3::new(motion.rotation, direction))
}
