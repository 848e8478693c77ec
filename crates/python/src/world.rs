//! Rendered towns, frame by frame.

use dsslam::synth;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::camera::Camera;
use crate::poses::{self, Array};

/// A rendered town: stereo images with depth, labels and true poses.
#[pyclass(frozen, module = "dsslam")]
pub(crate) struct World(synth::World);

fn image<'py, T: numpy::Element + Copy>(
    py: Python<'py>,
    raster: &geometry::Raster<T>,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    PyArray1::from_slice(py, &raster.data).reshape([raster.height, raster.width])
}

#[pymethods]
impl World {
    #[new]
    #[pyo3(signature = (preset="town", *, seed=1, rounds=1, relit=false))]
    fn new(py: Python<'_>, preset: &str, seed: u64, rounds: u32, relit: bool) -> PyResult<Self> {
        let names = synth::Preset::ALL.map(synth::Preset::name).join(", ");
        let expected = || PyValueError::new_err(format!("preset: found {preset:?}, expected one of {names}"));
        let preset = synth::Preset::ALL.into_iter().find(|p| p.name() == preset).ok_or_else(expected)?;
        if rounds == 0 {
            return Err(PyValueError::new_err("rounds: found 0, expected at least 1"));
        }
        let world = py.detach(|| synth::World::new(preset, seed, rounds));
        Ok(Self(if relit { world.relit() } else { world }))
    }

    fn __len__(&self) -> usize {
        self.0.n_frames()
    }

    #[getter]
    fn camera(&self) -> Camera {
        let (width, height) = self.0.image_size();
        Camera(dsslam::Camera::stereo(self.0.rig(), width, height))
    }

    fn t_ns(&self, i: usize) -> i64 {
        (self.0.timestamp_s(i) * 1e9).round() as i64
    }

    fn pose(&self, i: usize) -> PyResult<Array> {
        self.check(i)?;
        Ok(poses::matrix(&self.0.world_from_cam(i)))
    }

    #[expect(clippy::type_complexity, reason = "a pair of arrays")]
    fn images<'py>(
        &self,
        py: Python<'py>,
        i: usize,
    ) -> PyResult<(Bound<'py, PyArray2<u8>>, Bound<'py, PyArray2<u8>>)> {
        self.check(i)?;
        let images = py.detach(|| self.0.images(i));
        Ok((image(py, &images.left)?, image(py, &images.right)?))
    }

    fn frame<'py>(&self, py: Python<'py>, i: usize) -> PyResult<Bound<'py, PyDict>> {
        self.check(i)?;
        let frame = py.detach(|| self.0.frame(i));
        let all = PyDict::new(py);
        all.set_item("t_ns", self.t_ns(i))?;
        all.set_item("left", image(py, &frame.left)?)?;
        all.set_item("right", image(py, &frame.right)?)?;
        all.set_item("depth", image(py, &frame.depth_m)?)?;
        all.set_item("labels", image(py, &frame.labels)?)?;
        all.set_item("pose", poses::matrix(&frame.world_from_cam))?;
        Ok(all)
    }
}

impl World {
    fn check(&self, i: usize) -> PyResult<()> {
        let n = self.0.n_frames();
        if i < n { Ok(()) } else { Err(PyIndexError::new_err(format!("frame {i}: the world has {n}"))) }
    }
}
