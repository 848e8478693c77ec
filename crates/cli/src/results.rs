//! The results folder: made and checked before the work starts, each file written whole or not at all.

use std::fs::{self, File, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use crate::clock;

/// The folder that collects runs when `--out` is absent.
const RESULTS: &str = "results";

/// A folder that has been found writable.
#[derive(Debug)]
pub(crate) struct ResultsFolder {
    path: PathBuf,
    /// `<sequence>/<time>` when the folder lies in `results/` and `results/latest` should show it.
    latest: Option<PathBuf>,
    /// Locked as long as it is held, also if the program is killed; `None` where folders cannot be locked.
    _lock: Option<File>,
}

impl ResultsFolder {
    /// Exactly `out`, or a new folder `results/<sequence>/<time>` below `parent`.
    ///
    /// # Errors
    /// When the folder cannot be made, a file in it cannot be written, or another run writes into it.
    pub(crate) fn create(out: Option<&Path>, parent: &Path, sequence: &str) -> Result<Self> {
        let (path, latest) = match out {
            Some(out) => (out.to_owned(), None),
            None => {
                let latest = new_subfolder(&parent.join(RESULTS), &safe_name(sequence))?;
                (parent.join(RESULTS).join(&latest), Some(latest))
            }
        };
        io::create_output_folder(&path)?;
        let lock = lock(&path)?;
        Ok(Self { path, latest, _lock: lock })
    }

    /// Where the files go.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// The path of a file in the folder.
    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Writes a file whole or not at all.
    ///
    /// # Errors
    /// When the file cannot be written; an older file of that name is then untouched.
    pub(crate) fn write(&self, name: &str, bytes: &[u8]) -> Result<()> {
        Ok(io::write_atomic(&self.file(name), bytes)?)
    }

    /// Like [`ResultsFolder::write`], for writers that want a path; theirs ends like `name`.
    ///
    /// # Errors
    /// When the writer fails or the file cannot take its name.
    pub(crate) fn write_with(&self, name: &str, writer: impl FnOnce(&Path) -> Result<()>) -> Result<()> {
        let (part, target) = (self.file(&format!(".part.{name}")), self.file(name));
        let written = writer(&part).and_then(|()| Ok(fs::rename(&part, &target)?));
        if written.is_err() {
            let _ = fs::remove_file(&part);
        }
        written.with_context(|| cannot_write(&target))
    }

    /// Points `results/latest` at this folder. A folder given by `--out` leaves the link alone.
    ///
    /// # Errors
    /// When the link cannot be made.
    pub(crate) fn link_latest(&self) -> Result<()> {
        let Some(target) = &self.latest else { return Ok(()) };
        let Some(results) = self.path.ancestors().nth(2) else { return Ok(()) };
        let (link, part) = (results.join("latest"), results.join(".latest.part"));
        let _ = fs::remove_file(&part);
        let linked = symlink(target, &part).and_then(|()| fs::rename(&part, &link));
        if linked.is_err() {
            let _ = fs::remove_file(&part);
        }
        linked.with_context(|| format!("{}: cannot be created", link.display()))
    }
}

/// Locks a folder against other runs; not every system and file system can.
fn lock(folder: &Path) -> Result<Option<File>> {
    let Ok(handle) = File::open(folder) else { return Ok(None) };
    match handle.try_lock() {
        Ok(()) => Ok(Some(handle)),
        Err(TryLockError::WouldBlock) => {
            bail!(
                "{}: another run is writing its results into this folder, expected an --out of its own",
                folder.display()
            )
        }
        Err(TryLockError::Error(_)) => Ok(None),
    }
}

#[cfg(unix)]
use std::os::unix::fs::symlink;

/// Elsewhere there is no link that everybody may make.
#[cfg(not(unix))]
fn symlink(_: &Path, link: &Path) -> std::io::Result<()> {
    fs::write(link, [])
}

fn cannot_write(folder: &Path) -> String {
    format!("{}: cannot be written", folder.display())
}

/// Makes `results/<sequence>/<time>`; a second run within the same second gets a number. Returns the part below `results`.
fn new_subfolder(results: &Path, sequence: &str) -> Result<PathBuf> {
    let parent = results.join(sequence);
    fs::create_dir_all(&parent).with_context(|| cannot_write(&parent))?;
    let stamp = clock::utc_stamp();
    for attempt in 1..1000 {
        let name = if attempt == 1 { stamp.clone() } else { format!("{stamp}-{attempt}") };
        match fs::create_dir(parent.join(&name)) {
            Ok(()) => return Ok(Path::new(sequence).join(name)),
            Err(e) if e.kind() == ErrorKind::AlreadyExists => {}
            Err(e) => return Err(e).with_context(|| cannot_write(&parent.join(&name))),
        }
    }
    bail!("{}: a thousand results folders from the same second already exist", parent.display())
}

/// A sequence's name as a folder name.
fn safe_name(sequence: &str) -> String {
    let safe = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' };
    let name: String = sequence.chars().map(safe).collect();
    if name.trim_matches('.').is_empty() || name == "latest" {
        format!("sequence_{}", name.replace('.', ""))
    } else {
        name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_out_the_folder_is_new_and_latest_shows_the_newest() {
        let parent = tempfile::tempdir().unwrap();
        for content in ["first", "second"] {
            let folder = ResultsFolder::create(None, parent.path(), "town").unwrap();
            folder.write("a.txt", content.as_bytes()).unwrap();
            folder.link_latest().unwrap();
            let latest = parent.path().join("results/latest");
            assert_eq!(fs::read_to_string(latest.join("a.txt")).unwrap(), content);
            assert_eq!(latest.canonicalize().unwrap(), folder.path().canonicalize().unwrap());
        }
        assert_eq!(fs::read_dir(parent.path().join("results/town")).unwrap().count(), 2);
    }

    #[test]
    fn out_is_taken_exactly_and_files_are_replaced_whole() {
        let parent = tempfile::tempdir().unwrap();
        let out = parent.path().join("a/b");
        let folder = ResultsFolder::create(Some(&out), parent.path(), "town").unwrap();
        folder.write("a.txt", b"old").unwrap();
        assert!(folder.write_with("a.txt", |_| bail!("no ink")).is_err());
        assert_eq!(fs::read(out.join("a.txt")).unwrap(), b"old");
        folder.write_with("a.txt", |path| Ok(fs::write(path, b"new")?)).unwrap();
        assert_eq!(fs::read(out.join("a.txt")).unwrap(), b"new");
        folder.link_latest().unwrap();
        assert_eq!(fs::read_dir(&out).unwrap().count(), 1, "no part file and no probe is left");
        assert!(!parent.path().join("results").exists());
    }

    #[test]
    fn a_file_in_the_way_is_named() {
        let parent = tempfile::tempdir().unwrap();
        let out = parent.path().join("file");
        fs::write(&out, b"").unwrap();
        let error = ResultsFolder::create(Some(&out), parent.path(), "town").unwrap_err();
        assert!(format!("{error:#}").starts_with(&format!("{}: cannot be written: ", out.display())));
    }

    /// Two runs into one folder both ended well, their results mixed.
    #[test]
    fn a_folder_that_another_run_writes_into_is_refused_until_that_ends() {
        let parent = tempfile::tempdir().unwrap();
        let out = parent.path().join("out");
        let first = ResultsFolder::create(Some(&out), parent.path(), "town").unwrap();
        let error = ResultsFolder::create(Some(&out), parent.path(), "town").unwrap_err().to_string();
        assert!(error.starts_with(&format!("{}: another run is writing", out.display())), "{error}");
        drop(first);
        ResultsFolder::create(Some(&out), parent.path(), "town").unwrap();
    }

    #[test]
    fn names_become_folder_names() {
        for (name, expected) in
            [("kitti/06", "kitti_06"), ("..", "sequence_"), ("latest", "sequence_latest"), ("a b", "a_b")]
        {
            assert_eq!(safe_name(name), expected);
        }
    }
}
