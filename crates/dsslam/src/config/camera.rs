//! The camera of a run: the dataset's calibration file takes precedence over the configuration, and the program says so.

use std::path::{Path, PathBuf};

use geometry::{Distortion, Pinhole, Sensor, StereoRig};
use io::{Calibration, Provenance};

use super::Config;

/// The baseline of a stereo camera that sees depth about as precisely as sensors with structured light do.
const VIRTUAL_BASELINE_M: f64 = 0.08;

/// Why no camera is known.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// Neither the dataset nor the configuration gives the camera.
    #[error(
        "{}: the dataset has no calibration file and the configuration lacks {missing}; pass a configuration with a `camera` section (such as --config configs/tum-rgbd.yaml), --set {missing}=... or --calib FILE",
        dataset.display()
    )]
    Missing {
        /// The dataset.
        dataset: PathBuf,
        /// The first key that is missing.
        missing: &'static str,
    },
}

impl Config {
    /// Replaces the camera by that of the dataset. Returns a notice for each value that was given and is replaced.
    pub fn apply_calibration(&mut self, calibration: &Calibration) -> Vec<String> {
        let Calibration { rig: StereoRig { camera, baseline_m }, distortion, source } = calibration;
        let target = &mut self.camera;
        let optional = [
            ("camera.fx", &mut target.fx, camera.fx),
            ("camera.fy", &mut target.fy, camera.fy),
            ("camera.cx", &mut target.cx, camera.cx),
            ("camera.cy", &mut target.cy, camera.cy),
            ("camera.baseline_m", &mut target.baseline_m, *baseline_m),
        ];
        let plain = [
            ("camera.k1", &mut target.k1, distortion.k1),
            ("camera.k2", &mut target.k2, distortion.k2),
            ("camera.p1", &mut target.p1, distortion.p1),
            ("camera.p2", &mut target.p2, distortion.p2),
            ("camera.k3", &mut target.k3, distortion.k3),
        ];
        // A monocular dataset gives no baseline.
        let is_given = |key: &str, new: f64| key != "camera.baseline_m" || new > 0.0;
        let optional = optional.into_iter().filter(|(key, _, new)| is_given(key, *new));
        let changed: Vec<(&str, Option<f64>, f64)> = optional
            .map(|(key, value, new)| (key, value.replace(new), new))
            .chain(plain.map(|(key, value, new)| (key, Some(std::mem::replace(value, new)), new)))
            .collect();
        let notices = changed.into_iter();
        notices.filter_map(|(key, old, new)| self.note_replaced(key, old, new, source)).collect()
    }

    /// Takes over the frame rate that a calibration file of the dataset gives; a notice if another one was given.
    pub fn apply_frame_rate(&mut self, frame_rate_hz: f64, source: &str) -> Option<String> {
        let old = std::mem::replace(&mut self.camera.fps, frame_rate_hz);
        self.note_replaced("camera.fps", Some(old), frame_rate_hz, source)
    }

    /// Takes over the value of a depth image at one meter that the dataset gives; a notice if another one was given.
    pub fn apply_depth_units(&mut self, units_per_meter: f64, source: &str) -> Option<String> {
        let old = std::mem::replace(&mut self.camera.depth_units_per_metre, units_per_meter);
        self.note_replaced("camera.depth_units_per_metre", Some(old), units_per_meter, source)
    }

    fn note_replaced(&mut self, key: &str, old: Option<f64>, new: f64, source: &str) -> Option<String> {
        let place = self.origins.set(key, Provenance::Calibration(source.to_string()))?;
        old.filter(|old| *old != new)
            .map(|old| format!("{key} = {old} ({place}) is replaced by {new} from {source}"))
    }

    /// The camera in force; for a dataset with a calibration file call [`Config::apply_calibration`] first.
    ///
    /// # Errors
    /// [`CameraError::Missing`] naming `dataset`, the missing key and what to do.
    pub fn camera_in_force(&self, dataset: &Path, sensor: Sensor) -> Result<Calibration, CameraError> {
        let camera = &self.camera;
        let need = |missing: &'static str, value: Option<f64>| {
            value.ok_or_else(|| CameraError::Missing { dataset: dataset.to_path_buf(), missing })
        };
        let pinhole = Pinhole {
            fx: need("camera.fx", camera.fx)?,
            fy: need("camera.fy", camera.fy)?,
            cx: need("camera.cx", camera.cx)?,
            cy: need("camera.cy", camera.cy)?,
        };
        let baseline_m = match sensor {
            Sensor::Mono => camera.baseline_m.unwrap_or(0.0),
            Sensor::Rgbd => camera.baseline_m.unwrap_or(VIRTUAL_BASELINE_M),
            Sensor::Stereo => need("camera.baseline_m", camera.baseline_m)?,
        };
        Ok(Calibration {
            rig: StereoRig { camera: pinhole, baseline_m },
            distortion: Distortion {
                k1: camera.k1,
                k2: camera.k2,
                p1: camera.p1,
                p2: camera.p2,
                k3: camera.k3,
            },
            source: self.provenance("camera.fx").to_string(),
        })
    }
}
