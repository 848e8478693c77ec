//! Networks on ONNX Runtime, or where that is not installed on the built-in engine: known answers of tiny models, the same bits for
//! any number of threads, refusals. `built_in.rs` tests the built-in engine on every machine.

use std::path::Path;

use dsslam_dsfeat::{BUILT_IN, Error, Network};
use features::NetworkSize;
use geometry::GrayImage;

/// Side of the squares over which the test model averages, in pixels of its input.
const SIDE: usize = 4;

/// A model of `data/`, written by `data/make_models.py`.
fn file(name: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name);
    std::fs::read(path).expect("the file is part of the repository")
}

fn image(width: usize, height: usize) -> GrayImage {
    GrayImage::from_fn(width, height, |x, y| ((x * 7 + y * 13 + x * y / 5) % 256) as u8)
}

#[test]
fn the_map_is_what_the_model_computes_of_the_image() {
    let network = Network::load(&file("mean_4.onnx"), None, 1).unwrap();
    assert_eq!(network.input_size(640, 480), (64, 32));
    let image = image(64, 32);
    let map = network.answers(&image).unwrap().map;
    assert_eq!((map.values().width, map.values().height), (16, 8));
    for (column, row) in [(0, 0), (5, 3), (15, 7)] {
        let square = (0..SIDE * SIDE).map(|i| (SIDE * column + i % SIDE, SIDE * row + i / SIDE));
        let sum: f32 = square.map(|(x, y)| f32::from(image.at(x, y))).sum();
        let expected = sum / (SIDE * SIDE) as f32 / 255.0;
        assert!((map.values().at(column, row) - expected).abs() < 1e-5, "{column}, {row}");
        let (x, y) = ((SIDE * column) as f32 + 1.5, (SIDE * row) as f32 + 1.5);
        assert!((map.at(x, y) - expected).abs() < 1e-5, "sampled at the center of the square");
    }
}

#[test]
fn an_image_of_any_size_is_covered_from_corner_to_corner() {
    let network = Network::load(&file("mean_4.onnx"), None, 1).unwrap();
    for (width, height) in [(1241, 376), (640, 480), (20, 10)] {
        let bright_below = GrayImage::from_fn(width, height, |_, y| if y < height / 2 { 0 } else { 255 });
        let map = network.answers(&bright_below).unwrap().map;
        let (x, bottom) = (width as f32 / 3.0, (height - 1) as f32);
        assert!(map.at(x, 0.0) < 1e-5 && map.at(x, bottom) > 1.0 - 1e-5, "{width} x {height}");
    }
}

#[test]
fn the_same_bits_for_any_number_of_threads() {
    let network = Network::load(BUILT_IN, None, 1);
    let image = image(1241, 376);
    let once = network.unwrap().answers(&image).unwrap();
    for threads in [1, 2, 4] {
        let network = Network::load(BUILT_IN, None, threads).unwrap();
        for _ in 0..2 {
            assert!(network.answers(&image).unwrap() == once, "{threads} threads");
        }
    }
}

#[test]
fn the_built_in_model_sees_images_in_their_own_proportions_and_gives_two_answers() {
    let network = Network::load(BUILT_IN, None, 1).unwrap();
    let sizes = [(1241, 376), (640, 480), (752, 480), (100, 400)];
    let inputs = sizes.map(|(width, height)| network.input_size(width, height));
    assert_eq!(inputs, [(416, 128), (272, 192), (272, 192), (112, 464)]);
    for ((width, height), input) in sizes.into_iter().zip(inputs) {
        let answers = network.answers(&image(width, height)).unwrap();
        let map = &answers.map;
        assert_eq!((map.values().width, map.values().height), (input.0 / 2, input.1 / 2));
        assert!(answers.known.is_some_and(|known| (0.0..=1.0).contains(&known)));
        let places =
            (0..width).step_by(9).flat_map(|x| (0..height).step_by(7).map(move |y| (x as f32, y as f32)));
        for (x, y) in places {
            assert!(map.lasting_at(x, y) <= map.at(x, y) + 1e-5, "what moves does not last: {x}, {y}");
        }
    }
    let small = network.with_size(NetworkSize::Small);
    assert_eq!(small.input_size(1241, 376), (320, 96));
    assert_eq!(small.answers(&image(1241, 376)).unwrap().map.values().width, 160);
}

#[test]
fn other_models_are_refused() {
    let first = Network::load(&file("colour.onnx"), None, 1);
    let refusal = |result: Result<Network, Error>| result.unwrap_err().to_string();
    let text = refusal(first);
    assert!(text.starts_with("cannot be used as a model: input image is"), "{text}");
    assert!(text.ends_with("expected a float tensor of shape 1 x 1 x height x width"), "{text}");
    let text = refusal(Network::load(&file("flat.onnx"), None, 1));
    assert!(text.contains("output activation is") && text.contains("1 x 1 x rows x columns"), "{text}");
    let text = refusal(Network::load(&file("two_inputs.onnx"), None, 1));
    assert_eq!(text, "cannot be used as a model: the number of inputs is 2, expected 1");
    let whole = file("mean_4.onnx");
    let text = refusal(Network::load(&whole[..whole.len() / 2], None, 1));
    assert!(text.starts_with("cannot be used as a model: "), "{text}");
    assert!(refusal(Network::load(b"", None, 1)).starts_with("cannot be used as a model: "));
}

#[test]
fn a_map_of_what_is_no_number_is_refused() {
    let network = Network::load(&file("not_a_number.onnx"), None, 1).unwrap();
    assert!(network.answers(&GrayImage::new(64, 32, 9)).is_ok());
    let error = network.answers(&GrayImage::new(64, 32, 0)).unwrap_err().to_string();
    assert!(error.starts_with("the network failed: its output"), "{error}");
    assert!(matches!(network.answers(&GrayImage::default()), Err(Error::Failed(_))));
}
