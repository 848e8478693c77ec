//! Stereo rectification: two cameras turned so that the images of a point lie on one row.
//!
//! The method is that of OpenCV's `stereoRectify` with zero disparity and alpha 0 (no pixel without a source), which goes back to
//! J.-Y. Bouguet's calibration toolbox: each camera turns by half of the rotation between them, then both turn so that x
//! points along the baseline.

use crate::aliases::{Vec2, Vec3};
use crate::camera_model::CameraModel;
use crate::pinhole::Pinhole;
use crate::se3::SE3;
use crate::so3::SO3;
use crate::stereo::StereoRig;

/// Half of the largest field of view of a rectified image, as a tangent (60 degrees); a fisheye sees more than a plane can show.
const MAX_TANGENT: f64 = 1.732_050_807_568_877_2;

/// Points along each side of the image that the new field of view is computed from.
const SAMPLES_PER_SIDE: usize = 9;

/// How two raw cameras are rectified; the rectified images have the size of the raw ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StereoRectification {
    /// The turn of the left camera.
    pub rectified_from_left: SO3,
    /// The turn of the right camera.
    pub rectified_from_right: SO3,
    /// The rectified pair: one camera for both images, and the baseline in meters.
    pub rig: StereoRig,
}

/// Why two cameras are not rectified.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum RectificationError {
    /// Both cameras have one center, or a number is not finite.
    #[error("found no baseline between the two cameras, expected one above 0 m")]
    NoBaseline,
    /// The second camera is above or below the first.
    #[error(
        "found the second camera {y_m:.4} m along y and {x_m:.4} m along x of the first, expected it to the right"
    )]
    Vertical {
        /// Right camera center in left coordinates after the turn by half, meters.
        x_m: f64,
        /// The larger component, meters.
        y_m: f64,
    },
    /// The second camera is to the left of the first.
    #[error("found the second camera {left_by_m:.4} m to the left of the first, expected it to the right")]
    Swapped {
        /// Distance to the left, meters.
        left_by_m: f64,
    },
    /// The turned cameras share no field of view.
    #[error("found cameras that look in different directions, expected a common field of view")]
    NoCommonView,
    /// A lens whose coefficients fold its image back before it ends, so that pixels beyond have no ray.
    #[error(
        "found coefficients that fold the image back {radius_px:.0} px from the principal point, expected ones that hold \
         up to its corner, {corner_px:.0} px away; is it their order, the model or the image size?"
    )]
    Folded {
        /// Which camera it is: 0, or 1 for the second one.
        camera: usize,
        /// Where it folds, pixels from the principal point.
        radius_px: f64,
        /// The farthest corner of the image, pixels from the principal point.
        corner_px: f64,
    },
}

/// The rectification of two cameras with images of `(width, height)` pixels.
///
/// # Errors
/// [`RectificationError`] unless the right camera stands to the right of the left one, both look the same way, and their lenses can be
/// inverted.
pub fn rectify_stereo(
    left: &CameraModel,
    right: &CameraModel,
    (width, height): (usize, usize),
    right_from_left: &SE3,
) -> Result<StereoRectification, RectificationError> {
    let (rectified_from_left, rectified_from_right, baseline_m) = turns(right_from_left)?;
    let views = [(left, rectified_from_left), (right, rectified_from_right)];
    let camera = filled_view(&views, (width, height))?;
    Ok(StereoRectification {
        rectified_from_left,
        rectified_from_right,
        rig: StereoRig { camera, baseline_m },
    })
}

/// The pinhole that shows what a raw camera with images of `(width, height)` pixels sees, in an image of that size without
/// empty pixels; its field of view is at most 120 degrees.
///
/// # Errors
/// [`RectificationError::NoCommonView`] when the axis of the camera is not in its image, [`RectificationError::Folded`] when its lens
/// cannot be inverted.
pub fn rectify_single(model: &CameraModel, size: (usize, usize)) -> Result<Pinhole, RectificationError> {
    filled_view(&[(model, SO3::identity())], size)
}

