//! Text files with line numbers in their errors, and atomic writing. Used by datasets, trajectories and configuration.

use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// What is wrong with a file that is read or written; the message names file, line, found and expected.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FileError {
    /// The file does not exist.
    #[error("{}: no such file, expected {expected}", path.display())]
    Missing {
        /// The file that was looked for.
        path: PathBuf,
        /// What it should hold.
        expected: String,
    },
    /// The operating system refused to read it.
    #[error("{}: cannot be read: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The reason given by the operating system.
        reason: String,
    },
    /// The file holds no data (nothing, or only comments and blank lines).
    #[error("{}: found no data, expected {expected}", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
        /// What it should hold.
        expected: String,
    },
    /// A file that should be text holds something else.
    #[error("{}:{line}: found bytes that are not UTF-8 text, expected {expected}", path.display())]
    NotText {
        /// The file.
        path: PathBuf,
        /// The first line with such bytes, from 1.
        line: usize,
        /// What it should hold.
        expected: String,
    },
    /// A line does not hold what it should.
    #[error("{}:{line}: found {found}, expected {expected}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// Line number, from 1.
        line: usize,
        /// What stands there.
        found: String,
        /// What should stand there.
        expected: String,
    },
    /// A file or folder cannot be written.
    #[error("{}: cannot be written: {reason}", path.display())]
    Unwritable {
        /// The file or folder.
        path: PathBuf,
        /// The reason given by the operating system.
        reason: String,
    },
}

/// A text file in memory that can be walked by its data lines.
pub(crate) struct TextFile {
    pub(crate) path: PathBuf,
    text: String,
}

/// One line with data, with its number from 1.
#[derive(Clone, Copy)]
pub(crate) struct Line<'a> {
    pub(crate) file: &'a TextFile,
    pub(crate) number: usize,
    pub(crate) text: &'a str,
}

impl TextFile {
    /// Reads a whole file; `expected` says in an error what it should hold. A byte order mark is skipped, UTF-16 is translated, and
    /// comments (`#`) may hold any bytes.
    pub(crate) fn read(path: &Path, expected: &str) -> Result<Self, FileError> {
        let bytes = read_bytes(path).map_err(|error| match error.kind() {
            ErrorKind::NotFound => {
                FileError::Missing { path: path.to_path_buf(), expected: expected.to_string() }
            }
            _ => FileError::Unreadable { path: path.to_path_buf(), reason: error.to_string() },
        })?;
        let text = decoded(&bytes);
        let is_odd = |line: &str| {
            let data = line.split('#').next().unwrap_or_default();
            data.contains([char::REPLACEMENT_CHARACTER, '\0'])
        };
        match text.lines().position(is_odd) {
            Some(line) => Err(FileError::NotText {
                path: path.to_path_buf(),
                line: line + 1,
                expected: expected.to_string(),
            }),
            None => Ok(Self { path: path.to_path_buf(), text }),
        }
    }

    /// The raw text.
    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    /// Lines that are neither blank nor comments (`#`), in order.
    pub(crate) fn data_lines(&self) -> impl Iterator<Item = Line<'_>> {
        self.text
            .lines()
            .enumerate()
            .map(|(index, text)| Line { file: self, number: index + 1, text: text.trim() })
            .filter(|line| !line.text.is_empty() && !line.text.starts_with('#'))
    }

    /// The error of a file without data.
    pub(crate) fn empty(&self, expected: &str) -> FileError {
        FileError::Empty { path: self.path.clone(), expected: expected.to_string() }
    }
}

/// Texts and images of more bytes than this are none that people have.
const MOST_BYTES: u64 = 256 << 20;

/// The bytes of an ordinary file; pipes, devices, folders and files beyond all measure are refused before anything is read.
///
/// # Errors
/// What the operating system says, or what the path is instead.
pub(crate) fn read_bytes(path: &Path) -> std::io::Result<Vec<u8>> {
    check_regular(path)?;
    fs::read(path)
}

/// The bytes of a file of any length, such as a map; pipes, devices and folders are refused before anything is read.
///
/// # Errors
/// What the operating system says, or what the path is instead.
pub fn read_file(path: &Path) -> std::io::Result<Vec<u8>> {
    check_file(path)?;
    fs::read(path)
}

