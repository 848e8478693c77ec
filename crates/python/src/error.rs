//! Errors as Python exceptions.

use pyo3::PyErr;
use pyo3::create_exception;
use pyo3::exceptions::PyRuntimeError;

create_exception!(
    dsslam,
    Error,
    PyRuntimeError,
    "What DSSLAM cannot use: a file, a configuration, a camera, a frame. The message says what was found and what was expected."
);

/// An error of the library as `dsslam.Error`.
pub(crate) fn raised(error: impl std::fmt::Display) -> PyErr {
    Error::new_err(error.to_string())
}
