//! A point of the world and who sees it.

use features::Descriptor;
use geometry::Vec3;

use crate::{KeyframeId, PointId};

/// Largest belief in either direction, thousandths of log-odds: one in 400 is left to doubt, and a point that begins to move is
/// soon known to.
pub const MAX_BELIEF: i32 = 6000;
/// Belief in a new point: seven of eight stand still.
pub const FIRST_BELIEF: i32 = 2000;

/// A feature of a keyframe that shows a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Observation {
    /// The keyframe.
    pub keyframe: KeyframeId,
    /// Index of the feature in the keyframe's frame.
    pub feature: u32,
}

/// What tracking saw of a point, to be added to its statistics by [`Map::count`](crate::Map::count).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PointCount {
    /// The point; may have been merged or removed since.
    pub point: PointId,
    /// Number of frames in whose view it should have been.
    pub seen: u32,
    /// Number of frames in which it was matched.
    pub found: u32,
    /// What that says of its belief, thousandths of log-odds.
    pub evidence: i32,
}

/// A point of the map. Descriptor, normal and distances are kept fresh by the mutations.
#[derive(Clone, Debug)]
pub struct MapPoint {
    /// Its name in the map.
    pub id: PointId,
    /// Position in the world, meters.
    pub position: Vec3,
    /// The observation's descriptor with the least median Hamming distance to the others, ties by keyframe id.
    pub descriptor: Descriptor,
    /// Unit vector along the mean of the unit viewing directions, from the cameras to the point, world frame.
    pub normal: Vec3,
    /// Smallest distance at which the point is expected to be found, meters: `max_distance_m / scale^(levels - 1)`.
    pub min_distance_m: f64,
    /// Largest such distance: distance to the reference keyframe times the scale of its octave there.
    pub max_distance_m: f64,
    /// A keyframe that observes the point and that it follows when keyframes are moved.
    pub reference: KeyframeId,
    /// The newest keyframe when the point was made; never changes, may have been removed since.
    pub created_by: KeyframeId,
    /// Number of frames in whose view it should have been.
    pub seen: u32,
    /// Number of frames in which it was matched.
    pub found: u32,
    /// Belief that it stands still: log-odds of all evidence so far, thousandths, between -[`MAX_BELIEF`] and [`MAX_BELIEF`].
    pub belief: i32,
    pub(crate) observations: Vec<Observation>,
}

impl MapPoint {
    /// Probability that it stands still, of all that is known.
    pub fn trust(&self) -> f64 {
        self.trust_after([])
    }

    /// As [`MapPoint::trust`], with evidence added that it has not been told of, in order, thousandths of log-odds.
    pub fn trust_after(&self, evidence: impl IntoIterator<Item = i32>) -> f64 {
        let belief = evidence.into_iter().fold(self.belief, believing);
        1.0 / (1.0 + (-f64::from(belief) / 1000.0).exp())
    }

    /// Adds evidence, thousandths of log-odds.
    pub(crate) fn believe(&mut self, evidence: i32) {
        self.belief = believing(self.belief, evidence);
    }

    /// Every observation, in order of the keyframe ids; at most one per keyframe.
    pub fn observations(&self) -> &[Observation] {
        &self.observations
    }

    /// Number of keyframes that observe the point.
    pub fn n_observations(&self) -> usize {
        self.observations.len()
    }

    /// The feature under which a keyframe observes the point.
    pub fn feature_in(&self, keyframe: KeyframeId) -> Option<u32> {
        let at = self.observations.binary_search_by_key(&keyframe, |o| o.keyframe).ok()?;
        Some(self.observations[at].feature)
    }
}

/// A belief with evidence added.
fn believing(belief: i32, evidence: i32) -> i32 {
    belief.saturating_add(evidence).clamp(-MAX_BELIEF, MAX_BELIEF)
}
