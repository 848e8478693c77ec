//! Ctrl-C and SIGTERM: the first asks the run to end and write what there is, the second ends the program at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::console;
use crate::exit::Exit;

/// A flag that becomes true with the first signal.
pub(crate) fn on_signal() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    let installed = ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(Exit::Interrupted.code()));
        }
        console::note("stopping after this frame; press Ctrl-C again to quit at once, without results");
    });
    if let Err(error) = installed {
        console::note(console::warning(format!("Ctrl-C will end the program without results: {error}")));
    }
    stop
}