/// The one pinhole for all turned cameras whose image of `(width, height)` pixels is as wide as it can be without empty pixels.
fn filled_view(
    views: &[(&CameraModel, SO3)],
    (width, height): (usize, usize),
) -> Result<Pinhole, RectificationError> {
    let n_views = views.len() as f64;
    let focal = views.iter().map(|(model, _)| model.pinhole().fy).sum::<f64>() / n_views;
    // The mean of the corners comes to the middle of the image; one center for all makes the disparity of infinity zero.
    let size = Vec2::new(width as f64, height as f64);
    let last = size.add_scalar(-1.0);
    let corners =
        [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(x, y)| Vec2::new(x * last.x, y * last.y));
    let mut center = Vec2::zeros();
    for (model, turn) in views {
        let mean = corners.map(|corner| normalized(model, turn, &corner)).iter().sum::<Vec2>() / 4.0;
        center += (last * 0.5 - mean * focal) / n_views;
    }
    let mut scale = 0.0;
    for (model, turn) in views {
        let scale_of_view = smallest_scale(&inner_rectangle(model, turn, &size), focal, &center, &size);
        let failure = || {
            let folded = |(camera, (model, _)): (usize, &(&CameraModel, SO3))| fold(model, camera, &size);
            views.iter().enumerate().find_map(folded).unwrap_or(RectificationError::NoCommonView)
        };
        scale = f64::max(scale, scale_of_view.ok_or_else(failure)?);
    }
    let focal = focal * scale;
    Ok(Pinhole { fx: focal, fy: focal, cx: center.x, cy: center.y })
}

/// Where a lens folds its image back, if that is nearer than the farthest corner.
fn fold(model: &CameraModel, camera: usize, size: &Vec2) -> Option<RectificationError> {
    let Pinhole { fx, fy, cx, cy } = *model.pinhole();
    let distance = |x: f64, y: f64| ((x - cx) / fx).hypot((y - cy) / fy);
    let corners =
        [distance(0.0, 0.0), distance(size.x, 0.0), distance(0.0, size.y), distance(size.x, size.y)];
    let corner = corners.into_iter().fold(0.0, f64::max);
    let (sine, cosine) = model.max_angle().sin_cos();
    let last = model.project(&Vec3::new(sine, 0.0, cosine));
    let radius = distance(last.x, last.y);
    (radius < corner).then_some(RectificationError::Folded {
        camera,
        radius_px: radius * fx,
        corner_px: corner * fx,
    })
}

/// The turns of both cameras and the baseline.
fn turns(right_from_left: &SE3) -> Result<(SO3, SO3, f64), RectificationError> {
    // Both cameras look alike after each has turned by half.
    let half = SO3::exp(&(right_from_left.rotation.log() * -0.5));
    let translation = half * right_from_left.translation;
    let length = translation.norm();
    if !(length.is_finite() && length > 0.0) {
        return Err(RectificationError::NoBaseline);
    }
    if translation.x.abs() <= translation.y.abs() {
        return Err(RectificationError::Vertical { x_m: -translation.x, y_m: -translation.y });
    }
    if translation.x > 0.0 {
        return Err(RectificationError::Swapped { left_by_m: translation.x });
    }
    // The shortest turn of the baseline onto the x axis.
    let axis = translation.cross(&-Vec3::x());
    let angle = (translation.x.abs() / length).min(1.0).acos();
    let level = axis.try_normalize(0.0).map_or_else(SO3::identity, |axis| SO3::exp(&(axis * angle)));
    Ok((level * half.inverse(), level * half, length))
}

/// Where a raw pixel lies in the rectified view, `(X / Z, Y / Z)`, kept within the largest field of view.
fn normalized(model: &CameraModel, turn: &SO3, pixel: &Vec2) -> Vec2 {
    let ray = *turn * model.unproject(pixel);
    // What lies behind is far outside.
    let scale = 1.0 / ray.z.max(1e-9);
    (ray.xy() * scale).map(|v| v.clamp(-MAX_TANGENT, MAX_TANGENT))
}

/// Left, top, right and bottom of the largest upright rectangle inside the rectified image of the raw image's border.
fn inner_rectangle(model: &CameraModel, turn: &SO3, size: &Vec2) -> [f64; 4] {
    let mut inner = [f64::NEG_INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::INFINITY];
    for i in 0..SAMPLES_PER_SIDE {
        let along = i as f64 / (SAMPLES_PER_SIDE - 1) as f64;
        let at = |x: f64, y: f64| normalized(model, turn, &Vec2::new(x * size.x, y * size.y));
        inner[0] = inner[0].max(at(0.0, along).x);
        inner[1] = inner[1].max(at(along, 0.0).y);
        inner[2] = inner[2].min(at(1.0, along).x);
        inner[3] = inner[3].min(at(along, 1.0).y);
    }
    inner
}

/// The factor on the focal length from which on the whole image lies inside the rectangle; `None` when none does.
fn smallest_scale(inner: &[f64; 4], focal: f64, center: &Vec2, size: &Vec2) -> Option<f64> {
    let [left, top, right, bottom] = inner.map(|v| v * focal);
    let rest = size - center;
    let scales = [center.x / -left, center.y / -top, rest.x / right, rest.y / bottom];
    let valid = left < 0.0 && top < 0.0 && right > 0.0 && bottom > 0.0;
    valid.then(|| scales.into_iter().fold(0.0, f64::max))
}
