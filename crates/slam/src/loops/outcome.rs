//! Outcome of the search for a loop, as values with numbers.

use std::fmt;

use super::LoopCorrection;
use map::KeyframeId;
use optim::{CycleEdgeKind, Inconsistency, LoopNumbers};

/// The answer for one keyframe.
#[derive(Clone, Debug)]
pub enum LoopOutcome {
    /// No place looks alike; the normal case.
    None(NoLoop),
    /// A place looked alike for long enough, but it is not the same.
    Rejected {
        /// The keyframe of the earlier visit.
        candidate: KeyframeId,
        /// Why it was refused.
        reason: NoLoop,
    },
    /// The place is the same.
    Closed(Box<LoopCorrection>),
}

/// Why there is no loop.
#[derive(Clone, Debug, PartialEq)]
pub enum NoLoop {
    /// Loops are switched off, or there is no vocabulary to recognize places with.
    NoPlaces,
    /// The map is too small, or the last loop too fresh.
    TooEarly {
        /// Keyframes since then.
        keyframes: usize,
        /// How many there must be.
        needed: usize,
    },
    /// No other keyframe looks enough like this one.
    Alone {
        /// The best score of a keyframe that could be here.
        best_score: f64,
        /// What neighboring keyframes have at least.
        min_score: f64,
    },
    /// The place did not look alike for long enough.
    NotYetConsistent {
        /// For how many keyframes in a row before this one it did.
        seen: usize,
        /// How many are needed.
        needed: usize,
    },
    /// Too few descriptors match.
    TooFewMatches {
        /// Matches found.
        found: usize,
        /// Matches needed.
        needed: usize,
    },
    /// No rigid motion explains the matches.
    NoGeometry {
        /// Matches that the best motion explains.
        found: usize,
        /// How many it must explain.
        needed: usize,
    },
    /// The refined motion finds too few of the earlier visit's points.
    TooFewInliers {
        /// Points that agree.
        found: usize,
        /// How many are needed.
        needed: usize,
        /// Points that should be visible.
        visible: usize,
    },
    /// The lengths of both visits differ more than drift explains.
    Scale {
        /// Length now over length then.
        scale: f64,
        /// Largest believable ratio, either way.
        limit: f64,
    },
    /// The loop contradicts the path between the visits, or earlier loops.
    Inconsistent {
        /// The gate that it fails.
        reason: Inconsistency,
        /// What was measured.
        numbers: LoopNumbers,
    },
}

impl fmt::Display for NoLoop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NoLoop::NoPlaces => f.write_str("place recognition is off"),
            NoLoop::TooEarly { keyframes, needed } => {
                write!(
                    f,
                    "only {keyframes} keyframes since the start or the last loop, at least {needed} needed"
                )
            }
            NoLoop::Alone { best_score, min_score } => {
                write!(f, "no other place looks alike (best score {best_score:.3}, needed {min_score:.3})")
            }
            NoLoop::NotYetConsistent { seen, needed } => {
                write!(f, "the place looked alike from {seen} of {needed} keyframes before this one")
            }
            NoLoop::TooFewMatches { found, needed } => {
                write!(f, "too few descriptors match: {found} of {needed}")
            }
            NoLoop::NoGeometry { found, needed } => {
                write!(f, "no motion explains the matches: {found} of {needed} inliers")
            }
            NoLoop::TooFewInliers { found, needed, visible } => {
                write!(f, "too few of the {visible} visible points were found: {found} of {needed}")
            }
            NoLoop::Scale { scale, limit } => {
                write!(f, "the scale changed by a factor of {scale:.3}, at most {limit:.3} is plausible")
            }
            NoLoop::Inconsistent { reason, numbers } => contradiction(f, reason, numbers),
        }
    }
}

fn contradiction(f: &mut fmt::Formatter<'_>, reason: &Inconsistency, numbers: &LoopNumbers) -> fmt::Result {
    let (edges, length_m) = (numbers.cycle_edges, numbers.cycle_length_m);
    match reason {
        Inconsistency::BadInput { edge } => write!(f, "edge {edge} of the loop's cycle has unusable numbers"),
        Inconsistency::NoCycle => f.write_str("it closes no cycle against which it could be tested"),
        Inconsistency::Rotation { sigmas } => write!(
            f,
            "it contradicts the path between the visits: the cycle of {edges} edges and {length_m:.1} m fails to close \
             by {:.2} degrees, {sigmas:.1} times what drift explains",
            numbers.rotation_closure_deg
        ),
        Inconsistency::Translation { sigmas } => write!(
            f,
            "it contradicts the path between the visits: the cycle of {edges} edges and {length_m:.1} m fails to close \
             by {:.2} m, {sigmas:.1} times what drift explains",
            numbers.translation_closure_m
        ),
        Inconsistency::Residual { kind, sigmas, .. } => {
            let torn = match kind {
                CycleEdgeKind::Odometry => "the path between the visits",
                CycleEdgeKind::EarlierLoop => "an earlier loop",
                CycleEdgeKind::Candidate => "the other measurements",
            };
            write!(f, "it contradicts {torn} by {sigmas:.1} standard deviations")
        }
        Inconsistency::Convex(error) => write!(f, "it could not be tested: {error}"),
    }
}
