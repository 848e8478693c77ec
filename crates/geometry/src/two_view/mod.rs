//! The start of a monocular map: motion and points from the pixel matches of two views, or the reason why not yet.
//!
//! As in Mur-Artal, Montiel and Tardos (T-RO 2015, section IV) a homography and a fundamental matrix are estimated side by side, but
//! what they suggest decides: all motions behind both are refined on the epipolar errors of all matches, and the one that leaves
//! the least error wins. (The paper chooses a model by the share of their scores, before any motion is known: in scenes that are
//! neither flat nor deep that took wrong motions of planes.) A second motion that explains the points almost as well, and a
//! direction that the matches leave uncertain, are reasons to wait for a better second view.

mod candidate;
mod failure;
mod models;
mod outcome;
mod refine;

pub use failure::TwoViewFailure;

use crate::aliases::{Vec2, Vec3};
use crate::pinhole::Pinhole;
use crate::sampler::usable_weights;
use crate::se3::SE3;
use candidate::Candidate;
use models::Models;
use outcome::Outcome;
use std::fmt;

/// Chi-square, 2 degrees of freedom, 95 %: a pixel.
const CHI2_PIXEL: f64 = 5.991;
/// Chi-square, 1 degree of freedom, 95 %: the distance from a line.
const CHI2_LINE: f64 = 3.841;

/// When two views are good enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoViewOptions {
    /// Standard deviation of a pixel coordinate.
    pub sigma_px: f64,
    /// Most samples per model.
    pub max_iterations: usize,
    /// Least number of matches.
    pub min_matches: usize,
    /// Least number of matches that agree with the motion, and of points with enough parallax.
    pub min_points: usize,
    /// Least share of the model's inliers that agree with the motion.
    pub min_share: f64,
    /// Parallax in degrees that the `min_points` points with the most parallax must have.
    pub min_parallax_deg: f64,
    /// Parallax in degrees below which a match gives no point.
    pub min_point_parallax_deg: f64,
    /// Most that another motion may explain of what the best one does, as a share.
    pub max_second_share: f64,
    /// Largest standard deviation of the direction of the translation, degrees.
    pub max_direction_sigma_deg: f64,
}

impl Default for TwoViewOptions {
    fn default() -> Self {
        Self {
            sigma_px: 1.0,
            max_iterations: 1000,
            min_matches: 100,
            min_points: 50,
            min_share: 0.9,
            min_parallax_deg: 1.0,
            min_point_parallax_deg: 0.36,
            max_second_share: 0.8,
            max_direction_sigma_deg: 2.0,
        }
    }
}

/// Matched undistorted pixels of two views, with the trust in each match.
#[derive(Clone, Copy, Debug)]
pub struct TwoViewMatches<'a> {
    /// Pixels in the first view.
    pub first: &'a [Vec2],
    /// Pixels in the second view.
    pub second: &'a [Vec2],
    /// One weight per match, all equal if there is none. A match without weight gets a point if it agrees, but has no say.
    pub weights: Option<&'a [f64]>,
}

/// The model that a motion comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TwoViewModel {
    /// A plane.
    Homography,
    /// A scene with depth.
    Fundamental,
}

impl fmt::Display for TwoViewModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Homography => "homography",
            Self::Fundamental => "fundamental matrix",
        })
    }
}

/// Two views with their motion and points, in the unit of the distance between the two cameras.
#[derive(Clone, Debug, PartialEq)]
pub struct TwoView {
    /// The motion; its translation has length one.
    pub second_from_first: SE3,
    /// For each match its point in the first camera, in front of both and with small errors in both; `None` for the others.
    pub points: Vec<Option<Vec3>>,
    /// Where the motion comes from.
    pub model: TwoViewModel,
    /// Matches that the model explained.
    pub n_inliers: usize,
    /// Matches that agree with the motion, those with too little parallax for a point among them.
    pub n_consistent: usize,
    /// Number of points.
    pub n_points: usize,
    /// How much of what the motion gains by its points another one gains by the same matches, 0 to 1.
    pub second_share: f64,
    /// Parallax in degrees that `min_points` matches reach.
    pub parallax_deg: f64,
    /// Standard deviation of the direction of the translation along its least certain axis, degrees.
    pub direction_sigma_deg: f64,
    /// Median depth of the points in the first camera.
    pub median_depth: f64,
}

