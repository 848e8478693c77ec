//! Models without ONNX Runtime: the library rten, which is part of the program, runs them, on one thread.

use std::sync::Arc;
use std::thread;

use rten::{
    DataType, Dimension, LoadErrorKind, Model, ModelOptions, NodeId, RunOptions, ThreadPool, Value, ValueType,
};
use rten_tensor::prelude::*;
use rten_tensor::{NdTensorView, TensorView};

use crate::error::Error;
use crate::model::{Output, Port, Ports};

/// Side of the image on which a model whose input is open is tried when it is loaded, to see whether it runs.
const TRIAL_SIDE: usize = 128;

/// A model in rten with a thread of its own: with several the last digits depend on their number.
pub(crate) struct BuiltIn {
    model: Model,
    thread: Arc<ThreadPool>,
    pub(crate) ports: Ports,
}

impl BuiltIn {
    /// Loads a model and, if it takes one image, tries it.
    ///
    /// # Errors
    /// Not an ONNX model, or one that rten does not run.
    pub(crate) fn load(model: &[u8]) -> Result<Self, Error> {
        if model.is_empty() {
            return Err(Error::BadModel("the file is empty".into()));
        }
        let model =
            ModelOptions::with_all_ops().load(model.to_vec()).map_err(|error| match error.kind() {
                LoadErrorKind::ParseError | LoadErrorKind::UnknownFileType => {
                    Error::BadModel(error.to_string())
                }
                _ => Error::NeedsLibrary(error.to_string()),
            })?;
        let ports = |ids: &[NodeId]| ids.iter().map(|id| port(&model, *id)).collect::<Vec<Port>>();
        let ports = Ports { inputs: ports(model.input_ids()), outputs: ports(model.output_ids()) };
        let mut loaded = Self { model, thread: Arc::new(ThreadPool::with_num_threads(1)), ports };
        loaded.try_once()?;
        Ok(loaded)
    }

    /// Runs the model on a black image, if one image is what it takes, and notes the outputs whose shape it leaves open.
    fn try_once(&mut self) -> Result<(), Error> {
        let [Port { shape: Some(shape), .. }] = &self.ports.inputs[..] else { return Ok(()) };
        let &[_, channels @ (1..), height, width] = &shape[..] else { return Ok(()) };
        let side = |length: i64| usize::try_from(length).unwrap_or(TRIAL_SIDE);
        let shape = [1, side(channels), side(height), side(width)];
        let values = self.values(shape, &vec![0.0; shape.iter().product()]).map_err(Error::NeedsLibrary)?;
        for (port, value) in self.ports.outputs.iter_mut().zip(&values) {
            port.text = format!("{} of shape {:?}", value.dtype(), value.shape().to_vec());
            let lengths = value.shape().iter().map(|&n| n as i64).collect();
            let is_float = value.dtype() == ValueType::Tensor(DataType::Float);
            port.shape = is_float.then(|| port.shape.take().unwrap_or(lengths));
        }
        Ok(())
    }

    /// Runs on one tensor of this shape; returns all outputs, in order.
    ///
    /// # Errors
    /// A failure of rten, or an output that does not hold numbers.
    pub(crate) fn run(&mut self, shape: [usize; 4], values: &[f32]) -> Result<Vec<Output>, Error> {
        let found = self.values(shape, values).map_err(Error::Failed)?;
        let output = |(port, value): (&Port, Value)| {
            let values =
                TensorView::<f32>::try_from(&value).map_err(|error| Error::Failed(error.to_string()))?;
            Ok(Output { name: port.name.clone(), shape: values.shape().to_vec(), values: values.to_vec() })
        };
        self.ports.outputs.iter().zip(found).map(output).collect()
    }

    fn values(&self, shape: [usize; 4], values: &[f32]) -> Result<Vec<Value>, String> {
        let run = || {
            let inputs = vec![(self.model.input_ids()[0], NdTensorView::from_data(shape, values).into())];
            let options = RunOptions::default().with_thread_pool(Some(Arc::clone(&self.thread)));
            self.model.run(inputs, self.model.output_ids(), Some(options)).map_err(|error| error.to_string())
        };
        // A thread of rayon that waits for rten's would meanwhile take up other work, with its caller's locks held. This one waits.
        thread::scope(|scope| scope.spawn(run).join()).unwrap_or_else(|_| Err("rten panicked".into()))
    }
}

