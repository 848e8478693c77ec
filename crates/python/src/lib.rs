//! DSSLAM as a Python module. The package `dsslam` around it (python/dsslam) adds what is easier said in Python.
//!
//! Images are numpy arrays, taken without a copy where their memory allows it; the interpreter's lock is released while images are
//! tracked. Types that Python sees are named as there.

mod arguments;
mod camera;
mod error;
mod evaluate;
mod finished;
mod frame;
mod image;
mod map;
mod network;
mod poses;
mod session;
mod slam;
mod world;

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the program `dsslam` with `arguments`, of which the first is its name; returns its exit code.
#[pyfunction]
fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| cli::main(arguments))
}

#[pymodule]
fn _dsslam(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("Error", py.get_type::<error::Error>())?;
    module.add("PRESETS", dsslam::presets().collect::<Vec<_>>())?;
    module.add_class::<camera::Camera>()?;
    module.add_class::<slam::Slam>()?;
    module.add_class::<frame::Result>()?;
    module.add_class::<finished::Finished>()?;
    module.add_class::<map::Map>()?;
    module.add_class::<session::Stop>()?;
    module.add_class::<world::World>()?;
    module.add_function(wrap_pyfunction!(session::run, module)?)?;
    module.add_function(wrap_pyfunction!(evaluate::evaluate, module)?)?;
    module.add_function(wrap_pyfunction!(network::activation, module)?)?;
    module.add_function(wrap_pyfunction!(network::use_onnxruntime, module)?)?;
    module.add_function(wrap_pyfunction!(main, module)?)?;
    Ok(())
}
