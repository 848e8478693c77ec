//! The command line: parsed without side effects, resolved by the commands.

mod inspect;
mod network;
mod render;
mod run;
mod settings;
mod show;
mod vocab;

use clap::{Parser, Subcommand};

use crate::bag::BagAction;
use crate::config::{CalibArgs, CheckArgs, DefaultArgs};
use crate::console::Voice;
use crate::doctor::DoctorArgs;
use crate::export::ExportArgs;
use crate::help;

pub(crate) use inspect::{Eval, Inspect, ShellCommand, moved};
pub(crate) use network::{ActivationArgs, NetworkArgs};
pub(crate) use render::{DemoArgs, LayoutArg, SynthArgs, WorldArgs};
pub(crate) use run::{RunArgs, ScheduleArg};
pub(crate) use settings::SettingsArgs;
pub(crate) use show::{ShowArgs, ViewArgs};
pub(crate) use vocab::{VocabAction, VocabTrainArgs};

/// Visual SLAM: images in, trajectory and map out.
///
/// Estimates the path of a camera (stereo, RGB-D or a single one) and a map of what it saw.
#[derive(Debug, Parser)]
#[command(name = "dsslam", version, arg_required_else_help = true, after_help = help::with_codes(include_str!("../../help/dsslam.txt")), max_term_width = 110)]
pub(crate) struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub(crate) command: Command,
    /// Verbosity.
    #[command(flatten)]
    pub(crate) voice: Voice,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Runs SLAM on a sequence of images.
    #[command(after_help = help::with_codes(include_str!("../../help/run.txt")))]
    Run(Box<RunArgs>),
    /// Renders a street course, runs SLAM on it, prints the errors and draws the trajectory. Needs no data.
    #[command(after_help = help::with_codes(include_str!("../../help/demo.txt")))]
    Demo(DemoArgs),
    /// Renders a street course with exact ground truth as a dataset in KITTI's or EuRoC's layout.
    #[command(after_help = help::with_codes(include_str!("../../help/synth.txt")))]
    Synth(SynthArgs),
    /// Shows a finished run in the Rerun viewer: trajectory, ground truth, errors, times; everything if events.dslog was written.
    #[command(after_help = help::with_codes(include_str!("../../help/view.txt")))]
    View(ViewArgs),
    /// Evaluates trajectories and place recognition against ground truth, as tables and plots.
    #[command(subcommand, after_help = help::with_codes(include_str!("../../help/eval.txt")))]
    Eval(Eval),
    /// Prints the default configuration, checks and explains one, or shows what a calibration file says.
    #[command(subcommand, after_help = help::with_codes(include_str!("../../help/config.txt")))]
    Config(ConfigAction),
    /// Converts a map for other programs: point clouds, COLMAP and nerfstudio models, keyframe trajectories.
    #[command(after_help = help::with_codes(include_str!("../../help/export.txt")))]
    Export(ExportArgs),
    /// Looks at single stages: features, matches, disparities, activation; trains and converts vocabularies.
    #[command(subcommand, after_help = help::with_codes(include_str!("../../help/inspect.txt")))]
    Inspect(Inspect),
    /// Lists the topics of a bag: the same as `dsslam inspect bag`.
    #[command(subcommand, hide = true)]
    Bag(BagAction),
    /// Lists what this machine has, what it lacks, and how to install it.
    #[command(after_help = help::with_codes(include_str!("../../help/doctor.txt")))]
    Doctor(DoctorArgs),
    /// Prints completions and manual pages.
    #[command(subcommand, after_help = help::with_codes(include_str!("../../help/shell.txt")))]
    Shell(ShellCommand),
}

/// What `dsslam config` can do.
#[derive(Debug, Subcommand)]
pub(crate) enum ConfigAction {
    /// Prints the default configuration as YAML: the keys of everyday use.
    Default(DefaultArgs),
    /// Checks a configuration and explains every value in force: its origin, meaning and range.
    Check(CheckArgs),
    /// Prints what was understood of a calibration file, in the format of our own.
    Calib(CalibArgs),
}
