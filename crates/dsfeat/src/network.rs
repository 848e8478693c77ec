//! A model, ready to turn images into activation maps.

use std::fmt;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use features::{ActivationError, ActivationMap, ActivationSource, NetworkSize};
use geometry::{GrayImage, Raster};

use crate::error::Error;
use crate::library::Runner;
use crate::model::{ImageModel, Output, Port};

/// Largest side of a network's input.
const MAX_SIDE: usize = 8192;
/// The sides of an input whose size a model leaves open are multiples of this.
const UNIT: f64 = 16.0;
/// Names of the outputs of a model with two answers.
const ACTIVATION: &str = "activation";
const LASTING: &str = "lasting";
const KNOWN: &str = "known";

/// A loaded model with its buffers. The same image gives the same answers, for any number of threads.
pub struct Network {
    input: Input,
    /// Positions of the outputs `activation`, `lasting` and `known`.
    outputs: (usize, Option<usize>, Option<usize>),
    /// One image at a time.
    model: Mutex<ImageModel>,
}

/// Which size a model wants its images in.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Input {
    /// Width and height.
    Fixed(usize, usize),
    /// Any; about as many pixels as this, in the image's own proportions.
    Open(NetworkSize),
}

/// What a network says of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct Answers {
    /// Both answers at each place.
    pub map: ActivationMap,
    /// How sure the network is that it knows such scenes, 0 to 1; where it does not, both answers fade to 1. `None` where the
    /// model does not say.
    pub known: Option<f32>,
}

impl Network {
    /// Loads an ONNX model: one input of shape 1 x 1 x height x width for a gray image of 0 to 1, width and height fixed or left
    /// open; one output of shape 1 x 1 x rows x columns, or outputs `activation`, `lasting` and `known` of which the first
    /// two have that shape and the last one is a single number. `library` and `threads` as for [`ImageModel::load`].
    ///
    /// # Errors
    /// As [`ImageModel::load`], or a model with another input or other outputs.
    pub fn load(model: &[u8], library: Option<&Path>, threads: usize) -> Result<Self, Error> {
        Self::of(ImageModel::load(model, library, threads)?)
    }

    /// The network that a model is, if its input and outputs are those of [`Network::load`].
    ///
    /// # Errors
    /// Another input or other outputs.
    pub(crate) fn of(model: ImageModel) -> Result<Self, Error> {
        let ports = model.ports();
        let [input] = &ports.inputs[..] else {
            return Err(wrong("the number of inputs", ports.inputs.len(), "1"));
        };
        let input = image_input(input)?;
        let find = |name: &str| ports.outputs.iter().position(|output| output.name == name);
        let outputs = match &ports.outputs[..] {
            [_] => (0, None, None),
            several => {
                let activation = find(ACTIVATION).ok_or_else(|| {
                    wrong("the number of outputs", several.len(), "1, or activation, lasting and known")
                })?;
                (activation, find(LASTING), find(KNOWN))
            }
        };
        [Some(outputs.0), outputs.1]
            .into_iter()
            .flatten()
            .try_for_each(|i| check_output(&ports.outputs[i]))?;
        Ok(Self { input, outputs, model: Mutex::new(model) })
    }

    /// What runs the network.
    #[must_use]
    pub fn runner(&self) -> Runner {
        self.model.lock().unwrap_or_else(PoisonError::into_inner).runner()
    }

    /// The same with images of this size, if the model leaves it open.
    #[must_use]
    pub fn with_size(mut self, size: NetworkSize) -> Self {
        if let Input::Open(open) = &mut self.input {
            *open = size;
        }
        self
    }

    /// Width and height that an image of `width` x `height` pixels is resized to.
    #[must_use]
    pub fn input_size(&self, width: usize, height: usize) -> (usize, usize) {
        let size = match self.input {
            Input::Fixed(width, height) => return (width, height),
            Input::Open(size) => size.pixels() as f64,
        };
        let side = |pixels: f64| (UNIT * (pixels / UNIT).round()).clamp(UNIT, MAX_SIDE as f64);
        let rows = side((size * height.max(1) as f64 / width.max(1) as f64).sqrt());
        (side(size / rows) as usize, rows as usize)
    }

    /// What the network says of an image of any size. The image is resized to the network's input without regard to its
    /// proportions, which an input of open size follows.
    ///
    /// # Errors
    /// An empty image, a failure of the model, or an output that is not a map.
    pub fn answers(&self, image: &GrayImage) -> Result<Answers, Error> {
        let mut model = self.model.lock().unwrap_or_else(PoisonError::into_inner);
        let size = self.input_size(image.width, image.height);
        let mut outputs = model.run(image, size, 1)?;
        let (activation, lasting, known) = self.outputs;
        let known = known.and_then(|i| outputs[i].values.first().copied());
        let lasting = lasting.map(|i| raster(&mut outputs[i])).transpose()?;
        let map = ActivationMap::new(raster(&mut outputs[activation])?, image.width, image.height);
        let map = map.and_then(|map| match lasting {
            Some(lasting) => map.with_lasting(lasting),
            None => Some(map),
        });
        let map = map.ok_or_else(|| not_a_map(&outputs[activation].shape))?;
        Ok(Answers { map, known })
    }
}

/// The map in an output, which loses its values.
fn raster(output: &mut Output) -> Result<Raster<f32>, Error> {
    let values = std::mem::take(&mut output.values);
    let map = match output.shape[..] {
        [1, 1, rows, columns] => Raster::from_vec(columns, rows, values),
        _ => None,
    };
    map.ok_or_else(|| not_a_map(&output.shape))
}

fn not_a_map(shape: &[usize]) -> Error {
    Error::Failed(format!("its output has shape {shape:?}, expected 1 x 1 x rows x columns of numbers"))
}

impl ActivationSource for Network {
    fn activation(&self, image: &GrayImage) -> Result<ActivationMap, ActivationError> {
        self.answers(image).map(|answers| answers.map).map_err(|error| match error {
            Error::Failed(reason) => ActivationError::Failed(reason),
            other => ActivationError::Failed(other.to_string()),
        })
    }
}

impl fmt::Debug for Network {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Network({:?})", self.input)
    }
}

/// The size that an input of shape 1 x 1 x height x width wants.
fn image_input(input: &Port) -> Result<Input, Error> {
    let side = |length: i64| usize::try_from(length).ok().filter(|side| (1..=MAX_SIDE).contains(side));
    let found = match input.shape.as_deref() {
        Some([1, 1, ..0, ..0]) => Some(Input::Open(NetworkSize::default())),
        Some(&[1, 1, height, width]) => side(width).zip(side(height)).map(|(w, h)| Input::Fixed(w, h)),
        _ => None,
    };
    let expected = "a float tensor of shape 1 x 1 x height x width";
    found.ok_or_else(|| wrong(&format!("input {}", input.name), &input.text, expected))
}

/// Checks that an output is a tensor of four dimensions.
fn check_output(output: &Port) -> Result<(), Error> {
    match &output.shape {
        Some(shape) if shape.len() == 4 => Ok(()),
        _ => Err(wrong(
            &format!("output {}", output.name),
            &output.text,
            "a float tensor of shape 1 x 1 x rows x columns",
        )),
    }
}

fn wrong(what: &str, found: impl fmt::Display, expected: &str) -> Error {
    Error::WrongShape { what: what.into(), found: found.to_string(), expected: expected.into() }
}
