//! The viewer's process: found, started with a pipe, waited for. Whatever becomes of it, the run goes on.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::Duration;

use anyhow::{Context, Result};
use dsslam::{find_program, shield};

use super::Manner;

/// Name of the viewer's program.
const PROGRAM: &str = "dsslam-rerun";
/// How long a viewer may work on after the end of the run, in steps.
const STEPS: u32 = 1200;
const STEP: Duration = Duration::from_millis(50);

/// The viewer's program: beside this one, else on the `PATH`.
pub(crate) fn find() -> Option<PathBuf> {
    find_program(PROGRAM)
}

/// A viewer at work.
#[derive(Debug)]
pub(crate) struct ViewerProcess {
    child: Child,
}

/// How it ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ended {
    /// With this status.
    With(ExitStatus),
    /// Not yet.
    NotYet,
}

impl ViewerProcess {
    /// Starts the viewer on a file, or on the pipe that it returns.
    ///
    /// # Errors
    /// When the program cannot be started.
    pub(crate) fn start(
        program: &Path,
        file: Option<&Path>,
        manner: &Manner,
    ) -> Result<(Self, Option<Pipe>)> {
        let mut command = Command::new(program);
        command.args(arguments(file, manner)).stdout(Stdio::null());
        // A Ctrl-C at the terminal is meant for the run; the viewer ends with its input.
        shield(&mut command);
        command.stdin(if file.is_none() { Stdio::piped() } else { Stdio::null() });
        let mut child =
            command.spawn().with_context(|| format!("{}: cannot be started", program.display()))?;
        let pipe = child.stdin.take();
        Ok((ViewerProcess { child }, pipe))
    }

    /// Waits a while for its end.
    pub(crate) fn wait(&mut self) -> Ended {
        for _ in 0..STEPS {
            match self.child.try_wait() {
                Ok(Some(status)) => return Ended::With(status),
                Ok(None) => std::thread::sleep(STEP),
                Err(_) => return Ended::NotYet,
            }
        }
        Ended::NotYet
    }

    /// Waits for its end, however long that takes.
    ///
    /// # Errors
    /// When there is nothing to wait for.
    pub(crate) fn wait_for_ever(&mut self) -> Result<ExitStatus> {
        self.child.wait().context("waiting for the viewer failed")
    }

    /// Terminates it at once, so that nothing waits for its pipe.
    pub(crate) fn end(&mut self) {
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The writing end of a pipe.
pub(crate) type Pipe = std::process::ChildStdin;

fn arguments(file: Option<&Path>, manner: &Manner) -> Vec<OsString> {
    let mut arguments = vec![file.map_or("-".into(), |file| file.as_os_str().to_owned())];
    match manner {
        Manner::Open => {}
        Manner::Save(to) => arguments.extend(["--save".into(), to.as_os_str().to_owned()]),
        Manner::Connect(url) => {
            arguments.push("--connect".into());
            arguments.extend(url.iter().map(OsString::from));
        }
    }
    arguments
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_manner_has_its_arguments() {
        let of = |manner| arguments(None, &manner).join(&OsString::from(" "));
        assert_eq!(of(Manner::Open), "-");
        assert_eq!(of(Manner::Save("a b.rrd".into())), "- --save a b.rrd");
        assert_eq!(of(Manner::Connect(None)), "- --connect");
        assert_eq!(
            of(Manner::Connect(Some("rerun+http://a/proxy".into()))),
            "- --connect rerun+http://a/proxy"
        );
    }
}
