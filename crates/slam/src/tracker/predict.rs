//! The first pose of a frame: by the motion model, else by the reference keyframe, else by recovery.

use features::{Frame, ProjectionQuery, WindowMatch};
use geometry::{SE3, Vec3};
use map::{Map, PointId};

use super::Tracker;
use super::inertia::Inertia;
use super::last_frame::LastFrame;
use super::relocalize::relocalize;
use super::track_reference_keyframe::track_reference_keyframe;
use crate::lost::Lost;
use crate::pose::{RefinedPose, refine_with_positions};
use crate::search::{MAX_DISTANCE_WIDE, consistent_in_rotation, search};
use crate::visibility::project_inside;
use crate::world::World;

/// Windows tried in turn, in units of the usual radius.
const WIDENINGS: [f32; 3] = [1.0, 2.0, 4.0];
/// Points looked for at most; features with depth but without a map point fill the remaining places.
const MAX_SOURCES: usize = 600;

/// A pose with the matches that it was found with.
#[derive(Clone, Debug)]
pub(crate) struct Prediction {
    pub(crate) cam_from_world: SE3,
    /// Inlier matches, sorted by feature.
    pub(crate) matches: Vec<(u32, PointId)>,
    /// How it was found.
    pub(crate) attempt: Attempt,
    /// Whether the camera may have gone some way unseen.
    pub(crate) after_loss: bool,
}

impl Prediction {
    /// Whether the pose may be far off, so that the local map is first searched in wide windows.
    pub(crate) fn is_rough(&self) -> bool {
        self.after_loss || self.attempt != Attempt::Motion
    }
}

/// A way to predict a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Attempt {
    /// The last frame's points, searched where a constant velocity puts them.
    Motion,
    /// Descriptors matched against the keyframes around the last one, without any prediction.
    ReferenceKeyframe,
    /// Descriptors matched against the keyframes that look alike, wherever they are.
    Relocalization,
}

impl Tracker {
    /// Predicts in one way.
    pub(super) fn predict(
        &self,
        attempt: Attempt,
        frame: &Frame,
        world: &World,
        last: Option<&LastFrame>,
        inertia: Option<Inertia>,
    ) -> Result<Prediction, Lost> {
        match (attempt, last) {
            (Attempt::Motion, Some(last)) => self.predict_by_motion(frame, &world.map, last, inertia),
            (Attempt::ReferenceKeyframe, Some(last)) => {
                Ok(attempt.gave(track_reference_keyframe(frame, &world.map, last, &self.params)?))
            }
            _ => Ok(attempt.gave(relocalize(frame, world, &self.params)?)),
        }
    }

    /// Searches the last frame's points from where the motion model puts the camera; after a loss also from where it was.
    fn predict_by_motion(
        &self,
        frame: &Frame,
        map: &Map,
        last: &LastFrame,
        inertia: Option<Inertia>,
    ) -> Result<Prediction, Lost> {
        let rest = last.cam_from_world(map);
        let Some(velocity) = &self.velocity else { return self.predict_at(&rest, None, frame, map, last) };
        let predicted = velocity.motion_over(last.seconds_to(frame)) * rest;
        let moving = self.predict_at(&predicted, inertia, frame, map, last);
        match moving {
            Err(lost) if self.loss.is_lost => {
                self.predict_at(&rest, None, frame, map, last).map_err(|l| lost.further(l))
            }
            moving => moving,
        }
    }

    /// Where the camera would be had it gone on as before. Inertia is in meters, and says nothing of a camera that nobody saw.
    pub(super) fn inertia(&self, frame: &Frame, map: &Map, last: &LastFrame) -> Option<Inertia> {
        let velocity =
            self.velocity.filter(|_| !self.loss.is_lost && !self.params.camera.sensor.is_scale_free())?;
        let seconds = last.seconds_to(frame);
        Some(Inertia { predicted: velocity.motion_over(seconds) * last.cam_from_world(map), seconds })
    }