/// Whether a path is an ordinary file, and no pipe, device or folder; its length.
///
/// # Errors
/// What the operating system says, or what the path is instead.
pub fn check_file(path: &Path) -> std::io::Result<u64> {
    let data = fs::metadata(path)?;
    let refused = |what: &str| Err(std::io::Error::new(ErrorKind::InvalidInput, what.to_owned()));
    if data.is_dir() {
        return refused("it is a folder, expected a file");
    }
    if data.is_file() { Ok(data.len()) } else { refused("it is a pipe or a device, expected a file") }
}

/// Whether a path is an ordinary file of an ordinary length.
///
/// # Errors
/// What the operating system says, or what the path is instead.
pub(crate) fn check_regular(path: &Path) -> std::io::Result<()> {
    let length = check_file(path)?;
    if length <= MOST_BYTES {
        return Ok(());
    }
    let reason = format!("it has {length} bytes, expected at most {MOST_BYTES}");
    Err(std::io::Error::new(ErrorKind::InvalidInput, reason))
}

/// UTF-8 or UTF-16 as text with `\n` at the ends of lines; bytes that are neither become U+FFFD.
fn decoded(bytes: &[u8]) -> String {
    let utf16 = |bytes: &[u8], join: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes.as_chunks::<2>().0.iter().map(|&pair| join(pair)).collect();
        String::from_utf16_lossy(&units)
    };
    let text = match bytes {
        [0xff, 0xfe, rest @ ..] => utf16(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => utf16(rest, u16::from_be_bytes),
        [0xef, 0xbb, 0xbf, rest @ ..] => String::from_utf8_lossy(rest).into_owned(),
        _ => String::from_utf8_lossy(bytes).into_owned(),
    };
    // Line ends of old Macs.
    if text.contains('\r') && !text.contains('\n') { text.replace('\r', "\n") } else { text }
}

impl<'a> Line<'a> {
    /// The error of this line.
    pub(crate) fn error(&self, found: impl Into<String>, expected: impl Into<String>) -> FileError {
        FileError::Line {
            path: self.file.path.clone(),
            line: self.number,
            found: found.into(),
            expected: expected.into(),
        }
    }

    /// A finite number out of one field of this line.
    pub(crate) fn number(&self, field: &str) -> Result<f64, FileError> {
        match field.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            Ok(_) => Err(self.error(shown(field), "a finite number")),
            Err(_) => Err(self.error(shown(field), "a number")),
        }
    }

    /// All `N` numbers of `fields`; `what` describes them in an error ("12 numbers (...)").
    pub(crate) fn numbers<const N: usize>(
        &self,
        fields: impl Iterator<Item = &'a str>,
        what: &str,
    ) -> Result<[f64; N], FileError> {
        let fields: Vec<&str> = fields.collect();
        let mut values = [0.0; N];
        for (value, field) in values.iter_mut().zip(&fields) {
            *value = self.number(field)?;
        }
        if fields.len() != N {
            return Err(self.error(counted(fields.len(), "number"), what));
        }
        Ok(values)
    }
}

/// What lies in a folder, in any order; nothing where there is no such folder.
pub(crate) fn entries(folder: &Path) -> Result<Vec<PathBuf>, FileError> {
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let paths = fs::read_dir(folder).and_then(|all| all.map(|entry| Ok(entry?.path())).collect());
    paths.map_err(|error| FileError::Unreadable { path: folder.to_path_buf(), reason: error.to_string() })
}

/// `1 number`, `11 numbers`.
pub(crate) fn counted(n: usize, noun: &str) -> String {
    if n == 1 { format!("1 {noun}") } else { format!("{n} {noun}s") }
}

/// A piece of a file as quoted in an error, cut when it is long.
pub(crate) fn shown(text: &str) -> String {
    const LONGEST: usize = 40;
    if text.chars().count() <= LONGEST {
        return format!("`{text}`");
    }
    let head: String = text.chars().take(LONGEST).collect();
    format!("`{head}...`")
}

/// Writes a file under a temporary name beside it, then renames it, so that a reader never sees half of it, nor does a
/// killed program leave half of it. For many small files; a loss of power may still take the last ones.
///
/// # Errors
/// [`FileError::Unwritable`] when the folder is missing or may not be written; no temporary file is left behind.
pub fn write_atomic(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    replace(path, bytes, Durability::Process)
}

