//! Keypoints with their descriptors.

use geometry::Vec2;

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

impl Keypoint {
    /// Its place, pixels of level 0.
    pub fn pixel(&self) -> Vec2 {
        Vec2::new(f64::from(self.x), f64::from(self.y))
    }
}

/// Keypoints with their descriptors, same order: by octave, then row, then column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Features {
    /// Corners, distorted pixels of level 0.
    pub keypoints: Vec<Keypoint>,
    /// Descriptor of each.
    pub descriptors: Vec<Descriptor>,
}