    /// Searches the last frame's points around a predicted pose, in windows that grow until enough agree; `inertia` if the
    /// camera is to be there.
    fn predict_at(
        &self,
        predicted: &SE3,
        inertia: Option<Inertia>,
        frame: &Frame,
        map: &Map,
        last: &LastFrame,
    ) -> Result<Prediction, Lost> {
        let tracking = &self.params.tracking;
        let last_cam_from_world = last.cam_from_world(map);
        // Without depth there is no measure of what a long way is.
        let far = if self.params.camera.sensor.is_scale_free() {
            f64::INFINITY
        } else {
            frame.rig.stereo.baseline_m
        };
        let sources = last_points(map, last, &last_cam_from_world);
        let mut lost = Lost::TooFewMatches { found: 0, needed: tracking.min_motion_matches };
        for widening in WIDENINGS {
            let radius_px = widening * self.params.camera.motion_radius_px;
            let matches = search_last(frame, last, &last_cam_from_world, predicted, &sources, radius_px, far);
            let (found, needed) = (matches.len(), tracking.min_motion_matches);
            if found < needed {
                lost = lost.further(Lost::TooFewMatches { found, needed });
                continue;
            }
            let positions: Vec<(u32, Vec3)> =
                matches.iter().map(|&(f, source)| (f, sources[source].position)).collect();
            let noise = self.params.noise();
            let mut solved = refine_with_positions(frame, *predicted, &positions, noise);
            if let Some(inertia) = inertia {
                solved = inertia.likelier(frame, &positions, solved, noise);
            }
            let (cam_from_world, agrees) = solved;
            let agreeing = matches.iter().zip(&agrees).filter(|(_, agrees)| **agrees);
            let (found, needed) =
                (agreeing.clone().count(), tracking.min_predicted_inliers.max(matches.len() / 3));
            if found < needed {
                lost = lost.further(Lost::TooFewPredictedInliers { found, needed });
                continue;
            }
            let matches =
                agreeing.filter_map(|(&(f, source), _)| sources[source].id.map(|id| (f, id))).collect();
            return Ok(Prediction {
                cam_from_world,
                matches,
                attempt: Attempt::Motion,
                after_loss: self.loss.is_lost,
            });
        }
        Err(lost)
    }
}

impl Attempt {
    fn gave(self, pose: RefinedPose) -> Prediction {
        Prediction {
            cam_from_world: pose.cam_from_world,
            matches: pose.inliers,
            attempt: self,
            after_loss: false,
        }
    }
}

/// Something of the last frame to look for: a map point, or a feature's own depth.
struct Source {
    /// Feature of the last frame.
    feature: u32,
    position: Vec3,
    /// `None` for a feature that has depth but no map point.
    id: Option<PointId>,
}

/// The last frame's map points, and its nearest other features with depth until there are [`MAX_SOURCES`].
fn last_points(map: &Map, last: &LastFrame, last_cam_from_world: &SE3) -> Vec<Source> {
    let mut used = vec![false; last.frame.len()];
    let mut sources = Vec::with_capacity(MAX_SOURCES.max(last.matches.len()));
    for &(feature, id) in &last.matches {
        used[feature as usize] = true;
        if let Some(point) = map.point(id) {
            sources.push(Source { feature, position: point.position, id: Some(id) });
        }
    }
    let mut others: Vec<usize> =
        (0..last.frame.len()).filter(|&i| !used[i] && last.frame.has_depth(i)).collect();
    others.sort_by(|&a, &b| last.frame.depth[a].total_cmp(&last.frame.depth[b]).then(a.cmp(&b)));
    others.truncate(MAX_SOURCES.saturating_sub(sources.len()));
    let world_from_last = last_cam_from_world.inverse();
    sources.extend(others.into_iter().filter_map(|i| {
        let position = world_from_last * last.frame.unproject(i)?;
        Some(Source { feature: i as u32, position, id: None })
    }));
    sources
}

/// Matches `(feature, source)` within `radius_px * scale` of the predicted positions. The octaves looked at depend on
/// whether the camera moved forward, backward or neither by more than `far`.
fn search_last(
    frame: &Frame,
    last: &LastFrame,
    last_cam_from_world: &SE3,
    predicted: &SE3,
    sources: &[Source],
    radius_px: f32,
    far: f64,
) -> Vec<(u32, usize)> {
    let forward_m = (*last_cam_from_world * predicted.inverse()).translation.z;
    let top = (frame.scales.scales.len() - 1) as u8;
    let asked = sources.iter().enumerate().filter_map(|(i, source)| {
        let uvr = project_inside(frame, predicted, &source.position)?;
        let octave = last.frame.keypoints[source.feature as usize].octave;
        let (min_octave, max_octave) = if forward_m > far {
            (octave, top)
        } else if forward_m < -far {
            (0, octave)
        } else {
            (octave.saturating_sub(1), (octave + 1).min(top))
        };
        let query = ProjectionQuery {
            x: uvr.x as f32,
            y: uvr.y as f32,
            right_u: uvr.z as f32,
            radius_px: radius_px * frame.scales.scales[usize::from(octave)],
            min_octave,
            max_octave,
            descriptor: last.frame.descriptors[source.feature as usize],
        };
        Some((i, query))
    });
    let accept = |_, find: &WindowMatch| find.best.distance <= MAX_DISTANCE_WIDE;
    let matches = search(frame, asked, &vec![true; frame.len()], accept);
    consistent_in_rotation(frame, matches, |&source| {
        last.frame.keypoints[sources[source].feature as usize].angle_deg
    })
}

#[cfg(test)]
#[path = "../../tests/steps/predict.rs"]
mod tests;
