//! Standard output: a reader that has seen enough (`| head`) is not an error, a full disk is.

use std::io::{ErrorKind, Write};

use anyhow::{Context, Result};

/// Prints `text` and ends the line.
pub(super) fn say(text: impl AsRef<str>) -> Result<()> {
    match writeln!(std::io::stdout().lock(), "{}", text.as_ref()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error).context("cannot print the result"),
        _ => Ok(()),
    }
}

/// Prints a hint to standard error, where it is in nobody's way.
pub(super) fn hint(text: &str) {
    let _ = writeln!(std::io::stderr(), "hint: {text}");
}
