//! Command line of `dsslam eval places`.

use std::fmt;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::args::{NetworkArgs, SettingsArgs};

/// Arguments of `dsslam eval places`.
#[derive(Debug, Args)]
pub(crate) struct PlacesArgs {
    /// Folder of the sequence.
    #[arg(value_name = "SEQUENCE")]
    pub(super) sequence: PathBuf,
    /// Poses of all frames (KITTI, TUM or EuRoC) [default: those of the sequence].
    #[arg(long, value_name = "FILE")]
    pub(super) ground_truth: Option<PathBuf>,
    /// Selections to compare [default: all three]; may be repeated.
    #[arg(long, value_enum, value_name = "WHICH")]
    selection: Vec<Selection>,
    /// Folder for tables and figure.
    #[arg(long, value_name = "DIR")]
    pub(super) out: PathBuf,
    /// Features kept per image.
    #[arg(long, value_name = "N", default_value_t = 500, value_parser = clap::value_parser!(u32).range(20..=100_000))]
    pub(super) keep: u32,
    /// Spreads the kept features over the image, as a run does; the default keeps the best ones wherever they are, as
    /// in the paper.
    #[arg(long)]
    pub(super) cells: bool,
    /// Uses only every N-th frame.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) every: u32,
    /// Minimum number of frames between query and answer.
    #[arg(long, value_name = "FRAMES", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) gap: u32,
    /// Maximum distance between two frames of the same place, meters.
    #[arg(long, value_name = "M", default_value_t = 4.0)]
    pub(super) radius: f64,
    /// Maximum angle between their viewing directions, degrees; 180 accepts opposite directions.
    #[arg(long, value_name = "DEG", default_value_t = 45.0)]
    pub(super) max_angle: f64,
    /// Answers with the most similar earlier frame alone, as in the paper; the default also counts the images before, and lets
    /// geometry choose among 15.
    #[arg(long)]
    pub(super) single: bool,
    /// Dense learned features instead of ORB: XFeat as ONNX.
    #[arg(long, value_name = "FILE")]
    pub(super) features_model: Option<PathBuf>,
    /// Vocabulary for ORB [default: built in].
    #[arg(long, value_name = "FILE")]
    pub(super) vocab: Option<PathBuf>,
    /// The configuration.
    #[command(flatten)]
    pub(super) settings: SettingsArgs,
    /// The network of `seman` and `ours`.
    #[command(flatten)]
    pub(super) network: NetworkArgs,
}

impl PlacesArgs {
    /// The selections to compare, all in the order of the paper's table where none is named.
    pub(super) fn selections(&self) -> Vec<Selection> {
        let all = Selection::value_variants();
        if self.selection.is_empty() { all.to_vec() } else { self.selection.clone() }
    }

    /// Smallest number of chosen frames between query and answer.
    pub(super) fn min_gap(&self) -> usize {
        (self.gap as usize).div_ceil(self.every as usize).max(1)
    }
}

/// A selection of features for place recognition.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Selection {
    /// Highest response.
    Trad,
    /// Highest response off what may move.
    Seman,
    /// Highest activation of what is lasting.
    Ours,
}

impl fmt::Display for Selection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Trad => "trad",
            Self::Seman => "seman",
            Self::Ours => "ours",
        })
    }
}
