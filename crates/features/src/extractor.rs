//! ORB features of an image (Rublee et al., ICCV 2011) with the distribution of ORB-SLAM2.

use crate::descriptor::Descriptor;
use crate::detect::{Detector, region};
use crate::kernels::brief::{REACH, describe};
use crate::kernels::fast::{self, RADIUS};
use crate::kernels::{Simd, blur, moments};
use crate::keypoint::{ExtractorConfig, Features, Keypoint};
use crate::mask::FeatureMask;
use crate::plane::{Plane, reflect};
use crate::pyramid::{Placement, Pyramid};
use crate::quadtree::{Corner, Quadtree};
use crate::scales::{ScaleLevels, level_quotas};
use geometry::GrayImage;
use rayon::prelude::*;
use std::sync::Arc;

/// Extracts ORB features; owns all buffers, so that nothing but the result is allocated per image.
#[derive(Debug)]
pub struct Extractor {
    config: ExtractorConfig,
    simd: Simd,
    scales: Arc<ScaleLevels>,
    quotas: Vec<usize>,
    pyramid: Pyramid,
    workers: Vec<Worker>,
    mask: Option<Arc<FeatureMask>>,
}

/// Buffers and result of one level.
#[derive(Debug, Default)]
struct Worker {
    detector: Detector,
    quadtree: Quadtree,
    corners: Vec<Corner>,
    kept: Vec<Corner>,
    blurred: Plane,
    line: Vec<i16>,
    features: Features,
}

impl Extractor {
    /// An extractor with these settings.
    #[must_use]
    pub fn new(config: ExtractorConfig) -> Self {
        let scales = Arc::new(ScaleLevels::new(config.levels, config.scale_factor));
        let quotas = level_quotas(config.keep, config.levels, config.scale_factor);
        let workers = (0..config.levels).map(|_| Worker::default()).collect();
        Self {
            config,
            simd: Simd::detect(),
            scales,
            quotas,
            pyramid: Pyramid::default(),
            workers,
            mask: None,
        }
    }

    /// Takes features from now on only where the mask, which has the size of the images, allows it.
    #[must_use]
    pub fn with_mask(mut self, mask: Option<Arc<FeatureMask>>) -> Self {
        self.mask = mask;
        self
    }

    /// The features of `image`: at most `keep`, by octave, row, column; none when it is smaller than 33 pixels.
    ///
    /// Levels run in parallel on the current rayon pool; the result does not depend on the number of threads.
    pub fn extract(&mut self, image: &GrayImage) -> Features {
        self.pyramid.build(self.simd, &self.scales, image);
        let Self { config, simd, quotas, pyramid, workers, mask, .. } = self;
        let mask = mask.as_deref();
        let levels = pyramid.levels();
        workers[..levels.len()].par_iter_mut().with_max_len(1).enumerate().for_each(|(octave, worker)| {
            worker.run(
                *simd,
                config,
                &levels[octave],
                (octave as u8, pyramid.placement(octave)),
                (quotas[octave], mask),
            );
        });
        let n_features = workers.iter().map(|w| w.features.keypoints.len()).sum();
        let mut features = Features {
            keypoints: Vec::with_capacity(n_features),
            descriptors: Vec::with_capacity(n_features),
        };
        for worker in &workers[..levels.len()] {
            features.keypoints.extend_from_slice(&worker.features.keypoints);
            features.descriptors.extend_from_slice(&worker.features.descriptors);
        }
        features
    }

    /// The pyramid of the last image.
    #[must_use]
    pub fn pyramid(&self) -> &Pyramid {
        &self.pyramid
    }

    /// Scales of the levels.
    #[must_use]
    pub fn scales(&self) -> &Arc<ScaleLevels> {
        &self.scales
    }
}

