//! Command line of the groups of commands: `dsslam inspect`, `dsslam eval` and `dsslam shell`; and where commands have moved.

use clap::Subcommand;
use eval::command::EvalCommand;

use super::{ActivationArgs, VocabAction};
use crate::bag::BagArgs;
use crate::help;
use crate::places::PlacesArgs;
use crate::shell::{CompletionsArgs, ManArgs};
use crate::stage::{FeaturesArgs, MatchArgs, StereoArgs};

/// What `dsslam inspect` can look at.
#[derive(Debug, Subcommand)]
pub(crate) enum Inspect {
    /// Draws the keypoints of an image.
    #[command(after_help = help::with_codes(include_str!("../../help/features.txt")))]
    Features(FeaturesArgs),
    /// Draws the matches of two images, inliers and outliers of one motion.
    #[command(after_help = help::with_codes(include_str!("../../help/match.txt")))]
    Match(MatchArgs),
    /// Draws the disparities of a stereo frame.
    #[command(after_help = help::with_codes(include_str!("../../help/stereo.txt")))]
    Stereo(StereoArgs),
    /// Draws the activation of an image as a heat map, with the features that a selection keeps and drops.
    #[command(after_help = help::with_codes(include_str!("../../help/activation.txt")))]
    Activation(ActivationArgs),
    /// Lists the topics of a bag (rosbag2, MCAP, ROS 1) and what a run takes of it.
    #[command(after_help = help::with_codes(include_str!("../../help/bag.txt")))]
    Bag(BagArgs),
    /// Trains, describes and converts vocabularies for place recognition.
    #[command(subcommand, after_help = help::with_codes(include_str!("../../help/vocab.txt")))]
    Vocab(VocabAction),
}

/// What `dsslam eval` does.
#[derive(Debug, Subcommand)]
pub(crate) enum Eval {
    /// With files of trajectories, loops and results.
    #[command(flatten)]
    Of(EvalCommand),
    /// Recognizes places in a sequence with three selections of features: precision-recall curves and their areas.
    #[command(after_help = include_str!("../../help/places.txt"))]
    Places(PlacesArgs),
}

/// What `dsslam shell` prints.
#[derive(Debug, Subcommand)]
pub(crate) enum ShellCommand {
    /// Prints shell completions.
    #[command(after_help = help::with_codes(include_str!("../../help/completions.txt")))]
    Completions(CompletionsArgs),
    /// Prints the manual page, or writes the pages of all commands into a folder.
    #[command(after_help = help::with_codes(include_str!("../../help/man.txt")))]
    Man(ManArgs),
}

/// Commands of earlier versions, with their names now.
const MOVED: &[(&str, &str)] = &[
    ("features", "inspect features"),
    ("match", "inspect match"),
    ("stereo", "inspect stereo"),
    ("activation", "inspect activation"),
    ("vocab", "inspect vocab"),
    ("places", "eval places"),
    ("completions", "shell completions"),
    ("man", "shell man"),
];

/// Where a command that is not known any more has gone.
pub(crate) fn moved(name: &str) -> Option<String> {
    let (old, new) = MOVED.iter().find(|(old, _)| *old == name)?;
    Some(format!("`dsslam {old}` is now `dsslam {new}`"))
}
