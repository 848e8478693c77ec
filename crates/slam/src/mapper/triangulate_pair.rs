//! One new point from two features in two keyframes: by rays or by the better stereo depth, then tested in both.

use features::Frame;
use geometry::{SE3, Vec3, triangulate_dlt};
use map::Keyframe;

use crate::noise::agrees;

/// Cosine of the smallest parallax between two rays without stereo.
const MAX_RAY_COS: f64 = 0.9998;
/// Tolerance of the ratio of distances against the ratio of scales, on top of one pyramid factor.
const SCALE_TOLERANCE: f64 = 1.5;

/// A keyframe's camera, prepared once for many features.
pub(super) struct View<'a> {
    pub(super) frame: &'a Frame,
    pub(super) cam_from_world: SE3,
    pub(super) world_from_cam: SE3,
    pub(super) center: Vec3,
}

impl<'a> View<'a> {
    pub(super) fn new(keyframe: &'a Keyframe) -> Self {
        let world_from_cam = keyframe.cam_from_world.inverse();
        View {
            frame: &keyframe.frame,
            cam_from_world: keyframe.cam_from_world,
            center: world_from_cam.translation,
            world_from_cam,
        }
    }

    /// Direction of a feature's ray in the world, not normalized.
    fn ray(&self, feature: usize) -> Vec3 {
        self.world_from_cam.rotation * self.frame.rig.stereo.camera.unproject(&self.frame.pixel(feature))
    }

    /// Cosine of the parallax that the feature's own stereo measurement has; above 1 without one.
    fn stereo_cos(&self, feature: usize) -> f64 {
        if !self.frame.has_depth(feature) {
            return f64::INFINITY;
        }
        let half_baseline = 0.5 * self.frame.rig.stereo.baseline_m;
        (2.0 * half_baseline.atan2(f64::from(self.frame.depth[feature]))).cos()
    }

    fn stereo_point(&self, feature: usize) -> Option<Vec3> {
        self.frame.unproject(feature).map(|point_cam| self.world_from_cam * point_cam)
    }

    /// In front of the camera, and reprojected within the chi-square limit.
    fn agrees(&self, feature: usize, position: &Vec3) -> bool {
        agrees(self.frame, feature, &(self.cam_from_world * *position), 1.0)
    }
}

/// Position of the point seen as `feature_a` in `a` and `feature_b` in `b`; `None` if the two do not fit together.
pub(super) fn locate(a: &View<'_>, feature_a: usize, b: &View<'_>, feature_b: usize) -> Option<Vec3> {
    let (ray_a, ray_b) = (a.ray(feature_a), b.ray(feature_b));
    let ray_cos = ray_a.dot(&ray_b) / (ray_a.norm() * ray_b.norm());
    let (stereo_a, stereo_b) = (a.stereo_cos(feature_a), b.stereo_cos(feature_b));
    let has_stereo = stereo_a.is_finite() || stereo_b.is_finite();
    let rays_are_better = ray_cos > 0.0 && ray_cos < stereo_a.min(stereo_b);
    let position = if rays_are_better && (has_stereo || ray_cos < MAX_RAY_COS) {
        let pixel = |view: &View<'_>, feature| {
            let ray = view.frame.rig.stereo.camera.unproject(&view.frame.pixel(feature));
            geometry::Vec2::new(ray.x, ray.y)
        };
        triangulate_dlt(&[a.cam_from_world, b.cam_from_world], &[pixel(a, feature_a), pixel(b, feature_b)])?
    } else if stereo_a < stereo_b {
        a.stereo_point(feature_a)?
    } else {
        b.stereo_point(feature_b)?
    };
    let fits = a.agrees(feature_a, &position)
        && b.agrees(feature_b, &position)
        && scales_agree(a, feature_a, b, feature_b, &position);
    fits.then_some(position)
}

/// A point twice as far should appear at half the scale.
fn scales_agree(a: &View<'_>, feature_a: usize, b: &View<'_>, feature_b: usize, position: &Vec3) -> bool {
    let (distance_a, distance_b) = ((position - a.center).norm(), (position - b.center).norm());
    if distance_a <= 0.0 || distance_b <= 0.0 {
        return false;
    }
    let scale = |view: &View<'_>, feature: usize| {
        f64::from(view.frame.scales.scales[view.frame.keypoints[feature].octave as usize])
    };
    let by_distance = distance_b / distance_a;
    let by_scale = scale(a, feature_a) / scale(b, feature_b);
    let tolerance = SCALE_TOLERANCE * f64::from(a.frame.scales.factor);
    // A feature seen from nearer is larger there: distance_b / distance_a should equal scale_a / scale_b.
    by_distance * tolerance >= by_scale && by_distance <= by_scale * tolerance
}

#[cfg(test)]
#[path = "../../tests/steps/triangulate_pair.rs"]
mod tests;