/// Like [`write_atomic`], and waits until the file is on the disk: whenever the process stops, the old file is
/// there or the new one. For files that cannot be made again.
///
/// # Errors
/// As for [`write_atomic`].
pub fn write_durable(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    replace(path, bytes, Durability::Power)
}

/// What a file must survive.
#[derive(Clone, Copy, PartialEq)]
enum Durability {
    /// The end of the program.
    Process,
    /// The end of the machine.
    Power,
}

fn replace(path: &Path, bytes: &[u8], durability: Durability) -> Result<(), FileError> {
    static WRITTEN: AtomicU64 = AtomicU64::new(0);
    // Unique among the programs and threads that may write the same file.
    let number = WRITTEN.fetch_add(1, Ordering::Relaxed);
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".{}.{number}.part", std::process::id()));
    let temporary = path.with_file_name(name);
    let outcome =
        fill(&temporary, bytes, durability).and_then(|()| fs::rename(&temporary, path)).inspect_err(|_| {
            // The first error counts; a temporary file that was never made cannot be removed either.
            let _ = fs::remove_file(&temporary);
        });
    let outcome = match durability {
        Durability::Process => outcome,
        Durability::Power => outcome.and_then(|()| sync_folder_of(path)),
    };
    outcome.map_err(|error| FileError::Unwritable { path: path.to_path_buf(), reason: error.to_string() })
}

fn fill(path: &Path, bytes: &[u8], durability: Durability) -> std::io::Result<()> {
    let mut file = fs::File::create(path)?;
    file.write_all(bytes)?;
    if durability == Durability::Power { file.sync_all() } else { Ok(()) }
}

/// Waits until the new name of a file is on the disk; systems other than Unix cannot be asked to.
fn sync_folder_of(path: &Path) -> std::io::Result<()> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if cfg!(unix) { fs::File::open(folder)?.sync_all() } else { Ok(()) }
}

/// Makes a folder (with its parents) and proves that files can be written into it, before a run starts.
///
/// # Errors
/// [`FileError::Unwritable`] naming the folder.
pub fn create_output_folder(folder: &Path) -> Result<(), FileError> {
    let probe = folder.join(format!(".probe.{}.part", std::process::id()));
    fs::create_dir_all(folder)
        .and_then(|()| fs::write(&probe, b""))
        .and_then(|()| fs::remove_file(&probe))
        .map_err(|error| FileError::Unwritable { path: folder.to_path_buf(), reason: error.to_string() })
}

#[cfg(test)]
mod tests {
    use super::*;

    type Writer = fn(&Path, &[u8]) -> Result<(), FileError>;

    const WRITERS: [Writer; 2] = [write_atomic, write_durable];

    fn names_in(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn a_file_is_replaced_whole_and_nothing_else_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.bin");
        for write in WRITERS {
            write(&path, b"a long first version").unwrap();
            write(&path, b"short").unwrap();
            assert_eq!(fs::read(&path).unwrap(), b"short");
            assert_eq!(names_in(folder.path()), ["map.bin"]);
        }
    }

    #[test]
    fn a_file_that_cannot_be_written_is_named_and_leaves_no_trace() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("missing/map.bin");
        let taken = folder.path().join("taken");
        fs::create_dir_all(taken.join("inside")).unwrap();
        for write in WRITERS {
            for path in [&missing, &taken] {
                let error = write(path, b"x").unwrap_err().to_string();
                assert!(error.starts_with(&format!("{}: cannot be written: ", path.display())), "{error}");
            }
        }
        assert_eq!(names_in(folder.path()), ["taken"]);
    }

    #[test]
    fn many_threads_may_write_the_same_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = &folder.path().join("map.bin");
        let versions: Vec<Vec<u8>> = (0..4).map(|i| vec![i; 100_000 + usize::from(i)]).collect();
        std::thread::scope(|scope| {
            for version in &versions {
                scope.spawn(|| (0..20).for_each(|_| write_atomic(path, version).unwrap()));
            }
        });
        assert!(versions.contains(&fs::read(path).unwrap()));
        assert_eq!(names_in(folder.path()), ["map.bin"]);
    }
}
