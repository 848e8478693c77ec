//! ORB features of an image (Rublee et al., ICCV 2011) with the distribution of ORB-SLAM2.

use crate::activation::{ActivationError, ActivationMap, ActivationSource};
use crate::config::ExtractorConfig;
use crate::descriptor::Descriptor;
use crate::detect::{Detector, region};
use crate::kernels::brief::{REACH, describe};
use crate::kernels::fast::{self, RADIUS};
use crate::kernels::{blur, moments};
use crate::keypoint::{Features, Keypoint};
use crate::mask::FeatureMask;
use crate::plane::{Plane, reflect};
use crate::pyramid::{Placement, Pyramid};
use crate::quadtree::{Corner, Quadtree};
use crate::scales::{ScaleLevels, level_quotas};
use crate::selection::{Contender, SelectionConfig, select};
use geometry::GrayImage;
use rayon::prelude::*;
use simd::Simd;
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

/// What a selection keeps of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct Selected {
    /// The features kept.
    pub features: Features,
    /// Activation of each, 0 to 1.
    pub activation: Vec<f32>,
    /// Second answer at each, 0 to 1: whether it will be there another day.
    pub lasting: Vec<f32>,
    /// What the source thinks of the image.
    pub map: ActivationMap,
}

impl Extractor {
    /// An extractor with these settings.
    #[must_use]
    pub fn new(config: ExtractorConfig) -> Self {
        let scales = Arc::new(ScaleLevels::new(config.levels, config.level_ratio()));
        let quotas = level_quotas(config.n_extracted(), config.levels, config.level_ratio());
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
        self.set_mask(mask);
        self
    }

    /// As [`Extractor::with_mask`].
    pub fn set_mask(&mut self, mask: Option<Arc<FeatureMask>>) {
        self.mask = mask;
    }

