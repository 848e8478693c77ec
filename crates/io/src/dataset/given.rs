//! The calibration file that replaces a dataset's camera: named by the user, or lying in the folder. It never changes the layout.

use std::path::Path;

use geometry::{CameraModel, SE3};

use super::camera_file::{self, CameraFile};
use super::cameras::Cameras;
use super::layout::Layout;
use super::{DatasetError, OpenOptions, RawCamera, Sensor, Sequence};
use crate::images::ImageSize;
use crate::trajectory::Trajectory;

/// A calibration file, or none.
pub(super) struct Given {
    pub(super) file: Option<CameraFile>,
}

/// The cameras that a layout has itself.
#[derive(Clone, Copy)]
pub(super) struct Own<'a> {
    /// The left and the right one.
    pub(super) cameras: &'a [RawCamera],
    /// Where they were read.
    pub(super) source: &'a str,
}

impl Given {
    /// The file that `options` name, else the one in the folder. One that merely lies there and cannot be read is left alone where
    /// the layout has a calibration of its own.
    ///
    /// # Errors
    /// [`DatasetError`] for a file that cannot be read.
    pub(super) fn find(
        dir: &Path,
        options: &OpenOptions,
        layout: Option<&Layout>,
        warnings: &mut Vec<String>,
    ) -> Result<Self, DatasetError> {
        if let Some(path) = &options.calibration {
            return Ok(Self { file: Some(camera_file::read_calibration(path)?) });
        }
        let has_own = matches!(layout, Some(Layout::Kitti(_) | Layout::Euroc(_)));
        let file = match camera_file::find(dir).map(|path| camera_file::read_calibration(&path)).transpose() {
            Err(problem) if has_own => {
                warnings.push(format!("{problem}; the layout's own calibration is used"));
                None
            }
            file => file?,
        };
        Ok(Self { file })
    }

    /// What the file makes of the cameras that the layout has, with the sensor that is left; `None` without a file. A file of one
    /// camera takes the place of the right one from the layout, where it knows it.
    ///
    /// # Errors
    /// [`DatasetError`] for stereo that is wanted but not known, and cameras that cannot be rectified.
    pub(super) fn replace(
        &self,
        (wanted, sensor): (Option<Sensor>, Sensor),
        own: Option<Own<'_>>,
        images: Option<ImageSize>,
        dir: &Path,
        warnings: &mut Vec<String>,
    ) -> Result<Option<(Sensor, Cameras)>, DatasetError> {
        let Some(file) = &self.file else { return Ok(None) };
        if sensor != Sensor::Stereo || file.has_pair() {
            return Ok(Some((sensor, file.in_body(sensor, images)?)));
        }
        let raw = file.raw(Sensor::Mono, images)?;
        if let (Some(Own { cameras: [left, right, ..], source }), [new]) = (own, &raw[..]) {
            warnings.push(format!(
                "{}: describes a single camera; the place of the right one is that of {source}",
                file.source()
            ));
            // Rectified images have one camera for both.
            let is_rectified = left.model == right.model && is_ideal(&left.model);
            let right_model = if is_rectified { new.model } else { right.model };
            let pair = vec![
                RawCamera { body_from_cam: left.body_from_cam, ..new.clone() },
                RawCamera { model: right_model, size: new.size, body_from_cam: right.body_from_cam },
            ];
            return Ok(Some((sensor, file.rectified(pair, sensor)?)));
        }
        if wanted == Some(Sensor::Stereo) {
            let reason = format!("{} describes a single camera", file.source());
            return Err(DatasetError::unavailable(dir, sensor, reason));
        }
        warnings.push(format!("{}: describes a single camera, so the run is monocular", file.source()));
        Ok(Some((Sensor::Mono, file.in_body(Sensor::Mono, images)?)))
    }

    /// What else the file tells: rates, the scale of depth, how it was understood, and a picture that stands on its head.
    pub(super) fn finish(&self, sequence: &mut Sequence) {
        let Some(file) = &self.file else { return };
        sequence.frame_rate_hz = file.frame_rate_hz.or(sequence.frame_rate_hz);
        sequence.depth_units_per_metre = file.depth_units_per_metre.or(sequence.depth_units_per_metre);
        sequence.warnings.extend(file.notes.iter().cloned());
        if file.y_up {
            sequence.ground_truth.iter_mut().for_each(mirror);
        }
    }
}

/// Whether a camera is a pinhole without a lens.
fn is_ideal(model: &CameraModel) -> bool {
    matches!(model, CameraModel::Pinhole { distortion, .. } if distortion.is_zero())
}

/// Poses in coordinates with y up as those with y down: S T S with S = diag(1, -1, 1).
fn mirror(truth: &mut Trajectory) {
    for pose in &mut truth.poses {
        let mut rows = pose.world_from_cam.rows_3x4();
        for (i, value) in rows.iter_mut().enumerate() {
            let (row, column) = (i / 4, i % 4);
            if (row == 1) != (column == 1) {
                *value = -*value;
            }
        }
        pose.world_from_cam = SE3::from_rows_3x4(&rows);
    }
}
