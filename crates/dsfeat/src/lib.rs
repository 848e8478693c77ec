//! The activation network: rates how likely each image location belongs to the static, distinctive scene (DSFeat, Tian et al.).
//!
//! [`Network`] runs an ONNX model on a gray image and returns a [`features::ActivationMap`]; [`BUILT_IN`] is the
//! built-in model. Only this crate uses ONNX Runtime, which is loaded when a network is: `library.rs` says where it
//! is looked for. With the cargo feature `tract` models run without it, too. `training/` beside `src/` trains the models.

mod error;
mod heat;
mod library;
mod model;
mod models;
mod network;
mod onnx_runtime;
mod resize;
#[cfg(feature = "tract")]
mod tract;

pub use error::{Error, INSTALL};
pub use heat::{Rgb, heat_color, heat_map};
pub use library::{Runner, find_library, runner};
pub use model::{ImageModel, Output};
pub use models::BUILT_IN;
pub use network::{Answers, Network};
