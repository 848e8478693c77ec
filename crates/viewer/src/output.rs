//! Where the recording goes: a viewer that is opened, one that is running, a file.

use std::time::Duration;

use anyhow::{Context, Result};
use rerun::{RecordingStream, RecordingStreamBuilder, SpawnOptions};

use crate::args::Args;
use crate::layout::{Views, layout};

/// How long a viewer may take to read the rest.
const FLUSH: Duration = Duration::from_secs(30);

/// Opens the recording that the arguments ask for, views laid out.
///
/// # Errors
/// A viewer that is not there, a file that cannot be written.
pub(crate) fn open(args: &Args) -> Result<RecordingStream> {
    let builder = RecordingStreamBuilder::new("dsslam").with_blueprint(layout(Views::Usual));
    let recording = match (&args.save, &args.connect) {
        (Some(file), _) => {
            builder.save(file).with_context(|| format!("{}: cannot be written", file.display()))
        }
        (None, Some(url)) => builder.connect_grpc_opts(url).with_context(|| format!("{url}: no Rerun viewer")),
        (None, None) => builder
            .spawn_opts(&SpawnOptions { hide_welcome_screen: true, ..SpawnOptions::default() })
            .context("the Rerun viewer cannot be opened: `pip install rerun-sdk==0.36.3` brings it, or write a file"),
    }?;
    // The run has its own clocks.
    recording.set_log_tick_enabled(false);
    recording.set_log_time_enabled(false);
    Ok(recording)
}

/// Waits until everything has been written.
///
/// # Errors
/// A viewer that has gone away or does not read.
pub(crate) fn close(recording: &RecordingStream) -> Result<()> {
    recording.flush_with_timeout(FLUSH).context("not everything could be handed to the viewer")
}
