//! Depth of features from a registered depth image.

use crate::keypoint::Keypoint;
use geometry::DepthImage;

/// How depth images are read.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthConfig {
    /// Depth values per metre (TUM RGB-D: 5000).
    pub units_per_metre: f64,
    /// Nearest depth believed, metres.
    pub min_depth_m: f64,
    /// Farthest depth believed, metres.
    pub max_depth_m: f64,
}

impl Default for DepthConfig {
    fn default() -> Self {
        Self { units_per_metre: 5000.0, min_depth_m: 0.1, max_depth_m: 40.0 }
    }
}

impl DepthConfig {
    /// Depth in metres at the pixel nearest to a detected (distorted) key-point; `None` where the sensor gave none.
    pub(crate) fn depth_at(&self, depth: &DepthImage, keypoint: &Keypoint) -> Option<f64> {
        let (x, y) = (f64::from(keypoint.x).round(), f64::from(keypoint.y).round());
        if x < 0.0 || y < 0.0 {
            return None;
        }
        let units = depth.get(x as usize, y as usize)?;
        let metres = f64::from(units) / self.units_per_metre;
        (units > 0 && metres >= self.min_depth_m && metres <= self.max_depth_m).then_some(metres)
    }
}
