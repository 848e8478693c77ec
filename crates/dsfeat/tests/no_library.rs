//! A library that cannot be used is named, with the command that installs one. A process of its own: the first library that
//! is loaded, or fails to be, serves the whole process.

use std::path::Path;

use dsslam_dsfeat::{BUILT_IN, Error, Network};

fn refused(file: &Path) -> String {
    let error = Network::load(BUILT_IN, Some(file), 1).expect_err("no library");
    let text = error.to_string();
    assert!(matches!(error, Error::BadLibrary { .. }), "{text}");
    text
}

#[test]
fn a_file_that_is_no_onnx_runtime_is_named() {
    let missing = Path::new("/does/not/exist.so");
    assert!(refused(missing).starts_with("/does/not/exist.so: not a usable ONNX Runtime: No such file"));
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
    let text = refused(&manifest);
    assert!(text.starts_with(&manifest.display().to_string()), "{text}");
    assert!(text.contains("pip install") && text.contains("the network runs without it"), "{text}");
    assert_eq!(refused(&manifest), text, "nothing is loaded after a failure");
}
