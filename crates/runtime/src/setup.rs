//! Everything a run needs beside its frames.

use std::sync::Arc;

use features::{DepthConfig, ExtractorConfig, Rig, StereoConfig};
use slam::Params;

/// Which images a frame has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sensor {
    /// Left and right image, rectified.
    Stereo,
    /// Grey image with a registered depth image.
    Rgbd,
}

/// Camera and parameters of a run.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Which images are used.
    pub sensor: Sensor,
    /// The camera; its width and height are those that every image must have.
    pub rig: Arc<Rig>,
    /// Feature extraction.
    pub extractor: ExtractorConfig,
    /// Stereo association.
    pub stereo: StereoConfig,
    /// Added to every disparity: a known error of the stereo calibration, pixels.
    pub disparity_offset_px: f64,
    /// Frames of a first pass that refines the disparity offset from the images; 0: there is no such pass.
    pub calibration_frames: usize,
    /// Depth association.
    pub depth: DepthConfig,
    /// Tracking and mapping.
    pub slam: Params,
}
