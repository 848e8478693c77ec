//! An image turned into features with positions, depths and an index by place.

use crate::descriptor::Descriptor;
use crate::grid::Grid;
use crate::keypoint::{Features, Keypoint};
use crate::patch::Patch;
use crate::scales::ScaleLevels;
use geometry::{Distortion, StereoRig, Vec2, Vec3};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The camera of a frame: of an RGB-D camera with a virtual baseline, of a single camera with any.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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

    /// The pixel of an undistorted position: the inverse of [`Rig::undistort`].
    pub fn distort(&self, place: &Vec2) -> Vec2 {
        if self.distortion.is_zero() {
            return *place;
        }
        let ray = self.stereo.camera.unproject(place);
        let seen = self.distortion.distort(&Vec2::new(ray.x, ray.y));
        self.stereo.camera.project(&Vec3::new(seen.x, seen.y, 1.0))
    }

    /// The smallest box around the undistorted image.
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
    pub fn contains(&self, pixel: &Vec2) -> bool {
        let [min_x, max_x, min_y, max_y] = [self.min_x, self.max_x, self.min_y, self.max_y].map(f64::from);
        (min_x..max_x).contains(&pixel.x) && (min_y..max_y).contains(&pixel.y)
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
    /// What the features' surroundings look like, shared by all copies; empty where nobody asked for them.
    pub(crate) patches: Arc<Vec<Option<Patch>>>,
    /// Change of the disparity per row around the features, pixels, shared by all copies; empty where it is not known.
    pub(crate) slopes: Arc<Vec<f32>>,
    bounds: Bounds,
    grid: Grid,
    /// Shared by all copies, by whichever calibration.
    moment: Arc<()>,
}

