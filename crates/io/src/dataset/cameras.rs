//! What the raw cameras of a sequence are after rectification.

use std::path::{Path, PathBuf};

use geometry::{
    CameraModel, Distortion, RectificationError, SE3, SO3, StereoRectification, StereoRig, rectify_single,
    rectify_stereo,
};

use super::Sequence;
use super::{Calibration, DatasetError, RawCalibration, RawCamera, RectifiedView};

/// The calibration of a sequence, raw and rectified.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Cameras {
    pub(super) calibration: Option<Calibration>,
    pub(super) raw: Option<RawCalibration>,
    pub(super) views: Vec<RectifiedView>,
    /// Pose of the left camera, after rectification, in the body.
    pub(super) body_from_left: SE3,
}

impl Sequence {
    /// The same, seen by these cameras.
    pub(super) fn seen_by(self, cameras: Cameras) -> Self {
        let Cameras { calibration, raw, views, body_from_left } = cameras;
        Self { calibration, raw_calibration: raw, rectification: views, body_from_left, ..self }
    }
}

/// Where a calibration was read: the files and fields that errors name.
pub(super) struct Origin<'a> {
    /// File of the left camera.
    pub(super) left: &'a Path,
    /// File of the right camera.
    pub(super) right: &'a Path,
    /// Field of the right camera's image size.
    pub(super) size_field: &'a str,
    /// Field of the right camera's place.
    pub(super) pose_field: &'a str,
}

impl Cameras {
    /// Two cameras turned so that the images of a point lie on one row.
    ///
    /// # Errors
    /// [`DatasetError`] for cameras of different sizes and for cameras that do not form a stereo rig.
    pub(super) fn of_pair(
        left: RawCamera,
        right: RawCamera,
        origin: &Origin<'_>,
    ) -> Result<Self, DatasetError> {
        let source = origin.left.display().to_string();
        if left.size != right.size {
            let (found, expected) = (right.size.to_string(), format!("{} as in {source}", left.size));
            return Err(DatasetError::in_field(origin.right, origin.size_field, found, expected));
        }
        let (rig, views, body_from_left) = if let Some(rig) = rectified_already(&left, &right) {
            (rig, Vec::new(), left.body_from_cam)
        } else {
            let size = (left.size.width, left.size.height);
            let right_from_left = right.body_from_cam.inverse() * left.body_from_cam;
            let refused = |error| match error {
                RectificationError::Folded { camera: 0, .. } => {
                    failure(origin.left, &lens(&left.model), error)
                }
                RectificationError::Folded { .. } => failure(origin.right, &lens(&right.model), error),
                _ => failure(origin.right, origin.pose_field, error),
            };
            let StereoRectification { rectified_from_left, rectified_from_right, rig } =
                rectify_stereo(&left.model, &right.model, size, &right_from_left).map_err(refused)?;
            let views = vec![view(&left, rectified_from_left), view(&right, rectified_from_right)];
            (rig, views, left.body_from_cam * turn(&rectified_from_left).inverse())
        };
        Ok(Self {
            calibration: Some(Calibration { rig, distortion: Distortion::default(), source: source.clone() }),
            raw: Some(RawCalibration { cameras: vec![left, right], source }),
            views,
            body_from_left,
        })
    }

    /// One camera: keypoints of a pinhole are undistorted one by one; the image of any other lens is redrawn.
    ///
    /// # Errors
    /// [`DatasetError`] for a fisheye that does not see along its axis.
    pub(super) fn of_one(camera: RawCamera, file: &Path) -> Result<Self, DatasetError> {
        let (pinhole, distortion, views) = match camera.model {
            CameraModel::Pinhole { camera: pinhole, distortion } => (pinhole, distortion, Vec::new()),
            CameraModel::KannalaBrandt(_) | CameraModel::Rational(_) => {
                let size = (camera.size.width, camera.size.height);
                let refused = |error| match error {
                    RectificationError::Folded { .. } => failure(file, &lens(&camera.model), error),
                    _ => failure(file, "intrinsics", error),
                };
                let new = rectify_single(&camera.model, size).map_err(refused)?;
                (new, Distortion::default(), vec![view(&camera, SO3::identity())])
            }
        };
        let rig = StereoRig { camera: pinhole, baseline_m: 0.0 };
        let source = file.display().to_string();
        Ok(Self {
            calibration: Some(Calibration { rig, distortion, source: source.clone() }),
            body_from_left: camera.body_from_cam,
            raw: Some(RawCalibration { cameras: vec![camera], source }),
            views,
        })
    }
}

/// The rig of two equal ideal pinholes of which the right one stands exactly to the right: their images are used as they are.
fn rectified_already(left: &RawCamera, right: &RawCamera) -> Option<StereoRig> {
    let CameraModel::Pinhole { camera, distortion } = left.model else { return None };
    let right_from_left = right.body_from_cam.inverse() * left.body_from_cam;
    let along_x = right_from_left.translation;
    let is_rig = left.model == right.model
        && distortion.is_zero()
        && right_from_left.rotation == SO3::identity()
        && along_x.x < 0.0
        && along_x.y == 0.0
        && along_x.z == 0.0;
    is_rig.then_some(StereoRig { camera, baseline_m: -along_x.x })
}

/// A lens as messages name it.
fn lens(model: &CameraModel) -> String {
    format!("lens `{model}`")
}

fn failure(path: &Path, field: &str, error: RectificationError) -> DatasetError {
    DatasetError::Rectification { path: PathBuf::from(path), field: field.to_string(), error }
}

fn turn(rotation: &SO3) -> SE3 {
    SE3::new(*rotation, geometry::Vec3::zeros())
}

fn view(camera: &RawCamera, rectified_from_cam: SO3) -> RectifiedView {
    RectifiedView { model: camera.model, rectified_from_cam, size: camera.size }
}
