//! Where ONNX Runtime is, and the one environment of the process in it.

use std::env;
use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use ort::environment::Environment;

use crate::error::Error;

/// Names a library directly.
const VARIABLE: &str = "ORT_DYLIB_PATH";
/// What the file's name begins with; a version may follow.
const FILE: &str = "libonnxruntime.so";
/// Folders that distributions install libraries in.
const SYSTEM: [&str; 6] = [
    "/usr/local/lib",
    "/usr/lib",
    "/usr/lib64",
    "/usr/lib/x86_64-linux-gnu",
    "/usr/lib/aarch64-linux-gnu",
    "/opt/onnxruntime/lib",
];

/// What runs networks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Runner {
    /// The library ONNX Runtime.
    OnnxRuntime,
    /// What is built in: the same answers but for the last digits, several times slower.
    BuiltIn,
}

impl fmt::Display for Runner {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::OnnxRuntime => "ONNX Runtime",
            Self::BuiltIn => "the built-in engine",
        })
    }
}

/// What runs networks: ONNX Runtime with `library` or the first library found, which is loaded here, else the built-in engine.
///
/// # Errors
/// [`Error::BadLibrary`] where a library that was named, as `library` or by the environment, cannot be used.
pub fn runner(library: Option<&Path>) -> Result<Runner, Error> {
    Ok(environment(library)?.map_or(Runner::BuiltIn, |_| Runner::OnnxRuntime))
}

/// ONNX Runtime allows one environment per process, which stays until the process ends. A failure stays as well: `ort` must
/// not be asked to load a library again after one that could not be loaded.
static ENVIRONMENT: Mutex<Option<Result<Environment, Error>>> = Mutex::new(None);

/// The environment, made with `library` or the first library found when none has been loaded yet; `None` where no library
/// was named and none that can be used was found.
///
/// # Errors
/// [`Error::BadLibrary`] for a library that was named.
pub(crate) fn environment(library: Option<&Path>) -> Result<Option<Environment>, Error> {
    let mut slot = ENVIRONMENT.lock().unwrap_or_else(PoisonError::into_inner);
    let named = library.map(Path::to_owned).or_else(of_variable);
    let is_named = named.is_some();
    let loaded = match &*slot {
        Some(loaded) => loaded.clone(),
        None => match named.or_else(in_folders) {
            Some(path) => first(&mut slot, &path),
            None => return Ok(None),
        },
    };
    match loaded {
        Ok(environment) => Ok(Some(environment)),
        Err(error) if is_named => Err(error),
        Err(_) => Ok(None),
    }
}

/// Loads the first library of the process.
fn first(slot: &mut Option<Result<Environment, Error>>, path: &Path) -> Result<Environment, Error> {
    let bad = |reason: String| Error::BadLibrary { path: path.to_owned(), reason };
    // Relative paths would be looked for beside the program.
    let absolute = std::path::absolute(path).map_err(|error| bad(error.to_string()))?;
    fs::metadata(&absolute).map_err(|error| bad(error.to_string()))?;
    slot.insert(load(&absolute).map_err(bad)).clone()
}

/// Loads the library and makes the environment.
fn load(path: &Path) -> Result<Environment, String> {
    let builder = ort::init_from(path).map_err(|error| error.to_string())?;
    builder.with_name("dsslam").with_telemetry(false).build().map_err(|error| error.to_string())
}

/// The library that the environment variable names (there or not), else the first one in the usual folders. Nothing is loaded.
#[must_use]
pub fn find_library() -> Option<PathBuf> {
    of_variable().or_else(in_folders)
}

/// The library that the environment variable names.
fn of_variable() -> Option<PathBuf> {
    env::var_os(VARIABLE).filter(|path| !path.is_empty()).map(PathBuf::from)
}

/// The first library in the usual folders.
fn in_folders() -> Option<PathBuf> {
    folders().iter().find_map(|folder| newest_in(folder))
}

/// Beside the program, the user's folder for data (also as `pip install --target` fills it), those of the system.
fn folders() -> Vec<PathBuf> {
    let mut folders = Vec::new();
    let program = env::current_exe().ok().and_then(|file| file.parent().map(Path::to_owned));
    if let Some(folder) = program {
        folders.extend([folder.join("../lib/dsslam"), folder.clone()].into_iter().rev());
    }
    let home = env::var_os("HOME").map(|home| PathBuf::from(home).join(".local/share"));
    if let Some(data) = env::var_os("XDG_DATA_HOME").map(PathBuf::from).or(home) {
        folders.extend([data.join("dsslam"), data.join("dsslam/onnxruntime/capi")]);
    }
    folders.extend(SYSTEM.map(PathBuf::from));
    folders
}

/// The newest library in a folder, whole numbers of the version compared; a name without version comes first.
fn newest_in(folder: &Path) -> Option<PathBuf> {
    let entries = fs::read_dir(folder).ok()?;
    let found = entries.filter_map(|entry| {
        let path = entry.ok()?.path();
        let version = path.file_name()?.to_str()?.strip_prefix(FILE)?.to_owned();
        let is_one = version.is_empty() || version.starts_with('.');
        (is_one && path.is_file()).then_some((rank(&version), path))
    });
    found.max().map(|(_, path)| path)
}

/// Rank of what follows the name: nothing above all versions, then the higher version.
fn rank(version: &str) -> (bool, Vec<u64>) {
    let numbers = version.split('.').filter_map(|part| part.parse().ok()).collect();
    (version.is_empty(), numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_library_of_a_folder_is_taken() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(newest_in(folder.path()), None);
        let file = |name: &str| folder.path().join(name);
        for name in
            ["libonnxruntime.so.1.9.0", "libonnxruntime.so.1.24.4", "libonnxruntime.sofa", "libother.so"]
        {
            fs::write(file(name), "").unwrap();
        }
        assert_eq!(newest_in(folder.path()), Some(file("libonnxruntime.so.1.24.4")));
        fs::write(file("libonnxruntime.so"), "").unwrap();
        assert_eq!(newest_in(folder.path()), Some(file("libonnxruntime.so")));
        assert_eq!(newest_in(&file("missing")), None);
    }
}
