//! `dsslam eval`.

use std::io::ErrorKind;

use io::FileError;

use crate::args::Eval;
use crate::exit::{Exit, Failure};
use crate::{console, places};

/// Does what the arguments say.
///
/// # Errors
/// Wrong input, or an output that cannot be written.
pub(crate) fn run(what: Eval) -> Result<Exit, Failure> {
    let done = match what {
        Eval::Of(command) => command.run(),
        Eval::Places(args) => places::run(&args).map(|report| console::say(report.trim_end())),
    };
    done.map(|()| Exit::Done).map_err(|error| {
        let is_output = matches!(error.downcast_ref(), Some(FileError::Unwritable { .. }))
            || error.downcast_ref::<std::io::Error>().is_some_and(|e| e.kind() == ErrorKind::StorageFull);
        Failure { exit: if is_output { Exit::Output } else { Exit::Input }, error }
    })
}
