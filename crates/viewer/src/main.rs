//! `dsslam-rerun`: reads the event stream of a run, from a pipe or from its file, and shows it in Rerun.
//!
//! A separate program: it takes longer to build than everything else together, and a run does not depend on it. Start reading
//! at `show.rs` (one record after another), then `draw.rs` (the map and the path) and `layout.rs` (the views).

mod args;
mod colors;
mod draw;
mod input;
mod layout;
mod output;
mod plots;
mod show;

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;

/// Niceness added to that of the run: where processors are scarce, tracking goes before the pictures of it.
const NICENESS: i32 = 12;

fn main() -> ExitCode {
    // Where it is refused the viewer works as well.
    let _ = rustix::process::nice(NICENESS);
    match run(&args::Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // Whoever closed standard error does not want to know.
            let _ = writeln!(std::io::stderr(), "dsslam-rerun: {error:#}");
            ExitCode::from(1)
        }
    }
}

fn run(args: &args::Args) -> anyhow::Result<()> {
    let mut reader = input::open(&args.input)?;
    let recording = output::open(args)?;
    let shown = show::all(&mut reader, &recording);
    output::close(recording)?;
    shown
}
