//! Key-points and the settings of their detection.

use crate::descriptor::Descriptor;

/// A corner of the image pyramid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Keypoint {
    /// Column in pixels of level 0: as detected (distorted) in [`Features`], undistorted in a `Frame`.
    pub x: f32,
    /// Row, likewise.
    pub y: f32,
    /// Pyramid level it was found on.
    pub octave: u8,
    /// Direction from the corner to the brightness centroid of its surroundings, degrees from +x towards +y, [0, 360).
    pub angle_deg: f32,
    /// FAST score: the largest threshold for which it is a corner.
    pub response: f32,
}

/// Key-points with their descriptors, same order: by octave, then row, then column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Features {
    /// Corners, distorted pixels of level 0.
    pub keypoints: Vec<Keypoint>,
    /// Descriptor of each.
    pub descriptors: Vec<Descriptor>,
}

/// How features are extracted.
#[derive(Clone, Debug, PartialEq)]
pub struct ExtractorConfig {
    /// Most features per image.
    pub keep: usize,
    /// Pyramid levels.
    pub levels: usize,
    /// Ratio between levels.
    pub scale_factor: f32,
    /// FAST threshold that a cell uses when it has such corners.
    pub fast_initial: u8,
    /// FAST threshold for cells that have none.
    pub fast_minimum: u8,
    /// Whether positions are refined below a pixel of their level.
    pub subpixel: bool,
}

impl Default for ExtractorConfig {
    fn default() -> Self {
        Self { keep: 2000, levels: 8, scale_factor: 1.2, fast_initial: 20, fast_minimum: 7, subpixel: true }
    }
}
