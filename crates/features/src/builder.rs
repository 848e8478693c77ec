//! From images to a [`Frame`]: extraction, undistortion, depth of the features.

use crate::activation::{ActivationError, ActivationMap};
use crate::config::{Align, ExtractorConfig};
use crate::depth::DepthConfig;
use crate::evaluation::{Evaluator, Selection};
use crate::extractor::{Extractor, Selected};
use crate::frame::{Frame, Rig};
use crate::keypoint::{Features, Keypoint};
use crate::mask::FeatureMask;
use crate::patch::Patch;
use crate::pyramid::Pyramid;
use crate::selection::SelectionConfig;
use crate::stereo::{StereoConfig, StereoMatcher, StereoPair};
use geometry::{DepthImage, GrayImage};
use simd::Simd;
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
    selection: Option<Selection>,
}

/// A frame, with the activation map of its (left) image if features are selected by one.
pub type BuiltFrame = (Frame, Option<ActivationMap>);

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
            selection: None,
        }
    }

    /// From now on keeps of the features only those that `config` selects by the activation maps of `evaluator`; the number
    /// of the extractor's settings is that of the candidates. With `network_every` above 1 frames go by the last evaluation that is
    /// over, moved with the image; which one that is depends on the numbers of the frames alone, so that equal frames in equal
    /// order give equal bits, whatever the evaluator's pace.
    #[must_use]
    pub fn with_selection(mut self, config: SelectionConfig, evaluator: Box<dyn Evaluator>) -> Self {
        let every = self.extractor.config().network_every.max(1);
        self.selection = Some(Selection::new(config, evaluator, every));
        self
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
        self.set_mask(mask);
        self
    }

    /// As [`FrameBuilder::with_mask`].
    pub fn set_mask(&mut self, mask: Option<Arc<FeatureMask>>) {
        self.extractor.set_mask(mask);
    }

    /// A frame of a rectified stereo pair. Where the sizes differ no feature gets a depth.
    ///
    /// # Errors
    /// Those of the activation source; none without a selection.
    pub fn stereo(
        &mut self,
        index: u32,
        timestamp_s: f64,
        left: &GrayImage,
        right: &GrayImage,
    ) -> Result<BuiltFrame, ActivationError> {
        let Self { rig, extractor, right_pyramid, matcher, disparity_offset_px, selection, .. } = self;
        let scales = Arc::clone(extractor.scales());
        let same_size = left.width == right.width && left.height == right.height;
        let (extracted, ()) = rayon::join(
            || extract(extractor, selection.as_mut(), index, left),
            || {
                if same_size {
                    right_pyramid.build(Simd::detect(), &scales, right)
                }
            },
        );
        let extracted = extracted?;
        let disparities = if same_size {
            let pair = StereoPair { left: extractor.pyramid(), right: right_pyramid };
            matcher.disparities(rig, pair, &extracted.features.keypoints)
        } else {
            vec![[f32::NAN, 0.0]; extracted.features.keypoints.len()]
        };
        let patches = patches(extractor, &extracted.features);
        let extracted = extracted.undistorted(rig);
        let right_u = extracted
            .features
            .keypoints
            .iter()
            .zip(&disparities)
            .map(|(k, [d, _])| k.x - corrected(*d, *disparity_offset_px))
            .collect();
        let (mut frame, map) = self.frame(index, timestamp_s, extracted, right_u, patches);
        self.evaluate(index, left);
        frame.slopes = Arc::new(disparities.iter().map(|[_, slope]| *slope).collect());
        Ok((frame, map))
    }

    /// A frame of a gray image and a depth image registered to it.
    ///
    /// # Errors
    /// Those of the activation source; none without a selection.
    pub fn rgbd(
        &mut self,
        index: u32,
        timestamp_s: f64,
        gray: &GrayImage,
        depth: &DepthImage,
    ) -> Result<BuiltFrame, ActivationError> {
        let extracted = extract(&mut self.extractor, self.selection.as_mut(), index, gray)?;
        let depths: Vec<_> =
            extracted.features.keypoints.iter().map(|k| self.depth.depth_at(depth, k)).collect();
        let patches = patches(&self.extractor, &extracted.features);
        let extracted = extracted.undistorted(&self.rig);
        let bf = self.rig.stereo.bf();
        let virtual_column =
            |(k, d): (&Keypoint, Option<f64>)| d.map_or(f32::NAN, |d| (f64::from(k.x) - bf / d) as f32);
        let right_u = extracted.features.keypoints.iter().zip(depths).map(virtual_column).collect();
        self.evaluate(index, gray);
        Ok(self.frame(index, timestamp_s, extracted, right_u, patches))
    }

    /// A frame of a single image: no depths.
    ///
    /// # Errors
    /// Those of the activation source; none without a selection.
    pub fn mono(
        &mut self,
        index: u32,
        timestamp_s: f64,
        gray: &GrayImage,
    ) -> Result<BuiltFrame, ActivationError> {
        let extracted = extract(&mut self.extractor, self.selection.as_mut(), index, gray)?;
        let patches = patches(&self.extractor, &extracted.features);
        let extracted = extracted.undistorted(&self.rig);
        let right_u = vec![f32::NAN; extracted.features.keypoints.len()];
        self.evaluate(index, gray);
        Ok(self.frame(index, timestamp_s, extracted, right_u, patches))
    }

    /// Starts the evaluation of an image for the frames after it, if one is due.
    fn evaluate(&mut self, index: u32, image: &GrayImage) {
        if let Some(selection) = &mut self.selection {
            selection.evaluate_if_due(index, image);
        }
    }

    fn frame(
        &self,
        index: u32,
        timestamp_s: f64,
        extracted: Extracted,
        right_u: Vec<f32>,
        patches: Vec<Option<Patch>>,
    ) -> BuiltFrame {
        let Extracted { features, activation, lasting, map } = extracted;
        let (rig, scales) = (Arc::clone(&self.rig), Arc::clone(self.extractor.scales()));
        let mut frame = Frame::new(index, timestamp_s, rig, scales, features, right_u);
        (frame.activation, frame.lasting) = (activation, lasting);
        frame.patches = Arc::new(patches);
        (frame, map)
    }
}

