//! An ONNX model of images: the same input gives the same bits, for any number of threads. ONNX Runtime runs it, or, where that is
//! not found, what the cargo feature `tract` builds in.

use std::fmt;
use std::path::Path;

use geometry::GrayImage;

use crate::error::Error;
use crate::onnx_runtime::Library;
use crate::resize::Resizer;
#[cfg(feature = "tract")]
use crate::tract::BuiltIn;

/// A loaded model with its buffers.
pub struct ImageModel {
    engine: Engine,
    resizer: Resizer,
    pixels: Vec<f32>,
}

/// What runs the model.
enum Engine {
    Library(Library),
    #[cfg(feature = "tract")]
    BuiltIn(BuiltIn),
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
    /// process decides. `threads` is the number of threads of a run, at least 1.
    ///
    /// # Errors
    /// No library that can be used, or no model.
    pub fn load(model: &[u8], library: Option<&Path>, threads: usize) -> Result<Self, Error> {
        let engine = match Library::load(model, library, threads) {
            Ok(loaded) => Engine::Library(loaded),
            #[cfg(feature = "tract")]
            Err(Error::NoLibrary { .. }) => Engine::BuiltIn(BuiltIn::load(model)?),
            Err(error) => return Err(error),
        };
        Ok(Self { engine, resizer: Resizer::default(), pixels: Vec::new() })
    }

    /// Names of the outputs, in order.
    #[must_use]
    pub fn outputs(&self) -> Vec<&str> {
        self.ports().outputs.iter().map(|output| &*output.name).collect()
    }

    pub(crate) fn ports(&self) -> &Ports {
        match &self.engine {
            Engine::Library(library) => &library.ports,
            #[cfg(feature = "tract")]
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
            #[cfg(feature = "tract")]
            Engine::BuiltIn(model) => model.run(shape, &self.pixels),
        }
    }
}

impl fmt::Debug for ImageModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "ImageModel({:?})", self.outputs())
    }
}
