//! Poses as numpy arrays, and back.

use std::convert::Infallible;

use dsslam::SE3;
use geometry::{Mat6, SO3, Vec3};
use numpy::ndarray::{Array1, Array2, ArrayD};
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayDyn, PyArrayMethods, PyReadonlyArray3, ToPyArray};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Numbers that are a numpy array in Python.
#[derive(Clone)]
pub(crate) struct Array(ArrayD<f64>);

impl<'py> IntoPyObject<'py> for Array {
    type Target = PyArrayDyn<f64>;
    type Output = Bound<'py, Self::Target>;
    type Error = Infallible;

    fn into_pyobject(self, py: Python<'py>) -> Result<Self::Output, Self::Error> {
        Ok(self.0.to_pyarray(py))
    }
}

/// A pose as a 4x4 matrix.
pub(crate) fn matrix(pose: &SE3) -> Array {
    let matrix = pose.matrix();
    Array(Array2::from_shape_fn((4, 4), |at| matrix[at]).into_dyn())
}

/// A covariance as a 6x6 matrix.
pub(crate) fn covariance(covariance: &Mat6) -> Array {
    Array(Array2::from_shape_fn((6, 6), |at| covariance[at]).into_dyn())
}

/// A list of numbers.
pub(crate) fn vector(values: &[f64]) -> Array {
    Array(Array1::from_vec(values.to_vec()).into_dyn())
}

/// Poses as an array of shape (N, 4, 4).
pub(crate) fn matrices<'py>(
    py: Python<'py>,
    poses: impl Iterator<Item = SE3>,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    // The numbers of the transposed matrix column by column are those of the matrix row by row.
    let all: Vec<f64> =
        poses.flat_map(|pose| pose.matrix().transpose().data.0.into_iter().flatten()).collect();
    let n = all.len() / 16;
    PyArray1::from_vec(py, all).reshape([n, 4, 4])
}

/// Rows of `N` numbers as an array of shape (rows, N).
pub(crate) fn rows<'py, T: numpy::Element, const N: usize>(
    py: Python<'py>,
    rows: impl Iterator<Item = [T; N]>,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let all: Vec<T> = rows.flatten().collect();
    let n = all.len() / N;
    PyArray1::from_vec(py, all).reshape([n, N])
}

/// The poses of an array of shape (N, 4, 4) or (N, 3, 4).
pub(crate) fn of_array(array: &PyReadonlyArray3<'_, f64>, name: &str) -> PyResult<Vec<SE3>> {
    let view = array.as_array();
    if !matches!(*view.shape(), [_, 3 | 4, 4]) {
        let shape = view.shape();
        return Err(PyValueError::new_err(format!("{name}: found shape {shape:?}, expected (N, 4, 4)")));
    }
    let one = |(i, pose): (usize, numpy::ndarray::ArrayView2<'_, f64>)| {
        let matrix = geometry::Mat3::from_fn(|row, column| pose[(row, column)]);
        let translation = Vec3::new(pose[(0, 3)], pose[(1, 3)], pose[(2, 3)]);
        let is_rotation = (matrix * matrix.transpose() - geometry::Mat3::identity()).norm() < 1e-3;
        if !is_rotation || matrix.determinant() < 0.0 || translation.iter().any(|v| !v.is_finite()) {
            return Err(PyValueError::new_err(format!(
                "{name}: pose {i}: found no rotation, expected world_from_cam"
            )));
        }
        Ok(SE3::new(SO3::from_matrix(&matrix), translation))
    };
    view.outer_iter().enumerate().map(one).collect()
}
