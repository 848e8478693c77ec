//! A file that nobody needs: it gives its room back when the disk is full, so that the results find some.

use std::fs::{self, File};
use std::io::{Error, ErrorKind, Result, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The file as its writer sees it.
#[derive(Debug)]
pub(crate) struct YieldingFile {
    file: File,
    room: Room,
}

/// The room that it takes.
#[derive(Clone, Debug)]
pub(crate) struct Room {
    path: PathBuf,
    is_given: Arc<AtomicBool>,
}

impl YieldingFile {
    /// A new file.
    ///
    /// # Errors
    /// When it cannot be made.
    pub(crate) fn create(path: &Path) -> Result<Self> {
        let room = Room { path: path.to_owned(), is_given: Arc::default() };
        Ok(Self { file: File::create(path)?, room })
    }

    /// What can be given back while the file is written.
    pub(crate) fn room(&self) -> Room {
        self.room.clone()
    }
}

impl Write for YieldingFile {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        if self.room.is_given.load(Ordering::Relaxed) {
            return Err(Error::new(ErrorKind::StorageFull, "the disk is full, the results need its room"));
        }
        self.file.write(bytes).inspect_err(|_| self.room.give())
    }

    fn flush(&mut self) -> Result<()> {
        self.file.flush()
    }
}

impl Room {
    /// Removes the file; its writer fails from now on.
    pub(crate) fn give(&self) {
        self.is_given.store(true, Ordering::Relaxed);
        // The blocks are free at once, although the writer still holds the file.
        if let Ok(file) = File::options().write(true).open(&self.path) {
            let _ = file.set_len(0);
        }
        let _ = fs::remove_file(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn room_that_is_given_is_free_and_the_writer_says_why_it_ends() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("events");
        let mut file = YieldingFile::create(&path).unwrap();
        file.write_all(&[7; 1000]).unwrap();
        let room = file.room();
        assert_eq!(fs::metadata(&path).unwrap().len(), 1000);
        room.give();
        assert!(!path.exists());
        let error = file.write_all(b"more").unwrap_err();
        assert_eq!(error.to_string(), "the disk is full, the results need its room");
    }

    /// `/dev/full` refuses every byte, as a full disk does.
    #[test]
    fn a_full_disk_takes_the_file_away() {
        if !Path::new("/dev/full").exists() {
            return;
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("events");
        std::os::unix::fs::symlink("/dev/full", &path).unwrap();
        let mut file = YieldingFile::create(&path).unwrap();
        assert_eq!(file.write_all(b"x").unwrap_err().kind(), ErrorKind::StorageFull);
        assert!(path.symlink_metadata().is_err(), "the link is gone, the device is not");
    }
}
