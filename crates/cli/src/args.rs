//! The command line: parsed without side effects, resolved by the commands.

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand, ValueEnum};
use synth::Preset;

use crate::config::CheckArgs;
use crate::console::Voice;
use crate::doctor::DoctorArgs;
use crate::export::ExportArgs;
use crate::help;
use crate::network_args::{ActivationArgs, NetworkArgs, PlacesArgs};
use crate::shell::{CompletionsArgs, ManArgs};
use crate::stage::{FeaturesArgs, MatchArgs, StereoArgs};

/// Visual SLAM: images in, trajectory and map out.
///
/// Estimates the path of a camera (stereo, RGB-D) and a map of what it saw.
#[derive(Debug, Parser)]
#[command(name = "dsslam", version, arg_required_else_help = true, after_help = help::top(), max_term_width = 110)]
pub(crate) struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub(crate) command: Command,
    /// How much is said.
    #[command(flatten)]
    pub(crate) voice: Voice,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Runs SLAM on a sequence of images.
    #[command(after_help = help::run())]
    Run(RunArgs),
    /// Renders a street course, runs SLAM on it, prints the errors and draws the trajectory. Needs no data.
    #[command(after_help = help::demo())]
    Demo(DemoArgs),
    /// Renders a street course with exact ground truth as a dataset in KITTI's or EuRoC's layout.
    #[command(after_help = help::synth())]
    Synth(SynthArgs),
    /// Shows a finished run in the Rerun viewer: trajectory, ground truth, errors, times; with events.dslog everything.
    #[command(after_help = help::view())]
    View(ViewArgs),
    /// Evaluates trajectories against ground truth, as tables and plots.
    #[command(after_help = help::eval())]
    Eval(eval::command::EvalCommand),
    /// Draws what the network thinks of an image: activation as a heat map, features kept and dropped.
    #[command(after_help = help::activation())]
    Activation(ActivationArgs),
    /// Recognises places in a sequence with three selections of features: precision-recall curves and their areas.
    #[command(after_help = help::places())]
    Places(PlacesArgs),
    /// Prints the default configuration, or checks and explains one.
    #[command(after_help = help::config())]
    Config(ConfigArgs),
    /// Trains a vocabulary of place recognition, describes one, converts between file formats.
    #[command(after_help = help::vocab())]
    Vocab(VocabArgs),
    /// Writes a map for other programs: points, models for COLMAP and nerfstudio, trajectories of the keyframes.
    #[command(after_help = help::export())]
    Export(ExportArgs),
    /// Draws the key-points of an image.
    #[command(after_help = help::features())]
    Features(FeaturesArgs),
    /// Draws the matches of two images, sorted by whether one motion explains them.
    #[command(after_help = help::matching())]
    Match(MatchArgs),
    /// Draws the disparities of a stereo frame.
    #[command(after_help = help::stereo())]
    Stereo(StereoArgs),
    /// Says what is on this machine, what is missing, and how to get it.
    #[command(after_help = help::doctor())]
    Doctor(DoctorArgs),
    /// Prints the completions of a shell.
    #[command(after_help = help::completions())]
    Completions(CompletionsArgs),
    /// Prints the manual page, or writes those of all commands into a folder.
    #[command(after_help = help::man())]
    Man(ManArgs),
}

