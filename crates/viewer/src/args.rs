//! The command line.

use std::path::PathBuf;

use clap::Parser;

/// Shows the event stream of a DSSLAM run in Rerun.
#[derive(Debug, Parser)]
#[command(name = "dsslam-rerun", version, max_term_width = 110, after_help = EXAMPLES)]
pub(crate) struct Args {
    /// A results folder with events.dslog, such a file, or - for a pipe.
    #[arg(value_name = "INPUT")]
    pub(crate) input: PathBuf,
    /// Writes a file for the Rerun viewer instead of opening it.
    #[arg(long, value_name = "FILE.rrd", conflicts_with = "connect")]
    pub(crate) save: Option<PathBuf>,
    /// Sends to a running Rerun viewer [default URL: the one on this machine].
    #[arg(long, value_name = "URL", num_args = 0..=1, default_missing_value = "rerun+http://127.0.0.1:9876/proxy")]
    pub(crate) connect: Option<String>,
}

const EXAMPLES: &str = "\
Examples:
  dsslam-rerun results/latest
  dsslam-rerun results/latest --save run.rrd
  dsslam run SEQUENCE --rerun            starts this program by itself";
