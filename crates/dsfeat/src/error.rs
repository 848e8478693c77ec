//! Reasons why a network cannot run, and what to do about them.

use std::path::PathBuf;

/// How ONNX Runtime is installed, in one command.
pub const INSTALL: &str =
    "python3 -m pip install --no-deps --target ~/.local/share/dsslam onnxruntime==1.24.4";

/// Why there is no network or no activation map.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// The library that was named cannot be used.
    #[error(
        "{}: not a usable ONNX Runtime: {reason}; expected version 1.24 or newer. Install it with\n  {INSTALL}\n\
         or pass another library with --onnxruntime FILE. Where none is named, by --onnxruntime or ORT_DYLIB_PATH, the network runs without it",
        path.display()
    )]
    BadLibrary {
        /// The file.
        path: PathBuf,
        /// What the loader says.
        reason: String,
    },
    /// Not an ONNX model, or one with unknown operators.
    #[error("cannot be used as a model: {0}")]
    BadModel(String),
    /// The model does not run on the built-in engine, which has fewer operators than ONNX Runtime.
    #[error(
        "cannot be used as a model without ONNX Runtime, which was not found and may run it: {0}. Install it with\n  {INSTALL}\n\
         or pass --onnxruntime FILE"
    )]
    NeedsLibrary(String),
    /// The model has other inputs or outputs.
    #[error("cannot be used as a model: {what} is {found}, expected {expected}")]
    WrongShape {
        /// The input or output.
        what: String,
        /// What it is.
        found: String,
        /// What it should be.
        expected: String,
    },
    /// The model did not run.
    #[error("the network failed: {0}")]
    Failed(String),
}
