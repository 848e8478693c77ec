//! The sections `camera` and `input` of the configuration.

use std::path::PathBuf;

use geometry::Sensor;
use serde::{Deserialize, Serialize};
use settings::{
    ANY, Entry, Section, above, between, optional_choice, optional_file, optional_integer, optional_real,
    real,
};

/// The section `camera` of the configuration: used where the dataset has no calibration file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct CameraSettings {
    /// Focal length, px.
    pub fx: Option<f64>,
    /// Focal length, px.
    pub fy: Option<f64>,
    /// Principal point, px.
    pub cx: Option<f64>,
    /// Principal point, px.
    pub cy: Option<f64>,
    /// Radial distortion, r^2.
    pub k1: f64,
    /// Radial distortion, r^4.
    pub k2: f64,
    /// Tangential distortion.
    pub p1: f64,
    /// Tangential distortion.
    pub p2: f64,
    /// Radial distortion, r^6.
    pub k3: f64,
    /// Image width, px.
    pub width: Option<usize>,
    /// Image height, px.
    pub height: Option<usize>,
    /// Distance of the two cameras, m; virtual for RGB-D.
    pub baseline_m: Option<f64>,
    /// Frames per second.
    pub fps: f64,
    /// Value of a depth image at one meter.
    pub depth_units_per_metre: f64,
}

impl Default for CameraSettings {
    fn default() -> Self {
        Self {
            fx: None,
            fy: None,
            cx: None,
            cy: None,
            k1: 0.0,
            k2: 0.0,
            p1: 0.0,
            p2: 0.0,
            k3: 0.0,
            width: None,
            height: None,
            baseline_m: None,
            fps: 10.0,
            depth_units_per_metre: 5000.0,
        }
    }
}

#[rustfmt::skip]
impl Section for CameraSettings {
    const KEYS: &'static [Entry] = &[
        optional_real("camera.fx", "px", above(0.0), "focal length, horizontal; a calibration file of the dataset takes precedence"),
        optional_real("camera.fy", "px", above(0.0), "focal length, vertical"),
        optional_real("camera.cx", "px", ANY, "principal point, horizontal"),
        optional_real("camera.cy", "px", ANY, "principal point, vertical"),
        real("camera.k1", "", ANY, "radial distortion, r^2"),
        real("camera.k2", "", ANY, "radial distortion, r^4"),
        real("camera.p1", "", ANY, "tangential distortion"),
        real("camera.p2", "", ANY, "tangential distortion"),
        real("camera.k3", "", ANY, "radial distortion, r^6"),
        optional_integer("camera.width", "px", [16, 16_384], "image width; absent: taken from the first image"),
        optional_integer("camera.height", "px", [16, 16_384], "image height; absent: taken from the first image"),
        optional_real("camera.baseline_m", "m", above(0.0), "distance between the two cameras; for RGB-D the virtual baseline (bf / fx), 0.08 if absent"),
        real("camera.fps", "Hz", above(0.0), "frame rate; the longest gap between keyframes is one second of frames"),
        real("camera.depth_units_per_metre", "1/m", above(0.0), "value of a depth image at one meter"),
    ];
}

/// The section `input` of the configuration: what is read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct InputSettings {
    /// What to use of the dataset.
    pub sensor: Option<Sensor>,
    /// Factor by which images are reduced.
    pub scale: f64,
    /// Image that is 0 where no features are to be taken.
    pub mask: Option<PathBuf>,
    /// Largest time between a color image and its depth image, s.
    pub association_tolerance_s: f64,
}

impl Default for InputSettings {
    fn default() -> Self {
        Self { sensor: None, scale: 1.0, mask: None, association_tolerance_s: 0.02 }
    }
}

#[rustfmt::skip]
impl Section for InputSettings {
    const KEYS: &'static [Entry] = &[
        optional_choice("input.sensor", Sensor::WORDS, "which sensor to use; absent: the richest that the dataset offers"),
        real("input.scale", "", between(0.1, 1.0), "images are reduced by this factor before anything else; the camera is scaled with them"),
        optional_file("input.mask", "gray PNG, as large as the raw left image: no features where it is 0"),
        real("input.association_tolerance_s", "s", above(0.0), "maximum time between a color image and its depth image"),
    ];
}