/// Reconstructs two views of calibrated cameras.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoViewReconstruction {
    /// Camera of the first view.
    pub first: Pinhole,
    /// Camera of the second view.
    pub second: Pinhole,
    /// When the views are good enough.
    pub options: TwoViewOptions,
}

impl TwoViewReconstruction {
    /// Motion and points of two views; equal matches and seed give equal bits.
    ///
    /// # Errors
    /// [`TwoViewFailure`] with the numbers of the test that failed.
    ///
    /// # Panics
    /// When pixels do not come in pairs or weights are not one per match.
    pub fn reconstruct(&self, matches: &TwoViewMatches<'_>, seed: u64) -> Result<TwoView, TwoViewFailure> {
        let n = matches.first.len();
        assert_eq!(n, matches.second.len(), "pixels come in pairs");
        let weights = usable_weights(n, matches.weights);
        let Some(weights) = weights else { panic!("one weight per match") };
        let found = weights.iter().filter(|&&weight| weight > 0.0).count();
        if found < self.options.min_matches {
            return Err(TwoViewFailure::TooFewMatches { found, needed: self.options.min_matches });
        }
        let views = Views { reconstruction: self, matches, weights: &weights };
        let models = Models::estimate(&views, seed);
        let Some(motions) = models.motions(&views) else {
            return Err(TwoViewFailure::NoModel { n_matches: found });
        };
        let candidates = motions.iter().map(|suggestion| Candidate::new(&views, suggestion)).collect();
        let Some(outcome) = Outcome::new(&views, &models, candidates) else {
            // A homography that no plane explains: the camera turned only.
            return Err(self.too_little_parallax(TwoViewModel::Homography, 0.0));
        };
        self.judge(&outcome)?;
        Ok(outcome.into_two_view())
    }

    /// The tests of the best motion.
    fn judge(&self, outcome: &Outcome) -> Result<(), TwoViewFailure> {
        let Outcome { ref best, second_share: share, model, n_inliers } = *outcome;
        let options = &self.options;
        let needed = options.min_points.max((options.min_share * n_inliers as f64).ceil() as usize);
        if best.n_consistent < needed {
            return Err(TwoViewFailure::TooFewPoints { model, found: best.n_consistent, needed, n_inliers });
        }
        if best.parallax_deg < options.min_parallax_deg {
            return Err(self.too_little_parallax(model, best.parallax_deg));
        }
        if share > options.max_second_share {
            return Err(TwoViewFailure::Ambiguous { model, share, max_share: options.max_second_share });
        }
        let (found_deg, max_deg) = (best.direction_sigma_deg, options.max_direction_sigma_deg);
        if found_deg > max_deg {
            return Err(TwoViewFailure::Uncertain { model, found_deg, max_deg });
        }
        Ok(())
    }

    fn too_little_parallax(&self, model: TwoViewModel, found_deg: f64) -> TwoViewFailure {
        TwoViewFailure::TooLittleParallax { model, found_deg, needed_deg: self.options.min_parallax_deg }
    }
}

/// What all steps look at.
struct Views<'a> {
    reconstruction: &'a TwoViewReconstruction,
    matches: &'a TwoViewMatches<'a>,
    /// Usable weights, one per match.
    weights: &'a [f64],
}

impl Views<'_> {
    fn options(&self) -> &TwoViewOptions {
        &self.reconstruction.options
    }

    fn len(&self) -> usize {
        self.weights.len()
    }

    /// The pixels of a match.
    fn pixels(&self, i: usize) -> (&Vec2, &Vec2) {
        (&self.matches.first[i], &self.matches.second[i])
    }

    /// The rays of a match, each in its camera, with `z = 1`.
    fn rays(&self, i: usize) -> (Vec3, Vec3) {
        let (first, second) = self.pixels(i);
        (self.reconstruction.first.unproject(first), self.reconstruction.second.unproject(second))
    }

    /// Variance of a pixel coordinate, square pixels.
    fn variance(&self) -> f64 {
        self.options().sigma_px * self.options().sigma_px
    }
}
