//! Who moves by a correction: listed keyframes, what follows them, and how the scale of a single camera travels along.

use std::collections::BTreeMap;

use geometry::{SE3, Vec3};

use super::{Correction, KeyframeCorrection};
use crate::ids::Id;
use crate::map::RemovedKeyframe;
use crate::validate::{valid_pose, valid_position, valid_scale};
use crate::{KeyframeId, Map, MapError, PointId};

/// What a correction writes, all of it valid.
pub(crate) struct Motion {
    /// Keyframes that move, with the scale of their surroundings.
    keyframes: BTreeMap<KeyframeId, KeyframeCorrection>,
    points: Vec<(PointId, Vec3)>,
    /// Removed keyframes whose carrier has a new scale.
    removed: Vec<(KeyframeId, RemovedKeyframe)>,
}

impl Map {
    /// The motion that a valid correction means for the map as it is now.
    ///
    /// # Errors
    /// Something that follows would leave the range of numbers.
    pub(crate) fn motion_of(&self, correction: &Correction) -> Result<Motion, MapError> {
        let keyframes = self.moved_keyframes(correction);
        for k in keyframes.values() {
            valid_pose(k.keyframe, &k.cam_from_world)?;
            valid_scale(k.keyframe, self.scale_of(k.keyframe) * k.scale)?;
        }
        let points = self.moved_points(correction, &keyframes);
        for (point, position) in &points {
            valid_position(*point, position)?;
        }
        let removed = self.rescaled_removed(&keyframes);
        for (keyframe, r) in &removed {
            valid_pose(*keyframe, &r.removed_from_parent)?;
            valid_scale(*keyframe, r.scale)?;
        }
        Ok(Motion { keyframes, points, removed })
    }

    pub(crate) fn write_motion(&mut self, motion: &Motion) {
        let poses: Vec<(KeyframeId, SE3)> =
            motion.keyframes.values().map(|k| (k.keyframe, k.cam_from_world)).collect();
        self.write_estimates(&poses, &motion.points);
        for k in motion.keyframes.values().filter(|k| k.scale != 1.0) {
            self.keyframes.live_mut(k.keyframe).scale *= k.scale;
        }
        for &(id, rescaled) in &motion.removed {
            if let Some(removed) = self.keyframes.forward_mut(id) {
                *removed = rescaled;
            }
        }
    }

    /// The keyframes that move, walking the spanning trees from their roots, so that parents come before children.
    pub(crate) fn moved_keyframes(
        &self,
        correction: &Correction,
    ) -> BTreeMap<KeyframeId, KeyframeCorrection> {
        let listed: BTreeMap<KeyframeId, KeyframeCorrection> =
            correction.keyframes.iter().map(|&k| (k.keyframe, k)).collect();
        let mut moved = BTreeMap::new();
        let mut open: Vec<KeyframeId> = self.roots.clone();
        while let Some(id) = open.pop() {
            let keyframe = self.keyframes.live(id);
            open.extend(keyframe.children());
            let follows = || {
                let parent = keyframe.parent().filter(|_| keyframe.inserted_at > correction.seen_revision)?;
                Some(self.following(id, moved.get(&parent)?))
            };
            if let Some(new) = listed.get(&id).copied().or_else(follows)
                && (new.cam_from_world != keyframe.cam_from_world || new.scale != 1.0)
            {
                moved.insert(id, new);
            }
        }
        moved
    }

    /// The keyframe keeps its pose relative to its parent, in the parent's new scale.
    fn following(&self, keyframe: KeyframeId, new_parent: &KeyframeCorrection) -> KeyframeCorrection {
        let parent_from_world = self.keyframes.live(new_parent.keyframe).cam_from_world;
        let kf_from_parent = self.keyframes.live(keyframe).cam_from_world * parent_from_world.inverse();
        let cam_from_world = scaled(&kf_from_parent, new_parent.scale) * new_parent.cam_from_world;
        KeyframeCorrection { keyframe, cam_from_world, scale: new_parent.scale }
    }

    /// The positions that change: listed ones, and those that follow a moved reference keyframe.
    fn moved_points(
        &self,
        correction: &Correction,
        moved: &BTreeMap<KeyframeId, KeyframeCorrection>,
    ) -> Vec<(PointId, Vec3)> {
        let mut positions: BTreeMap<PointId, Vec3> =
            correction.points.iter().copied().filter(|(p, _)| self.point(*p).is_some()).collect();
        for (&id, new) in moved {
            let keyframe = self.keyframes.live(id);
            let world_from_cam = new.cam_from_world.inverse();
            for &point in keyframe.points().iter().flatten() {
                let p = self.points.live(point);
                if p.reference == id {
                    let point_cam = keyframe.cam_from_world * p.position;
                    positions.entry(point).or_insert_with(|| world_from_cam * (new.scale * point_cam));
                }
            }
        }
        positions.into_iter().collect()
    }

    /// Removed keyframes that a keyframe of new scale carries, in that scale.
    fn rescaled_removed(
        &self,
        moved: &BTreeMap<KeyframeId, KeyframeCorrection>,
    ) -> Vec<(KeyframeId, RemovedKeyframe)> {
        if moved.values().all(|k| k.scale == 1.0) {
            return Vec::new();
        }
        let rescaled = |id: KeyframeId| {
            let removed = self.keyframes.forward(id)?;
            let (alive, _) = self.resolve_keyframe(id)?;
            let factor = moved.get(&alive).map(|k| k.scale).filter(|&s| s != 1.0)?;
            let removed_from_parent = scaled(&removed.removed_from_parent, factor);
            Some((id, RemovedKeyframe { removed_from_parent, scale: removed.scale * factor, ..*removed }))
        };
        (0..self.keyframes.len()).map(KeyframeId::from_index).filter_map(rescaled).collect()
    }
}

/// The same motion where everything is `scale` times as long.
fn scaled(motion: &SE3, scale: f64) -> SE3 {
    SE3::new(motion.rotation, motion.translation * scale)
}
