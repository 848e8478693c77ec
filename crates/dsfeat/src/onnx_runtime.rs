//! Models as ONNX Runtime runs them.

use std::path::Path;

use ort::session::Session;
use ort::session::builder::GraphOptimizationLevel;
use ort::value::{Outlet, TensorElementType, TensorRef, ValueType};

use crate::error::Error;
use crate::library;
use crate::model::{Output, Port, Ports};

/// A model in ONNX Runtime.
pub(crate) struct Library {
    session: Session,
    pub(crate) ports: Ports,
}

impl Library {
    /// Loads a model; arguments as for [`ImageModel::load`](crate::ImageModel::load). `None` where no library was named and
    /// none that can be used was found.
    ///
    /// # Errors
    /// A library that was named and cannot be used, or no model.
    pub(crate) fn load(model: &[u8], library: Option<&Path>, threads: usize) -> Result<Option<Self>, Error> {
        let Some(environment) = library::environment(library)? else { return Ok(None) };
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
        let ports = |outlets: &[Outlet]| outlets.iter().map(port).collect();
        let ports = Ports { inputs: ports(session.inputs()), outputs: ports(session.outputs()) };
        Ok(Some(Self { session, ports }))
    }

    /// Runs on one tensor of this shape; returns all outputs, in order.
    ///
    /// # Errors
    /// A failure of ONNX Runtime, or an output that does not hold numbers.
    pub(crate) fn run(&mut self, shape: [usize; 4], values: &[f32]) -> Result<Vec<Output>, Error> {
        let failed = |error: ort::Error| Error::Failed(error.to_string());
        let tensor = TensorRef::from_array_view((shape, values)).map_err(failed)?;
        let outputs = self.session.run(ort::inputs![tensor]).map_err(failed)?;
        let output = |(name, value): (&str, ort::value::ValueRef<'_>)| {
            let (shape, values) = value.try_extract_tensor::<f32>().map_err(failed)?;
            let shape = shape.iter().map(|&length| usize::try_from(length).unwrap_or(0)).collect();
            Ok(Output { name: name.to_owned(), shape, values: values.to_vec() })
        };
        outputs.iter().map(output).collect()
    }
}

fn port(outlet: &Outlet) -> Port {
    let shape = match outlet.dtype() {
        ValueType::Tensor { ty: TensorElementType::Float32, shape, .. } => Some(shape.to_vec()),
        _ => None,
    };
    Port { name: outlet.name().to_owned(), shape, text: outlet.dtype().to_string() }
}

fn bad_model<R>(error: ort::Error<R>) -> Error {
    Error::BadModel(error.to_string())
}
