//! Why a frame has no pose, as values with numbers.

use std::fmt;

use crate::tracker::NoPair;

/// Why a frame could not be tracked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lost {
    /// Neither the motion model nor the reference keyframe gave enough descriptor matches.
    TooFewMatches {
        /// The best number of matches of all attempts.
        found: usize,
        /// What the attempt would have needed.
        needed: usize,
    },
    /// The pose found by prediction has too few inliers.
    TooFewPredictedInliers {
        /// Inliers of the best attempt.
        found: usize,
        /// What it would have needed.
        needed: usize,
    },
    /// The local map confirms too few points.
    TooFewLocalInliers {
        /// Inlier matches after the last optimization.
        found: usize,
        /// What it would have needed.
        needed: usize,
    },
    /// The local map confirms a pose that no camera can have reached.
    TooFar {
        /// How far it is from where the camera would be had it moved on, meters.
        off_m: f64,
        /// How far it may be, meters.
        most_m: f64,
    },
}

impl Lost {
    /// Of two failed attempts the one that came further; of equals the first.
    #[must_use]
    pub fn further(self, other: Lost) -> Lost {
        let progress = |lost: &Lost| match *lost {
            Lost::TooFewMatches { found, .. } => (0, found),
            Lost::TooFewPredictedInliers { found, .. } => (1, found),
            Lost::TooFewLocalInliers { found, .. } => (2, found),
            Lost::TooFar { .. } => (3, 0),
        };
        if progress(&other) > progress(&self) { other } else { self }
    }

    /// The reason in a few words without numbers.
    pub fn cause(&self) -> &'static str {
        match self {
            Lost::TooFewMatches { .. } => "too few matches with the last frame and the reference keyframe",
            Lost::TooFewPredictedInliers { .. } => "the predicted pose has too few inliers",
            Lost::TooFewLocalInliers { .. } => "the local map confirms too few points",
            Lost::TooFar { .. } => "the pose found is farther away than the camera can have moved",
        }
    }
}

impl fmt::Display for Lost {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.cause())?;
        match self {
            Lost::TooFewMatches { found, needed }
            | Lost::TooFewPredictedInliers { found, needed }
            | Lost::TooFewLocalInliers { found, needed } => write!(f, "{found} of {needed}"),
            Lost::TooFar { off_m, most_m } => {
                write!(f, "{off_m:.2} m from where it would be had it gone on, {most_m:.2} m at most")
            }
        }
    }
}

/// Why the map could not be started with a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NotReady {
    /// Too few features with a depth.
    TooFewDepths {
        /// Features with a depth in this frame.
        found: usize,
        /// What the start needs.
        needed: usize,
        /// All features of this frame.
        features: usize,
    },
    /// No two views with a reliable motion between them yet.
    NoPair(NoPair),
    /// The keyframe that starts the map is not in it yet.
    MapStarting,
}

impl NotReady {
    /// The reason in a few words without numbers.
    pub fn cause(&self) -> &'static str {
        match self {
            NotReady::TooFewDepths { features: 0, .. } => "the image has no features",
            NotReady::TooFewDepths { .. } => "too few features have a depth",
            NotReady::NoPair(reason) => reason.cause(),
            NotReady::MapStarting => "the map is being initialized",
        }
    }
}

impl fmt::Display for NotReady {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NotReady::TooFewDepths { found, needed, features } => write!(
                f,
                "the map cannot start: {found} of {features} features have a depth, {needed} needed"
            ),
            NotReady::NoPair(reason) => write!(f, "the map cannot start: {reason}"),
            NotReady::MapStarting => f.write_str("the map is being initialized"),
        }
    }
}

#[cfg(test)]
#[path = "../tests/steps/lost.rs"]
mod tests;
