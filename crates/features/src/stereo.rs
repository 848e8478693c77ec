//! Disparities of the left keypoints by direct search in the right image; no features are extracted there.
//!
//! Per keypoint: costs of its patch along the whole row at its octave, the best must stand out and be the best seen from the
//! right image too; then alignment at full resolution. At the end matches with an unusually high residual are dropped.

use crate::align::{self, Alignment, align};
use crate::frame::Rig;
use crate::kernels::minimum;
use crate::kernels::sad::{self, costs_along_row};
use crate::keypoint::Keypoint;
use crate::plane::Plane;
use crate::pyramid::Pyramid;
use geometry::median;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use settings::{Entry, Section, above, between, optional_real, real};
use simd::Simd;

/// How disparities are searched and which are believed: the section `stereo` of the configuration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct StereoConfig {
    /// Nearest depth searched, meters; `None`: five baselines.
    pub min_depth_m: Option<f64>,
    /// Depth in baselines up to which a point is close.
    pub close_depth_baselines: f64,
    /// Added to every disparity: a known error of the stereo calibration, pixels.
    pub disparity_offset_px: f64,
    /// The best cost must be below this share of the best one farther than three pixels away (1: no such test).
    pub uniqueness: f32,
    /// Largest disagreement of the search back from the right image, pixels of the octave.
    pub max_left_right_px: usize,
    /// Matches with a residual of at least this multiple of the median are dropped.
    pub max_residual_ratio: f32,
}

impl Default for StereoConfig {
    fn default() -> Self {
        Self {
            min_depth_m: None,
            close_depth_baselines: 40.0,
            disparity_offset_px: 0.0,
            uniqueness: 0.85,
            max_left_right_px: 1,
            max_residual_ratio: 2.1,
        }
    }
}

#[rustfmt::skip]
impl Section for StereoConfig {
    const KEYS: &'static [Entry] = &[
        optional_real("stereo.min_depth_m", "m", above(0.0), "minimum depth of stereo matches; absent: five baselines"),
        real("stereo.close_depth_baselines", "baselines", above(0.0), "features nearer than this become map points at once"),
        real("stereo.disparity_offset_px", "px", between(-5.0, 5.0), "added to every disparity to correct a known error of the stereo calibration"),
    ];
}

/// Smaller disparities, about the accuracy of the measurement, say nothing of the depth.
const MIN_DISPARITY_PX: f64 = 0.1;
/// Baselines of the nearest depth when none is configured.
const NEAREST_BASELINES: f64 = 5.0;

/// Matches patches along rows.
#[derive(Debug)]
pub(crate) struct StereoMatcher {
    config: StereoConfig,
    simd: Simd,
}

/// A left and a right image with equal sizes of their levels.
#[derive(Clone, Copy)]
pub(crate) struct StereoPair<'a> {
    pub(crate) left: &'a Pyramid,
    pub(crate) right: &'a Pyramid,
}

/// Scratch memory of one search.
#[derive(Default)]
struct Scratch {
    sad: sad::Scratch,
    costs: Vec<u16>,
}

/// Result of a search on one level.
#[derive(Clone, Copy)]
struct Coarse {
    /// Pixels of the level.
    disparity: f32,
    /// Brightness that the right patch lacks, gray levels.
    offset: i16,
}

impl StereoMatcher {
    pub(crate) fn new(config: StereoConfig) -> Self {
        Self { config, simd: Simd::detect() }
    }

