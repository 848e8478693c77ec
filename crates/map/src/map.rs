//! The map itself: what it holds and every query.

use std::fmt;
use std::sync::Arc;

use geometry::SE3;

use crate::arena::Arena;
use crate::closed_loop::ClosedLoop;
use crate::ids::Id;
use crate::take_back::TakenBack;
use crate::{Keyframe, KeyframeId, MapPoint, Observation, PointId};

/// A point is young while the keyframe that was newest when it was made is one of this many newest inserted keyframes
/// (counted by id, removed ones included). Only a young point may have a single observation: `insert` of a keyframe
/// removes the points that stop being young with fewer than two.
pub const PROBATION_KEYFRAMES: usize = 3;

/// Keyframes and points with all their relations. `clone` is a cheap snapshot that later mutations leave alone.
#[derive(Clone, Default)]
pub struct Map {
    pub(crate) keyframes: Arena<KeyframeId, Keyframe, RemovedKeyframe>,
    pub(crate) points: Arena<PointId, MapPoint, PointId>,
    /// The keyframes without a parent, one per sub-map, in order of their ids.
    pub(crate) roots: Vec<KeyframeId>,
    pub(crate) revision: u64,
    /// See [`Map::loops`](crate::Map::loops).
    pub(crate) loops: Vec<Arc<ClosedLoop>>,
    /// Loops that were taken back in this run: of use to poses that were noted before, and no part of the map's content.
    pub(crate) taken_back: Vec<Arc<TakenBack>>,
    /// For each of the newest [`PROBATION_KEYFRAMES`] keyframes, oldest first, the first point id that it could create.
    pub(crate) first_young: Vec<PointId>,
}

/// Where a removed keyframe was, seen from its parent in the spanning tree.
#[derive(Clone, Copy)]
pub(crate) struct RemovedKeyframe {
    pub(crate) parent: KeyframeId,
    pub(crate) removed_from_parent: SE3,
    /// Product of the scales of all corrections since the insertion of the removed keyframe.
    pub(crate) scale: f64,
}

impl fmt::Debug for Map {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Map")
            .field("revision", &self.revision)
            .field("n_keyframes", &self.n_keyframes())
            .field("n_points", &self.n_points())
            .finish_non_exhaustive()
    }
}

impl Map {
    /// An empty map at revision 0.
    pub fn new() -> Self {
        Self::default()
    }

    /// Number of mutations so far.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// A keyframe, unless it was removed or never existed.
    pub fn keyframe(&self, id: KeyframeId) -> Option<&Keyframe> {
        self.keyframes.get(id)
    }

    /// A point, unless it was removed, merged or never existed.
    pub fn point(&self, id: PointId) -> Option<&MapPoint> {
        self.points.get(id)
    }

    /// Mean activation of the features that see a point; those of a keyframe that is gone count as 1.
    pub fn activation(&self, point: &MapPoint) -> f32 {
        let of = |seen: &Observation| {
            self.keyframe(seen.keyframe).map_or(1.0, |k| k.frame.activation[seen.feature as usize])
        };
        let sum: f32 = point.observations().iter().map(of).sum();
        sum / point.n_observations().max(1) as f32
    }

    /// Keyframes in order of their ids.
    pub fn keyframes(&self) -> impl DoubleEndedIterator<Item = &Keyframe> {
        self.keyframes.iter().map(|(_, k)| k)
    }

    /// Points in order of their ids.
    pub fn points(&self) -> impl DoubleEndedIterator<Item = &MapPoint> {
        self.points.iter().map(|(_, p)| p)
    }

    /// The features of a keyframe that show a point, in order, with the point; empty for a keyframe that does not exist.
    pub fn points_of(&self, keyframe: KeyframeId) -> impl Iterator<Item = (u32, &MapPoint)> {
        let table = self.keyframe(keyframe).map_or(&[][..], Keyframe::points);
        (0_u32..).zip(table).filter_map(|(feature, point)| Some((feature, self.point((*point)?)?)))
    }

    /// Number of keyframes.
    pub fn n_keyframes(&self) -> usize {
        self.keyframes.n_live()
    }

    /// Number of points.
    pub fn n_points(&self) -> usize {
        self.points.n_live()
    }

    /// The id that the next inserted keyframe will have.
    pub fn next_keyframe_id(&self) -> KeyframeId {
        self.keyframes.next_id()
    }

    /// The id that the next inserted point will have.
    pub fn next_point_id(&self) -> PointId {
        self.points.next_id()
    }

    /// The last inserted of the keyframes that are still there.
    pub fn newest_keyframe(&self) -> Option<KeyframeId> {
        self.keyframes.iter().next_back().map(|(id, _)| id)
    }

    /// The point is on probation, see [`PROBATION_KEYFRAMES`].
    pub fn is_young(&self, point: &MapPoint) -> bool {
        point.created_by.index() + PROBATION_KEYFRAMES >= self.keyframes.len()
    }

    /// The point that a point is now, through all merges; `None` if it was removed or never existed.
    pub fn resolve(&self, point: PointId) -> Option<PointId> {
        let mut id = point;
        while let Some(&keep) = self.points.forward(id) {
            id = keep;
        }
        self.point(id).map(|p| p.id)
    }

    /// Matches made on an older snapshot, in terms of this map: merged points resolved, removed ones left out, and of
    /// two features that now show the same point the first kept.
    pub fn resolve_matches(&self, matches: &[(u32, PointId)]) -> Vec<(u32, PointId)> {
        let mut known = std::collections::BTreeSet::new();
        let resolved = matches.iter().filter_map(|&(feature, point)| Some((feature, self.resolve(point)?)));
        resolved.filter(|&(_, point)| known.insert(point)).collect()
    }

    /// The living keyframe that carries a keyframe's pose, and the pose `removed_from_alive` relative to it (identity
    /// for a living one), so that `cam_from_world = removed_from_alive * alive.cam_from_world`; `None` if the id was
    /// never given out. Poses relative to the removed one have the scale of [`scale_of`](Self::scale_of) it.
    pub fn resolve_keyframe(&self, keyframe: KeyframeId) -> Option<(KeyframeId, SE3)> {
        let mut id = keyframe;
        let mut removed_from_id = SE3::identity();
        while let Some(removed) = self.keyframes.forward(id) {
            removed_from_id = removed_from_id * removed.removed_from_parent;
            id = removed.parent;
        }
        self.keyframe(id).map(|k| (k.id, removed_from_id))
    }
}
