//! From images to a [`Frame`]: extraction, undistortion, depth of the features.

use crate::depth::DepthConfig;
use crate::extractor::Extractor;
use crate::frame::{Frame, Rig};
use crate::kernels::Simd;
use crate::keypoint::{ExtractorConfig, Features, Keypoint};
use crate::mask::FeatureMask;
use crate::pyramid::Pyramid;
use crate::stereo::{StereoConfig, StereoMatcher, StereoPair};
use geometry::{DepthImage, GrayImage, Vec2};
use std::sync::Arc;

/// Builds frames of one camera; owns the buffers, which are reused from frame to frame.
#[derive(Debug)]
pub struct FrameBuilder {
    rig: Arc<Rig>,
    extractor: Extractor,
    right_pyramid: Pyramid,
    matcher: StereoMatcher,
    depth: DepthConfig,
    disparity_offset_px: f32,
}

impl FrameBuilder {
    /// A builder for this camera.
    #[must_use]
    pub fn new(rig: Arc<Rig>, extractor: ExtractorConfig, stereo: StereoConfig, depth: DepthConfig) -> Self {
        let matcher = StereoMatcher::new(stereo);
        Self {
            rig,
            extractor: Extractor::new(extractor),
            right_pyramid: Pyramid::default(),
            matcher,
            depth,
            disparity_offset_px: 0.0,
        }
    }

    /// Adds `offset_px` to every disparity from now on: a correction of the stereo calibration, pixels of level 0.
    #[must_use]
    pub fn with_disparity_offset(mut self, offset_px: f64) -> Self {
        self.disparity_offset_px = offset_px as f32;
        self
    }

    /// Takes features of the left image from now on only where the mask allows it.
    #[must_use]
    pub fn with_mask(mut self, mask: Option<Arc<FeatureMask>>) -> Self {
        self.extractor = self.extractor.with_mask(mask);
        self
    }

    /// The camera.
    #[must_use]
    pub fn rig(&self) -> &Arc<Rig> {
        &self.rig
    }

    /// A frame of a rectified stereo pair. Where the sizes differ no feature gets a depth.
    pub fn stereo(&mut self, index: u32, timestamp_s: f64, left: &GrayImage, right: &GrayImage) -> Frame {
        let Self { rig, extractor, right_pyramid, matcher, disparity_offset_px, .. } = self;
        let scales = Arc::clone(extractor.scales());
        let same_size = left.width == right.width && left.height == right.height;
        let (features, ()) = rayon::join(
            || extractor.extract(left),
            || {
                if same_size {
                    right_pyramid.build(Simd::detect(), &scales, right)
                }
            },
        );
        let disparities = if same_size {
            let pair = StereoPair { left: extractor.pyramid(), right: right_pyramid };
            matcher.disparities(rig, pair, &features.keypoints)
        } else {
            vec![f32::NAN; features.keypoints.len()]
        };
        let features = undistorted(rig, features);
        let right_u = features
            .keypoints
            .iter()
            .zip(disparities)
            .map(|(k, d)| k.x - corrected(d, *disparity_offset_px))
            .collect();
        Frame::new(index, timestamp_s, Arc::clone(rig), scales, features, right_u)
    }

    /// A frame of a grey image and a depth image registered to it.
    pub fn rgbd(&mut self, index: u32, timestamp_s: f64, gray: &GrayImage, depth: &DepthImage) -> Frame {
        let features = self.extractor.extract(gray);
        let depths: Vec<_> = features.keypoints.iter().map(|k| self.depth.depth_at(depth, k)).collect();
        let features = undistorted(&self.rig, features);
        let bf = self.rig.stereo.bf();
        let virtual_column =
            |(k, d): (&Keypoint, Option<f64>)| d.map_or(f32::NAN, |d| (f64::from(k.x) - bf / d) as f32);
        let right_u = features.keypoints.iter().zip(depths).map(virtual_column).collect();
        self.frame(index, timestamp_s, features, right_u)
    }

    /// A frame of a single image: no depths.
    pub fn mono(&mut self, index: u32, timestamp_s: f64, gray: &GrayImage) -> Frame {
        let features = undistorted(&self.rig, self.extractor.extract(gray));
        let right_u = vec![f32::NAN; features.keypoints.len()];
        self.frame(index, timestamp_s, features, right_u)
    }

    fn frame(&self, index: u32, timestamp_s: f64, features: Features, right_u: Vec<f32>) -> Frame {
        let (rig, scales) = (Arc::clone(&self.rig), Arc::clone(self.extractor.scales()));
        Frame::new(index, timestamp_s, rig, scales, features, right_u)
    }
}

/// A disparity with its offset; NaN when nothing above zero is left.
fn corrected(disparity: f32, offset_px: f32) -> f32 {
    let disparity = disparity + offset_px;
    if disparity > 0.0 { disparity } else { f32::NAN }
}

/// Moves the key-points to where an ideal lens would have shown them.
fn undistorted(rig: &Rig, mut features: Features) -> Features {
    if !rig.distortion.is_zero() {
        for keypoint in &mut features.keypoints {
            let place = rig.undistort(&Vec2::new(f64::from(keypoint.x), f64::from(keypoint.y)));
            (keypoint.x, keypoint.y) = (place.x as f32, place.y as f32);
        }
    }
    features
}
