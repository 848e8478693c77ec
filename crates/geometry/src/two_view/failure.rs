//! Why two views are not reconstructed, as values with numbers.

use super::TwoViewModel;

/// Why two views give no map; a later second view may.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum TwoViewFailure {
    /// Too few matches with a weight.
    #[error("too few matches between the two views: {found} of {needed}")]
    TooFewMatches {
        /// Matches there are.
        found: usize,
        /// Matches needed.
        needed: usize,
    },
    /// Neither a homography nor a fundamental matrix explains the matches.
    #[error("neither a homography nor a fundamental matrix explains the {n_matches} matches")]
    NoModel {
        /// Matches that were tried.
        n_matches: usize,
    },
    /// Too few matches agree with the best motion.
    #[error("too few matches agree with the motion: {found} of {needed} ({model}, {n_inliers} inliers)")]
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
    #[error("too little parallax: {found_deg:.2} of {needed_deg:.2} degrees ({model})")]
    TooLittleParallax {
        /// The model it came from.
        model: TwoViewModel,
        /// Parallax that enough matches reach, degrees.
        found_deg: f64,
        /// Parallax needed, degrees.
        needed_deg: f64,
    },
    /// Two different motions explain the matches.
    #[error(
        "two motions explain the views: the second {:.0} % as well as the first, at most {:.0} % allowed ({model})",
        100.0 * share,
        100.0 * max_share
    )]
    Ambiguous {
        /// The model they came from.
        model: TwoViewModel,
        /// How much another motion explains of what the best one does.
        share: f64,
        /// Largest share that is accepted.
        max_share: f64,
    },
    /// The matches leave the direction of the move uncertain.
    #[error(
        "the direction of the move is uncertain: by {found_deg:.1} degrees, at most {max_deg:.1} allowed ({model})"
    )]
    Uncertain {
        /// The model it came from.
        model: TwoViewModel,
        /// Standard deviation of the direction, degrees.
        found_deg: f64,
        /// Largest that is accepted, degrees.
        max_deg: f64,
    },
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
