//! `apply_correction`: a closed loop or a global solution, computed on an older revision of the map.

use std::collections::{BTreeMap, BTreeSet};

use geometry::{SE3, Vec3};

use crate::covisibility::CovisibilityChange;
use crate::keyframe::insert_sorted;
use crate::validate::{find_twice, valid_pose, valid_position};
use crate::{KeyframeId, Map, MapError, PointId};

/// New poses and positions for the map of an older revision, and what a loop joins. Ids are those of that revision.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Correction {
    /// New `cam_from_world`, metres.
    pub keyframes: Vec<(KeyframeId, SE3)>,
    /// New positions in the world, metres.
    pub points: Vec<(PointId, Vec3)>,
    /// Revision of the map that the correction was computed on.
    pub seen_revision: u64,
    /// Pairs (keep, drop) that are the same point.
    pub merged: Vec<(PointId, PointId)>,
    /// Pairs of keyframes that the loop joins.
    pub loop_edges: Vec<(KeyframeId, KeyframeId)>,
}

impl Map {
    /// Applies a correction to the map as it is now.
    ///
    /// Listed keyframes take their new pose. Unlisted ones inserted after `seen_revision` keep their pose relative to
    /// their spanning-tree parent; other unlisted ones stay. Listed points take their new position, the others keep
    /// their place relative to their reference keyframe. What has been removed since is passed over (a listed position
    /// of a merged point too), merged pairs and loop edges are resolved to what lives now.
    ///
    /// # Errors
    /// The revision lies ahead, an id never existed or is listed twice, a listed keyframe was inserted after the
    /// revision, a number is not finite or a rotation not a rotation, or a pair names the same thing twice.
    pub fn apply_correction(&mut self, correction: &Correction) -> Result<(), MapError> {
        self.validate_correction(correction)?;
        let poses = self.corrected_poses(correction);
        for (keyframe, pose) in &poses {
            valid_pose(*keyframe, pose)?;
        }
        let positions = self.corrected_positions(correction, &poses);
        for (point, position) in &positions {
            valid_position(*point, position)?;
        }

        let poses: Vec<(KeyframeId, SE3)> = poses.into_iter().collect();
        self.write_estimates(&poses, &positions);
        self.merge_pairs(&correction.merged);
        self.add_loop_edges(&correction.loop_edges);
        self.revision += 1;
        Ok(())
    }

    fn validate_correction(&self, correction: &Correction) -> Result<(), MapError> {
        let seen = correction.seen_revision;
        if seen > self.revision {
            return Err(MapError::RevisionAhead { seen, now: self.revision });
        }
        for (keyframe, pose) in &correction.keyframes {
            self.need_known_keyframe(*keyframe)?;
            valid_pose(*keyframe, pose)?;
            let inserted_at = self.keyframe(*keyframe).map_or(0, |k| k.inserted_at);
            if inserted_at > seen {
                return Err(MapError::NotSeen { keyframe: *keyframe, inserted_at, seen });
            }
        }
        for (point, position) in &correction.points {
            self.need_known_point(*point)?;
            valid_position(*point, position)?;
        }
        if let Some(keyframe) = find_twice(correction.keyframes.iter().map(|k| k.0)) {
            return Err(MapError::KeyframeTwice { keyframe });
        }
        if let Some(point) = find_twice(correction.points.iter().map(|p| p.0)) {
            return Err(MapError::PointTwice { point });
        }
        self.validate_pairs(correction)
    }

    fn validate_pairs(&self, correction: &Correction) -> Result<(), MapError> {
        for &(keep, drop) in &correction.merged {
            self.need_known_point(keep)?;
            self.need_known_point(drop)?;
            if keep == drop {
                return Err(MapError::MergeWithItself { point: keep });
            }
        }
        for &(a, b) in &correction.loop_edges {
            self.need_known_keyframe(a)?;
            self.need_known_keyframe(b)?;
            if a == b {
                return Err(MapError::LoopToItself { keyframe: a });
            }
        }
        Ok(())
    }

    /// The poses that change, walking the spanning tree from the root, so that a parent comes before its children.
    fn corrected_poses(&self, correction: &Correction) -> BTreeMap<KeyframeId, SE3> {
        let listed: BTreeMap<KeyframeId, SE3> = correction.keyframes.iter().copied().collect();
        let mut moved = BTreeMap::new();
        let mut open: Vec<KeyframeId> = self.root.into_iter().collect();
        while let Some(id) = open.pop() {
            let keyframe = self.keyframes.live(id);
            open.extend(keyframe.children());
            let pose = match listed.get(&id) {
                Some(&pose) => Some(pose),
                None if keyframe.inserted_at > correction.seen_revision => {
                    keyframe.parent().and_then(|parent| {
                        let new_parent: &SE3 = moved.get(&parent)?;
                        let parent_from_world = self.keyframes.live(parent).cam_from_world;
                        Some(keyframe.cam_from_world * parent_from_world.inverse() * *new_parent)
                    })
                }
                None => None,
            };
            if let Some(pose) = pose.filter(|p| *p != keyframe.cam_from_world) {
                moved.insert(id, pose);
            }
        }
        moved
    }

    /// The positions that change: listed ones, and those that follow a moved reference keyframe.
    fn corrected_positions(
        &self,
        correction: &Correction,
        moved: &BTreeMap<KeyframeId, SE3>,
    ) -> Vec<(PointId, Vec3)> {
        let mut positions: BTreeMap<PointId, Vec3> =
            correction.points.iter().copied().filter(|(p, _)| self.point(*p).is_some()).collect();
        for (&id, new_pose) in moved {
            let keyframe = self.keyframes.live(id);
            let new_from_old = new_pose.inverse() * keyframe.cam_from_world;
            for &point in keyframe.points().iter().flatten() {
                let p = self.points.live(point);
                if p.reference == id {
                    positions.entry(point).or_insert_with(|| new_from_old * p.position);
                }
            }
        }
        positions.into_iter().collect()
    }

    fn merge_pairs(&mut self, pairs: &[(PointId, PointId)]) {
        let mut change = CovisibilityChange::default();
        let mut kept = BTreeSet::new();
        for &(keep, drop) in pairs {
            if let (Some(keep), Some(drop)) = (self.resolve(keep), self.resolve(drop))
                && keep != drop
            {
                self.merge_into(keep, drop, &mut change);
                kept.insert(keep);
            }
        }
        self.apply_covisibility(change);
        for point in kept {
            if self.point(point).is_some() {
                self.refresh_point(point);
            }
        }
    }

    fn add_loop_edges(&mut self, pairs: &[(KeyframeId, KeyframeId)]) {
        for &(a, b) in pairs {
            if let (Some((a, _)), Some((b, _))) = (self.resolve_keyframe(a), self.resolve_keyframe(b))
                && a != b
            {
                insert_sorted(&mut self.keyframes.live_mut(a).loop_edges, b);
                insert_sorted(&mut self.keyframes.live_mut(b).loop_edges, a);
            }
        }
    }
}
