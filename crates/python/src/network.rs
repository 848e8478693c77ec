//! The activation network, and the library that runs it.

use std::path::PathBuf;
use std::sync::OnceLock;

use dsslam::{Config, NetworkOptions};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;

use crate::error::raised;
use crate::image::{self, Pixels};

/// ONNX Runtime of the Python package, where nothing else names one.
static LIBRARY: OnceLock<PathBuf> = OnceLock::new();

/// Takes the ONNX Runtime in `file` from now on, unless one has been named or loaded already.
#[pyfunction]
pub(crate) fn use_onnxruntime(file: PathBuf) {
    LIBRARY.get_or_init(|| file);
}

/// Which network, and which library runs it.
pub(crate) fn options(model: Option<PathBuf>) -> NetworkOptions {
    let mut options = NetworkOptions::default();
    options.model = model;
    options.library = LIBRARY.get().cloned();
    options
}

/// Activation of an image.
#[pyfunction]
#[pyo3(signature = (image, *, network=None, color="rgb"))]
pub(crate) fn activation<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyAny>,
    network: Option<PathBuf>,
    color: &str,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let image = Pixels::of(image, "image", image::color(color)?)?;
    let view = image.view();
    let map = py.detach(|| {
        let selecting = ["features.selection=activation".to_owned()];
        let settings = Config::load(None, &selecting).map_err(raised)?.features;
        let (network, _) = dsslam::open_network(&settings, &options(network)).map_err(raised)?;
        let answers = network.answers(&view.to_image().map_err(raised)?).map_err(raised)?;
        Ok::<_, PyErr>(answers.map)
    })?;
    let values = map.values();
    PyArray1::from_slice(py, &values.data).reshape([values.height, values.width])
}
