//! Command line of `dsslam run`.

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use io::{Sensor, Variant};

use super::{NetworkArgs, SettingsArgs, ShowArgs};

/// Arguments of `dsslam run`.
#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// Folder of the sequence (KITTI odometry, TUM RGB-D, EuRoC, or images with a calibration file), a bag (rosbag2, MCAP,
    /// ROS 1), a video, or a camera such as /dev/video0.
    #[arg(value_name = "SEQUENCE")]
    pub(crate) sequence: PathBuf,
    /// The configuration.
    #[command(flatten)]
    pub(crate) settings: SettingsArgs,
    /// Calibration file of the cameras, for images and videos: DSSLAM's YAML, EuRoC's sensor.yaml, BoofCV's XML.
    #[arg(long, value_name = "FILE")]
    pub(crate) calib: Option<PathBuf>,
    /// Topics of a bag [default: by their names and types]: left=TOPIC and right=TOPIC or depth=TOPIC.
    #[arg(long, value_name = "ROLE=TOPIC,...")]
    pub(crate) topics: Option<bag::Roles>,
    /// How to use the images [default: the richest sensor that the folder offers].
    #[arg(long, value_parser = sensor_parser())]
    pub(crate) sensor: Option<Sensor>,
    /// Writes the results into this folder instead of results/SEQUENCE/TIME.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Prints summary.json and nothing else on standard output.
    #[arg(long)]
    pub(crate) json: bool,
    /// Refuses the run where a figure is doubtful, such as the focal length or the unit of depth; otherwise that is a warning.
    #[arg(long)]
    pub(crate) strict: bool,
    /// Stops after this many frames.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) max_frames: Option<u32>,
    /// Runs on a variant of the sequence: words joined by '-' of reversed, mirrored, every2, start10, gain1.2, noise5, seed1.
    #[arg(long, value_name = "VARIANT", help_heading = "Evaluation", default_value_t = Variant::default(), hide_default_value = true)]
    pub(crate) variant: Variant,
    /// Ground truth in KITTI's, TUM's or EuRoC's format instead of the sequence's own, of the same body (KITTI: camera 0, EuRoC: the
    /// IMU); or a topic of a bag with poses.
    #[arg(long, value_name = "FILE", help_heading = "Evaluation")]
    pub(crate) ground_truth: Option<PathBuf>,
    /// Segment lengths of t_rel and r_rel, meters.
    #[arg(long, value_name = "M,M,...", value_delimiter = ',', default_values_t = eval::KITTI_LENGTHS_M, help_heading = "Evaluation")]
    pub(crate) lengths: Vec<f64>,
    /// How the stages of the run are scheduled [default: lockstep; live for cameras].
    #[arg(long, value_enum, help_heading = "Schedule")]
    pub(crate) schedule: Option<ScheduleArg>,
    /// With --schedule live: feeds frames at the pace of their timestamps and skips them while tracking is behind.
    #[arg(long, help_heading = "Schedule")]
    pub(crate) realtime: bool,
    /// Records the order of events, so that --replay can repeat the run bit for bit.
    #[arg(long, value_name = "FILE", help_heading = "Schedule")]
    pub(crate) journal: Option<PathBuf>,
    /// Replays a recorded run (--journal) bit for bit; sequence, configuration, vocabulary and start map must be the same.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["schedule", "realtime", "journal"], help_heading = "Schedule")]
    pub(crate) replay: Option<PathBuf>,
    /// Disables loop closing: the same as --set loops.enabled=false.
    #[arg(long, help_heading = "Places and maps")]
    pub(crate) no_loops: bool,
    /// The network that selects features.
    #[command(flatten)]
    pub(crate) network: NetworkArgs,
    /// Test aid: seed of random pauses of all stages, on which no result may depend.
    #[arg(long, value_name = "SEED", hide = true)]
    pub(crate) delays: Option<u64>,
    /// Vocabulary for place recognition, in DSSLAM's or ORB-SLAM2's format [default: built in].
    #[arg(long, value_name = "FILE", help_heading = "Places and maps")]
    pub(crate) vocab: Option<PathBuf>,
    /// Saves the map at the end of the run.
    #[arg(long, value_name = "FILE", help_heading = "Places and maps")]
    pub(crate) save_map: Option<PathBuf>,
    /// Resumes from a saved map.
    #[arg(long, value_name = "FILE", help_heading = "Places and maps")]
    pub(crate) load_map: Option<PathBuf>,
    /// With --load-map: only localizes the camera in the map and adds nothing to it.
    #[arg(long, requires = "load_map", help_heading = "Places and maps")]
    pub(crate) localize: bool,
    /// Visualization.
    #[command(flatten)]
    pub(crate) show: ShowArgs,
}

/// How the stages of a run are scheduled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ScheduleArg {
    /// One after another on one thread.
    Sequential,
    /// Each on a thread of its own, with the same results as one after another.
    Lockstep,
    /// Each on a thread of its own; tracking never waits for the map.
    Live,
}

/// Reads a sensor's word; the help names all of them.
fn sensor_parser() -> impl TypedValueParser<Value = Sensor> {
    let possible = |sensor: Sensor| {
        PossibleValue::new(sensor.word()).help(match sensor {
            Sensor::Stereo => "Two rectified cameras",
            Sensor::Rgbd => "A camera and registered depth images",
            Sensor::Mono => "One camera: the scale of trajectory and map is free",
        })
    };
    PossibleValuesParser::new(Sensor::ALL.map(possible)).try_map(|word| word.parse::<Sensor>())
}
