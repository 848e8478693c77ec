//! `apply_correction`: a closed loop, a joined sub-map or a global solution, computed on an older revision of the map.

mod motion;
mod validate;

use std::collections::BTreeSet;

use geometry::{SE3, Vec3};

use crate::covisibility::CovisibilityChange;
use crate::keyframe::insert_sorted;
use crate::{KeyframeId, Map, MapError, PointId};

/// New poses and positions for the map of an older revision, and what a loop joins. Ids are those of that revision.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Correction {
    /// New poses.
    pub keyframes: Vec<KeyframeCorrection>,
    /// New positions in the world, meters.
    pub points: Vec<(PointId, Vec3)>,
    /// Revision of the map that the correction was computed on.
    pub seen_revision: u64,
    /// Sub-maps that become one, as (any keyframe of the one, the keyframe of the other that it will hang under): the
    /// tree of the first is re-rooted at the given keyframe, which becomes a child of the second.
    pub joined: Vec<(KeyframeId, KeyframeId)>,
    /// Pairs (keep, drop) that are the same point.
    pub merged: Vec<(PointId, PointId)>,
    /// Pairs of keyframes that the loop joins, the earlier visit first.
    pub loop_edges: Vec<(KeyframeId, KeyframeId)>,
    /// Closed loops to be taken back before all else, as (keyframe of the earlier visit, keyframe of the later one); see
    /// [`Map::loops`].
    pub taken_back: Vec<(KeyframeId, KeyframeId)>,
}

/// Where a correction puts a keyframe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeyframeCorrection {
    /// The keyframe.
    pub keyframe: KeyframeId,
    /// Its new pose, meters.
    pub cam_from_world: SE3,
    /// New length of what was 1 long around this keyframe; 1 where scale is observed (stereo, depth).
    pub scale: f64,
}

impl KeyframeCorrection {
    /// A new pose without a change of scale.
    pub fn rigid(keyframe: KeyframeId, cam_from_world: SE3) -> Self {
        KeyframeCorrection { keyframe, cam_from_world, scale: 1.0 }
    }
}

impl Map {
    /// Applies a correction to the map as it is now.
    ///
    /// Loops to be taken back are so first, which moves keyframes; all that follows, scales too, is meant for the map without them.
    ///
    /// Listed keyframes take their new pose. Unlisted ones inserted after `seen_revision` keep their pose relative to
    /// their spanning-tree parent (of the tree before anything is joined), its translation times the parent's scale,
    /// and pass that scale on; other unlisted ones stay. Listed points take their new position, the others keep their
    /// camera coordinates in their reference keyframe, times its scale. Removed keyframes keep their pose relative to
    /// the living one that carries it, the translation times its scale. Then sub-maps are joined, points merged and
    /// loop edges added, in the order listed. What has been removed since is passed over (a listed position of a
    /// merged point too); joined keyframes, merged pairs and loop edges are resolved to what lives now.
    ///
    /// # Errors
    /// The revision lies ahead, an id never existed or is listed twice, a listed keyframe was inserted after the
    /// revision, a number is not finite, a rotation not a rotation or a scale not positive, a pair names the same
    /// thing twice, or two keyframes to join are in one sub-map (by an earlier pair, for instance).
    pub fn apply_correction(&mut self, correction: &Correction) -> Result<(), MapError> {
        self.validate_correction(correction)?;
        if correction.taken_back.is_empty() {
            return self.apply_valid(correction);
        }
        let mut without = self.clone();
        without.take_back(&correction.taken_back)?;
        without.apply_valid(correction)?;
        *self = without;
        Ok(())
    }

    fn apply_valid(&mut self, correction: &Correction) -> Result<(), MapError> {
        let motion = self.motion_of(correction)?;

        if correction.joined.is_empty() {
            self.note_loops(&correction.loop_edges);
        } else {
            // Poses of before would be in coordinates that are gone.
            self.loops.clear();
        }
        self.write_motion(&motion);
        self.join_submaps(&correction.joined);
        self.merge_pairs(&correction.merged);
        self.add_loop_edges(&correction.loop_edges);
        self.revision += 1;
        Ok(())
    }

    /// Product of the scales that corrections gave a keyframe, living or removed, since its insertion: a translation
    /// relative to it that was noted when this was `then` is today `scale_of / then` times as long. 1 for an id that
    /// was never given out.
    pub fn scale_of(&self, keyframe: KeyframeId) -> f64 {
        let living = self.keyframe(keyframe).map(|k| k.scale);
        living.or_else(|| Some(self.keyframes.forward(keyframe)?.scale)).unwrap_or(1.0)
    }

    fn join_submaps(&mut self, pairs: &[(KeyframeId, KeyframeId)]) {
        for &(keyframe, under) in pairs {
            if let (Some((keyframe, _)), Some((under, _))) =
                (self.resolve_keyframe(keyframe), self.resolve_keyframe(under))
            {
                self.hang_tree(keyframe, under);
            }
        }
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
