//! An image turned into features with positions, depths and an index by place.

use crate::descriptor::Descriptor;
use crate::grid::Grid;
use crate::keypoint::{Features, Keypoint};
use crate::scales::ScaleLevels;
use geometry::{Distortion, StereoRig, Vec2, Vec3};
use std::sync::Arc;

/// The camera of a frame: of an RGB-D camera with a virtual baseline, of a single camera with any.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    /// Pinhole camera and baseline of the undistorted images.
    pub stereo: StereoRig,
    /// Lens distortion of the images; zero for rectified ones.
    pub distortion: Distortion,
    /// Image width in pixels.
    pub width: usize,
    /// Image height in pixels.
    pub height: usize,
}

impl Rig {
    /// The undistorted position of a pixel.
    #[must_use]
    pub fn undistort(&self, pixel: &Vec2) -> Vec2 {
        if self.distortion.is_zero() {
            return *pixel;
        }
        let ray = self.stereo.camera.unproject(pixel);
        let ideal = self.distortion.undistort(&Vec2::new(ray.x, ray.y));
        self.stereo.camera.project(&Vec3::new(ideal.x, ideal.y, 1.0))
    }

    /// The camera of images whose left and right are exchanged.
    #[must_use]
    pub fn mirrored(&self) -> Self {
        let mut mirrored = self.clone();
        mirrored.stereo.camera.cx = self.width as f64 - 1.0 - self.stereo.camera.cx;
        mirrored.distortion.p2 = -self.distortion.p2;
        mirrored
    }

    /// The smallest box around the undistorted image.
    #[must_use]
    pub fn undistorted_bounds(&self) -> Bounds {
        let (width, height) = (self.width as f64, self.height as f64);
        let mut bounds = Bounds { min_x: f32::MAX, max_x: f32::MIN, min_y: f32::MAX, max_y: f32::MIN };
        for i in 0..=2 {
            for j in 0..=2 {
                let edge = Vec2::new(width * f64::from(i) / 2.0, height * f64::from(j) / 2.0);
                let place = self.undistort(&edge);
                bounds.min_x = bounds.min_x.min(place.x as f32);
                bounds.max_x = bounds.max_x.max(place.x as f32);
                bounds.min_y = bounds.min_y.min(place.y as f32);
                bounds.max_y = bounds.max_y.max(place.y as f32);
            }
        }
        bounds
    }
}

/// A box of pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Left edge.
    pub min_x: f32,
    /// Right edge.
    pub max_x: f32,
    /// Upper edge.
    pub min_y: f32,
    /// Lower edge.
    pub max_y: f32,
}

impl Bounds {
    /// Whether a pixel lies inside, the left and upper edge included.
    #[must_use]
    pub fn contains(&self, pixel: &Vec2) -> bool {
        let (x, y) = (pixel.x as f32, pixel.y as f32);
        x >= self.min_x && x < self.max_x && y >= self.min_y && y < self.max_y
    }
}

/// The features of one moment; does not change after it was built and is shared as `Arc<Frame>`.
///
/// All vectors have one element per feature.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Number of the frame in its sequence.
    pub index: u32,
    /// Time of exposure in seconds.
    pub timestamp_s: f64,
    /// The camera.
    pub rig: Arc<Rig>,
    /// Scales of the octaves.
    pub scales: Arc<ScaleLevels>,
    /// Corners in undistorted pixels of level 0.
    pub keypoints: Vec<Keypoint>,
    /// Descriptors.
    pub descriptors: Vec<Descriptor>,
    /// Column in the right (or virtual right) image; NaN when unknown.
    pub right_u: Vec<f32>,
    /// Depth along z in meters; NaN when unknown.
    pub depth: Vec<f32>,
    /// Trust that each feature stays where it is now, 1 when nothing is known.
    pub activation: Vec<f32>,
    /// Trust that it will be there another day, 1 when nothing is known.
    pub lasting: Vec<f32>,
    bounds: Bounds,
    grid: Grid,
}

impl Frame {
    /// A frame of features whose positions are already undistorted; `right_u` is NaN where unknown and otherwise left of
    /// the keypoint.
    ///
    /// # Panics
    /// When the lengths differ.
    #[must_use]
    pub fn new(
        index: u32,
        timestamp_s: f64,
        rig: Arc<Rig>,
        scales: Arc<ScaleLevels>,
        features: Features,
        right_u: Vec<f32>,
    ) -> Self {
        let Features { keypoints, descriptors } = features;
        assert!(keypoints.len() == descriptors.len() && keypoints.len() == right_u.len(), "lengths differ");
        let bf = rig.stereo.bf() as f32;
        let depth = keypoints.iter().zip(&right_u).map(|(k, u)| bf / (k.x - u)).collect();
        let bounds = rig.undistorted_bounds();
        let grid = Grid::new(bounds, &keypoints, &right_u);
        let all = vec![1.0; keypoints.len()];
        Self {
            index,
            timestamp_s,
            rig,
            scales,
            keypoints,
            descriptors,
            right_u,
            depth,
            activation: all.clone(),
            lasting: all,
            bounds,
            grid,
        }
    }

    /// Number of features.
    #[must_use]
    pub fn len(&self) -> usize {
        self.keypoints.len()
    }

    /// Whether there is no feature.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.keypoints.is_empty()
    }

    /// The box around the undistorted image.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Whether the depth of feature `i` is known.
    #[must_use]
    pub fn has_depth(&self, i: usize) -> bool {
        self.depth[i] > 0.0
    }

    /// Number of features with depth.
    #[must_use]
    pub fn n_with_depth(&self) -> usize {
        (0..self.len()).filter(|&i| self.has_depth(i)).count()
    }

    /// Undistorted position of feature `i`, pixels of level 0.
    #[must_use]
    pub fn pixel(&self, i: usize) -> Vec2 {
        let keypoint = &self.keypoints[i];
        Vec2::new(f64::from(keypoint.x), f64::from(keypoint.y))
    }

    /// Position of feature `i` in coordinates of the (left) camera, meters; `None` without depth.
    #[must_use]
    pub fn unproject(&self, i: usize) -> Option<Vec3> {
        let pixel = self.pixel(i);
        self.has_depth(i).then(|| self.rig.stereo.unproject(pixel.x, pixel.y, f64::from(self.depth[i])))
    }

    /// Inverse variance of the position of feature `i`, per squared pixel of level 0.
    #[must_use]
    pub fn inv_sigma_sq(&self, i: usize) -> f64 {
        f64::from(self.scales.inv_sigma_sq[usize::from(self.keypoints[i].octave)])
    }

    /// Features of these octaves (both ends included) at most `radius_px` from `(x, y)` in x and in y, in index order.
    #[must_use]
    pub fn features_near(&self, x: f32, y: f32, radius_px: f32, min_octave: u8, max_octave: u8) -> Vec<u32> {
        let mut found = Vec::new();
        for entry in self.grid.window(x - radius_px, x + radius_px, y - radius_px, y + radius_px).flatten() {
            let near = (entry.x - x).abs() <= radius_px && (entry.y - y).abs() <= radius_px;
            if near && entry.octave >= min_octave && entry.octave <= max_octave {
                found.push(entry.feature);
            }
        }
        found.sort_unstable();
        found
    }

    /// The index by place.
    #[inline(always)]
    pub(crate) fn grid(&self) -> &Grid {
        &self.grid
    }
}
