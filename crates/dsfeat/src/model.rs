//! An ONNX model of images as ONNX Runtime runs it: the same input gives the same bits, for any number of threads.

use std::fmt;
use std::path::Path;

use geometry::GrayImage;
use ort::session::Session;
use ort::session::builder::GraphOptimizationLevel;
use ort::value::TensorRef;

use crate::error::Error;
use crate::library;
use crate::resize::Resizer;

/// A loaded model with its buffers.
pub struct ImageModel {
    session: Session,
    resizer: Resizer,
    pixels: Vec<f32>,
}

/// A tensor that a model gives.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// Its name.
    pub name: String,
    /// Length of each dimension.
    pub shape: Vec<usize>,
    /// Its numbers, the last dimension innermost.
    pub values: Vec<f32>,
}

impl ImageModel {
    /// Loads an ONNX model. `library` is the file of ONNX Runtime, by default the first one found; the first model of the
    /// process decides. `threads` is the number of threads of a run, at least 1.
    ///
    /// # Errors
    /// No library that can be used, or no model.
    pub fn load(model: &[u8], library: Option<&Path>, threads: usize) -> Result<Self, Error> {
        let environment = library::environment(library)?;
        let session = Session::builder(&environment)
            .map_err(bad_model)?
            .with_optimization_level(GraphOptimizationLevel::All)
            .map_err(bad_model)?
            .with_intra_threads(threads.max(1))
            .map_err(bad_model)?
            .with_intra_op_spinning(false)
            .map_err(bad_model)?
            .with_deterministic_compute(true)
            .map_err(bad_model)?
            .commit_from_memory(model)
            .map_err(bad_model)?;
        Ok(Self { session, resizer: Resizer::default(), pixels: Vec::new() })
    }

    /// Names of the outputs, in order.
    #[must_use]
    pub fn outputs(&self) -> Vec<&str> {
        self.session.outputs().iter().map(|output| output.name()).collect()
    }

    pub(crate) fn session(&self) -> &Session {
        &self.session
    }

    /// Runs on an image of 0 to 1 that is resized to `width` x `height` without regard to its proportions and given in `channels`
    /// equal channels (1 x channels x height x width); returns all outputs, in order.
    ///
    /// # Errors
    /// An empty image, a failure of ONNX Runtime, or an output that does not hold numbers.
    pub fn run(
        &mut self,
        image: &GrayImage,
        (width, height): (usize, usize),
        channels: usize,
    ) -> Result<Vec<Output>, Error> {
        if image.data.is_empty() {
            return Err(Error::Failed("the image is empty".into()));
        }
        self.resizer.run(image, width, height, &mut self.pixels);
        for _ in 1..channels {
            self.pixels.extend_from_within(..width * height);
        }
        let failed = |error: ort::Error| Error::Failed(error.to_string());
        let tensor =
            TensorRef::from_array_view(([1, channels, height, width], &self.pixels[..])).map_err(failed)?;
        let outputs = self.session.run(ort::inputs![tensor]).map_err(failed)?;
        let output = |(name, value): (&str, ort::value::ValueRef<'_>)| {
            let (shape, values) = value.try_extract_tensor::<f32>().map_err(failed)?;
            let shape = shape.iter().map(|&length| usize::try_from(length).unwrap_or(0)).collect();
            Ok(Output { name: name.to_owned(), shape, values: values.to_vec() })
        };
        outputs.iter().map(output).collect()
    }
}

impl fmt::Debug for ImageModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "ImageModel({:?})", self.outputs())
    }
}

fn bad_model<R>(error: ort::Error<R>) -> Error {
    Error::BadModel(error.to_string())
}
