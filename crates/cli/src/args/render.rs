//! Command line of what is rendered: `dsslam demo` and `dsslam synth`.

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use synth::Preset;

use super::ShowArgs;

/// Arguments of `dsslam demo`.
#[derive(Debug, Args)]
pub(crate) struct DemoArgs {
    /// The course to render.
    #[command(flatten)]
    pub(crate) world: WorldArgs,
    /// Overrides one key of the configuration; may be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) overrides: Vec<String>,
    /// Writes the results into this folder instead of results/PRESET/TIME.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Visualization.
    #[command(flatten)]
    pub(crate) show: ShowArgs,
    /// Prints summary.json and nothing else on standard output.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Arguments of `dsslam synth`.
#[derive(Debug, Args)]
pub(crate) struct SynthArgs {
    /// Folder to write.
    #[arg(value_name = "OUT")]
    pub(crate) out: PathBuf,
    /// The course to render.
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
    /// Also writes depth/: 16-bit depth of the left image, 256 per meter.
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
    /// Number of stereo frames [default: all rounds].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) frames: Option<u32>,
    /// Number of times the closed course is driven.
    #[arg(long, value_name = "R", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100))]
    pub(crate) rounds: u32,
    /// Changes the light in each round after the first, alternating between a low, strong sun with hard contrast and an overcast, hazy
    /// sky, with another exposure; needs --rounds. Geometry, traffic, depth and labels stay as they are.
    #[arg(long)]
    pub(crate) relight: bool,
    /// Stops after 40 m and turns the camera on the spot by these angles, one after the other, in degrees and to the right; drives on
    /// with the camera turned by their sum.
    #[arg(long, value_name = "DEG,DEG,...", value_delimiter = ',', allow_hyphen_values = true, value_parser = turn)]
    pub(crate) turns: Vec<f64>,
    /// Seed of the world: equal seeds give equal images.
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub(crate) seed: u64,
}

/// Reads an angle.
fn turn(text: &str) -> Result<f64, String> {
    let angle = text.parse().ok().filter(|angle: &f64| angle.abs() <= 3600.0);
    angle.ok_or_else(|| "expected degrees from -3600 to 3600".to_owned())
}

/// Reads the name of a preset; `--help` lists them.
fn preset_parser() -> impl TypedValueParser<Value = Preset> {
    let possible = |preset: Preset| PossibleValue::new(preset.name()).help(preset.about());
    PossibleValuesParser::new(Preset::ALL.map(possible)).try_map(|name| name.parse::<Preset>())
}
