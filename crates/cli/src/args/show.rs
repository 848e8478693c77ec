//! Command line of the visualization: options of a run, and `dsslam view`.

use std::path::PathBuf;

use clap::Args;

/// Visualization of a run.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Watching")]
pub(crate) struct ShowArgs {
    /// Writes events.dslog into the results folder, for `dsslam view`.
    #[arg(long)]
    pub(crate) events: bool,
    /// Writes poses, transforms, path and map points as an MCAP file while the run goes on, for Foxglove and ROS 2.
    #[arg(long, value_name = "FILE")]
    pub(crate) mcap: Option<PathBuf>,
    /// Opens the Rerun viewer and shows the run live.
    #[arg(long)]
    pub(crate) rerun: bool,
    /// Writes a file for the Rerun viewer.
    #[arg(long, value_name = "FILE.rrd", conflicts_with = "rerun")]
    pub(crate) rerun_save: Option<PathBuf>,
    /// Streams to a running Rerun viewer [default URL: the one on this machine].
    #[arg(long, value_name = "URL", num_args = 0..=1, default_missing_value = "", conflicts_with_all = ["rerun", "rerun_save"])]
    pub(crate) rerun_connect: Option<String>,
    /// Shows images and features of every N-th frame only.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) rerun_every: u32,
}

/// Arguments of `dsslam view`.
#[derive(Debug, Args)]
pub(crate) struct ViewArgs {
    /// Results folder of a run.
    #[arg(value_name = "RESULTS", default_value = "results/latest")]
    pub(crate) results: PathBuf,
    /// Shows the folder's other files together with this saved map (--save-map), instead of events.dslog.
    #[arg(long, value_name = "FILE.dsmap")]
    pub(crate) map: Option<PathBuf>,
    /// Writes a file for the Rerun viewer instead of opening it.
    #[arg(long, value_name = "FILE.rrd", conflicts_with = "connect")]
    pub(crate) save: Option<PathBuf>,
    /// Sends to a running Rerun viewer [default URL: the one on this machine].
    #[arg(long, value_name = "URL", num_args = 0..=1, default_missing_value = "")]
    pub(crate) connect: Option<String>,
}
