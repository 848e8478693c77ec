//! SLAM by pushing images.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

use dsslam::{Config, Images, PixelFormat, SlamOptions};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arguments;
use crate::camera::Camera;
use crate::error::raised;
use crate::finished::Finished;
use crate::frame::Result;
use crate::image::{self, Depth, Pixels};

/// SLAM on images that are pushed one frame after another.
#[pyclass(frozen, module = "dsslam")]
pub(crate) struct Slam {
    /// One call at a time.
    state: Mutex<State>,
    camera: dsslam::Camera,
    config: Config,
    options: SlamOptions,
    color: PixelFormat,
}

/// A run takes frames until it is finished.
enum State {
    Running(Box<dsslam::Slam>),
    Finished(Finished),
    /// While one becomes the other, or where it could not.
    Empty,
}

impl Slam {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Starts anew with these options.
    fn restart(&self, options: &SlamOptions) -> std::result::Result<(), dsslam::Error> {
        let slam = dsslam::Slam::with(&self.config, self.camera.clone(), options)?;
        *self.state() = State::Running(Box::new(slam));
        Ok(())
    }
}

#[pymethods]
impl Slam {
    #[new]
    #[pyo3(signature = (config=None, camera=None, *, settings=None, map=None, localize=false, vocabulary=None, network=None, schedule=None, color="rgb"))]
    #[expect(clippy::too_many_arguments, reason = "they have names in Python")]
    fn new(
        py: Python<'_>,
        config: Option<PathBuf>,
        camera: Option<&Bound<'_, Camera>>,
        settings: Option<&Bound<'_, PyDict>>,
        map: Option<PathBuf>,
        localize: bool,
        vocabulary: Option<PathBuf>,
        network: Option<PathBuf>,
        schedule: Option<&str>,
        color: &str,
    ) -> PyResult<Self> {
        let Some(camera) = camera else {
            let expected =
                "camera: found none, expected a dsslam.Camera, such as Camera.from_file(\"cameras.yaml\")";
            return Err(pyo3::exceptions::PyTypeError::new_err(expected));
        };
        let camera = camera.get().0.clone();
        let config = arguments::config(config.as_deref(), settings)?;
        let options = arguments::options(map, localize, vocabulary, network, schedule)?;
        let color = image::color(color)?;
        let slam = py.detach(|| dsslam::Slam::with(&config, camera.clone(), &options)).map_err(raised)?;
        Ok(Self { state: Mutex::new(State::Running(Box::new(slam))), camera, config, options, color })
    }

    #[pyo3(signature = (t_ns, left, right=None, depth=None, mask=None))]
    fn track(
        &self,
        py: Python<'_>,
        t_ns: i64,
        left: &Bound<'_, PyAny>,
        right: Option<&Bound<'_, PyAny>>,
        depth: Option<&Bound<'_, PyAny>>,
        mask: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Result> {
        let left = Pixels::of(left, "left", self.color)?;
        let right = right.map(|right| Pixels::of(right, "right", self.color)).transpose()?;
        let depth = depth.map(|depth| Depth::of(depth, "depth")).transpose()?;
        let mask = mask.map(|mask| Pixels::of_mask(mask, "mask")).transpose()?;
        let mut images = Images::from(left.view());
        if let Some(right) = &right {
            images = images.with_right(right.view());
        }
        if let Some(depth) = &depth {
            images = images.with_depth(depth.view());
        }
        if let Some(mask) = &mask {
            images = images.with_mask(mask.view());
        }
        let answer = py.detach(|| match &mut *self.state() {
            State::Running(slam) => slam.track(t_ns, images).map_err(raised),
            _ => Err(raised("this Slam is finished; reset() starts again")),
        })?;
        Ok(Result::new(&answer, t_ns))
    }

    fn finish(&self, py: Python<'_>) -> PyResult<Finished> {
        py.detach(|| {
            let mut state = self.state();
            let finished = match std::mem::replace(&mut *state, State::Empty) {
                State::Running(slam) => {
                    let notices = slam.notices().to_vec();
                    Finished::new(slam.finish().map_err(raised)?, self.camera.sensor(), notices, None)
                }
                State::Finished(finished) => finished,
                State::Empty => return Err(raised("this Slam could not be finished; reset() starts again")),
            };
            *state = State::Finished(finished.clone());
            Ok(finished)
        })
    }

    fn save(&self, py: Python<'_>, file: PathBuf) -> PyResult<String> {
        self.finish(py)?.save(py, file)
    }

    fn load(&self, py: Python<'_>, file: PathBuf) -> PyResult<()> {
        let mut options = self.options.clone();
        (options.start_map, options.localize_only) = (Some(file), false);
        py.detach(|| self.restart(&options)).map_err(raised)
    }

    fn localize(&self, py: Python<'_>, file: PathBuf) -> PyResult<()> {
        let mut options = self.options.clone();
        (options.start_map, options.localize_only) = (Some(file), true);
        py.detach(|| self.restart(&options)).map_err(raised)
    }

    fn reset(&self, py: Python<'_>) -> PyResult<()> {
        py.detach(|| self.restart(&self.options)).map_err(raised)
    }

    #[getter]
    fn notices(&self) -> Vec<String> {
        match &*self.state() {
            State::Running(slam) => slam.notices().to_vec(),
            State::Finished(finished) => finished.notices.clone(),
            State::Empty => Vec::new(),
        }
    }

    #[getter]
    fn config(&self) -> String {
        match &*self.state() {
            State::Running(slam) => slam.config().to_yaml(),
            _ => self.config.to_yaml(),
        }
    }

    #[getter]
    fn is_finished(&self) -> bool {
        !matches!(&*self.state(), State::Running(_))
    }

    fn __enter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }

    fn __exit__(
        &self,
        py: Python<'_>,
        _kind: &Bound<'_, PyAny>,
        _value: &Bound<'_, PyAny>,
        _traceback: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        self.finish(py).map(|_| ())
    }
}