/// An input or output as the model's file describes it.
fn port(model: &Model, id: NodeId) -> Port {
    let node = model.node_info(id);
    let dtype = node.as_ref().and_then(|node| node.dtype());
    let shape = node.as_ref().and_then(|node| node.shape()).map(|dims| {
        let length = |dim: &Dimension| match dim {
            Dimension::Fixed(length) => *length as i64,
            Dimension::Symbolic(_) => -1,
        };
        dims.iter().map(length).collect::<Vec<i64>>()
    });
    let name = node.as_ref().and_then(|node| node.name()).unwrap_or_default().to_owned();
    let kind = dtype.map_or_else(|| "a value of unknown type".to_owned(), |dtype| dtype.to_string());
    let text = shape.as_ref().map_or_else(|| kind.clone(), |shape| format!("{kind} of shape {shape:?}"));
    let is_float = dtype.is_none_or(|dtype| dtype == ValueType::Tensor(DataType::Float));
    Port { name, shape: shape.filter(|_| is_float), text }
}

#[cfg(test)]
#[allow(clippy::print_stdout, reason = "a skipped test says so")]
mod tests {
    use std::path::Path;

    use features::{Extractor, ExtractorConfig, SelectionConfig, SelectionRule, Spread};
    use geometry::GrayImage;
    use rayon::prelude::*;

