//! What can keep a network from running, with the way out.

use std::path::PathBuf;

/// How ONNX Runtime is installed, in one command.
pub const INSTALL: &str =
    "python3 -m pip install --no-deps --target ~/.local/share/dsslam onnxruntime==1.24.4";

/// Why there is no network or no activation map.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// The library is nowhere.
    #[error(
        "ONNX Runtime (libonnxruntime.so, 1.24 or newer) was found neither beside the program nor in {}. Install it with\n  \
         {INSTALL}\nor give it with --onnxruntime FILE; without it --set features.selection=response works",
        folders.iter().map(|f| f.display().to_string()).collect::<Vec<_>>().join(", ")
    )]
    NoLibrary {
        /// Where it was looked for.
        folders: Vec<PathBuf>,
    },
    /// The library is there but cannot be used.
    #[error(
        "{}: is no usable ONNX Runtime: {reason}; expected version 1.24 or newer. Install it with\n  {INSTALL}\n\
         or give another with --onnxruntime FILE; without it --set features.selection=response works",
        path.display()
    )]
    BadLibrary {
        /// The file.
        path: PathBuf,
        /// What the loader says.
        reason: String,
    },
    /// The model is no ONNX model, or uses operators that are not there.
    #[error("cannot be used as a model: {0}")]
    BadModel(String),
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
