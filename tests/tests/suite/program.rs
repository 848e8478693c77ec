//! The `dsslam` program as the tests call it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// What a call of the program left.
pub(crate) struct Call {
    pub(crate) code: i32,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Call {
    /// Ended with this code and this line on standard error.
    #[track_caller]
    pub(crate) fn expect(&self, code: i32, line: &str) {
        let found = self.stderr.lines().any(|l| l == line);
        assert!(self.code == code && found, "expected code {code} and the line\n{line}\nfound {self}");
    }

    /// Ended well.
    #[track_caller]
    pub(crate) fn expect_success(&self) {
        assert_eq!(self.code, 0, "{self}");
    }
}

impl std::fmt::Display for Call {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "code {}\n{}{}", self.code, self.stdout, self.stderr)
    }
}

/// The program of this build: beside the tests' own folder. `cargo test --workspace` builds it.
pub(crate) fn program() -> PathBuf {
    let tests = std::env::current_exe().unwrap();
    let program = tests.ancestors().nth(2).unwrap().join("dsslam");
    assert!(program.exists(), "{} is not built: cargo build -p dsslam-cli", program.display());
    program
}

/// The program with arguments, without colors. A run that names no configuration has the defaults, whatever its layout suggests.
pub(crate) fn command(args: &[&str]) -> Command {
    let mut command = Command::new(program());
    let is_run = args.iter().find(|arg| !arg.starts_with('-')) == Some(&"run");
    let default = if is_run && !args.contains(&"--config") { &["--config", "default"][..] } else { &[] };
    command.args(args).args(default).env("NO_COLOR", "1").current_dir(std::env::temp_dir());
    command
}

/// Calls the program and waits for its end.
pub(crate) fn dsslam(args: &[&str]) -> Call {
    ended(command(args).output().unwrap())
}

/// The outcome of a finished call; a panic of the program fails the test at once.
pub(crate) fn ended(output: Output) -> Call {
    let call = Call {
        code: output.status.code().unwrap_or(-1),
        stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
        stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
    };
    assert!(call.code != 101 && !call.stderr.contains("panicked"), "the program panicked: {call}");
    call
}

/// `summary.json` of a results folder.
pub(crate) fn summary(results: &Path) -> serde_json::Value {
    let path = results.join("summary.json");
    let text = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_str(&text).unwrap()
}

/// A path as an argument.
pub(crate) fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}