    use super::*;
    use crate::library::Runner;
    use crate::model::ImageModel;
    use crate::models::BUILT_IN;
    use crate::network::Network;
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
        let mut library = Library::load(BUILT_IN, None, 1).unwrap();
        let mut first = None;
        for shape in [[1, 1, 128, 416], [1, 1, 96, 320], [1, 1, 128, 416]] {
            let values = values(shape);
            let here = built_in.run(shape, &values).unwrap();
            assert_eq!(here[0].shape, [1, 1, shape[2] / 2, shape[3] / 2]);
            assert!(here.iter().flat_map(|output| &output.values).all(|v| (0.0..=1.0).contains(v)));
            if shape[2] == 128 {
                assert!(
                    *first.get_or_insert_with(|| here.clone()) == here,
                    "the same bits whatever ran before"
                );
            }
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
    fn threads_of_rayon_wait_without_taking_up_other_work() {
        let network = network(BUILT_IN).unwrap();
        let image = GrayImage::from_fn(640, 480, |x, y| ((x * 7 + y * 13 + x * y / 5) % 256) as u8);
        let expected = network.answers(&image).unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        // A thread that took up another evaluation while it waits would wait for itself.
        let same = pool.install(|| {
            (0..12).into_par_iter().map(|_| network.answers(&image).unwrap() == expected).collect::<Vec<_>>()
        });
        assert_eq!(same, [true; 12]);
    }

    /// Folders of real frames, and which frames.
    const FRAMES: [(&str, [usize; 2]); 7] = [
        ("kitti03_first400/image_0", [30, 300]),
        ("kitti06_first51/image_0", [5, 40]),
        ("kittiraw_0005/image_0", [20, 120]),
        ("kittiraw_1405/image_0", [10, 60]),
        ("tum_fr1_desk/rgb", [50, 400]),
        ("boofcv_library/left", [10, 40]),
        ("euroc_MH01_200/mav0/cam0/data", [20, 150]),
    ];

    /// A model of the integration tests.
    fn file(name: &str) -> Vec<u8> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name);
        std::fs::read(path).unwrap()
    }

    fn network(model: &[u8]) -> Result<Network, Error> {
        Network::of(ImageModel::built_in(model)?)
    }

    #[test]
    fn the_map_is_what_the_model_computes_of_the_image() {
        let network = network(&file("mean_4.onnx")).unwrap();
        let image = GrayImage::from_fn(64, 32, |x, y| ((x * 7 + y * 13 + x * y / 5) % 256) as u8);
        let map = network.answers(&image).unwrap().map;
        assert_eq!((map.values().width, map.values().height), (16, 8));
        for (column, row) in [(0, 0), (5, 3), (15, 7)] {
            let square = (0..16).map(|i| f32::from(image.at(4 * column + i % 4, 4 * row + i / 4)));
            let expected = square.sum::<f32>() / 16.0 / 255.0;
            assert!((map.values().at(column, row) - expected).abs() < 1e-5, "{column}, {row}");
        }
    }

    #[test]
    fn what_is_no_network_is_refused() {
        for bytes in [&b""[..], &BUILT_IN[..1000]] {
            assert!(matches!(network(bytes), Err(Error::BadModel(_))));
        }
        let refusal = |name: &str| network(&file(name)).unwrap_err().to_string();
        for (name, what) in [
            ("colour.onnx", "input image is tensor(f32) of shape [1, 3, 32, 64]"),
            ("flat.onnx", "output activation is tensor(f32) of shape [1, 2048]"),
            ("two_inputs.onnx", "the number of inputs is 2, expected 1"),
        ] {
            let text = refusal(name);
            assert!(text.starts_with(&format!("cannot be used as a model: {what}")), "{text}");
        }
        let network = network(&file("not_a_number.onnx")).unwrap();
        let error = network.answers(&GrayImage::new(64, 32, 0)).unwrap_err().to_string();
        assert!(error.starts_with("the network failed: its output"), "{error}");
    }

    #[test]
    fn both_engines_lead_to_the_same_choice_of_features_on_real_frames() {
        let library = Network::load(BUILT_IN, None, 1).unwrap();
        let data = std::env::var_os("DSSLAM_DATA").filter(|_| library.runner() == Runner::OnnxRuntime);
        let Some(data) = data else {
            println!("skipped: ONNX Runtime or DSSLAM_DATA is missing");
            return;
        };
        let built_in = network(BUILT_IN).unwrap();
        let selecting = SelectionRule::Activation;
        let mut extractor =
            Extractor::new(ExtractorConfig { keep: 500, selection: selecting, ..Default::default() });
        let rule = SelectionConfig { rule: selecting, keep: 500, spread: Spread::Cells };
        let (mut n_frames, mut worst) = (0, 0.0_f32);
        for (folder, indices) in FRAMES {
            let Ok(entries) = std::fs::read_dir(Path::new(&data).join(folder)) else {
                println!("skipped: DSSLAM_DATA has no {folder}");
                continue;
            };
            let mut files: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
            files.sort();
            for i in indices {
                let image = io::load_gray(&files[i]).unwrap();
                let [here, there] = [&built_in, &library].map(|network| network.answers(&image).unwrap().map);
                let [kept, expected] = [&here, &there]
                    .map(|map| extractor.extract_selected(&image, &rule, map).unwrap().features.keypoints);
                assert!(kept.len() == 500 && kept == expected, "{folder}, frame {i}");
                let differences =
                    here.values().data.iter().zip(&there.values().data).map(|(a, b)| (a - b).abs());
                worst = differences.fold(worst, f32::max);
                n_frames += 1;
            }
        }
        assert!(n_frames > 0, "DSSLAM_DATA has none of the sequences");
        println!("{n_frames} frames, largest difference {worst:e}");
    }

    #[test]
    fn a_model_with_an_operator_that_only_onnx_runtime_has_says_so() {
        let text = network(&file("normalized.onnx")).unwrap_err().to_string();
        assert!(
            text.contains("LRN") && text.contains("ONNX Runtime, which was not found and may run it"),
            "{text}"
        );
        assert!(text.contains("pip install") && text.contains("--onnxruntime FILE"), "{text}");
        if let Some(mut library) = Library::load(&file("normalized.onnx"), None, 1).unwrap() {
            assert_eq!(library.run([1, 1, 32, 64], &[0.5; 2048]).unwrap()[0].shape, [1, 1, 8, 16]);
        }
    }
}
