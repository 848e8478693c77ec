//! Exit codes, and errors that carry one.

use std::fmt;

/// How the program ends. A panic (101) is a bug and not listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Exit {
    /// The command succeeded.
    Done = 0,
    /// Fewer than half of the usable frames have a pose, or `--strict` refuses the scale.
    Unusable = 1,
    /// Invalid arguments, configuration or dataset: no frame was processed.
    Input = 2,
    /// Results could not be written.
    Output = 3,
    /// A stage of the run failed, which is a bug; results so far have been written.
    Failed = 4,
    /// Interrupted by Ctrl-C or SIGTERM; results so far have been written.
    Interrupted = 130,
}

/// The table of exit codes as `--help` shows it.
pub(crate) const EXIT_CODES: &str = "\
Exit codes:
  0    success
  1    fewer than half of the usable frames have a pose; with --strict also: the scale is off
  2    invalid arguments, configuration or dataset, or doubts with --strict; no frame was processed
  3    the results cannot be written
  4    a stage of the run failed, which is a bug; results so far have been written
  130  interrupted (Ctrl-C, SIGTERM); results so far have been written";

impl Exit {
    /// The number that the shell sees.
    pub(crate) fn code(self) -> u8 {
        self as u8
    }
}

/// An error and the exit code with which it ends the program.
#[derive(Debug)]
pub(crate) struct Failure {
    /// The code for the shell.
    pub(crate) exit: Exit,
    /// What went wrong, with its causes.
    pub(crate) error: anyhow::Error,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:#}", self.error)
    }
}

/// Attaches an exit code to an error.
pub(crate) trait OrExit<T> {
    /// Blames the input: code 2.
    fn or_input(self) -> Result<T, Failure>;
    /// Blames the output: code 3.
    fn or_output(self) -> Result<T, Failure>;
}

impl<T, E: Into<anyhow::Error>> OrExit<T> for Result<T, E> {
    fn or_input(self) -> Result<T, Failure> {
        self.map_err(|error| Failure { exit: Exit::Input, error: error.into() })
    }

    fn or_output(self) -> Result<T, Failure> {
        self.map_err(|error| Failure { exit: Exit::Output, error: error.into() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::{Context, anyhow};

    #[test]
    fn a_failure_prints_its_causes_on_one_line() {
        let failure = Err::<(), _>(anyhow!("no space left")).context("summary.json").or_output().unwrap_err();
        assert_eq!(failure.to_string(), "summary.json: no space left");
        assert_eq!(failure.exit.code(), 3);
    }

    #[test]
    fn the_help_names_every_code() {
        for exit in [Exit::Done, Exit::Unusable, Exit::Input, Exit::Output, Exit::Failed, Exit::Interrupted] {
            assert!(EXIT_CODES.contains(&format!("\n  {:<4} ", exit.code())), "{exit:?}");
        }
    }
}
