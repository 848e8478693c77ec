//! Observers of a run: the person at the terminal, the file `events.dslog`, the viewer. None of them can stop or slow it.

mod audience;
mod process;
mod recorded;
mod start;
mod view;
mod yielding;

use std::path::{Path, PathBuf};

use anyhow::{Result, anyhow, ensure};

use crate::args::ShowArgs;
use crate::exit::{Failure, OrExit};
use crate::files::folder_of;

pub(crate) use audience::Audience;
pub(crate) use process::{ViewerProcess, find};
pub(crate) use start::true_poses;
pub(crate) use view::view;

/// What the viewer does with a stream.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Manner {
    /// Opens a window.
    Open,
    /// Writes a file.
    Save(PathBuf),
    /// Sends it to a viewer that is running: at a URL, or on this machine.
    Connect(Option<String>),
}

impl Manner {
    /// What the arguments ask for.
    pub(crate) fn of(open: bool, save: Option<&PathBuf>, connect: Option<&String>) -> Option<Self> {
        match (save, connect) {
            (Some(file), _) => Some(Manner::Save(file.clone())),
            (None, Some(url)) => Some(Manner::Connect(Some(url.clone()).filter(|url| !url.is_empty()))),
            (None, None) => open.then_some(Manner::Open),
        }
    }

    /// What the arguments of a run ask for.
    fn of_run(args: &ShowArgs) -> Option<Self> {
        Manner::of(args.rerun, args.rerun_save.as_ref(), args.rerun_connect.as_ref())
    }

    /// The file that is written is proved to be writable.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(crate) fn check(&self) -> Result<()> {
        let Manner::Save(file) = self else { return Ok(()) };
        check_writable(file)
    }
}

/// A file that is going to be written is proved to be writable.
///
/// # Errors
/// A file that cannot be written.
pub(crate) fn check_writable(file: &Path) -> Result<()> {
    ensure!(!file.is_dir(), "{}: cannot be written: it is a folder", file.display());
    ensure!(file.file_name().is_some(), "{}: cannot be written: the file name is missing", file.display());
    Ok(io::create_output_folder(folder_of(file))?)
}

/// The viewer's program, if the arguments ask for one; looked for before the work starts, and the files are proved to be writable.
///
/// # Errors
/// A missing viewer, or a file that cannot be written.
pub(crate) fn viewer(args: &ShowArgs) -> Result<Option<PathBuf>, Failure> {
    args.mcap.as_deref().map(check_writable).transpose().or_output()?;
    let Some(manner) = Manner::of_run(args) else { return Ok(None) };
    manner.check().or_output()?;
    program().map(Some)
}

/// The viewer's program.
///
/// # Errors
/// When it is missing.
pub(crate) fn program() -> Result<PathBuf, Failure> {
    find()
        .ok_or_else(|| {
            anyhow!("dsslam-rerun was found neither beside this program nor in PATH: build it with ./install.sh --rerun")
        })
        .or_input()
}
