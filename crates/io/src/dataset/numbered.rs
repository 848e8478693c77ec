//! A folder of images whose names are numbers (`000000.png`), KITTI's layout.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::file::{FileError, entries};
use crate::images::IMAGE_ENDINGS;

/// The numbered images of a folder.
pub(super) struct NumberedImages {
    folder: PathBuf,
    files: BTreeMap<u32, PathBuf>,
    /// How a missing file would be called: digits and extension of the first one.
    digits: usize,
    extension: String,
}

impl NumberedImages {
    /// Lists a folder; a folder that does not exist has no images.
    pub(super) fn list(folder: &Path) -> Result<Self, FileError> {
        let mut images = Self {
            folder: folder.to_path_buf(),
            files: BTreeMap::new(),
            digits: 6,
            extension: "png".to_string(),
        };
        images.files = list_numbered(folder, &IMAGE_ENDINGS)?;
        images.learn_naming();
        Ok(images)
    }

    fn learn_naming(&mut self) {
        if let Some(first) = self.files.values().next() {
            self.digits = first.file_stem().map_or(self.digits, |stem| stem.len());
            if let Some(extension) = first.extension() {
                self.extension = extension.to_string_lossy().into_owned();
            }
        }
    }

    /// Whether there is no image.
    pub(super) fn is_empty(&self) -> bool {
        self.files.is_empty()
    }

    /// Number of images.
    pub(super) fn len(&self) -> usize {
        self.files.len()
    }

    /// The lowest number.
    pub(super) fn first(&self) -> Option<u32> {
        self.files.keys().next().copied()
    }

    /// The highest number.
    pub(super) fn last(&self) -> Option<u32> {
        self.files.keys().next_back().copied()
    }

    /// Whether the image of this number exists.
    pub(super) fn has(&self, number: u32) -> bool {
        self.files.contains_key(&number)
    }

    /// The file of this number, also where it is missing (loading it will say so).
    pub(super) fn path(&self, number: u32) -> PathBuf {
        self.files.get(&number).cloned().unwrap_or_else(|| {
            self.folder.join(format!("{number:0width$}.{}", self.extension, width = self.digits))
        })
    }
}

/// The files of a folder whose names are a number and one of these endings; none where there is no such folder.
pub(super) fn list_numbered(folder: &Path, endings: &[&str]) -> Result<BTreeMap<u32, PathBuf>, FileError> {
    let mut files = BTreeMap::new();
    let mut paths = entries(folder)?;
    // In reverse, so that of two files with one number the first by name wins (000000.jpeg, .jpg, .png).
    paths.sort();
    for path in paths.into_iter().rev() {
        if let Some(number) = number_of(&path, endings) {
            files.insert(number, path);
        }
    }
    Ok(files)
}

/// The number in a file name that consists of digits and one of these endings.
fn number_of(path: &Path, endings: &[&str]) -> Option<u32> {
    let extension = path.extension()?.to_str()?.to_ascii_lowercase();
    let stem = path.file_stem()?.to_str()?;
    let fits = endings.contains(&extension.as_str()) && stem.bytes().all(|byte| byte.is_ascii_digit());
    fits.then(|| stem.parse().ok())?
}