/// Arguments of `dsslam run`.
#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// Folder of the sequence: KITTI odometry, TUM RGB-D, EuRoC, or images with a calibration file; or a video, or a camera such as
    /// /dev/video0.
    #[arg(value_name = "SEQUENCE")]
    pub(crate) sequence: PathBuf,
    /// Configuration file (YAML); what it leaves out has its default.
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// Calibration file of the cameras, for images and videos: DSSLAM's YAML, EuRoC's sensor.yaml, BoofCV's XML.
    #[arg(long, value_name = "FILE")]
    pub(crate) calib: Option<PathBuf>,
    /// How to use the images; by default what the folder holds.
    #[arg(long, value_enum)]
    pub(crate) sensor: Option<SensorArg>,
    /// Overrides one key of the configuration; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) overrides: Vec<String>,
    /// Writes the results into this folder instead of results/SEQUENCE/TIME.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Prints the content of summary.json, and nothing else, on standard output.
    #[arg(long)]
    pub(crate) json: bool,
    /// Stops after this many frames.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) max_frames: Option<u32>,
    /// How the stages of the run share time; by default lockstep, of a camera live.
    #[arg(long, value_enum, help_heading = "Schedule")]
    pub(crate) schedule: Option<ScheduleArg>,
    /// With --schedule live: frames come at the pace of their timestamps, and are skipped while tracking is behind.
    #[arg(long, help_heading = "Schedule")]
    pub(crate) realtime: bool,
    /// Writes what happened in which order, so that --replay does the run again, bit for bit.
    #[arg(long, value_name = "FILE", help_heading = "Schedule")]
    pub(crate) journal: Option<PathBuf>,
    /// Does the run of a journal again; sequence, configuration, vocabulary and start map must be those of that run.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["schedule", "realtime", "journal"], help_heading = "Schedule")]
    pub(crate) replay: Option<PathBuf>,
    /// Does not look for places seen before: the same as --set loops.enabled=false.
    #[arg(long, help_heading = "Places and maps")]
    pub(crate) no_loops: bool,
    /// The network that selects features.
    #[command(flatten)]
    pub(crate) network: NetworkArgs,
    /// Test aid: seed of random pauses of all stages, on which no result may depend.
    #[arg(long, value_name = "SEED", hide = true)]
    pub(crate) delays: Option<u64>,
    /// Vocabulary to recognise places with, in DSSLAM's or ORB-SLAM2's format; by default the one that is part of the
    /// program.
    #[arg(long, value_name = "FILE", help_heading = "Places and maps")]
    pub(crate) vocab: Option<PathBuf>,
    /// Writes the map at the end of the run.
    #[arg(long, value_name = "FILE", help_heading = "Places and maps")]
    pub(crate) save_map: Option<PathBuf>,
    /// Goes on with the map of a file.
    #[arg(long, value_name = "FILE", help_heading = "Places and maps")]
    pub(crate) load_map: Option<PathBuf>,
    /// With --load-map: only finds the camera in the map and inserts nothing.
    #[arg(long, requires = "load_map", help_heading = "Places and maps")]
    pub(crate) localize: bool,
    /// Who watches the run.
    #[command(flatten)]
    pub(crate) show: ShowArgs,
}

/// Who watches a run.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Watching")]
pub(crate) struct ShowArgs {
    /// Writes events.dslog into the results folder: what `dsslam view` shows of the run later.
    #[arg(long)]
    pub(crate) events: bool,
    /// Opens the Rerun viewer and shows the run while it goes on.
    #[arg(long)]
    pub(crate) rerun: bool,
    /// Writes a file for the Rerun viewer.
    #[arg(long, value_name = "FILE.rrd", conflicts_with = "rerun")]
    pub(crate) rerun_save: Option<PathBuf>,
    /// Streams to a Rerun viewer that is running; without URL to the one on this machine.
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
    /// Shows the other files of the folder, not events.dslog, with the map of this file, as --save-map has written it.
    #[arg(long, value_name = "FILE.dsmap")]
    pub(crate) map: Option<PathBuf>,
    /// Writes a file for the Rerun viewer instead of opening it.
    #[arg(long, value_name = "FILE.rrd", conflicts_with = "connect")]
    pub(crate) save: Option<PathBuf>,
    /// Sends to a Rerun viewer that is running; without URL to the one on this machine.
    #[arg(long, value_name = "URL", num_args = 0..=1, default_missing_value = "")]
    pub(crate) connect: Option<String>,
}

/// How the stages of a run share time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ScheduleArg {
    /// One after another on one thread.
    Sequential,
    /// Each on a thread of its own, with the same results as one after another.
    Lockstep,
    /// Each on a thread of its own; tracking never waits for the map.
    Live,
}

/// How the images of a sequence are used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum SensorArg {
    /// Two rectified cameras.
    Stereo,
    /// A camera and registered depth images.
    Rgbd,
    /// One camera: the scale of trajectory and map is free.
    Mono,
}

impl From<SensorArg> for io::Sensor {
    fn from(sensor: SensorArg) -> Self {
        match sensor {
            SensorArg::Stereo => io::Sensor::Stereo,
            SensorArg::Rgbd => io::Sensor::Rgbd,
            SensorArg::Mono => io::Sensor::Mono,
        }
    }
}

/// Arguments of `dsslam demo`.
#[derive(Debug, Args)]
pub(crate) struct DemoArgs {
    /// The course that is rendered.
    #[command(flatten)]
    pub(crate) world: WorldArgs,
    /// Overrides one key of the configuration; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) overrides: Vec<String>,
    /// Writes the results into this folder instead of results/PRESET/TIME.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Who watches the run.
    #[command(flatten)]
    pub(crate) show: ShowArgs,
    /// Prints the content of summary.json, and nothing else, on standard output.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Arguments of `dsslam synth`.
#[derive(Debug, Args)]
pub(crate) struct SynthArgs {
    /// Folder to write.
    #[arg(value_name = "OUT")]
    pub(crate) out: PathBuf,
    /// The course that is rendered.
    #[command(flatten)]
    pub(crate) world: WorldArgs,
    /// Layout of the folder.
    #[arg(long, value_enum, default_value_t = LayoutArg::Kitti)]
    pub(crate) layout: LayoutArg,
    /// With --layout euroc: lens of the raw cameras, radtan or fisheye.
    #[arg(long, default_value_t = LensArg::Radtan, value_enum)]
    pub(crate) lens: LensArg,
    /// Also writes masks/: what is moving, parked, sky or still in each pixel of the left image.
    #[arg(long)]
    pub(crate) masks: bool,
    /// Also writes depth/: 16-bit depth of the left image, 256 per metre.
    #[arg(long)]
    pub(crate) depth: bool,
}

/// Layout of a rendered dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum LayoutArg {
    /// KITTI odometry: rectified images, calib.txt, times.txt, poses.txt.
    Kitti,
    /// EuRoC: raw images of two cameras that are turned against each other, sensor.yaml, poses of the body.
    Euroc,
}

