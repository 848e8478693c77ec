//! A map as arrays.

use std::fmt::Display;
use std::path::PathBuf;

use map::KeyframeId;
use numpy::{PyArray1, PyArray2, PyArray3};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::raised;
use crate::poses;

/// Keyframes, points and observations. Rows of `points` and of everything named after them belong together, likewise those of
/// keyframes and of observations.
#[pyclass(frozen, module = "dsslam")]
pub(crate) struct Map(pub(crate) map::Map);

/// Row of each of these ids, which are below `next`.
fn rows(ids: impl Iterator<Item = u32>, next: u32) -> Vec<u32> {
    let mut rows = vec![u32::MAX; next as usize];
    for (row, id) in (0..).zip(ids) {
        rows[id as usize] = row;
    }
    rows
}

#[pymethods]
impl Map {
    #[staticmethod]
    fn load(py: Python<'_>, file: PathBuf) -> PyResult<Self> {
        py.detach(|| {
            let unusable = |reason: &dyn Display| raised(format!("{}: {reason}", file.display()));
            let bytes = io::read_file(&file).map_err(|error| unusable(&error))?;
            let (map, _) = map::file::decode(&bytes).map_err(|error| unusable(&error))?;
            Ok(Self(map))
        })
    }

    #[getter]
    fn n_keyframes(&self) -> usize {
        self.0.n_keyframes()
    }

    #[getter]
    fn n_points(&self) -> usize {
        self.0.n_points()
    }

    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        poses::rows(py, self.0.points().map(|point| point.position.into()))
    }

    #[getter]
    fn point_ids<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        PyArray1::from_iter(py, self.0.points().map(|point| point.id.0))
    }

    #[getter]
    fn point_normals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        poses::rows(py, self.0.points().map(|point| point.normal.into()))
    }

    #[getter]
    fn activation<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        PyArray1::from_iter(py, self.0.points().map(|point| self.0.activation(point)))
    }

    #[getter]
    fn descriptors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u8>>> {
        poses::rows(py, self.0.points().map(|point| point.descriptor.to_bytes()))
    }

    #[getter]
    fn keyframe_ids<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        PyArray1::from_iter(py, self.0.keyframes().map(|keyframe| keyframe.id.0))
    }

    #[getter]
    fn keyframe_frames<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        PyArray1::from_iter(py, self.0.keyframes().map(|keyframe| keyframe.frame.index))
    }

    #[getter]
    fn keyframe_times<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, self.0.keyframes().map(|keyframe| keyframe.frame.timestamp_s))
    }

    #[getter]
    fn keyframe_poses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        poses::matrices(py, self.0.keyframes().map(|keyframe| keyframe.cam_from_world.normalized().inverse()))
    }

    #[getter]
    fn keyframe_submaps<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        let root = |id: KeyframeId| self.0.submap_of(id).unwrap_or(id).0;
        PyArray1::from_iter(py, self.0.keyframes().map(|keyframe| root(keyframe.id)))
    }

    #[getter]
    fn observations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let map = &self.0;
        let keyframes = rows(map.keyframes().map(|keyframe| keyframe.id.0), map.next_keyframe_id().0);
        let points = rows(map.points().map(|point| point.id.0), map.next_point_id().0);
        let mut places = Vec::new();
        let (mut pixels, mut octaves) = (Vec::new(), Vec::new());
        for point in self.0.points() {
            for seen in point.observations() {
                let Some(keyframe) = self.0.keyframe(seen.keyframe) else { continue };
                let (frame, feature) = (&keyframe.frame, seen.feature as usize);
                let keypoint = &frame.keypoints[feature];
                places.push([points[point.id.0 as usize], keyframes[seen.keyframe.0 as usize]]);
                pixels.push([keypoint.x, keypoint.y, frame.right_u[feature]]);
                octaves.push(keypoint.octave);
            }
        }
        let columns = |i: usize| PyArray1::from_iter(py, places.iter().map(|row| row[i]));
        let observations = PyDict::new(py);
        observations.set_item("point", columns(0))?;
        observations.set_item("keyframe", columns(1))?;
        observations.set_item("pixel", poses::rows(py, pixels.iter().map(|p| [p[0], p[1]]))?)?;
        observations.set_item("right_column", PyArray1::from_iter(py, pixels.iter().map(|p| p[2])))?;
        observations.set_item("octave", PyArray1::from_vec(py, octaves))?;
        Ok(observations)
    }

    fn __repr__(&self) -> String {
        format!("Map({} keyframes, {} points)", self.0.n_keyframes(), self.0.n_points())
    }
}
