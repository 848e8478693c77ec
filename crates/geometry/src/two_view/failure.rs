//! Why two views are not reconstructed, as values with numbers.

use super::TwoViewModel;
use std::fmt;

/// Why two views give no map; a later second view may.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TwoViewFailure {
    /// Too few matches with a weight.
    TooFewMatches {
        /// Matches there are.
        found: usize,
        /// Matches needed.
        needed: usize,
    },
    /// Neither a homography nor a fundamental matrix explains the matches.
    NoModel {
        /// Matches that were tried.
        n_matches: usize,
    },
    /// Too few matches agree with the best motion.
    TooFewPoints {
        /// The model it came from.
        model: TwoViewModel,
        /// Matches that agree.
        found: usize,
        /// Matches needed.
        needed: usize,
        /// Matches that the model explains.
        n_inliers: usize,
    },
    /// The camera moved too little for what it sees.
    TooLittleParallax {
        /// The model it came from.
        model: TwoViewModel,
        /// Parallax that enough matches reach, degrees.
        found_deg: f64,
        /// Parallax needed, degrees.
        needed_deg: f64,
    },
    /// Two different motions explain the matches.
    Ambiguous {
        /// The model they came from.
        model: TwoViewModel,
        /// How much another motion explains of what the best one does.
        share: f64,
        /// Largest share that is accepted.
        max_share: f64,
    },
    /// The matches leave the direction of the move uncertain.
    Uncertain {
        /// The model it came from.
        model: TwoViewModel,
        /// Standard deviation of the direction, degrees.
        found_deg: f64,
        /// Largest that is accepted, degrees.
        max_deg: f64,
    },
}

impl fmt::Display for TwoViewFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFewMatches { found, needed } => {
                write!(f, "too few matches between the two views: {found} of {needed}")
            }
            Self::NoModel { n_matches } => {
                write!(f, "neither a homography nor a fundamental matrix explains the {n_matches} matches")
            }
            Self::TooFewPoints { model, found, needed, n_inliers } => write!(
                f,
                "too few matches agree with the motion: {found} of {needed} ({model}, {n_inliers} inliers)"
            ),
            Self::TooLittleParallax { model, found_deg, needed_deg } => {
                write!(f, "too little parallax: {found_deg:.2} of {needed_deg:.2} degrees ({model})")
            }
            Self::Ambiguous { model, share, max_share } => write!(
                f,
                "two motions explain the views: the second {:.0} % as well as the first, at most {:.0} % allowed ({model})",
                100.0 * share,
                100.0 * max_share
            ),
            Self::Uncertain { model, found_deg, max_deg } => write!(
                f,
                "the direction of the move is uncertain: by {found_deg:.1} degrees, at most {max_deg:.1} allowed ({model})"
            ),
        }
    }
}

impl TwoViewFailure {
    /// The failure in a few words without numbers, the same for every pair of views that fails so.
    pub fn cause(&self) -> &'static str {
        match self {
            Self::TooFewMatches { .. } => "too few matches between two views",
            Self::NoModel { .. } => "no motion explains the matches between two views",
            Self::TooFewPoints { .. } => "too few matches agree with the motion between two views",
            Self::TooLittleParallax { .. } => "too little parallax",
            Self::Ambiguous { .. } => "two motions explain the views equally well",
            Self::Uncertain { .. } => "the direction of the move is uncertain",
        }
    }
}

impl std::error::Error for TwoViewFailure {}
