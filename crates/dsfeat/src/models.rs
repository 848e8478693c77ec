//! The built-in model; `models/README.md` says how it was trained.

/// The model as an ONNX file: one gray image in, both answers out.
pub const BUILT_IN: &[u8] = include_bytes!("../models/dsfeat.onnx");
