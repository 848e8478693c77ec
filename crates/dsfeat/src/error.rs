//! Reasons why a network cannot run, and what to do about them.

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
         {INSTALL}\nor pass --onnxruntime FILE; without it, use --set features.selection=response",
        folders.iter().map(|f| f.display().to_string()).collect::<Vec<_>>().join(", ")
    )]
    NoLibrary {
        /// Where it was looked for.
        folders: Vec<PathBuf>,
    },
    /// The library is there but cannot be used.
    #[error(
        "{}: not a usable ONNX Runtime: {reason}; expected version 1.24 or newer. Install it with\n  {INSTALL}\n\
         or pass another library with --onnxruntime FILE; without it, use --set features.selection=response",
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
