//! Disparities of the left key-points by direct search in the right image; no features are extracted there.

use crate::frame::Rig;
use crate::keypoint::Keypoint;
use crate::plane::Plane;
use crate::pyramid::Pyramid;
use crate::scales::ScaleLevels;
use rayon::prelude::*;

/// How disparities are searched and which are believed.
#[derive(Clone, Debug, PartialEq)]
pub struct StereoConfig {
    /// Nearest depth searched, metres; 0: four baselines.
    pub min_depth_m: f64,
    /// The best cost must be below this share of every other local minimum.
    pub uniqueness: f32,
    /// Largest disagreement of the search back from the right image, pixels of the octave.
    pub max_left_right_px: f32,
    /// Matches with a cost of at least this multiple of the median are dropped.
    pub max_cost_ratio: f32,
}

impl Default for StereoConfig {
    fn default() -> Self {
        Self { min_depth_m: 0.0, uniqueness: 0.9, max_left_right_px: 1.0, max_cost_ratio: 2.1 }
    }
}

/// Half side of the compared patches, pixels of the octave.
const HALF: usize = 5;

/// Matches patches along rows.
#[derive(Debug)]
pub(crate) struct StereoMatcher {
    config: StereoConfig,
}

/// A disparity in pixels of the octave and its cost.
#[derive(Clone, Copy, Debug)]
struct Found {
    disparity: f32,
    cost: u32,
}

impl StereoMatcher {
    pub(crate) fn new(config: StereoConfig) -> Self {
        Self { config }
    }

    /// Disparity of each key-point in pixels of level 0; NaN where none is believed.
    pub(crate) fn disparities(
        &self,
        rig: &Rig,
        scales: &ScaleLevels,
        keypoints: &[Keypoint],
        left: &Pyramid,
        right: &Pyramid,
    ) -> Vec<f32> {
        let min_depth =
            if self.config.min_depth_m > 0.0 { self.config.min_depth_m } else { 4.0 * rig.stereo.baseline_m };
        let max_disparity = (rig.stereo.bf() / min_depth) as f32;
        let find = |k: &Keypoint| {
            let octave = usize::from(k.octave);
            let scale = scales.scales[octave];
            let (left, right) = (left.levels().get(octave)?, right.levels().get(octave)?);
            self.find(
                left,
                right,
                (k.x / scale).round() as usize,
                (k.y / scale).round() as usize,
                max_disparity / scale,
            )
        };
        let found: Vec<Option<Found>> = keypoints.par_iter().with_min_len(64).map(find).collect();
        let mut costs: Vec<u32> = found.iter().flatten().map(|f| f.cost).collect();
        if costs.is_empty() {
            return vec![f32::NAN; keypoints.len()];
        }
        let middle = costs.len() / 2;
        let median = *costs.select_nth_unstable(middle).1;
        let believed = |f: &Found| (f.cost as f32) < self.config.max_cost_ratio * median as f32;
        let disparity = |(k, f): (&Keypoint, &Option<Found>)| {
            f.filter(believed).map_or(f32::NAN, |f| f.disparity * scales.scales[usize::from(k.octave)])
        };
        keypoints.iter().zip(&found).map(disparity).collect()
    }

    fn find(&self, left: &Plane, right: &Plane, x: usize, y: usize, max_disparity: f32) -> Option<Found> {
        let fits = x >= HALF && y >= HALF && x + HALF < left.width() && y + HALF < left.height();
        if !fits {
            return None;
        }
        let n = (max_disparity as usize).min(x - HALF) + 1;
        let costs: Vec<u32> = (0..n).map(|d| cost(left, right, x, x - d, y)).collect();
        let best = (0..n).min_by_key(|&d| (costs[d], d))?;
        let other = (0..n).filter(|d| d.abs_diff(best) > 2).map(|d| costs[d]).min();
        if other.is_some_and(|other| costs[best] as f32 >= self.config.uniqueness * other as f32) {
            return None;
        }
        if best == 0 || best + 1 == n {
            return None;
        }
        let right_x = x - best;
        let m = (max_disparity as usize).min(left.width() - 1 - HALF - right_x) + 1;
        let back = (0..m).min_by_key(|&d| (cost(left, right, right_x + d, right_x, y), d))?;
        if back.abs_diff(best) as f32 > self.config.max_left_right_px {
            return None;
        }
        let [before, centre, after] = [costs[best - 1], costs[best], costs[best + 1]].map(|c| c as f32);
        let delta = 0.5 * (before - after) / (before + after - 2.0 * centre);
        (delta.abs() <= 1.0).then_some(Found { disparity: best as f32 + delta, cost: costs[best] })
    }
}

/// Sum of absolute differences of two patches, each without its centre value.
fn cost(left: &Plane, right: &Plane, left_x: usize, right_x: usize, y: usize) -> u32 {
    let bias = i32::from(left.at(left_x, y)) - i32::from(right.at(right_x, y));
    let mut sum = 0;
    for row in y - HALF..=y + HALF {
        let a = &left.row(row)[left_x - HALF..=left_x + HALF];
        let b = &right.row(row)[right_x - HALF..=right_x + HALF];
        for (p, q) in a.iter().zip(b) {
            sum += (i32::from(*p) - i32::from(*q) - bias).unsigned_abs();
        }
    }
    sum
}
