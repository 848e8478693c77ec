//! Configuration files in temporary folders.

use std::path::PathBuf;

use tempfile::TempDir;

/// A folder that vanishes with the test.
pub(super) struct Folder(TempDir);

impl Folder {
    pub(super) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub(super) fn file(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(super) fn write(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        std::fs::write(self.file(name), content).unwrap();
        self.file(name)
    }

    /// A message with this folder's path replaced by `DIR`.
    pub(super) fn hide(&self, message: impl ToString) -> String {
        message.to_string().replace(self.0.path().to_str().unwrap(), "DIR")
    }
}
