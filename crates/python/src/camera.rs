//! Cameras.

use std::path::PathBuf;

use dsslam::{Distortion, Input, InputOptions, Pinhole, StereoRig};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arguments;
use crate::error::raised;

/// Sensor, image size and calibration of the camera that images are pushed from. Made by one of its static methods.
#[pyclass(frozen, module = "dsslam")]
#[derive(Clone)]
pub(crate) struct Camera(pub(crate) dsslam::Camera);

/// Focal lengths and principal point, which must be numbers that a camera can have.
fn pinhole(fx: f64, fy: f64, cx: f64, cy: f64, size: (usize, usize)) -> PyResult<Pinhole> {
    for (name, value) in [("fx", fx), ("fy", fy)] {
        if !(value.is_finite() && value > 0.0) {
            return Err(PyValueError::new_err(format!("{name}: found {value}, expected pixels above 0")));
        }
    }
    for (name, value) in [("cx", cx), ("cy", cy)] {
        if !value.is_finite() {
            return Err(PyValueError::new_err(format!("{name}: found {value}, expected pixels")));
        }
    }
    if size.0 == 0 || size.1 == 0 {
        let (width, height) = size;
        return Err(PyValueError::new_err(format!("size: found {width} x {height} pixels, expected some")));
    }
    Ok(Pinhole { fx, fy, cx, cy })
}

fn baseline(value: f64) -> PyResult<f64> {
    if value.is_finite() && value > 0.0 {
        return Ok(value);
    }
    Err(PyValueError::new_err(format!("baseline: found {value}, expected meters above 0")))
}

/// `k1, k2, p1, p2, k3` as OpenCV orders them; missing ones are 0.
fn distortion(coefficients: Vec<f64>) -> PyResult<Distortion> {
    let n = coefficients.len();
    if n > 5 || coefficients.iter().any(|c| !c.is_finite()) {
        return Err(PyValueError::new_err(format!(
            "distortion: found {n} values, expected at most 5 finite ones: k1, k2, p1, p2, k3"
        )));
    }
    let at = |i: usize| coefficients.get(i).copied().unwrap_or(0.0);
    Ok(Distortion { k1: at(0), k2: at(1), p1: at(2), p2: at(3), k3: at(4) })
}

#[pymethods]
impl Camera {
    #[staticmethod]
    #[pyo3(signature = (fx, fy, cx, cy, *, baseline, width, height))]
    fn stereo(
        fx: f64,
        fy: f64,
        cx: f64,
        cy: f64,
        baseline: f64,
        width: usize,
        height: usize,
    ) -> PyResult<Self> {
        let camera = pinhole(fx, fy, cx, cy, (width, height))?;
        let rig = StereoRig { camera, baseline_m: self::baseline(baseline)? };
        Ok(Self(dsslam::Camera::stereo(rig, width, height)))
    }

    #[staticmethod]
    #[pyo3(signature = (fx, fy, cx, cy, *, width, height, distortion=Vec::new(), baseline=0.08))]
    #[expect(clippy::too_many_arguments, reason = "they have names in Python")]
    fn rgbd(
        fx: f64,
        fy: f64,
        cx: f64,
        cy: f64,
        width: usize,
        height: usize,
        distortion: Vec<f64>,
        baseline: f64,
    ) -> PyResult<Self> {
        let camera = pinhole(fx, fy, cx, cy, (width, height))?;
        let rig = StereoRig { camera, baseline_m: self::baseline(baseline)? };
        Ok(Self(dsslam::Camera::rgbd(rig, self::distortion(distortion)?, width, height)))
    }

    #[staticmethod]
    #[pyo3(signature = (fx, fy, cx, cy, *, width, height, distortion=Vec::new()))]
    fn mono(
        fx: f64,
        fy: f64,
        cx: f64,
        cy: f64,
        width: usize,
        height: usize,
        distortion: Vec<f64>,
    ) -> PyResult<Self> {
        let camera = pinhole(fx, fy, cx, cy, (width, height))?;
        Ok(Self(dsslam::Camera::mono(camera, self::distortion(distortion)?, width, height)))
    }

    #[staticmethod]
    #[pyo3(signature = (file, sensor=None))]
    fn from_file(file: PathBuf, sensor: Option<&str>) -> PyResult<Self> {
        dsslam::Camera::from_file(file, arguments::sensor(sensor)?).map(Self).map_err(raised)
    }

    #[staticmethod]
    #[pyo3(signature = (config, sensor, settings=None))]
    fn from_config(config: PathBuf, sensor: &str, settings: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let config = arguments::config(Some(&config), settings)?;
        let sensor = arguments::sensor_of(sensor)?;
        dsslam::Camera::from_config(&config, sensor).map(Self).map_err(raised)
    }

    #[staticmethod]
    #[pyo3(signature = (folder, config=None, *, sensor=None, calibration=None, settings=None))]
    fn of_dataset(
        folder: PathBuf,
        config: Option<PathBuf>,
        sensor: Option<&str>,
        calibration: Option<PathBuf>,
        settings: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let config = crate::session::chosen(&folder, config.as_deref(), settings, None)?.config;
        let mut options = InputOptions::default();
        options.sensor = arguments::sensor(sensor)?;
        options.calibration = calibration;
        let input = Input::open(&folder, &config, &options).map_err(raised)?;
        Ok(Self(dsslam::Camera::of(&input)))
    }

    #[getter]
    fn sensor(&self) -> &'static str {
        self.0.sensor().word()
    }

    #[getter]
    fn size(&self) -> (usize, usize) {
        let size = self.0.size();
        (size.width, size.height)
    }

    fn __repr__(&self) -> String {
        let size = self.0.size();
        format!("Camera({}, {} x {})", self.0.sensor().word(), size.width, size.height)
    }
}
