//! Refines the stereo calibration from the images alone: a constant offset of all disparities.
//!
//! A right camera that is turned by a few thousandths of a degree against its calibration shifts every disparity by the
//! same fraction of a pixel. Depths of near and far points then disagree with how the points move, so the offset shows in
//! the cost of a bundle adjustment and is where that cost is lowest (Cvisic et al., arXiv 2109.03462, refine a full
//! calibration in this way; the offset alone is what matters most for scale).

use map::{KeyframeId, Map};
use optim::{BundleOptions, BundleProblem, refine_bundle};

use crate::noise::Noise;
use crate::problem::MapProblem;

/// An offset with its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OffsetEstimate {
    /// To be added to measured disparities, pixels.
    pub offset_px: f64,
    /// Standard deviation, pixels, if residuals are as large as assumed (0.4 px at octave 0) and independent.
    pub sigma_px: f64,
    /// Observations with depth that it rests on.
    pub observations: usize,
}

/// Standard deviation of a feature's position at octave 0, pixels, as seen in residuals on real drives.
const SIGMA_PX: f64 = 0.4;
/// What is expected before anything was seen: rectification is good to about this many pixels.
const PRIOR_SIGMA_PX: f64 = 0.1;
/// What the model does not know (moving objects, lenses): no estimate is better than this.
const SYSTEMATIC_SIGMA_PX: f64 = 0.03;
/// Larger offsets are rejected: something else is wrong.
const MAX_OFFSET_PX: f64 = 0.4;
/// Steps of the two parabolas, pixels.
const STEPS_PX: [f64; 2] = [0.1, 0.05];
/// Fewer keyframes do not tell.
const MIN_KEYFRAMES: usize = 8;
/// Fewer observations with depth do not tell.
const MIN_OBSERVATIONS: usize = 1000;
/// Points count from this many observations on.
const MIN_TRACK: usize = 3;
const ITERATIONS: usize = 25;

/// The disparity offset that the map's keyframes agree on; `None` if there are too few of them or the cost has no clear
/// minimum near zero.
pub fn estimate_disparity_offset(map: &Map) -> Option<OffsetEstimate> {
    let problem = whole_map(map)?;
    let observations = problem.observations.iter().filter(|o| !o.right_u.is_nan()).count();
    if problem.cameras.len() < MIN_KEYFRAMES || observations < MIN_OBSERVATIONS {
        return None;
    }
    let (mut offset, mut curvature) = (0.0_f64, 0.0);
    for step in STEPS_PX {
        let costs = [-step, 0.0, step].map(|shift| cost_at(&problem, offset + shift));
        let [before, middle, after] = costs;
        curvature = (before + after - 2.0 * middle) / (step * step);
        if curvature <= 0.0 {
            return None;
        }
        let move_px = 0.5 * (before - after) / (curvature * step);
        offset = (offset + move_px.clamp(-2.0 * step, 2.0 * step)).clamp(-MAX_OFFSET_PX, MAX_OFFSET_PX);
    }
    // Both are Gaussian: the estimate is drawn towards zero by how much the images tell less than the prior.
    let variance = 1.0 / curvature + SYSTEMATIC_SIGMA_PX * SYSTEMATIC_SIGMA_PX;
    let prior = PRIOR_SIGMA_PX * PRIOR_SIGMA_PX;
    let trust = prior / (prior + variance);
    Some(OffsetEstimate { offset_px: offset * trust, sigma_px: (variance * trust).sqrt(), observations })
}

/// Lowest robust cost with `offset_px` added to all disparities.
fn cost_at(problem: &BundleProblem, offset_px: f64) -> f64 {
    let mut shifted = problem.clone();
    for observation in &mut shifted.observations {
        observation.right_u -= offset_px;
    }
    let options = BundleOptions { max_iterations: ITERATIONS, robust: true, ..BundleOptions::default() };
    refine_bundle(&shifted, &options).report.final_cost
}

/// All keyframes and well observed points as one problem; the first keyframe is fixed.
fn whole_map(map: &Map) -> Option<BundleProblem> {
    let keyframes: Vec<KeyframeId> = map.keyframes().map(|kf| kf.id).collect();
    let first = *keyframes.first()?;
    let points = map.points().filter(|point| point.observations().len() >= MIN_TRACK).map(|p| p.id).collect();
    let noise = Noise { sigma_px: SIGMA_PX, weighted: false };
    MapProblem::new(map, keyframes, points, noise, |id| id == first).map(|whole| whole.problem)
}
