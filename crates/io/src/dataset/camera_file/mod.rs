//! Calibration files of cameras: our own YAML, EuRoC's `sensor.yaml`, BoofCV's `stereo_params.xml`.

mod boofcv;
mod own;
pub(super) mod sensor;

use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::IgnoredAny;

use super::cameras::{Cameras, Origin};
use super::fields::document;
use super::{DatasetError, RawCamera, Sensor};
use crate::file::TextFile;

const EXPECTED: &str = "the calibration of a camera";

/// Files that a folder of images may hold its calibration in, in the order of preference.
const NAMES: [&str; 3] = ["calibration.yaml", "calibration.yml", "stereo_params.xml"];

/// What a calibration file tells.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CameraFile {
    /// The file that errors and notices name.
    path: PathBuf,
    /// One camera, or the left and the right one.
    pub(super) cameras: Vec<RawCamera>,
    /// Images per second.
    pub(super) frame_rate_hz: Option<f64>,
    /// Names of the fields with the right camera's image size and place.
    right_fields: (&'static str, &'static str),
}

/// The calibration file of a folder, if it holds one.
pub(super) fn find(folder: &Path) -> Option<PathBuf> {
    NAMES.iter().map(|name| folder.join(name)).find(|path| path.is_file())
}

/// Reads a calibration file; its content tells the format.
///
/// # Errors
/// [`DatasetError`] naming the field, what was found and what was expected.
pub(super) fn read(path: &Path) -> Result<CameraFile, DatasetError> {
    /// The keys that tell the two YAML formats apart.
    #[derive(Deserialize)]
    struct Keys {
        cameras: Option<IgnoredAny>,
        camera_model: Option<IgnoredAny>,
    }
    let file = TextFile::read(path, EXPECTED)?;
    if file.data_lines().next().is_none() {
        return Err(file.empty(EXPECTED).into());
    }
    if file.text().trim_start().starts_with('<') {
        return boofcv::read(&file);
    }
    let keys: Keys = document(&file)?;
    if keys.cameras.is_some() || keys.camera_model.is_none() {
        return own::read(&file);
    }
    Ok(CameraFile {
        path: path.to_path_buf(),
        cameras: vec![sensor::camera(&file)?],
        frame_rate_hz: None,
        right_fields: ("resolution", "T_BS"),
    })
}

impl CameraFile {
    /// The cameras that a sensor uses.
    ///
    /// # Errors
    /// [`DatasetError`] for stereo with one camera, and for cameras that cannot be rectified.
    pub(super) fn cameras(&self, sensor: Sensor) -> Result<Cameras, DatasetError> {
        let (size_field, pose_field) = self.right_fields;
        let origin = Origin { left: &self.path, right: &self.path, size_field, pose_field };
        let mut cameras = match (sensor, &self.cameras[..]) {
            (Sensor::Stereo, [left, right, ..]) => Cameras::of_pair(left.clone(), right.clone(), &origin)?,
            (_, [left, ..]) => Cameras::of_one(left.clone(), &self.path)?,
            (_, []) => Cameras::default(),
        };
        // The body of such a file is the camera itself.
        cameras.body_from_left = geometry::SE3::identity();
        Ok(cameras)
    }

    /// The file, as messages name it.
    pub(super) fn source(&self) -> String {
        self.path.display().to_string()
    }
}
