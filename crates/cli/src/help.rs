//! What `--help` says below the options: examples that work as they stand (`help/*.txt`), and the exit codes.

use crate::exit::EXIT_CODES;

/// A text of `help/` and the exit codes.
pub(crate) fn with_codes(text: &str) -> String {
    format!("{text}\n{EXIT_CODES}")
}
