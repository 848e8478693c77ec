//! Command line of `dsslam places`.

use std::fmt;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::{NetworkArgs, SettingsArgs};

/// Arguments of `dsslam places`.
#[derive(Debug, Args)]
pub(crate) struct PlacesArgs {
    /// Folder of the sequence.
    #[arg(value_name = "SEQUENCE")]
    pub(crate) sequence: PathBuf,
    /// Poses of all frames (KITTI, TUM or EuRoC), by default those of the sequence.
    #[arg(long, value_name = "FILE")]
    pub(crate) ground_truth: Option<PathBuf>,
    /// Selections to compare; by default all three. May be given several times.
    #[arg(long, value_enum, value_name = "WHICH")]
    pub(crate) selection: Vec<PlaceSelection>,
    /// Folder for tables and figure.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Features kept per image.
    #[arg(long, value_name = "N", default_value_t = 500, value_parser = clap::value_parser!(u32).range(20..=100_000))]
    pub(crate) keep: u32,
    /// Spreads the features kept over the image, as in a run; without it the best ones are kept wherever they are, as the
    /// paper does.
    #[arg(long)]
    pub(crate) cells: bool,
    /// Takes only every so many frames.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) every: u32,
    /// Smallest number of frames of the sequence between query and answer.
    #[arg(long, value_name = "FRAMES", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) gap: u32,
    /// Largest distance of two frames at the same place, metres.
    #[arg(long, value_name = "M", default_value_t = 4.0)]
    pub(crate) radius: f64,
    /// Largest angle between their viewing directions, degrees; 180 accepts opposite directions.
    #[arg(long, value_name = "DEG", default_value_t = 45.0)]
    pub(crate) max_angle: f64,
    /// Dense learned features instead of ORB: XFeat as ONNX.
    #[arg(long, value_name = "FILE")]
    pub(crate) features_model: Option<PathBuf>,
    /// Vocabulary for ORB, by default the one that is part of the program.
    #[arg(long, value_name = "FILE")]
    pub(crate) vocab: Option<PathBuf>,
    /// The configuration.
    #[command(flatten)]
    pub(crate) settings: SettingsArgs,
    /// The network of `ours`.
    #[command(flatten)]
    pub(crate) network: NetworkArgs,
}

impl PlacesArgs {
    /// Smallest number of chosen frames between query and answer.
    pub(crate) fn min_gap(&self) -> usize {
        (self.gap as usize).div_ceil(self.every as usize).max(1)
    }
}

/// A selection of features for place recognition.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PlaceSelection {
    /// Highest response.
    Trad,
    /// Highest response off what may move.
    Seman,
    /// Highest activation.
    Ours,
}

impl PlaceSelection {
    /// All of them, in the order of the paper's table.
    pub(crate) const ALL: [Self; 3] = [Self::Trad, Self::Seman, Self::Ours];
}

impl fmt::Display for PlaceSelection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Trad => "trad",
            Self::Seman => "seman",
            Self::Ours => "ours",
        })
    }
}