impl Worker {
    /// Detects, distributes, orients and describes the features of one level.
    fn run(
        &mut self,
        simd: Simd,
        config: &ExtractorConfig,
        level: &Plane,
        (octave, placement): (u8, Placement),
        (quota, mask): (usize, Option<&FeatureMask>),
    ) {
        let Features { keypoints, descriptors } = &mut self.features;
        keypoints.clear();
        descriptors.clear();
        let Some(bounds) = region(level) else { return };
        self.detector.run(simd, level, config.fast_initial, config.fast_minimum, &mut self.corners);
        if let Some(mask) = mask {
            let place = |c: &Corner| placement.to_full(f32::from(c.x), f32::from(c.y));
            self.corners.retain(|corner| mask.allows(octave, place(corner)));
        }
        self.quadtree.distribute(&self.corners, bounds, quota, &mut self.kept);
        if self.kept.is_empty() {
            return;
        }
        blur::gaussian(simd, level, &mut self.line, &mut self.blurred);
        for corner in &self.kept {
            let (x, y) = (usize::from(corner.x), usize::from(corner.y));
            let (m10, m01) = moments::moments(simd, level.data(), level.stride(), y * level.stride() + x);
            let angle_deg = direction_deg(m10, m01);
            let (dx, dy) = if config.subpixel { refine(simd, level, x, y) } else { (0.0, 0.0) };
            let response = f32::from(corner.score);
            let (full_x, full_y) = placement.to_full(x as f32 + dx, y as f32 + dy);
            keypoints.push(Keypoint { x: full_x, y: full_y, octave, angle_deg, response });
            descriptors.push(describe_at(simd, &self.blurred, x, y, angle_deg));
        }
    }
}

/// Angle of the vector `(x, y)` in degrees, [0, 360).
fn direction_deg(x: i32, y: i32) -> f32 {
    let angle = (y as f32).atan2(x as f32).to_degrees();
    let angle = if angle < 0.0 { angle + 360.0 } else { angle };
    if angle >= 360.0 { 0.0 } else { angle }
}

/// The descriptor at a pixel of the blurred level; pixels beyond the edge are mirrored.
fn describe_at(simd: Simd, blurred: &Plane, x: usize, y: usize, angle_deg: f32) -> Descriptor {
    let angle = f64::from(angle_deg * (std::f64::consts::PI / 180.0) as f32);
    let (sin, cos) = (angle.sin() as f32, angle.cos() as f32);
    let inside = |p: usize, len: usize| p >= REACH && p + REACH < len;
    if inside(x, blurred.width()) && inside(y, blurred.height()) {
        let stride = blurred.stride();
        return describe(simd, blurred.data(), stride, y * stride + x, cos, sin);
    }
    const SIDE: usize = 2 * REACH + 1;
    let mirrored = |p: usize, len: usize| -> [usize; SIDE] {
        std::array::from_fn(|i| reflect(p as isize + i as isize - REACH as isize, len))
    };
    let columns = mirrored(x, blurred.width());
    let mut patch = [0; SIDE * SIDE + 3];
    for (line, row) in patch.chunks_exact_mut(SIDE).zip(mirrored(y, blurred.height())) {
        let source = blurred.pixels(row);
        for (value, column) in line.iter_mut().zip(columns) {
            *value = source[column];
        }
    }
    describe(simd, &patch, SIDE, REACH * SIDE + REACH, cos, sin)
}

/// Position of a corner relative to its pixel: centroid of the squared scores of its 3 x 3 surroundings, within a pixel.
///
/// Of the estimators tried (parabola, quadratic surface, structure tensor, Harris) this one repeats best between two views.
fn refine(simd: Simd, level: &Plane, x: usize, y: usize) -> (f32, f32) {
    let scores = fast::score_square(simd, &std::array::from_fn(|i| level.row(y + i - RADIUS - 1)), x);
    let (mut sum, mut sum_x, mut sum_y) = (0, 0, 0);
    for (row, dy) in scores.iter().zip(-1..) {
        for (score, dx) in row.iter().zip(-1..) {
            let weight = i32::from(*score) * i32::from(*score);
            sum += weight;
            sum_x += dx * weight;
            sum_y += dy * weight;
        }
    }
    if sum == 0 { (0.0, 0.0) } else { (sum_x as f32 / sum as f32, sum_y as f32 / sum as f32) }
}
