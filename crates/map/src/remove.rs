//! `remove_keyframe`: the map closes over the gap.

use std::cmp::Reverse;

use crate::covisibility::CovisibilityChange;
use crate::keyframe::{insert_sorted, remove_sorted};
use crate::map::RemovedKeyframe;
use crate::{KeyframeId, Map, MapError, PointFate, PointId};

/// What `remove_keyframe` did.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Removed {
    /// Points that had too few observations left and were removed, in order of the removed keyframe's features.
    pub points: Vec<PointId>,
    /// Where the children went: (child, new parent), in order of attachment.
    pub reparented: Vec<(KeyframeId, KeyframeId)>,
}

impl Map {
    /// Removes a keyframe with its observations and loop edges; points are settled as by [`unlink`](Map::unlink).
    ///
    /// Each child gets a new parent among the removed one's parent and the children already attached: the pair that
    /// shares most points first (ties by id), the old parent for those that share none. No cycle can arise, as these
    /// subtrees are disjoint. [`resolve_keyframe`](Map::resolve_keyframe) leads to the parent.
    ///
    /// # Errors
    /// The keyframe does not exist or is the root of a sub-map.
    pub fn remove_keyframe(&mut self, id: KeyframeId) -> Result<Removed, MapError> {
        let keyframe = self.need_keyframe(id)?;
        let parent = keyframe.parent.ok_or(MapError::RemoveRoot { keyframe: id })?;
        let world_from_parent = self.keyframes.live(parent).cam_from_world.inverse();
        let removed_from_parent = keyframe.cam_from_world * world_from_parent;
        let scale = keyframe.scale;

        let points = self.forget_observations(id);
        for other in std::mem::take(&mut self.keyframes.live_mut(id).loop_edges) {
            remove_sorted(&mut self.keyframes.live_mut(other).loop_edges, id);
        }
        let reparented = self.reparent_children(id, parent);
        self.keyframes.remove(id, Some(RemovedKeyframe { parent, removed_from_parent, scale }));
        self.revision += 1;
        Ok(Removed { points, reparented })
    }

    /// Ends every observation of a keyframe; returns the points that go with them.
    fn forget_observations(&mut self, id: KeyframeId) -> Vec<PointId> {
        let observed: Vec<PointId> = self.keyframes.live(id).points().iter().flatten().copied().collect();
        let mut change = CovisibilityChange::default();
        let mut gone = Vec::new();
        for point in observed {
            self.detach(point, id, &mut change);
            if self.settle(point, &mut change) == PointFate::Removed {
                gone.push(point);
            }
        }
        self.apply_covisibility(change);
        gone
    }

    fn reparent_children(&mut self, id: KeyframeId, parent: KeyframeId) -> Vec<(KeyframeId, KeyframeId)> {
        let mut orphans = std::mem::take(&mut self.keyframes.live_mut(id).children);
        let mut candidates = vec![parent];
        let mut moves = Vec::new();
        while let Some((child, new_parent)) = self.closest_pair(&orphans, &candidates) {
            remove_sorted(&mut orphans, child);
            candidates.push(child);
            moves.push((child, new_parent));
        }
        moves.extend(orphans.into_iter().map(|child| (child, parent)));

        remove_sorted(&mut self.keyframes.live_mut(parent).children, id);
        for &(child, new_parent) in &moves {
            self.keyframes.live_mut(child).parent = Some(new_parent);
            insert_sorted(&mut self.keyframes.live_mut(new_parent).children, child);
        }
        moves
    }

    /// The orphan and candidate that share most points, ties by (orphan, candidate); `None` if none share any.
    fn closest_pair(
        &self,
        orphans: &[KeyframeId],
        candidates: &[KeyframeId],
    ) -> Option<(KeyframeId, KeyframeId)> {
        let pairs = orphans.iter().flat_map(|&orphan| {
            let covisible = self.keyframes.live(orphan).covisible().iter();
            covisible.filter(|(k, _)| candidates.contains(k)).map(move |&(k, w)| (Reverse(w), orphan, k))
        });
        pairs.min().map(|(_, orphan, candidate)| (orphan, candidate))
    }
}
