//! The activation network: rates how likely each image location belongs to the static, distinctive scene (DSFeat, Tian et al.).
//!
//! [`Network`] runs an ONNX model on a gray image and returns a [`features::ActivationMap`]; [`BUILT_IN`] is the
//! built-in model. ONNX Runtime runs it where that is found (`library.rs` says where it is looked for), else the library rten,
//! which is part of the program and several times slower. Only this crate uses either. `training/` beside `src/` trains the models.

mod built_in;
mod error;
mod heat;
mod library;
mod model;
mod models;
mod network;
mod onnx_runtime;
mod resize;

pub use error::{Error, INSTALL};
pub use heat::{Rgb, heat_color, heat_map};
pub use library::{Runner, find_library, runner};
pub use model::{ImageModel, Output};
pub use models::BUILT_IN;
pub use network::{Answers, Network};