    /// Disparity of each keypoint in pixels of level 0, above zero and NaN where none is accepted, with its change per row. Runs on
    /// the current rayon pool; the result does not depend on the number of threads.
    pub(crate) fn disparities(
        &self,
        rig: &Rig,
        pair: StereoPair<'_>,
        keypoints: &[Keypoint],
    ) -> Vec<[f32; 2]> {
        let min_depth = self.config.min_depth_m.unwrap_or(NEAREST_BASELINES * rig.stereo.baseline_m);
        let max_disparity = (rig.stereo.bf() / min_depth) as f32;
        let find = |scratch: &mut Scratch, keypoint: &Keypoint| {
            let found = self.find(pair, keypoint, max_disparity, scratch)?;
            (found.disparity > MIN_DISPARITY_PX && found.disparity < f64::from(max_disparity))
                .then_some(found)
        };
        let found: Vec<Option<Alignment>> =
            keypoints.par_iter().with_min_len(32).map_init(Scratch::default, find).collect();
        let mut residuals: Vec<f64> = found.iter().flatten().map(|f| f.residual).collect();
        let Some(median) = median(&mut residuals) else { return vec![[f32::NAN, 0.0]; keypoints.len()] };
        // Residuals of perfect images are all zero.
        let limit = (f64::from(self.config.max_residual_ratio) * median).max(1.0);
        found
            .iter()
            .map(|f| {
                f.filter(|f| f.residual < limit)
                    .map_or([f32::NAN, 0.0], |f| [f.disparity as f32, f.slope as f32])
            })
            .collect()
    }

    /// The disparity of one keypoint at level 0.
    fn find(
        &self,
        pair: StereoPair<'_>,
        keypoint: &Keypoint,
        max_disparity: f32,
        scratch: &mut Scratch,
    ) -> Option<Alignment> {
        let octave = usize::from(keypoint.octave);
        let placement = pair.left.placement(octave);
        let scale = placement.x;
        let (left, right) = (&pair.left.levels()[octave], &pair.right.levels()[octave]);
        let place = placement.to_level(keypoint.x, keypoint.y);
        let place = (place.0.round() as usize, place.1.round() as usize);
        let coarse = self.search(left, right, place, (max_disparity / scale) as usize, scratch)?;

        let (left, right) = (&pair.left.levels()[0], &pair.right.levels()[0]);
        let (x, y) = (keypoint.x.round() as usize, keypoint.y.round() as usize);
        let margin = align::MARGIN;
        if x < margin || y < margin || x + margin >= left.width() || y + margin >= left.height() {
            return None;
        }
        let start = Alignment::start(f64::from(coarse.disparity * scale), f64::from(coarse.offset));
        let mut fine = align(self.simd, (left, x, y), right, start, f64::from(scale))?;
        // From the center of the patch to the corner itself.
        fine.disparity += fine.slope * (f64::from(keypoint.y) - y as f64);
        Some(fine)
    }

    /// The disparity of a pixel by the whole row of its level, to about a tenth of a pixel.
    fn search(
        &self,
        left: &Plane,
        right: &Plane,
        (x, y): (usize, usize),
        max_disparity: usize,
        scratch: &mut Scratch,
    ) -> Option<Coarse> {
        let (width, height) = (left.width(), left.height());
        let fits = x >= sad::LEFT && x + sad::LEFT < width && y >= sad::ABOVE && y + sad::ABOVE <= height;
        if !fits {
            return None;
        }
        // From the largest disparity to minus one: places in the right image from left to right.
        let first = x.saturating_sub(max_disparity).max(sad::LEFT);
        let n = x + 2 - first;
        let Scratch { sad, costs } = scratch;
        costs_along_row(self.simd, (left, x, y), (right, first, n), sad, costs);
        let (best, fraction) = minimum::distinct_minimum(self.simd, costs, self.config.uniqueness)?;
        let right_x = first + best;
        let disparity = x as f32 - right_x as f32 - fraction;
        let offset = sad.bias(best);

        let back_first = right_x.saturating_sub(1).max(sad::LEFT);
        let back_end = (right_x + max_disparity + 1).min(width + 1 - sad::LEFT);
        costs_along_row(
            self.simd,
            (right, right_x, y),
            (left, back_first, back_end - back_first),
            sad,
            costs,
        );
        let back = back_first + minimum::last_minimum(self.simd, costs);
        (back.abs_diff(x) <= self.config.max_left_right_px).then_some(Coarse { disparity, offset })
    }
}
