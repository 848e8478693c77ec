//! Models without ONNX Runtime: the library tract runs them, on one thread.

use std::sync::Arc;

use tract_onnx::prelude::*;
use tract_onnx::tract_hir::infer::{DimFact, Factoid};

use crate::error::Error;
use crate::model::{Output, Port, Ports};

/// Side of the images for which a model whose input is open is planned when it is loaded, to see whether it can be.
const TRIAL_SIDE: usize = 64;

/// A model in tract, planned for the size of the last image.
pub(crate) struct BuiltIn {
    model: InferenceModel,
    pub(crate) ports: Ports,
    planned: Option<([usize; 4], Plan)>,
}

type Plan = Arc<TypedRunnableModel>;

impl BuiltIn {
    /// Loads a model.
    ///
    /// # Errors
    /// Not an ONNX model, or one with operators that tract does not have.
    pub(crate) fn load(model: &[u8]) -> Result<Self, Error> {
        if model.is_empty() {
            return Err(Error::BadModel("the file is empty".into()));
        }
        let model = tract_onnx::onnx().model_for_read(&mut &*model).map_err(bad_model)?;
        let inputs: Vec<Port> =
            (0..model.inputs.len()).map(|i| input(&model, i)).collect::<Result<_, _>>()?;
        let side = |length: i64| usize::try_from(length).unwrap_or(TRIAL_SIDE);
        let outputs = match &inputs[..] {
            [Port { shape: Some(shape), .. }] if shape.len() == 4 => {
                let typed = typed(&model, [0, 1, 2, 3].map(|i| if i == 0 { 1 } else { side(shape[i]) }))?;
                typed
                    .outputs
                    .iter()
                    .map(|outlet| output(&model, &typed, *outlet))
                    .collect::<Result<_, _>>()?
            }
            _ => Vec::new(),
        };
        Ok(Self { model, ports: Ports { inputs, outputs }, planned: None })
    }

    /// Runs on one tensor of this shape; returns all outputs, in order.
    ///
    /// # Errors
    /// A failure of tract, or an output that does not hold numbers.
    pub(crate) fn run(&mut self, shape: [usize; 4], values: &[f32]) -> Result<Vec<Output>, Error> {
        let plan = match &self.planned {
            Some((planned, plan)) if *planned == shape => plan.clone(),
            _ => {
                let optimized = typed(&self.model, shape)?.into_optimized().map_err(failed)?;
                let plan = optimized.into_runnable().map_err(failed)?;
                self.planned.insert((shape, plan)).1.clone()
            }
        };
        let tensor = Tensor::from_shape(&shape, values).map_err(failed)?;
        let outputs = plan.run(tvec!(tensor.into())).map_err(failed)?;
        let output = |(port, value): (&Port, &TValue)| {
            let values = value.to_plain_array_view::<f32>().map_err(failed)?;
            let shape = value.shape().to_vec();
            Ok(Output { name: port.name.clone(), shape, values: values.iter().copied().collect() })
        };
        self.ports.outputs.iter().zip(&outputs).map(output).collect()
    }
}

/// The model for an input of this shape.
fn typed(model: &InferenceModel, shape: [usize; 4]) -> Result<TypedModel, Error> {
    let model = model.clone().with_input_fact(0, f32::fact(shape).into()).map_err(bad_model)?;
    model.into_typed().map_err(bad_model)
}

fn input(model: &InferenceModel, i: usize) -> Result<Port, Error> {
    let fact = model.input_fact(i).map_err(bad_model)?;
    let is_float = fact.datum_type.concretize() == Some(f32::datum_type());
    let length = |dim: &DimFact| dim.concretize().and_then(|dim| dim.to_i64().ok()).unwrap_or(-1);
    let shape = is_float.then(|| fact.shape.dims().map(length).collect());
    let name = model.node(model.inputs[i].node).name.clone();
    Ok(Port { name, shape, text: format!("{fact:?}") })
}

fn output(model: &InferenceModel, typed: &TypedModel, outlet: OutletId) -> Result<Port, Error> {
    let fact = typed.outlet_fact(outlet).map_err(bad_model)?;
    let is_float = fact.datum_type == f32::datum_type();
    let shape = is_float.then(|| fact.shape.iter().map(|dim| dim.to_i64().unwrap_or(-1)).collect());
    let label = typed.outlet_label(outlet).or_else(|| model.outlet_label(outlet));
    let name = label.map_or_else(|| typed.node(outlet.node).name.clone(), str::to_owned);
    Ok(Port { name, shape, text: format!("{fact:?}") })
}

fn bad_model(error: TractError) -> Error {
    Error::BadModel(format!("{error:#}"))
}

fn failed(error: TractError) -> Error {
    Error::Failed(format!("{error:#}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::BUILT_IN;
    use crate::onnx_runtime::Library;

    fn values(shape: [usize; 4]) -> Vec<f32> {
        (0..shape[2] * shape[3]).map(|i| ((i * 7919 + i / shape[3] * 131) % 256) as f32 / 255.0).collect()
    }

    #[test]
    fn the_built_in_network_answers_as_in_onnx_runtime_but_for_the_last_digits() {
        let mut built_in = BuiltIn::load(BUILT_IN).unwrap();
        let names: Vec<&str> = built_in.ports.outputs.iter().map(|port| &*port.name).collect();
        assert_eq!(names, ["activation", "lasting", "known"]);
        assert!(built_in.ports.outputs.iter().all(|port| port.shape.as_ref().is_some_and(|s| s.len() == 4)));
        // Without the library there is nothing to compare with, but the answers are still probabilities.
        let mut library = Library::load(BUILT_IN, None, 1).ok();
        for shape in [[1, 1, 128, 416], [1, 1, 96, 320], [1, 1, 128, 416]] {
            let values = values(shape);
            let here = built_in.run(shape, &values).unwrap();
            assert_eq!(here[0].shape, [1, 1, shape[2] / 2, shape[3] / 2]);
            assert!(here.iter().flat_map(|output| &output.values).all(|v| (0.0..=1.0).contains(v)));
            let Some(there) = library.as_mut().map(|library| library.run(shape, &values).unwrap()) else {
                continue;
            };
            for (a, b) in here.iter().zip(&there) {
                assert_eq!((&a.name, &a.shape), (&b.name, &b.shape));
                let worst = a.values.iter().zip(&b.values).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                assert!(worst < 1e-5, "{}: {worst}", a.name);
            }
        }
    }

    #[test]
    fn what_is_not_a_model_is_refused() {
        for bytes in [&b""[..], &BUILT_IN[..1000]] {
            assert!(matches!(BuiltIn::load(bytes), Err(Error::BadModel(_))));
        }
    }
}