/// The surroundings of the features of the image that was extracted last, before they are undistorted; none where they are not
/// wanted.
fn patches(extractor: &Extractor, features: &Features) -> Vec<Option<Patch>> {
    if extractor.config().align != Align::Always {
        return Vec::new();
    }
    let pyramid = extractor.pyramid();
    let cut = |k: &Keypoint| {
        let octave = usize::from(k.octave);
        let (x, y) = pyramid.placement(octave).to_level(k.x, k.y);
        Patch::cut(&pyramid.levels()[octave], x, y)
    };
    features.keypoints.iter().map(cut).collect()
}

/// The features of an image, how far each is trusted now and another day, and the map that says so.
struct Extracted {
    features: Features,
    activation: Vec<f32>,
    lasting: Vec<f32>,
    map: Option<ActivationMap>,
}

/// The features of an image, selected if there is a selection; without one each has the activation 1.
fn extract(
    extractor: &mut Extractor,
    selection: Option<&mut Selection>,
    index: u32,
    image: &GrayImage,
) -> Result<Extracted, ActivationError> {
    let Some(selection) = selection else {
        let features = extractor.extract(image);
        let all = vec![1.0; features.keypoints.len()];
        return Ok(Extracted { features, activation: all.clone(), lasting: all, map: None });
    };
    let Selected { features, activation, lasting, map } = selection.select(extractor, index, image)?;
    Ok(Extracted { features, activation, lasting, map: Some(map) })
}

/// A disparity with its offset; NaN when nothing above zero is left.
fn corrected(disparity: f32, offset_px: f32) -> f32 {
    let disparity = disparity + offset_px;
    if disparity > 0.0 { disparity } else { f32::NAN }
}

impl Extracted {
    /// The keypoints moved to where an ideal lens would have shown them.
    fn undistorted(mut self, rig: &Rig) -> Self {
        if !rig.distortion.is_zero() {
            for keypoint in &mut self.features.keypoints {
                let place = rig.undistort(&keypoint.pixel());
                (keypoint.x, keypoint.y) = (place.x as f32, place.y as f32);
            }
        }
        self
    }
}
