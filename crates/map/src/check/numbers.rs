//! Numbers are finite, rotations are rotations, derived data are those of the observations.

use super::Violation;
use crate::derived::{representative_descriptor, viewing_geometry};
use crate::validate::{is_sane, is_scale, pose_defect};
use crate::{Map, MapPoint, PointId};

impl Map {
    pub(super) fn check_numbers(&self, found: &mut Vec<Violation>) {
        for (keyframe, k) in self.keyframes.iter() {
            if let Some(defect) = pose_defect(&k.cam_from_world) {
                found.push(Violation::Pose { keyframe, defect });
            }
        }
        for keyframe in (0..self.keyframes.len()).map(crate::ids::Id::from_index) {
            let removed = self.keyframes.forward(keyframe);
            if let Some(defect) = removed.and_then(|r| pose_defect(&r.removed_from_parent)) {
                found.push(Violation::Pose { keyframe, defect });
            }
            let scale = self.scale_of(keyframe);
            if !is_scale(scale) {
                found.push(Violation::Scale { keyframe, scale });
            }
        }
        for (id, point) in self.points.iter() {
            let distances = [point.min_distance_m, point.max_distance_m];
            let is_finite = point.normal.iter().chain(&distances).all(|x| x.is_finite());
            if !is_finite || !is_sane(&point.position) {
                found.push(Violation::PointNumbers { point: id });
            }
            self.check_derived(id, point, found);
        }
    }

    /// Compares with a fresh computation, where the observations allow one.
    fn check_derived(&self, id: PointId, point: &MapPoint, found: &mut Vec<Violation>) {
        let observations = point.observations();
        let exists = |keyframe, feature: u32| {
            self.keyframe(keyframe).is_some_and(|k| (feature as usize) < k.frame.len())
        };
        let reference = observations.iter().find(|o| o.keyframe == point.reference);
        let (Some(&reference), true) =
            (reference, observations.iter().all(|o| exists(o.keyframe, o.feature)))
        else {
            return; // reported by the checks of the observations
        };
        if point.descriptor != representative_descriptor(&self.keyframes, observations) {
            found.push(Violation::StaleDescriptor { point: id });
        }
        let view = viewing_geometry(&self.keyframes, observations, reference, &point.position);
        let fresh = [view.min_distance_m, view.max_distance_m, view.normal.x, view.normal.y, view.normal.z];
        let n = point.normal;
        let stored = [point.min_distance_m, point.max_distance_m, n.x, n.y, n.z];
        if stored.map(f64::to_bits) != fresh.map(f64::to_bits) {
            found.push(Violation::StaleGeometry { point: id });
        }
    }
}
