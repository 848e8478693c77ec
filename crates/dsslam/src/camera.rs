//! The camera that images are pushed from.

use std::path::Path;

use geometry::{Distortion, Pinhole, StereoRig};
use io::{Calibration, ImageSize, Sensor, Sequence, SequenceKind};

use crate::{Config, Error, Input};

/// Sensor, image size and calibration.
///
/// ```
/// use dsslam::{Camera, Pinhole, StereoRig};
///
/// let camera = Pinhole { fx: 458.0, fy: 457.0, cx: 367.0, cy: 248.0 };
/// let rig = StereoRig { camera, baseline_m: 0.11 };
/// let stereo = Camera::stereo(rig, 752, 480);
/// assert_eq!(stereo.size().width, 752);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Without frames.
    sequence: Sequence,
    /// Of the raw images of one camera.
    size: ImageSize,
}

impl Camera {
    /// Two cameras whose images are rectified: without distortion, and a point lies in the same row of both. Intrinsics in pixels.
    pub fn stereo(rig: StereoRig, width: usize, height: usize) -> Self {
        Self::of_rig(Sensor::Stereo, rig, Distortion::default(), width, height)
    }

    /// A camera with a registered depth image. `rig.baseline_m` is that of a stereo camera that sees depth as precisely, about
    /// 0.08 m for a structured-light sensor.
    pub fn rgbd(rig: StereoRig, distortion: Distortion, width: usize, height: usize) -> Self {
        Self::of_rig(Sensor::Rgbd, rig, distortion, width, height)
    }

    /// One camera; the unit of length of its map is free.
    pub fn mono(camera: Pinhole, distortion: Distortion, width: usize, height: usize) -> Self {
        Self::of_rig(Sensor::Mono, StereoRig { camera, baseline_m: 0.0 }, distortion, width, height)
    }

    /// The cameras of a calibration file in any format of [`io::read_calibration`]. Raw images are rectified where that is needed. `sensor`: `None` for stereo where the file has two cameras, else mono.
    ///
    /// # Errors
    /// A file that is not a calibration, or stereo with one camera.
    pub fn from_file(file: impl AsRef<Path>, sensor: Option<Sensor>) -> Result<Self, Error> {
        let (sequence, size) = io::open_cameras(file.as_ref(), sensor)?;
        Ok(Self { sequence, size })
    }

    /// The camera of the configuration's section `camera`.
    ///
    /// # Errors
    /// A key of the camera that is missing, its width and height included.
    pub fn from_config(config: &Config, sensor: Sensor) -> Result<Self, Error> {
        let calibration = config.camera_in_force(Path::new("camera"), sensor)?;
        let (Some(width), Some(height)) = (config.camera.width, config.camera.height) else {
            return Err(Error::NoImageSize);
        };
        Ok(Self::of_rig(sensor, calibration.rig, calibration.distortion, width, height))
    }

    /// The camera of a dataset, so that its images can be pushed one by one: raw images, as they lie in its files.
    pub fn of(input: &Input) -> Self {
        let intake = input.intake();
        let sequence = Sequence { frames: Vec::new(), ground_truth: None, ..intake.sequence.clone() };
        Self { sequence, size: intake.size }
    }

    fn of_rig(sensor: Sensor, rig: StereoRig, distortion: Distortion, width: usize, height: usize) -> Self {
        let calibration = Calibration { rig, distortion, source: "the caller's camera".to_owned() };
        let calibration = Some(calibration);
        let sequence = Sequence { calibration, ..Sequence::new("pushed", SequenceKind::Images, sensor) };
        Self { sequence, size: ImageSize { width, height } }
    }

    /// The images that each frame must have.
    pub fn sensor(&self) -> Sensor {
        self.sequence.sensor
    }

    /// Size of each image, pixels.
    pub fn size(&self) -> ImageSize {
        self.size
    }

    pub(crate) fn into_parts(self) -> (Sequence, ImageSize) {
        (self.sequence, self.size)
    }
}
