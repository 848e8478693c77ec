//! Command line of `dsslam inspect vocab`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

/// What `dsslam inspect vocab` can do.
#[derive(Debug, Subcommand)]
pub(crate) enum VocabAction {
    /// Trains a vocabulary on images; equal images, options and seed give equal bytes.
    Train(VocabTrainArgs),
    /// Describes a vocabulary: size, words, weights, origin.
    Info {
        /// The vocabulary, in either format [default: built in].
        file: Option<PathBuf>,
    },
    /// Converts a vocabulary between DSSLAM's binary format and ORB-SLAM2's text format.
    Convert {
        /// The vocabulary to read; the format is detected.
        input: PathBuf,
        /// The file to write: in ORB-SLAM2's text format if it ends in .txt, otherwise in DSSLAM's.
        output: PathBuf,
    },
}

/// Arguments of `dsslam inspect vocab train`.
#[derive(Debug, Args)]
pub(crate) struct VocabTrainArgs {
    /// Images, or folders searched recursively for .png, .jpg and .jpeg files, sorted by name.
    #[arg(value_name = "IMAGES", required = true)]
    pub(crate) images: Vec<PathBuf>,
    /// Children per node.
    #[arg(short = 'k', long, value_name = "K", default_value_t = 10, value_parser = clap::value_parser!(u32).range(2..=i64::from(bow::MAX_BRANCHING)))]
    pub(crate) branching: u32,
    /// Depth of the tree.
    #[arg(short = 'l', long, value_name = "L", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=i64::from(bow::MAX_LEVELS)))]
    pub(crate) levels: u32,
    /// The file to write: in ORB-SLAM2's text format if it ends in .txt, otherwise in DSSLAM's.
    #[arg(short = 'o', long, value_name = "FILE")]
    pub(crate) out: PathBuf,
    /// Seed of all random choices.
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub(crate) seed: u64,
    /// Maximum number of features per image.
    #[arg(long, value_name = "N", default_value_t = bow::tool::TRAINING_FEATURES as u32, value_parser = clap::value_parser!(u32).range(50..=100_000))]
    pub(crate) keep: u32,
}
