//! The built-in models; `models/README.md` says how they were trained.

/// A model of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    /// Trained with the hybrid loss: semantic labels first, matching later.
    Hybrid,
    /// Trained with the semantic loss alone: the paper's baseline.
    Semantic,
}

impl Model {
    /// The model as an ONNX file.
    #[must_use]
    pub fn bytes(self) -> &'static [u8] {
        match self {
            Model::Hybrid => include_bytes!("../models/dsfeat_hybrid.onnx"),
            Model::Semantic => include_bytes!("../models/dsfeat_semantic.onnx"),
        }
    }
}
