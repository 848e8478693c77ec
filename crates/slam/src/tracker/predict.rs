//! The first pose of a frame: by the motion model, else by the reference keyframe, else by recovery.

use features::{Frame, ProjectionQuery, consistent_rotations, search_windows};
use geometry::SE3;
use map::{Map, PointId};

use super::last_frame::LastFrame;
use super::pose::{RefinedPose, refine};
use super::{Tracker, recover};
use crate::assign::one_to_one;
use crate::lost::Lost;
use crate::visibility::project_inside;

/// Largest descriptor distance of a match by projection (of 256 bits).
pub(crate) const MAX_DISTANCE_WIDE: u32 = 100;

/// A pose with the matches that it was found with.
#[derive(Clone, Debug)]
pub(crate) struct Prediction {
    pub(crate) cam_from_world: SE3,
    /// Inlier matches, sorted by feature.
    pub(crate) matches: Vec<(u32, PointId)>,
    pub(crate) without_motion_model: bool,
}

/// A way to predict a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Attempt {
    /// The last frame's points, searched where a constant velocity puts them.
    Motion,
    /// Descriptors matched against keyframes, without any prediction.
    Recovery,
}

impl Tracker {
    /// Predicts in one way.
    pub(super) fn predict(
        &self,
        attempt: Attempt,
        frame: &Frame,
        map: &Map,
        last: &LastFrame,
    ) -> Result<Prediction, Lost> {
        match attempt {
            Attempt::Motion => self.predict_by_motion(frame, map, last),
            Attempt::Recovery => {
                recover::recover(frame, map, last, &self.params).map(|pose| Prediction::from_pose(pose, true))
            }
        }
    }

    /// Searches the last frame's points where the motion model puts them, in a window and then in twice the window.
    fn predict_by_motion(&self, frame: &Frame, map: &Map, last: &LastFrame) -> Result<Prediction, Lost> {
        let tracking = &self.params.tracking;
        let last_cam_from_world = last.cam_from_world(map);
        let predicted = match self.velocity {
            Some(velocity) => scaled(&velocity, f64::from(last.intervals_to(frame))) * last_cam_from_world,
            None => last_cam_from_world,
        };
        let mut matches = search_last(frame, map, last, &predicted, tracking.motion_radius_px);
        if matches.len() < tracking.min_motion_matches {
            matches = search_last(frame, map, last, &predicted, 2.0 * tracking.motion_radius_px);
        }
        if matches.len() < tracking.min_motion_matches {
            return Err(Lost::TooFewMatches { found: matches.len(), needed: tracking.min_motion_matches });
        }
        let pose = refine(frame, map, predicted, &matches);
        let (found, needed) = (pose.inliers.len(), tracking.min_predicted_inliers);
        if found < needed {
            return Err(Lost::TooFewPredictedInliers { found, needed });
        }
        Ok(Prediction::from_pose(pose, false))
    }
}

impl Prediction {
    fn from_pose(pose: RefinedPose, without_motion_model: bool) -> Self {
        Prediction { cam_from_world: pose.cam_from_world, matches: pose.inliers, without_motion_model }
    }
}

/// The motion of `intervals` frames at a constant velocity.
pub(super) fn scaled(velocity: &SE3, intervals: f64) -> SE3 {
    if intervals == 1.0 { *velocity } else { SE3::exp(&(velocity.log() * intervals)) }
}

/// Matches of the last frame's points within `radius_px * scale` of their predicted positions. The octaves looked at
/// depend on whether the camera moved forward, backward or neither by more than its baseline.
fn search_last(
    frame: &Frame,
    map: &Map,
    last: &LastFrame,
    predicted: &SE3,
    radius_px: f32,
) -> Vec<(u32, PointId)> {
    let last_from_predicted = last.cam_from_world(map) * predicted.inverse();
    let forward_m = last_from_predicted.translation.z;
    let baseline_m = frame.rig.stereo.baseline_m;
    let top = (frame.scales.scales.len() - 1) as u8;
    let mut queries = Vec::with_capacity(last.matches.len());
    let mut sources = Vec::with_capacity(last.matches.len());
    for &(feature, id) in &last.matches {
        let Some(point) = map.point(id) else { continue };
        let Some(uvr) = project_inside(frame, predicted, &point.position) else { continue };
        let octave = last.frame.keypoints[feature as usize].octave;
        let (min_octave, max_octave) = if forward_m > baseline_m {
            (octave, top)
        } else if forward_m < -baseline_m {
            (0, octave)
        } else {
            (octave.saturating_sub(1), (octave + 1).min(top))
        };
        queries.push(ProjectionQuery {
            x: uvr.x as f32,
            y: uvr.y as f32,
            right_u: uvr.z as f32,
            radius_px: radius_px * frame.scales.scales[octave as usize],
            min_octave,
            max_octave,
            descriptor: last.frame.descriptors[feature as usize],
        });
        sources.push((feature, id));
    }
    let free = vec![true; frame.len()];
    let finds = search_windows(frame, &queries, &free);
    let pairs = one_to_one(&finds, frame.len(), |_, find| find.best.distance <= MAX_DISTANCE_WIDE);
    let turns: Vec<f32> = pairs
        .iter()
        .map(|&(feature, query)| {
            last.frame.keypoints[sources[query].0 as usize].angle_deg
                - frame.keypoints[feature as usize].angle_deg
        })
        .collect();
    let consistent = consistent_rotations(&turns);
    pairs
        .iter()
        .zip(consistent)
        .filter(|(_, consistent)| *consistent)
        .map(|(&(feature, query), _)| (feature, sources[query].1))
        .collect()
}
