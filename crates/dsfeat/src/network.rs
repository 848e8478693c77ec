//! A model, ready to turn images into activation maps.

use std::fmt;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use features::{ActivationError, ActivationMap, ActivationSource};
use geometry::{GrayImage, Raster};
use ort::value::{Outlet, TensorElementType, ValueType};

use crate::error::Error;
use crate::model::ImageModel;

/// Largest side of a network's input.
const MAX_SIDE: usize = 8192;

/// A loaded model with its buffers. The same image gives the same map, for any number of threads.
pub struct Network {
    width: usize,
    height: usize,
    /// One image at a time.
    model: Mutex<ImageModel>,
}

impl Network {
    /// Loads an ONNX model: one input of shape 1 x 1 x height x width for a gray image of 0 to 1, one output of shape
    /// 1 x 1 x rows x columns. `library` and `threads` as for [`ImageModel::load`].
    ///
    /// # Errors
    /// No library that can be used, no model, or one with another input or output.
    pub fn load(model: &[u8], library: Option<&Path>, threads: usize) -> Result<Self, Error> {
        let model = ImageModel::load(model, library, threads)?;
        let session = model.session();
        let [input] = session.inputs() else {
            return Err(wrong("the number of inputs", session.inputs().len(), "1"));
        };
        let [output] = session.outputs() else {
            return Err(wrong("the number of outputs", session.outputs().len(), "1"));
        };
        let (width, height) = image_size(input)?;
        check_output(output)?;
        Ok(Self { width, height, model: Mutex::new(model) })
    }

    /// Width and height of the network's input, pixels.
    #[must_use]
    pub fn input_size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// The activation map of an image of any size; the image is resized to the network's input without regard to its
    /// proportions.
    ///
    /// # Errors
    /// An empty image, a failure of ONNX Runtime, or an output that is not a map.
    pub fn activation(&self, image: &GrayImage) -> Result<ActivationMap, Error> {
        let mut model = self.model.lock().unwrap_or_else(PoisonError::into_inner);
        let output = model.run(image, (self.width, self.height), 1)?.swap_remove(0);
        let map = match output.shape[..] {
            [1, 1, rows, columns] => Raster::from_vec(columns, rows, output.values),
            _ => None,
        };
        map.and_then(|map| ActivationMap::new(map, image.width, image.height)).ok_or_else(|| {
            let shape = &output.shape;
            Error::Failed(format!("its output has shape {shape:?}, expected 1 x 1 x rows x columns"))
        })
    }
}

impl ActivationSource for Network {
    fn activation(&self, image: &GrayImage) -> Result<ActivationMap, ActivationError> {
        Network::activation(self, image).map_err(|error| match error {
            Error::Failed(reason) => ActivationError::Failed(reason),
            other => ActivationError::Failed(other.to_string()),
        })
    }
}

impl fmt::Debug for Network {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Network({} x {})", self.width, self.height)
    }
}

/// Width and height of an input of shape 1 x 1 x height x width.
fn image_size(input: &Outlet) -> Result<(usize, usize), Error> {
    let side = |length: i64| usize::try_from(length).ok().filter(|side| (1..=MAX_SIDE).contains(side));
    let size = match input.dtype() {
        ValueType::Tensor { ty: TensorElementType::Float32, shape, .. } => match **shape {
            [1, 1, height, width] => side(width).zip(side(height)),
            _ => None,
        },
        _ => None,
    };
    size.ok_or_else(|| {
        wrong(
            &format!("input {}", input.name()),
            input.dtype(),
            "a float tensor of shape 1 x 1 x height x width",
        )
    })
}

/// Checks that an output is a tensor of four dimensions.
fn check_output(output: &Outlet) -> Result<(), Error> {
    match output.dtype() {
        ValueType::Tensor { ty: TensorElementType::Float32, shape, .. } if shape.len() == 4 => Ok(()),
        other => Err(wrong(
            &format!("output {}", output.name()),
            other,
            "a float tensor of shape 1 x 1 x rows x columns",
        )),
    }
}

fn wrong(what: &str, found: impl fmt::Display, expected: &str) -> Error {
    Error::WrongShape { what: what.into(), found: found.to_string(), expected: expected.into() }
}