impl Frame {
    /// A frame of features whose positions are already undistorted; `right_u` is NaN where unknown and otherwise left of
    /// the keypoint.
    ///
    /// # Panics
    /// When the lengths differ.
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
            patches: Arc::default(),
            slopes: Arc::default(),
            bounds,
            grid,
            moment: Arc::default(),
        }
    }

    /// The same features as another calibration shows them. `offset_px` is added to every disparity, and for each row below the
    /// principal point `slope` more.
    #[must_use]
    pub fn recalibrated(&self, rig: &Arc<Rig>, offset_px: f64, slope: f64) -> Self {
        let mut keypoints = self.keypoints.clone();
        let mut right_u = self.right_u.clone();
        for (keypoint, right_u) in keypoints.iter_mut().zip(&mut right_u) {
            let place = keypoint.pixel();
            let raw = self.rig.distort(&place);
            let added = offset_px + slope * (raw.y - self.rig.stereo.camera.cy);
            let right = self.rig.distort(&Vec2::new(f64::from(*right_u), place.y)) - Vec2::new(added, 0.0);
            let seen = rig.undistort(&raw);
            (keypoint.x, keypoint.y) = (seen.x as f32, seen.y as f32);
            // Nothing above zero may be left of the disparity.
            let right = if right_u.is_nan() { f32::NAN } else { rig.undistort(&right).x as f32 };
            *right_u = if right < keypoint.x { right } else { f32::NAN };
        }
        let features = Features { keypoints, descriptors: self.descriptors.clone() };
        let (rig, scales) = (Arc::clone(rig), Arc::clone(&self.scales));
        let mut frame = Self::new(self.index, self.timestamp_s, rig, scales, features, right_u);
        frame.take_from(self);
        frame
    }

    /// The same features, some of them moved: `(feature, dx, dy)` in pixels of level 0. The disparities
    /// change as far as they change from row to row.
    #[must_use]
    pub fn moved(&self, shifts: &[(u32, f32, f32)]) -> Self {
        let mut keypoints = self.keypoints.clone();
        let mut right_u = self.right_u.clone();
        for &(feature, dx, dy) in shifts {
            let keypoint = &mut keypoints[feature as usize];
            keypoint.x += dx;
            keypoint.y += dy;
            let slope = self.slopes.get(feature as usize).copied().unwrap_or(0.0);
            right_u[feature as usize] += dx - slope * dy;
        }
        let features = Features { keypoints, descriptors: self.descriptors.clone() };
        let (rig, scales) = (Arc::clone(&self.rig), Arc::clone(&self.scales));
        let mut frame = Self::new(self.index, self.timestamp_s, rig, scales, features, right_u);
        frame.take_from(self);
        frame
    }

    /// Takes over what does not depend on where the features are.
    fn take_from(&mut self, other: &Self) {
        self.activation.clone_from(&other.activation);
        self.lasting.clone_from(&other.lasting);
        self.patches = Arc::clone(&other.patches);
        self.slopes = Arc::clone(&other.slopes);
        self.moment = Arc::clone(&other.moment);
    }

    /// What the surroundings of feature `i` look like, if that was kept.
    pub fn patch(&self, i: usize) -> Option<&Patch> {
        self.patches.get(i)?.as_ref()
    }

    /// Whether both are the same features, be it by different calibrations.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.moment, &other.moment)
    }

    /// Number of features.
    pub fn len(&self) -> usize {
        self.keypoints.len()
    }

    /// Whether there is no feature.
    pub fn is_empty(&self) -> bool {
        self.keypoints.is_empty()
    }

    /// The box around the undistorted image.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Whether the depth of feature `i` is known.
    pub fn has_depth(&self, i: usize) -> bool {
        self.depth[i] > 0.0
    }

    /// Number of features with depth.
    pub fn n_with_depth(&self) -> usize {
        (0..self.len()).filter(|&i| self.has_depth(i)).count()
    }

    /// Undistorted position of feature `i`, pixels of level 0.
    pub fn pixel(&self, i: usize) -> Vec2 {
        self.keypoints[i].pixel()
    }

    /// Position of feature `i` in coordinates of the (left) camera, meters; `None` without depth.
    pub fn unproject(&self, i: usize) -> Option<Vec3> {
        let pixel = self.pixel(i);
        self.has_depth(i).then(|| self.rig.stereo.unproject(pixel.x, pixel.y, f64::from(self.depth[i])))
    }

    /// Inverse variance of the position of feature `i`, per squared pixel of level 0.
    pub fn inv_sigma_sq(&self, i: usize) -> f64 {
        f64::from(self.scales.inv_sigma_sq[usize::from(self.keypoints[i].octave)])
    }

    /// The index by place.
    #[inline(always)]
    pub(crate) fn grid(&self) -> &Grid {
        &self.grid
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::descriptor::Descriptor;
    use geometry::Pinhole;

    fn rig(focal: f64, k1: f64) -> Arc<Rig> {
        let camera = Pinhole { fx: focal, fy: focal, cx: 320.0, cy: 240.0 };
        let distortion = Distortion { k1, ..Distortion::default() };
        Arc::new(Rig { stereo: StereoRig { camera, baseline_m: 0.1 }, distortion, width: 640, height: 480 })
    }

    fn frame(rig: &Arc<Rig>) -> Frame {
        let place = |i: usize| Keypoint {
            x: 100.0 + 40.0 * i as f32,
            y: 80.0 + 30.0 * i as f32,
            octave: 0,
            angle_deg: 0.0,
            response: 1.0,
        };
        let (keypoints, descriptors) = ((0..10).map(place).collect(), vec![Descriptor::default(); 10]);
        let right_u = (0..10).map(|i| if i == 3 { f32::NAN } else { place(i).x - 5.0 }).collect();
        let scales = Arc::new(ScaleLevels::new(8, 1.2));
        Frame::new(7, 0.5, Arc::clone(rig), scales, Features { keypoints, descriptors }, right_u)
    }

    #[test]
    fn another_calibration_shows_the_same_pixels_and_the_way_back_is_exact() {
        let (plain, bent) = (rig(500.0, 0.0), rig(510.0, -0.1));
        let before = frame(&plain);
        let after = before.recalibrated(&bent, 0.5, 0.01);
        assert!(after.is_same(&before) && !frame(&plain).is_same(&before));
        for i in 0..10 {
            let raw = bent.distort(&after.pixel(i));
            assert!(
                (raw - before.pixel(i)).norm() < 1e-3,
                "the lens bends what is seen, not what the image holds"
            );
        }
        let back = after.recalibrated(&plain, -0.5, -0.01);
        for i in (0..10).filter(|&i| i != 3) {
            assert!((back.pixel(i) - before.pixel(i)).norm() < 1e-3);
            assert!(
                (back.right_u[i] - before.right_u[i]).abs() < 0.1,
                "rows differ a little where they bend"
            );
        }
        assert!(!back.has_depth(3));
    }

    #[test]
    fn what_is_added_to_disparities_shows_in_depth() {
        let plain = rig(500.0, 0.0);
        let after = frame(&plain).recalibrated(&rig(500.0, 0.0), 1.0, 0.01);
        // Ten rows of 30 pixels from 160 above the center on.
        let disparity = |i: usize| 5.0 + 1.0 + 0.01 * (80.0 + 30.0 * i as f64 - 240.0);
        for i in (0..10).filter(|&i| i != 3) {
            assert!((f64::from(after.depth[i]) - 50.0 / disparity(i)).abs() < 1e-4, "{i}");
        }
        assert_eq!(
            frame(&plain).recalibrated(&plain, -6.0, 0.0).n_with_depth(),
            0,
            "nothing is behind infinity"
        );
    }
}
