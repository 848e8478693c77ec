//! The two models, side by side, and the choice between them.

use super::{CHI2_LINE, CHI2_PIXEL, TwoViewModel, Views};
use crate::aliases::{Mat3, Vec2, Vec3};
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

/// The model that won.
pub(super) struct Chosen {
    pub(super) model: TwoViewModel,
    pub(super) homography_share: f64,
    /// Matches with a weight that it explains.
    pub(super) n_inliers: usize,
    /// The motions `second_from_first` behind it, translations of length one; none when the camera turned only.
    pub(super) motions: Vec<SE3>,
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

    /// The model that explains the matches better; a plane is preferred, as it makes the fundamental matrix ambiguous.
    pub(super) fn choose(&self, views: &Views<'_>) -> Option<Chosen> {
        let by_plane = self.homography.as_ref().map_or(0.0, |h| homography_score(views, &h.model));
        let by_lines = self.fundamental.as_ref().map_or(0.0, |f| fundamental_score(views, &f.model));
        let homography_share = by_plane / (by_plane + by_lines);
        let count = |inliers: &[usize]| inliers.iter().filter(|&&i| views.weights[i] > 0.0).count();
        let (first, second) = (&views.reconstruction.first, &views.reconstruction.second);
        match (&self.homography, &self.fundamental) {
            (Some(h), _) if homography_share > views.options().homography_share => {
                let motions = decompose_homography(&h.model, first, second).into_iter().flatten();
                Some(Chosen {
                    model: TwoViewModel::Homography,
                    homography_share,
                    n_inliers: count(&h.inliers),
                    motions: motions.filter_map(|planar| unit(&planar.b_from_a)).collect(),
                })
            }
            (_, Some(f)) => {
                let essential = essential_from_fundamental(&f.model, first, second);
                Some(Chosen {
                    model: TwoViewModel::Fundamental,
                    homography_share,
                    n_inliers: count(&f.inliers),
                    motions: decompose_essential(&essential).into_iter().flatten().collect(),
                })
            }
            _ => None,
        }
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

/// Mur-Artal et al. 2015, equation 2: what the errors of each match in both images leave of their limit.
fn homography_score(views: &Views<'_>, homography: &Homography) -> f64 {
    let gain = |error_sq: f64| (CHI2_PIXEL - error_sq / views.variance()).max(0.0);
    let score = |i: usize| {
        let (first, second) = views.pixels(i);
        homography.transfer_errors_sq(first, second).map(gain).iter().sum::<f64>() * views.weights[i]
    };
    (0..views.len()).map(score).sum()
}

/// The same for distances from epipolar lines, which have one degree of freedom but the same limit, so that both scores compare.
fn fundamental_score(views: &Views<'_>, fundamental: &Mat3) -> f64 {
    let gain = |error_sq: f64| {
        let error_sq = error_sq / views.variance();
        if error_sq < CHI2_LINE { CHI2_PIXEL - error_sq } else { 0.0 }
    };
    let score = |i: usize| {
        let (first, second) = views.pixels(i);
        let in_second = line_error_sq(&(fundamental * first.push(1.0)), second);
        let in_first = line_error_sq(&fundamental.tr_mul(&second.push(1.0)), first);
        (gain(in_second) + gain(in_first)) * views.weights[i]
    };
    (0..views.len()).map(score).sum()
}

/// Squared distance of a pixel from a line.
fn line_error_sq(line: &Vec3, pixel: &Vec2) -> f64 {
    line.dot(&pixel.push(1.0)).powi(2) / line.xy().norm_squared()
}