/// Lens of rendered raw cameras.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum LensArg {
    /// Radial and tangential distortion, 79 degrees wide.
    Radtan,
    /// Equidistant, 111 degrees wide.
    Fisheye,
}

impl From<LensArg> for synth::Lens {
    fn from(lens: LensArg) -> Self {
        match lens {
            LensArg::Radtan => synth::Lens::Radtan,
            LensArg::Fisheye => synth::Lens::Fisheye,
        }
    }
}

/// Which world is rendered and how far the camera drives.
#[derive(Debug, Args)]
pub(crate) struct WorldArgs {
    /// Kind of world.
    #[arg(long, default_value_t = Preset::Town, value_parser = preset_parser())]
    pub(crate) preset: Preset,
    /// Number of stereo frames; by default all of the rounds.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) frames: Option<u32>,
    /// How often the closed course is driven.
    #[arg(long, value_name = "R", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100))]
    pub(crate) rounds: u32,
    /// Seed of the world: equal seeds give equal images.
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub(crate) seed: u64,
}

/// Reads the name of a preset; `--help` lists them.
fn preset_parser() -> impl TypedValueParser<Value = Preset> {
    PossibleValuesParser::new(Preset::ALL.map(Preset::name)).try_map(|name| name.parse::<Preset>())
}

/// Arguments of `dsslam config`.
#[derive(Debug, Args)]
pub(crate) struct ConfigArgs {
    /// What to do with the configuration.
    #[command(subcommand)]
    pub(crate) action: ConfigAction,
}

/// What `dsslam config` can do.
#[derive(Debug, Subcommand)]
pub(crate) enum ConfigAction {
    /// Prints the complete default configuration as YAML.
    Default,
    /// Checks a configuration and explains every value in force: where it comes from, what it means, what it may be.
    Check(CheckArgs),
}

/// Arguments of `dsslam vocab`.
#[derive(Debug, Args)]
pub(crate) struct VocabArgs {
    /// What to do with a vocabulary.
    #[command(subcommand)]
    pub(crate) action: VocabAction,
}

/// What `dsslam vocab` can do.
#[derive(Debug, Subcommand)]
pub(crate) enum VocabAction {
    /// Trains a vocabulary on images; equal images, options and seed give equal bytes.
    Train(VocabTrainArgs),
    /// Describes a vocabulary: size, words, weights, origin.
    Info {
        /// The vocabulary, in either format; by default the one that is part of the program.
        file: Option<PathBuf>,
    },
    /// Converts a vocabulary between DSSLAM's binary format and ORB-SLAM2's text format.
    Convert {
        /// The vocabulary to read; its content tells the format.
        input: PathBuf,
        /// The file to write: in ORB-SLAM2's text format if it ends in .txt, otherwise in DSSLAM's.
        output: PathBuf,
    },
}

/// Arguments of `dsslam vocab train`.
#[derive(Debug, Args)]
pub(crate) struct VocabTrainArgs {
    /// Images, or folders that stand for the .png, .jpg and .jpeg files in them and in their folders, sorted by name.
    #[arg(value_name = "IMAGES", required = true)]
    pub(crate) images: Vec<PathBuf>,
    /// Children of a node.
    #[arg(short = 'k', long, value_name = "K", default_value_t = 10, value_parser = clap::value_parser!(u32).range(2..=i64::from(bow::MAX_BRANCHING)))]
    pub(crate) branching: u32,
    /// Steps from the root to a word.
    #[arg(short = 'l', long, value_name = "L", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=i64::from(bow::MAX_LEVELS)))]
    pub(crate) levels: u32,
    /// The file to write: in ORB-SLAM2's text format if it ends in .txt, otherwise in DSSLAM's.
    #[arg(short = 'o', long, value_name = "FILE")]
    pub(crate) out: PathBuf,
    /// Seed of all random choices.
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub(crate) seed: u64,
    /// Most features taken of an image.
    #[arg(long, value_name = "N", default_value_t = bow::tool::TRAINING_FEATURES as u32, value_parser = clap::value_parser!(u32).range(50..=100_000))]
    pub(crate) keep: u32,
}
