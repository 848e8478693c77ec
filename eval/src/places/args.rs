//! Command line of `dsslam eval places`.

use std::fmt;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

/// Below `dsslam eval places --help`.
pub(crate) const HELP: &str = "\
Examples:
  dsslam eval places kitti/sequences/06 --out /tmp/places
  dsslam eval places town --selection trad --every 2 --out /tmp/places

Selections: trad (highest response), seman (the same off what may move), ours (highest activation).
weights.words=false (--set) makes all words count alike; by default they count as far as their features are trusted.
Files: areas.csv (a row per selection), places.csv (a row per query), curves.csv, precision_recall.png and .svg.";

/// Arguments of `dsslam eval places`.
#[derive(Debug, Args)]
pub(crate) struct PlacesArgs {
    /// Folder of the sequence.
    #[arg(value_name = "SEQUENCE")]
    pub(super) sequence: PathBuf,
    /// Poses of all frames (KITTI, TUM or EuRoC), by default those of the sequence.
    #[arg(long, value_name = "FILE")]
    pub(super) ground_truth: Option<PathBuf>,
    /// Selections to compare; by default all three. May be given several times.
    #[arg(long, value_enum, value_name = "WHICH")]
    selection: Vec<Selection>,
    /// Folder for tables and figure.
    #[arg(long, value_name = "DIR")]
    pub(super) out: PathBuf,
    /// Features kept per image.
    #[arg(long, value_name = "N", default_value_t = 500, value_parser = clap::value_parser!(u32).range(20..=100_000))]
    pub(super) keep: u32,
    /// Spreads the features kept over the image, as in a run; without it the best ones are kept wherever they are, as the
    /// paper does.
    #[arg(long)]
    pub(super) cells: bool,
    /// Takes only every so many frames.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) every: u32,
    /// Smallest number of frames of the sequence between query and answer.
    #[arg(long, value_name = "FRAMES", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) gap: u32,
    /// Largest distance of two frames at the same place, meters.
    #[arg(long, value_name = "M", default_value_t = 4.0)]
    pub(super) radius: f64,
    /// Largest angle between their viewing directions, degrees; 180 accepts opposite directions.
    #[arg(long, value_name = "DEG", default_value_t = 45.0)]
    pub(super) max_angle: f64,
    /// Dense learned features instead of ORB: XFeat as ONNX.
    #[arg(long, value_name = "FILE")]
    pub(super) features_model: Option<PathBuf>,
    /// Vocabulary for ORB, by default the one that is part of the program.
    #[arg(long, value_name = "FILE")]
    pub(super) vocab: Option<PathBuf>,
    /// Configuration file (YAML); what it leaves out has its default.
    #[arg(long, value_name = "FILE")]
    pub(super) config: Option<PathBuf>,
    /// Overrides one key of the configuration; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(super) overrides: Vec<String>,
    /// Network (ONNX) of `ours` instead of the one that is part of the program: grey image in, activation map out.
    #[arg(long, value_name = "FILE", help_heading = "Network")]
    pub(super) dsfeat_model: Option<PathBuf>,
    /// ONNX Runtime's library; by default that of ORT_DYLIB_PATH, else libonnxruntime.so beside the program, in
    /// ~/.local/share/dsslam or in the system's folders.
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
    /// Highest activation.
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
