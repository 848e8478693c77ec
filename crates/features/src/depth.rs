//! Depth of features from a registered depth image.

use crate::keypoint::Keypoint;
use geometry::DepthImage;

/// How depth images are read.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthConfig {
    /// Depth values per meter (TUM RGB-D: 5000).
    pub units_per_meter: f64,
    /// Minimum accepted depth, meters.
    pub min_depth_m: f64,
    /// Maximum accepted depth, meters.
    pub max_depth_m: f64,
    /// A keypoint is at a depth edge, and its depth is rejected, when a depth within [`EDGE_REACH_PX`] differs by
    /// more than this share of its own.
    pub max_jump: f64,
}

/// How far from the keypoint a depth edge counts, pixels.
pub const EDGE_REACH_PX: usize = 3;

impl Default for DepthConfig {
    fn default() -> Self {
        Self { units_per_meter: 5000.0, min_depth_m: 0.1, max_depth_m: 40.0, max_jump: 0.05 }
    }
}

impl DepthConfig {
    /// Depth in meters at the pixel nearest to a detected (distorted) keypoint; `None` where the sensor gave none and at
    /// depth edges, where a corner may lie on either side.
    pub(crate) fn depth_at(&self, depth: &DepthImage, keypoint: &Keypoint) -> Option<f64> {
        let (x, y) = (f64::from(keypoint.x).round(), f64::from(keypoint.y).round());
        if x < 0.0 || y < 0.0 {
            return None;
        }
        let (x, y) = (x as usize, y as usize);
        let units = depth.get(x, y)?;
        let meters = f64::from(units) / self.units_per_meter;
        let believed = units > 0 && meters >= self.min_depth_m && meters <= self.max_depth_m;
        (believed && !self.is_edge(depth, x, y, units)).then_some(meters)
    }

    /// Whether a depth around `(x, y)` differs from `units`, the depth there, by more than a share of it.
    fn is_edge(&self, depth: &DepthImage, x: usize, y: usize, units: u16) -> bool {
        let limit = self.max_jump * f64::from(units);
        let rows = y.saturating_sub(EDGE_REACH_PX)..(y + EDGE_REACH_PX + 1).min(depth.height);
        let columns = x.saturating_sub(EDGE_REACH_PX)..(x + EDGE_REACH_PX + 1).min(depth.width);
        rows.into_iter().any(|row| {
            depth.row(row)[columns.clone()]
                .iter()
                .any(|&other| other > 0 && f64::from(units.abs_diff(other)) > limit)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keypoint(x: f32, y: f32) -> Keypoint {
        Keypoint { x, y, octave: 0, angle_deg: 0.0, response: 1.0 }
    }

    /// Two meters on the left, `right_m` from column 20 on.
    fn step(right_m: f64) -> DepthImage {
        let mut depth = DepthImage::new(40, 30, 10_000);
        for y in 0..30 {
            depth.row_mut(y)[20..].fill((right_m * 5000.0) as u16);
        }
        depth
    }

    #[test]
    fn depths_are_meters_at_the_nearest_pixel() {
        let config = DepthConfig::default();
        assert_eq!(config.depth_at(&step(3.0), &keypoint(5.4, 7.6)), Some(2.0));
        assert_eq!(config.depth_at(&step(3.0), &keypoint(30.0, 7.0)), Some(3.0));
    }

    #[test]
    fn edges_are_not_believed_and_slopes_are() {
        let config = DepthConfig::default();
        let reach = EDGE_REACH_PX as f32;
        assert_eq!(config.depth_at(&step(3.0), &keypoint(19.0 - reach, 7.0)), Some(2.0));
        assert_eq!(config.depth_at(&step(3.0), &keypoint(20.0 - reach, 7.0)), None);
        assert_eq!(config.depth_at(&step(2.09), &keypoint(19.0, 7.0)), Some(2.0));
    }

    #[test]
    fn holes_and_the_outside_have_no_depth() {
        let config = DepthConfig::default();
        assert_eq!(config.depth_at(&step(0.0), &keypoint(30.0, 7.0)), None);
        // A hole beside it says nothing about an edge.
        assert_eq!(config.depth_at(&step(0.0), &keypoint(19.0, 7.0)), Some(2.0));
        assert_eq!(config.depth_at(&step(3.0), &keypoint(-3.0, 7.0)), None);
        assert_eq!(config.depth_at(&step(3.0), &keypoint(45.0, 7.0)), None);
    }
}
