//! Insertion of a keyframe: its matches become observations, its unmatched close features become points.

use std::sync::Arc;

use features::Frame;
use geometry::{SE3, Vec3};
use map::{Batch, KeyframeId, NewKeyframe, NewPoint, Observation, Parent, PointId};

use super::Mapper;
use crate::params::Params;
use crate::tracker::{InitialPair, KeyframeRequest, Placement};

impl Mapper {
    pub(super) fn insert_keyframe(&mut self, request: &KeyframeRequest) -> Option<KeyframeId> {
        if let Some(pair) = &request.pair {
            return self.insert_pair(pair, request);
        }
        let (cam_from_world, parent) = match &request.placement {
            Placement::NewSubmap { cam_from_world } => (*cam_from_world, Parent::NewSubmap),
            Placement::Near(pose) => (pose.cam_from_world(&self.world.map)?.normalized(), Parent::Closest),
        };
        let matches = self.world.map.resolve_matches(&request.matches);
        let keyframe = self.world.map.next_keyframe_id();
        let frame = self.world.calibrated(&request.frame);
        let points = depth_points(&frame, &cam_from_world, &matches, &self.params)
            .into_iter()
            .map(|(feature, position)| NewPoint {
                position,
                observations: vec![Observation { keyframe, feature }],
            })
            .collect();
        let batch = Batch { keyframe: Some(NewKeyframe { frame, cam_from_world, matches, parent }), points };
        let inserted = self.world.map.insert(batch).ok()?;
        self.young.extend(inserted.points);
        inserted.keyframe
    }

    /// Starts a monocular sub-map with two keyframes and the points that both see.
    fn insert_pair(&mut self, pair: &InitialPair, request: &KeyframeRequest) -> Option<KeyframeId> {
        let keyframe = |frame: &Arc<Frame>, cam_from_world, parent| {
            Some(NewKeyframe { frame: frame.clone(), cam_from_world, matches: Vec::new(), parent })
        };
        let [first_frame, second_frame] =
            [&pair.first, &request.frame].map(|frame| self.world.calibrated(frame));
        let root = keyframe(&first_frame, pair.first_from_world, Parent::NewSubmap);
        let first = self.world.map.insert(Batch { keyframe: root, points: Vec::new() }).ok()?.keyframe?;
        self.world.places.add(first, &first_frame);
        let second = self.world.map.next_keyframe_id();
        let points = pair
            .points
            .iter()
            .map(|&(in_first, in_second, position)| NewPoint {
                position,
                observations: vec![
                    Observation { keyframe: first, feature: in_first },
                    Observation { keyframe: second, feature: in_second },
                ],
            })
            .collect();
        let child = keyframe(&second_frame, pair.second_from_world, Parent::Under(first));
        let inserted = self.world.map.insert(Batch { keyframe: child, points }).ok()?;
        self.young.extend(inserted.points);
        inserted.keyframe
    }
}

/// Positions for unmatched features with depth, nearest first: all that are close, and in any case until matched and
/// new points with depth are enough.
fn depth_points(
    frame: &Frame,
    cam_from_world: &SE3,
    matches: &[(u32, PointId)],
    params: &Params,
) -> Vec<(u32, Vec3)> {
    let mut matched = vec![false; frame.len()];
    for &(feature, _) in matches {
        matched[feature as usize] = true;
    }
    let mut by_depth: Vec<usize> = (0..frame.len()).filter(|&i| frame.has_depth(i)).collect();
    by_depth.sort_by(|&a, &b| frame.depth[a].total_cmp(&frame.depth[b]).then(a.cmp(&b)));
    let world_from_cam = cam_from_world.inverse();
    let mut points = Vec::new();
    for (rank, &feature) in by_depth.iter().enumerate() {
        if f64::from(frame.depth[feature]) > params.camera.close_depth_m
            && rank >= params.mapping.min_depth_points
        {
            break;
        }
        if !matched[feature]
            && let Some(point_cam) = frame.unproject(feature)
        {
            points.push((feature as u32, world_from_cam * point_cam));
        }
    }
    points
}

#[cfg(test)]
#[path = "../../tests/steps/insert.rs"]
mod tests;
