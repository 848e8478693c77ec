//! The start of a monocular map: motion and points from the pixel matches of two views, or the reason why not yet.
//!
//! After Mur-Artal, Montiel and Tardos (T-RO 2015, section IV): a homography and a fundamental matrix compete, the motions
//! behind the winner are tried on the points. Beyond the paper, each motion is refined on the epipolar errors of all matches
//! before it is judged, and judged on all matches, so that points off a plane help to tell its two solutions apart.

mod candidate;
mod failure;
mod models;
mod refine;

pub use failure::TwoViewFailure;

use crate::aliases::{Vec2, Vec3};
use crate::pinhole::Pinhole;
use crate::sampler::usable_weights;
use crate::se3::SE3;
use candidate::{Candidate, same_motion};
use models::Models;
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
    /// Most points of the second best motion, as a share of those of the best.
    pub max_second_share: f64,
    /// Share of the homography in the sum of both scores above which it is chosen.
    pub homography_share: f64,
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
            max_second_share: 0.7,
            homography_share: 0.4,
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

/// The model that explains the matches.
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
    /// What was chosen.
    pub model: TwoViewModel,
    /// Share of the homography in the sum of both scores.
    pub homography_share: f64,
    /// Matches that the model explains.
    pub n_inliers: usize,
    /// Matches that agree with the motion, those with too little parallax for a point among them.
    pub n_consistent: usize,
    /// Number of points.
    pub n_points: usize,
    /// Points of the second best motion.
    pub n_second: usize,
    /// Parallax in degrees that `min_points` matches reach.
    pub parallax_deg: f64,
    /// Median depth of the points in the first camera.
    pub median_depth: f64,
}

impl TwoView {
    /// The same views in another unit of length: all lengths times `factor`.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let motion = &self.second_from_first;
        Self {
            second_from_first: SE3::new(motion.rotation, motion.translation * factor),
            points: self.points.iter().map(|point| point.map(|point| point * factor)).collect(),
            median_depth: self.median_depth * factor,
            ..self.clone()
        }
    }
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
        let view = Views { reconstruction: self, matches, weights: &weights };
        let models = Models::estimate(&view, seed);
        let Some(chosen) = models.choose(&view) else {
            return Err(TwoViewFailure::NoModel { n_matches: found });
        };
        let motions = chosen.motions.iter().map(|motion| refine::refine_motion(&view, motion));
        let candidates: Vec<Candidate> = motions.map(|motion| Candidate::new(&view, motion)).collect();
        let order = |c: &&Candidate| (c.n_points, c.n_consistent);
        // `max_by_key` takes the last of equals; reversed, that is the first.
        let Some(best) = candidates.iter().rev().max_by_key(order) else {
            // A homography without a plane: the camera turned only.
            return Err(self.too_little_parallax(chosen.model, 0.0));
        };
        let others = candidates.iter().filter(|other| !same_motion(&other.motion, &best.motion));
        let n_second = others.map(|other| other.n_points).max().unwrap_or(0);
        self.judge(&chosen, best, n_second)?;
        Ok(best.to_two_view(&chosen, n_second))
    }

    /// The tests of the best motion.
    fn judge(
        &self,
        chosen: &models::Chosen,
        best: &Candidate,
        n_second: usize,
    ) -> Result<(), TwoViewFailure> {
        let options = &self.options;
        let model = chosen.model;
        let needed = options.min_points.max((options.min_share * chosen.n_inliers as f64).ceil() as usize);
        if best.n_consistent < needed {
            let (found, n_inliers) = (best.n_consistent, chosen.n_inliers);
            return Err(TwoViewFailure::TooFewPoints { model, found, needed, n_inliers });
        }
        if best.parallax_deg < options.min_parallax_deg {
            return Err(self.too_little_parallax(model, best.parallax_deg));
        }
        if n_second as f64 > options.max_second_share * best.n_points as f64 {
            let (best, max_share) = (best.n_points, options.max_second_share);
            return Err(TwoViewFailure::Ambiguous { model, best, second: n_second, max_share });
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
