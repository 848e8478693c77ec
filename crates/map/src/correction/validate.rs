//! What is wrong with a correction, found before the first write.

use std::collections::BTreeMap;

use super::{Correction, KeyframeCorrection};
use crate::validate::{find_twice, valid_pose, valid_position, valid_scale};
use crate::{KeyframeId, Map, MapError};

impl Map {
    pub(super) fn validate_correction(&self, correction: &Correction) -> Result<(), MapError> {
        let seen = correction.seen_revision;
        if seen > self.revision {
            return Err(MapError::RevisionAhead { seen, now: self.revision });
        }
        for &KeyframeCorrection { keyframe, cam_from_world, scale } in &correction.keyframes {
            self.need_known_keyframe(keyframe)?;
            valid_pose(keyframe, &cam_from_world)?;
            valid_scale(keyframe, scale)?;
            let inserted_at = self.keyframe(keyframe).map_or(0, |k| k.inserted_at);
            if inserted_at > seen {
                return Err(MapError::NotSeen { keyframe, inserted_at, seen });
            }
        }
        for (point, position) in &correction.points {
            self.need_known_point(*point)?;
            valid_position(*point, position)?;
        }
        if let Some(keyframe) = find_twice(correction.keyframes.iter().map(|k| k.keyframe)) {
            return Err(MapError::KeyframeTwice { keyframe });
        }
        if let Some(point) = find_twice(correction.points.iter().map(|p| p.0)) {
            return Err(MapError::PointTwice { point });
        }
        self.find_loops(&correction.taken_back)?;
        self.validate_pairs(correction)?;
        self.validate_joined(&correction.joined)
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

    /// Each pair joins different sub-maps, those joined by the pairs before it counting as one.
    fn validate_joined(&self, pairs: &[(KeyframeId, KeyframeId)]) -> Result<(), MapError> {
        let mut absorbed: BTreeMap<KeyframeId, KeyframeId> = BTreeMap::new();
        for &(keyframe, parent) in pairs {
            self.need_known_keyframe(keyframe)?;
            self.need_known_keyframe(parent)?;
            let [joined, other] = [keyframe, parent].map(|k| {
                let mut root = self.submap_of(k)?;
                while let Some(&into) = absorbed.get(&root) {
                    root = into;
                }
                Some(root)
            });
            match (joined, other) {
                (Some(joined), Some(other)) if joined != other => absorbed.insert(joined, other),
                _ => return Err(MapError::SameSubmap { keyframe, parent }),
            };
        }
        Ok(())
    }
}
