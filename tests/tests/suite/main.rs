//! The test suite of the whole: one program, so that a rendered sequence is shared and linking is paid for once.

mod architecture;

use std::path::{Path, PathBuf};

/// The repository.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}
