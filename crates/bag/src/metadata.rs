//! The files of a bag: one file, or a rosbag2 folder with its `metadata.yaml`.

use std::fs::File;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use serde::Deserialize;
use tempfile::TempPath;

use crate::error::BagError;
use crate::mcap_file::{self, McapFile};
use crate::ros1_file::{self, Ros1File};
use crate::sqlite_file::{self, SqliteFile};
use crate::storage::{Storage, ZSTD};

/// Endings of the files of a bag.
const ENDINGS: [&str; 3] = ["db3", "mcap", "bag"];
/// What describes a folder of rosbag2.
const METADATA: &str = "metadata.yaml";
/// Bytes that tell the kind of a file.
const HEAD: u64 = 16;

/// What `metadata.yaml` tells that is of use here.
#[derive(Deserialize, Default)]
struct Information {
    #[serde(default)]
    relative_file_paths: Vec<String>,
    #[serde(default)]
    compression_mode: String,
}

#[derive(Deserialize, Default)]
struct Metadata {
    #[serde(default)]
    rosbag2_bagfile_information: Information,
}

/// The opened files of a bag, in their order, and the unpacked copies that are removed in the end.
pub(crate) struct Files {
    pub(crate) storages: Vec<Box<dyn Storage>>,
    pub(crate) copies: Vec<TempPath>,
    pub(crate) remarks: Vec<String>,
}

/// Whether a path is a bag by its name, or a folder with one and without further folders, as rosbag2 makes them.
pub fn is_bag(path: &Path) -> bool {
    if !path.is_dir() {
        return is_named(path) && path.is_file();
    }
    let mut entries = std::fs::read_dir(path).into_iter().flatten().flatten();
    let has_files = !files_in(path).is_empty() || is_described(path);
    has_files && !entries.any(|entry| entry.path().is_dir())
}

/// Whether a folder is one of rosbag2 by its `metadata.yaml`, even if its files are missing.
fn is_described(folder: &Path) -> bool {
    let text = std::fs::read_to_string(folder.join(METADATA)).unwrap_or_default();
    text.contains("rosbag2_bagfile_information")
}

fn is_named(path: &Path) -> bool {
    let name = path.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
    let name = name.strip_suffix(".zstd").unwrap_or(&name);
    ENDINGS.iter().any(|ending| name.strip_suffix(ending).is_some_and(|stem| stem.ends_with('.')))
}

/// The bag files of a folder, by name.
fn files_in(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut files: Vec<PathBuf> = entries.filter(|path| path.is_file() && is_named(path)).collect();
    files.sort();
    files
}

/// Opens a bag.
///
/// # Errors
/// No bag, or a file that cannot be read.
pub(crate) fn open(path: &Path) -> Result<Files, BagError> {
    let mut files = Files { storages: Vec::new(), copies: Vec::new(), remarks: Vec::new() };
    if !path.is_dir() {
        files.add(path, false)?;
        return Ok(files);
    }
    let (named, is_packed) = listed(path, &mut files.remarks);
    let all = if named.is_empty() { files_in(path) } else { named };
    if all.is_empty() {
        return Err(BagError::NotABag {
            path: path.to_path_buf(),
            found: "a folder without bag files".to_owned(),
        });
    }
    for file in all {
        if file.is_file() {
            files.add(&file, is_packed)?;
        } else {
            files.remarks.push(format!("{}: missing, although metadata.yaml names it", file.display()));
        }
    }
    if files.storages.is_empty() {
        let found = format!("no file that can be read ({})", files.remarks.join("; "));
        return Err(BagError::NotABag { path: path.to_path_buf(), found });
    }
    Ok(files)
}

/// The files that `metadata.yaml` names, and whether messages are packed one by one.
fn listed(folder: &Path, remarks: &mut Vec<String>) -> (Vec<PathBuf>, bool) {
    let file = folder.join(METADATA);
    let Ok(text) = std::fs::read_to_string(&file) else { return (Vec::new(), false) };
    let read: Result<Metadata, _> = serde_saphyr::from_str(&text);
    match read {
        Ok(Metadata {
            rosbag2_bagfile_information: Information { relative_file_paths, compression_mode },
        }) => {
            // Older versions write the path from where the bag was recorded.
            let place = |name: &String| Path::new(name).file_name().map(|name| folder.join(name));
            let files = relative_file_paths.iter().filter_map(place).collect();
            (files, compression_mode.eq_ignore_ascii_case("message"))
        }
        Err(error) => {
            let reason = error.to_string();
            let reason = reason.lines().next().unwrap_or_default();
            remarks.push(format!("{}: {reason}; the files are taken by name", file.display()));
            (Vec::new(), false)
        }
    }
}

impl Files {
    fn add(&mut self, path: &Path, is_packed: bool) -> Result<(), BagError> {
        let unreadable = |reason| BagError::Unreadable { path: path.to_path_buf(), reason };
        let mut head = Vec::new();
        let file = File::open(path).map_err(unreadable)?;
        file.take(HEAD).read_to_end(&mut head).map_err(unreadable)?;
        if head.starts_with(ZSTD) {
            let copy = unpacked(path)?;
            self.add(&copy, is_packed)?;
            self.copies.push(copy);
            return Ok(());
        }
        let storage: Box<dyn Storage> = if head.starts_with(mcap_file::MAGIC) {
            Box::new(McapFile::open(path, is_packed)?)
        } else if head.starts_with(ros1_file::MAGIC) {
            Box::new(Ros1File::open(path)?)
        } else if head.starts_with(sqlite_file::MAGIC) {
            Box::new(SqliteFile::open(path, is_packed)?)
        } else {
            let found = if head.is_empty() {
                "an empty file".to_owned()
            } else {
                format!("a file that begins with {:?}", String::from_utf8_lossy(&head))
            };
            return Err(BagError::NotABag { path: path.to_path_buf(), found });
        };
        self.storages.push(storage);
        Ok(())
    }
}

/// An unpacked copy of a packed file, in the folder for temporary files.
fn unpacked(path: &Path) -> Result<TempPath, BagError> {
    let unreadable = |reason| BagError::Unreadable { path: path.to_path_buf(), reason };
    let mut copy = tempfile::NamedTempFile::new().map_err(unreadable)?;
    let mut decoder = File::open(path).and_then(zstd::Decoder::new).map_err(unreadable)?;
    std::io::copy(&mut decoder, &mut copy).and_then(|_| copy.flush()).map_err(unreadable)?;
    Ok(copy.into_temp_path())
}
