//! Where the recording goes: a viewer that is opened, one that is running, a file.

use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

use anyhow::{Context, Result, bail};
use rerun::{RecordingStream, RecordingStreamBuilder, SpawnOptions};

use crate::args::Args;
use crate::layout::{Views, layout};

/// How long a viewer may take to read the rest.
const FLUSH: Duration = Duration::from_secs(30);
/// How long a viewer may take to answer.
const CONNECT: Duration = Duration::from_secs(3);

/// Opens the recording that the arguments ask for, views laid out.
///
/// # Errors
/// A missing viewer, a file that cannot be written.
pub(crate) fn open(args: &Args) -> Result<RecordingStream> {
    let builder = RecordingStreamBuilder::new("dsslam").with_blueprint(layout(Views::WithoutImage));
    let recording = match (&args.save, &args.connect) {
        (Some(file), _) => {
            builder.save(file).with_context(|| format!("{}: cannot be written", file.display()))
        }
        (None, Some(url)) => {
            check_listens(url)?;
            builder.connect_grpc_opts(url).with_context(|| format!("{url}: no Rerun viewer"))
        }
        (None, None) => builder
            .spawn_opts(&SpawnOptions { hide_welcome_screen: true, ..SpawnOptions::default() })
            .context("the Rerun viewer cannot be opened: install it with `pip install rerun-sdk==0.36.3`, or write a file"),
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
pub(crate) fn close(recording: RecordingStream) -> Result<()> {
    let flushed = recording.flush_with_timeout(FLUSH);
    if flushed.is_err() {
        // Its destructor would wait for the viewer for ever.
        std::mem::forget(recording);
    }
    flushed.context("not everything could be sent to the viewer (without a display, write a file with --save, or with --rerun-save during a run)")
}

/// Whether a viewer listens at a URL; Rerun itself would retry forever.
///
/// # Errors
/// When none does.
fn check_listens(url: &str) -> Result<()> {
    let Some(place) = address(url) else { return Ok(()) };
    let found = place.to_socket_addrs().with_context(|| format!("{url}: not the address of a viewer"))?;
    let mut last = None;
    for address in found {
        match TcpStream::connect_timeout(&address, CONNECT) {
            Ok(_) => return Ok(()),
            Err(error) => last = Some(error),
        }
    }
    let reason = last.map_or("no address".to_owned(), |error| error.to_string());
    bail!("{url}: no Rerun viewer answers ({reason}); start one with `rerun`")
}

/// Host and port of a URL such as `rerun+http://127.0.0.1:9876/proxy`; `None` where it names no port.
fn address(url: &str) -> Option<&str> {
    let (_, rest) = url.split_once("://")?;
    let place = rest.split('/').next()?;
    place.rsplit_once(':')?.1.parse::<u16>().ok().map(|_| place)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_url_with_a_port_has_an_address() {
        assert_eq!(address("rerun+http://127.0.0.1:9876/proxy"), Some("127.0.0.1:9876"));
        assert_eq!(address("rerun+http://[::1]:9876/proxy"), Some("[::1]:9876"));
        assert_eq!(address("rerun+https://example.org/proxy"), None);
        assert_eq!(address("nonsense"), None);
    }

    #[test]
    fn a_viewer_that_is_not_there_is_named() {
        let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("a free port");
        let url = format!("rerun+http://{}/proxy", listener.local_addr().expect("its address"));
        check_listens(&url).expect("somebody listens");
        drop(listener);
        let message = check_listens(&url).expect_err("nobody listens").to_string();
        assert!(message.starts_with(&format!("{url}: no Rerun viewer answers (")), "{message}");
    }
}
