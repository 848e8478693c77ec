//! `set_estimates`: writes the poses and positions of a solution.

use std::sync::Arc;

use features::Frame;
use geometry::{SE3, Vec3};

use crate::ids::Id;
use crate::validate::{find_twice, valid_pose, valid_position};
use crate::{KeyframeId, Map, MapError, PointId};

impl Map {
    /// Writes poses (`cam_from_world`) and positions (world), meters; normals and distance ranges follow, also those
    /// of unlisted points that a moved keyframe observes.
    ///
    /// # Errors
    /// An id does not exist or is listed twice, a number is not finite, or a rotation is not a rotation.
    pub fn set_estimates(
        &mut self,
        poses: &[(KeyframeId, SE3)],
        positions: &[(PointId, Vec3)],
    ) -> Result<(), MapError> {
        for (keyframe, pose) in poses {
            self.need_keyframe(*keyframe)?;
            valid_pose(*keyframe, pose)?;
        }
        for (point, position) in positions {
            self.need_point(*point)?;
            valid_position(*point, position)?;
        }
        if let Some(keyframe) = find_twice(poses.iter().map(|p| p.0)) {
            return Err(MapError::KeyframeTwice { keyframe });
        }
        if let Some(point) = find_twice(positions.iter().map(|p| p.0)) {
            return Err(MapError::PointTwice { point });
        }

        self.write_estimates(poses, positions);
        self.revision += 1;
        Ok(())
    }

    /// Replaces the frame of every keyframe by what `recalibrated` makes of it: the same features by another calibration. Poses and
    /// positions stay; a correction that goes with it must follow.
    ///
    /// # Panics
    /// When a frame has another number of features.
    pub fn recalibrate(&mut self, recalibrated: impl Fn(&Arc<Frame>) -> Arc<Frame>) {
        let ids: Vec<KeyframeId> = self.keyframes().map(|keyframe| keyframe.id).collect();
        for id in ids {
            let keyframe = self.keyframes.live_mut(id);
            let frame = recalibrated(&keyframe.frame);
            assert_eq!(frame.len(), keyframe.frame.len(), "a calibration neither makes nor loses features");
            keyframe.frame = frame;
        }
        self.revision += 1;
    }

    /// Writes valid estimates of living things, then renews each affected point once.
    pub(crate) fn write_estimates(&mut self, poses: &[(KeyframeId, SE3)], positions: &[(PointId, Vec3)]) {
        let mut affected = vec![false; self.next_point_id().index()];
        for &(id, cam_from_world) in poses {
            let keyframe = self.keyframes.live_mut(id);
            keyframe.cam_from_world = cam_from_world;
            keyframe.points().iter().flatten().for_each(|p| affected[p.index()] = true);
        }
        for &(id, position) in positions {
            self.points.live_mut(id).position = position;
            affected[id.index()] = true;
        }
        let affected = (0..affected.len()).filter(|&i| affected[i]).map(PointId::from_index);
        affected.for_each(|p| self.refresh_geometry(p));
    }
}
