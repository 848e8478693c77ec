//! What changed between two snapshots, found by comparing what they share: for viewers, which only want news.

use crate::{Keyframe, KeyframeId, Map, MapPoint, PointId};

/// Differences of a map from an older snapshot of it, in order of the ids. Things are listed when they were written to since,
/// which does not mean that each of their values is another one.
#[derive(Clone, Default)]
pub struct Changes<'a> {
    /// Points that are new or were written to.
    pub points: Vec<&'a MapPoint>,
    /// Points that are no longer there.
    pub gone_points: Vec<PointId>,
    /// Keyframes that are new or were written to.
    pub keyframes: Vec<&'a Keyframe>,
    /// Keyframes that are no longer there.
    pub gone_keyframes: Vec<KeyframeId>,
}

impl Map {
    /// The differences from an older snapshot. Costs as much as was written to since, not as much as the map is large.
    pub fn changes_since<'a>(&'a self, older: &'a Map) -> Changes<'a> {
        let mut changes = Changes::default();
        for (id, point) in self.points.changed_since(&older.points) {
            match point {
                Some(point) => changes.points.push(point),
                None => changes.gone_points.push(id),
            }
        }
        for (id, keyframe) in self.keyframes.changed_since(&older.keyframes) {
            match keyframe {
                Some(keyframe) => changes.keyframes.push(keyframe),
                None => changes.gone_keyframes.push(id),
            }
        }
        changes
    }
}