    /// The features of `image`: at most `keep`, by octave, row, column; none when it is smaller than 33 pixels.
    ///
    /// Levels run in parallel on the current rayon pool; the result does not depend on the number of threads.
    pub fn extract(&mut self, image: &GrayImage) -> Features {
        self.pyramid.build(self.simd, &self.scales, image);
        let work = |worker: &mut Worker, level: Level<'_>| {
            worker.detect(&level);
            worker.describe(&level);
        };
        self.on_levels(work, |_| ());
        self.collect()
    }

    /// As [`Extractor::extract`], then reduced to those that `selection` keeps, each with its activation. The map is made
    /// while candidates are detected; only features that are kept are described.
    ///
    /// # Errors
    /// Those of the source.
    pub fn extract_selected(
        &mut self,
        image: &GrayImage,
        selection: &SelectionConfig,
        source: &dyn ActivationSource,
    ) -> Result<Selected, ActivationError> {
        let map = self.detect(image, |_| source.activation(image))?;
        Ok(self.keep(map, selection, image))
    }

    /// Selects among the candidates of `image`, which are in the workers, and describes those kept.
    pub(crate) fn keep(
        &mut self,
        map: ActivationMap,
        selection: &SelectionConfig,
        image: &GrayImage,
    ) -> Selected {
        let [activation, lasting] = self.select(&map, selection, (image.width, image.height));
        self.on_levels(|worker, level| worker.describe(&level), |_| ());
        Selected { features: self.collect(), activation, lasting, map }
    }

    /// Leaves the candidates of `image` in the workers; returns what `beside` makes of the pyramid meanwhile.
    pub(crate) fn detect<T: Send>(
        &mut self,
        image: &GrayImage,
        beside: impl FnOnce(&Pyramid) -> T + Send,
    ) -> T {
        self.pyramid.build(self.simd, &self.scales, image);
        self.on_levels(|worker, level| worker.detect(&level), beside)
    }

    /// Reduces the candidates to those kept; returns both answers at each, by octave, row, column.
    fn select(
        &mut self,
        map: &ActivationMap,
        config: &SelectionConfig,
        size: (usize, usize),
    ) -> [Vec<f32>; 2] {
        let n_levels = self.pyramid.levels().len();
        let workers = &mut self.workers[..n_levels];
        let mut contenders = Vec::new();
        for (octave, worker) in workers.iter().enumerate() {
            let placement = self.pyramid.placement(octave);
            contenders.extend(worker.kept.iter().map(|corner| {
                let (x, y) = placement.to_full(f32::from(corner.x), f32::from(corner.y));
                Contender { x, y, response: corner.score }
            }));
        }
        let kept = select(&contenders, map, config, size);
        let at_kept = |answer: fn(&ActivationMap, f32, f32) -> f32| -> Vec<f32> {
            kept.iter().map(|&i| answer(map, contenders[i].x, contenders[i].y)).collect()
        };
        let answers = [at_kept(ActivationMap::at), at_kept(ActivationMap::lasting_at)];
        let mut is_kept = vec![false; contenders.len()];
        kept.iter().for_each(|&i| is_kept[i] = true);
        let mut is_kept = is_kept.into_iter();
        workers.iter_mut().for_each(|worker| worker.kept.retain(|_| is_kept.next() == Some(true)));
        answers
    }

    /// Does `work` on each level, in parallel, and what is done with the pyramid beside it.
    fn on_levels<T: Send>(
        &mut self,
        work: impl Fn(&mut Worker, Level<'_>) + Send + Sync,
        beside: impl FnOnce(&Pyramid) -> T + Send,
    ) -> T {
        let Self { config, simd, quotas, pyramid, workers, mask, .. } = self;
        let (mask, pyramid) = (mask.as_deref(), &*pyramid);
        let levels = pyramid.levels();
        let workers = &mut workers[..levels.len()];
        let on_level = |(octave, worker): (usize, &mut Worker)| {
            let placement = pyramid.placement(octave);
            let (plane, quota, octave) = (&levels[octave], quotas[octave], octave as u8);
            work(worker, Level { simd: *simd, config, plane, octave, placement, quota, mask });
        };
        let on_all = || workers.par_iter_mut().with_max_len(1).enumerate().for_each(on_level);
        rayon::join(on_all, || beside(pyramid)).1
    }

    /// The features that the workers hold.
    fn collect(&self) -> Features {
        let workers = &self.workers[..self.pyramid.levels().len()];
        let n_features = workers.iter().map(|w| w.features.keypoints.len()).sum();
        let mut features = Features {
            keypoints: Vec::with_capacity(n_features),
            descriptors: Vec::with_capacity(n_features),
        };
        for worker in workers {
            features.keypoints.extend_from_slice(&worker.features.keypoints);
            features.descriptors.extend_from_slice(&worker.features.descriptors);
        }
        features
    }

    /// The settings.
    pub(crate) fn config(&self) -> &ExtractorConfig {
        &self.config
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

/// A level of the pyramid and what is done there.
struct Level<'a> {
    simd: Simd,
    config: &'a ExtractorConfig,
    plane: &'a Plane,
    octave: u8,
    placement: Placement,
    quota: usize,
    mask: Option<&'a FeatureMask>,
}

impl Worker {
    /// Detects and distributes the corners of a level, and blurs it for their descriptors.
    fn detect(&mut self, level: &Level<'_>) {
        self.kept.clear();
        let Some(bounds) = region(level.plane) else { return };
        let ExtractorConfig { fast_initial, fast_minimum, .. } = *level.config;
        self.detector.run(level.simd, level.plane, fast_initial, fast_minimum, &mut self.corners);
        if let Some(mask) = level.mask {
            let place = |c: &Corner| level.placement.to_full(f32::from(c.x), f32::from(c.y));
            self.corners.retain(|corner| mask.allows(level.octave, place(corner)));
        }
        self.quadtree.distribute(&self.corners, bounds, level.quota, &mut self.kept);
        if !self.kept.is_empty() {
            blur::gaussian(level.simd, level.plane, &mut self.line, &mut self.blurred);
        }
    }

    /// Orients and describes the corners kept.
    fn describe(&mut self, level: &Level<'_>) {
        let Level { simd, config, plane, octave, placement, .. } = *level;
        let Features { keypoints, descriptors } = &mut self.features;
        keypoints.clear();
        descriptors.clear();
        for corner in &self.kept {
            let (x, y) = (usize::from(corner.x), usize::from(corner.y));
            let (m10, m01) = moments::moments(simd, plane.data(), plane.stride(), y * plane.stride() + x);
            let angle_deg = direction_deg(m10, m01);
            let (dx, dy) = if config.subpixel { refine(simd, plane, x, y) } else { (0.0, 0.0) };
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
