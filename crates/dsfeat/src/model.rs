//! An ONNX model of images: the same input gives the same bits, for any number of threads. ONNX Runtime runs it, or, where that is
//! not found, the built-in engine.

use std::fmt;
use std::path::Path;

use geometry::GrayImage;

use crate::built_in::BuiltIn;
use crate::error::Error;
use crate::library::Runner;
use crate::onnx_runtime::Library;
use crate::resize::Resizer;

/// A loaded model with its buffers.
pub struct ImageModel {
    engine: Engine,
    resizer: Resizer,
    pixels: Vec<f32>,
}

/// What runs the model.
enum Engine {
    Library(Library),
    BuiltIn(Box<BuiltIn>),
}

/// An input or output as the model describes it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Port {
    pub(crate) name: String,
    /// Length of each dimension, negative where it is left open; `None` for what is not a tensor of floats.
    pub(crate) shape: Option<Vec<i64>>,
    /// Its type in words.
    pub(crate) text: String,
}

/// Inputs and outputs of a model, in order.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Ports {
    pub(crate) inputs: Vec<Port>,
    pub(crate) outputs: Vec<Port>,
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
    /// process decides. Where none is found the model runs on the built-in engine. `threads` is the number of threads of a run in
    /// ONNX Runtime, at least 1; the built-in engine takes one.
    ///
    /// # Errors
    /// A library that was named and cannot be used, no model, or one that does not run on the built-in engine.
    pub fn load(model: &[u8], library: Option<&Path>, threads: usize) -> Result<Self, Error> {
        match Library::load(model, library, threads)? {
            Some(loaded) => Ok(Self::on(Engine::Library(loaded))),
            None => Self::built_in(model),
        }
    }

    /// Loads an ONNX model that runs on the built-in engine.
    ///
    /// # Errors
    /// No model, or one that does not run on the built-in engine.
    pub(crate) fn built_in(model: &[u8]) -> Result<Self, Error> {
        Ok(Self::on(Engine::BuiltIn(Box::new(BuiltIn::load(model)?))))
    }

    fn on(engine: Engine) -> Self {
        Self { engine, resizer: Resizer::default(), pixels: Vec::new() }
    }

    /// What runs the model.
    #[must_use]
    pub fn runner(&self) -> Runner {
        match &self.engine {
            Engine::Library(_) => Runner::OnnxRuntime,
            Engine::BuiltIn(_) => Runner::BuiltIn,
        }
    }

    /// Names of the outputs, in order.
    #[must_use]
    pub fn outputs(&self) -> Vec<&str> {
        self.ports().outputs.iter().map(|output| &*output.name).collect()
    }

    pub(crate) fn ports(&self) -> &Ports {
        match &self.engine {
            Engine::Library(library) => &library.ports,
            Engine::BuiltIn(model) => &model.ports,
        }
    }

    /// Runs on an image of 0 to 1 that is resized to `width` x `height` without regard to its proportions and given in `channels`
    /// equal channels (1 x channels x height x width); returns all outputs, in order.
    ///
    /// # Errors
    /// An empty image, a failure of the model, or an output that does not hold numbers.
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
        let shape = [1, channels, height, width];
        match &mut self.engine {
            Engine::Library(library) => library.run(shape, &self.pixels),
            Engine::BuiltIn(model) => model.run(shape, &self.pixels),
        }
    }
}

impl fmt::Debug for ImageModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "ImageModel({:?})", self.outputs())
    }
}
