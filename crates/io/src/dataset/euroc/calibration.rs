//! What the cameras of an EuRoC sequence are after rectification.

use std::path::Path;

use geometry::{
    CameraModel, Distortion, SE3, SO3, StereoRectification, StereoRig, rectify_single, rectify_stereo,
};

use super::super::{Calibration, DatasetError, RawCalibration, RawCamera, RectifiedView, Sensor};
use super::sensor;

/// The calibration of a sequence, raw and rectified.
pub(super) struct Cameras {
    pub(super) calibration: Option<Calibration>,
    pub(super) raw: Option<RawCalibration>,
    pub(super) views: Vec<RectifiedView>,
    pub(super) body_from_left: SE3,
}

impl Cameras {
    /// Reads what the sensor needs; without any `sensor.yaml` the configuration must give the camera of rectified images.
    pub(super) fn read(
        root: &Path,
        sensor: Sensor,
        warnings: &mut Vec<String>,
    ) -> Result<Self, DatasetError> {
        let [left, right] = ["cam0", "cam1"].map(|camera| root.join(camera).join("sensor.yaml"));
        let source = left.display().to_string();
        if !left.exists() && (sensor == Sensor::Mono || !right.exists()) {
            warnings.push(format!(
                "{source}: no such file, so the configuration must give the camera of rectified images"
            ));
            return Ok(Self {
                calibration: None,
                raw: None,
                views: Vec::new(),
                body_from_left: SE3::identity(),
            });
        }
        let left = sensor::read(&left)?;
        match sensor {
            Sensor::Stereo => Self::of_pair(left, sensor::read(&right)?, source, &right),
            _ => Self::of_one(left, source),
        }
    }

    fn of_pair(
        left: RawCamera,
        right: RawCamera,
        source: String,
        right_file: &Path,
    ) -> Result<Self, DatasetError> {
        if left.size != right.size {
            return Err(DatasetError::Field {
                path: right_file.to_path_buf(),
                line: String::new(),
                field: "resolution".to_string(),
                found: right.size.to_string(),
                expected: format!("{} as in {source}", left.size),
            });
        }
        let size = (left.size.width, left.size.height);
        let right_from_left = right.body_from_cam.inverse() * left.body_from_cam;
        let StereoRectification { rectified_from_left, rectified_from_right, rig } =
            rectify_stereo(&left.model, &right.model, size, &right_from_left)
                .map_err(|error| DatasetError::Rectification { path: right_file.to_path_buf(), error })?;
        let body_from_left = left.body_from_cam * turn(&rectified_from_left).inverse();
        let views = vec![view(&left, rectified_from_left), view(&right, rectified_from_right)];
        Ok(Self {
            calibration: Some(Calibration { rig, distortion: Distortion::default(), source: source.clone() }),
            raw: Some(RawCalibration { cameras: vec![left, right], source }),
            views,
            body_from_left,
        })
    }

    /// One camera: key-points of a pinhole are undistorted one by one; the image of a fisheye is drawn anew.
    fn of_one(camera: RawCamera, source: String) -> Result<Self, DatasetError> {
        let (pinhole, distortion, views) = match camera.model {
            CameraModel::Pinhole { camera: pinhole, distortion } => (pinhole, distortion, Vec::new()),
            CameraModel::KannalaBrandt(_) => {
                let size = (camera.size.width, camera.size.height);
                let new = rectify_single(&camera.model, size)
                    .map_err(|error| DatasetError::Rectification { path: source.clone().into(), error })?;
                (new, Distortion::default(), vec![view(&camera, SO3::identity())])
            }
        };
        let rig = StereoRig { camera: pinhole, baseline_m: 0.0 };
        Ok(Self {
            calibration: Some(Calibration { rig, distortion, source: source.clone() }),
            body_from_left: camera.body_from_cam,
            raw: Some(RawCalibration { cameras: vec![camera], source }),
            views,
        })
    }
}

fn turn(rotation: &SO3) -> SE3 {
    SE3::new(*rotation, geometry::Vec3::zeros())
}

fn view(camera: &RawCamera, rectified_from_cam: SO3) -> RectifiedView {
    RectifiedView { model: camera.model, rectified_from_cam, size: camera.size }
}
