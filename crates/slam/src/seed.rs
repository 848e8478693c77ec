//! Seeds of the random decisions: no two uses share a stream.

use geometry::mix_seed;

/// What random numbers are drawn for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SeedPurpose {
    /// Pose of a frame from a keyframe around the last one.
    ReferenceKeyframe = 1,
    /// Pose of a frame from a keyframe that looks alike.
    Relocalization = 2,
    /// Motion between the two visits of a loop.
    LoopVerification = 3,
    /// The two views of a monocular start.
    InitialPair = 4,
    /// Rotation between two frames of a turn on the spot.
    Turning = 5,
}

impl SeedPurpose {
    /// The seed for frame or keyframe `of`, compared with keyframe `with` (0 where there is none).
    pub(crate) fn seed(self, seed: u64, of: u32, with: u32) -> u64 {
        mix_seed(seed, u64::from(of), self as u64 + (u64::from(with) << 8))
    }
}

#[cfg(test)]
#[path = "../tests/steps/seed.rs"]
mod tests;
