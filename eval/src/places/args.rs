//! Command line of `dsslam eval places`.

use std::fmt;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

/// Below `dsslam eval places --help`.
pub(crate) const HELP: &str = "\
Examples:
  dsslam eval places kitti/sequences/06 --out /tmp/places
  dsslam eval places town --selection trad --every 2 --out /tmp/places

Selections: trad (highest response), seman (the same off what may move), ours (highest activation
of what will still be there another day).
By default, words are weighted by what will still be there; --set weights.words=false weights all words equally.
Files: areas.csv (a row per selection), places.csv (a row per query), curves.csv, precision_recall.png and .svg.";

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
    /// Configuration file (YAML); keys that it omits have their defaults.
    #[arg(long, value_name = "FILE")]
    pub(super) config: Option<PathBuf>,
    /// Overrides one key of the configuration; may be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(super) overrides: Vec<String>,
    /// Network (ONNX) of `ours` instead of the built-in one: gray image in, activation map out.
    #[arg(long, value_name = "FILE", help_heading = "Network")]
    pub(super) dsfeat_model: Option<PathBuf>,
    /// ONNX Runtime's library [default: ORT_DYLIB_PATH, else libonnxruntime.so beside the program, in
    /// ~/.local/share/dsslam or in the system folders; without it the network runs several times slower].
    #[arg(long, value_name = "FILE", help_heading = "Network")]
    pub(super) onnxruntime: Option<PathBuf>,
}

impl PlacesArgs {
    /// The selections to compare.
    pub(super) fn selections(&self) -> Vec<Selection> {
        if self.selection.is_empty() { Selection::ALL.to_vec() } else { self.selection.clone() }
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

impl Selection {
    /// All of them, in the order of the paper's table.
    const ALL: [Self; 3] = [Self::Trad, Self::Seman, Self::Ours];
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
