//! A number from 0 to 1 for how far to trust a frame: a product of factors, each for one way in which a pose can be bad.

use crate::assess::QualityReason;

/// Times the least number of inliers from which more of them do not matter.
const MANY_INLIERS: f64 = 2.0;
/// Cells of the image, of [`CELLS`], from which points are well spread.
const SPREAD_CELLS: f64 = 6.0;
/// Cells that the image is divided into, across and down.
pub(crate) const CELLS: [usize; 2] = [4, 3];
/// Largest good standard deviation of the position over the median depth of the points.
const GOOD_SIGMA_PER_DEPTH: f64 = 0.01;
/// Largest good standard deviation of the rotation, degrees.
const GOOD_SIGMA_DEG: f64 = 0.5;
/// Near points from which more do not matter.
const MANY_NEAR: f64 = 20.0;
/// Largest good residual, in units of the expected one.
const GOOD_RESIDUAL: f64 = 1.2;
/// Factor on the frame that found its place again, and frames until nothing of it is left.
const RELOCALIZED: f64 = 0.5;
const RELOCALIZED_FRAMES: f64 = 5.0;
/// Factor where the motion model failed.
const WITHOUT_MOTION_MODEL: f64 = 0.7;
/// Factors from this on are not named as a reason.
const HARDLY_LOWER: f64 = 0.9;

/// What the quality of a frame follows from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Signs {
    /// Points that agree with the pose.
    pub(crate) inliers: usize,
    /// Points that a frame needs.
    pub(crate) needed: usize,
    /// Cells of the image with one of them.
    pub(crate) cells: usize,
    /// Largest standard deviation of the position over the median depth of the points, and of the rotation in degrees; `None`
    /// where nothing is known of them.
    pub(crate) sigma: Option<[f64; 2]>,
    /// Points near enough to tell where the camera is; `None` without depth.
    pub(crate) near: Option<usize>,
    /// Robust standard deviation of the residuals, in units of the expected one.
    pub(crate) residual: f64,
    /// Frames since a lost camera found its place again.
    pub(crate) since_relocalized: Option<u32>,
    /// Whether the motion model failed.
    pub(crate) without_motion_model: bool,
}

/// The product of all factors, and the reasons that lower it, the strongest first.
pub(crate) fn quality(signs: &Signs) -> (f64, Vec<QualityReason>) {
    let up_to = |n: usize, many: f64| (n as f64 / many).min(1.0);
    let below = |value: f64, good: f64| if value > good { good / value } else { 1.0 };
    let sigma =
        signs.sigma.map_or(1.0, |[m, deg]| below(m, GOOD_SIGMA_PER_DEPTH).min(below(deg, GOOD_SIGMA_DEG)));
    let relocalized = signs
        .since_relocalized
        .map_or(1.0, |n| RELOCALIZED + (1.0 - RELOCALIZED) * (f64::from(n) / RELOCALIZED_FRAMES).min(1.0));
    let mut factors = [
        (up_to(signs.inliers, MANY_INLIERS * signs.needed as f64), QualityReason::FewInliers),
        (up_to(signs.cells, SPREAD_CELLS), QualityReason::BadlySpread),
        (sigma, QualityReason::LargeCovariance),
        (signs.near.map_or(1.0, |near| up_to(near, MANY_NEAR)), QualityReason::MostlyFar),
        (below(signs.residual, GOOD_RESIDUAL).powi(2), QualityReason::LargeResiduals),
        (relocalized, QualityReason::JustRelocalized),
        (
            if signs.without_motion_model { WITHOUT_MOTION_MODEL } else { 1.0 },
            QualityReason::WithoutMotionModel,
        ),
    ];
    let quality = factors.iter().map(|(factor, _)| factor).product();
    // Stable: of equal factors the one that stands first.
    factors.sort_by(|a, b| a.0.total_cmp(&b.0));
    let reasons = factors.iter().filter(|(factor, _)| *factor < HARDLY_LOWER).map(|(_, reason)| *reason);
    (quality, reasons.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn good() -> Signs {
        Signs {
            inliers: 200,
            needed: 30,
            cells: 10,
            sigma: Some([0.001, 0.05]),
            near: Some(80),
            residual: 0.9,
            since_relocalized: None,
            without_motion_model: false,
        }
    }

    #[test]
    fn a_good_frame_is_trusted_entirely() {
        assert_eq!(quality(&good()), (1.0, vec![]));
        // What is not known is not held against it.
        assert_eq!(quality(&Signs { sigma: None, near: None, ..good() }), (1.0, vec![]));
    }

    #[test]
    fn each_sign_lowers_it_for_its_own_reason() {
        for (signs, expected, reason) in [
            (Signs { inliers: 30, ..good() }, 0.5, QualityReason::FewInliers),
            (Signs { cells: 3, ..good() }, 0.5, QualityReason::BadlySpread),
            (Signs { sigma: Some([0.02, 0.1]), ..good() }, 0.5, QualityReason::LargeCovariance),
            (Signs { sigma: Some([0.0, 2.0]), ..good() }, 0.25, QualityReason::LargeCovariance),
            (Signs { near: Some(5), ..good() }, 0.25, QualityReason::MostlyFar),
            (Signs { residual: 2.4, ..good() }, 0.25, QualityReason::LargeResiduals),
            (Signs { since_relocalized: Some(0), ..good() }, 0.5, QualityReason::JustRelocalized),
            (Signs { without_motion_model: true, ..good() }, 0.7, QualityReason::WithoutMotionModel),
        ] {
            let (found, reasons) = quality(&signs);
            assert!((found - expected).abs() < 1e-12, "{signs:?}: {found}");
            assert_eq!(reasons, [reason], "{signs:?}");
        }
        let after = |n| quality(&Signs { since_relocalized: Some(n), ..good() }).0;
        assert!(after(0) < after(1) && after(4) < after(5) && after(5) == 1.0 && after(90) == 1.0);
    }

    #[test]
    fn reasons_stand_in_order_of_their_weight() {
        let bad = Signs { inliers: 30, cells: 1, near: Some(17), without_motion_model: true, ..good() };
        let (found, reasons) = quality(&bad);
        use QualityReason::*;
        assert_eq!(reasons, [BadlySpread, FewInliers, WithoutMotionModel, MostlyFar]);
        assert!((found - 0.5 / 6.0 * 0.7 * 0.85).abs() < 1e-12);
        let none = quality(&Signs { inliers: 0, ..good() });
        assert_eq!((none.0, none.1[0]), (0.0, FewInliers));
    }
}
