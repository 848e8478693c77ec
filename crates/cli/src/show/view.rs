//! `dsslam view`: a finished run in the viewer.

use std::io::Write;

use anyhow::{Context, Result, anyhow};
use events::{FILE_NAME, StreamWriter};

use super::{Manner, ViewerProcess, program, recorded};
use crate::args::ViewArgs;
use crate::exit::{Exit, Failure, OrExit};

/// Shows a results folder: its events, or where there are none what the other files tell.
///
/// # Errors
/// A folder that holds no run, a viewer that is missing or fails.
pub(crate) fn view(args: &ViewArgs) -> Result<Exit, Failure> {
    let manner = Manner::of(true, args.save.as_ref(), args.connect.as_ref()).unwrap_or(Manner::Open);
    let results = &args.results;
    if !results.is_dir() {
        return Err(anyhow!("{}: not a results folder", results.display())).or_input();
    }
    let events = results.join(FILE_NAME);
    let records = match &args.map {
        None if events.is_file() => None,
        map => Some(recorded::records(results, map.as_deref()).or_input()?),
    };
    manner.check().or_output()?;
    let program = program()?;
    let file = Some(&*events).filter(|_| records.is_none());
    let (mut process, pipe) = ViewerProcess::start(&program, file, &manner).or_input()?;
    if let (Some(records), Some(pipe)) = (records, pipe) {
        // A viewer that has gone away has said why.
        let _ = write(&records, pipe);
    }
    let status = process.wait_for_ever().or_input()?;
    if status.success() { Ok(Exit::Done) } else { Err(anyhow!("the viewer ended with {status}")).or_output() }
}

/// Writes everything and closes the pipe.
fn write(records: &[events::Record], pipe: impl Write) -> Result<()> {
    let mut writer = StreamWriter::new(pipe)?;
    records.iter().try_for_each(|record| writer.write(record)).context("the viewer has stopped reading")
}
