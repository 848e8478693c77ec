//! What the program says: results on standard output, everything else on standard error.
//!
//! A closed pipe (`dsslam run ... | head`) is no error; colours appear only on a terminal and never with `NO_COLOR`.

use std::io::{IsTerminal, Write};

/// Prints one line of results to standard output.
pub(crate) fn say(line: impl AsRef<str>) {
    // A reader that has gone away has seen what it wanted.
    let _ = writeln!(std::io::stdout(), "{}", line.as_ref());
}

/// Prints one line for the person at the terminal to standard error.
pub(crate) fn note(line: impl AsRef<str>) {
    let _ = writeln!(std::io::stderr(), "{}", line.as_ref());
}

/// A line that starts with `warning:`.
pub(crate) fn warning(text: impl AsRef<str>) -> String {
    format!("{} {}", paint("warning:", "33"), text.as_ref())
}

/// A line that starts with `error:`.
pub(crate) fn error(text: impl AsRef<str>) -> String {
    format!("{} {}", paint("error:", "1;31"), text.as_ref())
}

/// `text` in the given ANSI style when standard error shows colours.
fn paint(text: &str, style: &str) -> String {
    if shows_colours() { format!("\x1b[{style}m{text}\x1b[0m") } else { text.to_owned() }
}

/// Whether standard error is a terminal that wants colours (<https://no-color.org>).
fn shows_colours() -> bool {
    let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    let dumb = std::env::var_os("TERM").is_some_and(|term| term == "dumb");
    std::io::stderr().is_terminal() && !set("NO_COLOR") && !dumb
}
