//! One camera that turns on the spot: nothing new has a depth, so the map cannot grow and its points leave the view. The rotation is
//! still known from directions: from views kept along the turn, so that it does not drift when the camera comes back. The
//! position is held where the turn began, until points of the map come into view again or the camera moves on.

use std::sync::Arc;

use features::Frame;
use geometry::{SE3, SO3, Vec3, median};
use map::{Map, RelativePose};

use super::directions::{SeenRotation, rotation_between};
use super::last_frame::LastFrame;
use super::local_map::{LocalMap, LocallyTracked};
use super::motion_model::MotionModel;
use super::predict::{Attempt, Prediction};
use super::{TrackState, TrackStats, Tracked, Tracker};
use crate::assess::{Assessment, QualityReason};
use crate::lost::Lost;
use crate::params::Params;
use crate::pose::refine;
use crate::probe::Probe;
use crate::search::{Window, points_around, search_points};
use crate::world::World;

/// Directions that must agree with a rotation, and the share of all matches that they must be.
const MIN_INLIERS: usize = 50;
const MIN_SHARE: f64 = 0.7;
/// How far a camera has turned over the last frames that turns on the spot.
const MIN_TURN_RAD: f64 = 0.03;
/// A view is kept for each such angle.
const VIEW_SPACING_RAD: f64 = 0.12;
const MAX_VIEWS: usize = 100;
/// Windows tried in turn, in units of the usual radius.
const WIDENINGS: [f32; 3] = [1.0, 2.0, 4.0];
/// Frames in a row that may fail before a turn is forgotten.
const MAX_MISSED: u32 = 5;
/// Points that say where a turning camera is; fewer, at the rim of the image, do not.
const MIN_POINTS: usize = 50;
/// How far a camera that still turns on the spot may seem to have moved over the last frames, in median depths of its points.
const STILL: f64 = 0.03;
/// Keyframes around the beginning of the turn whose points are looked for.
const NEIGHBORS: usize = 20;
const WINDOW: Window = Window { radius_px: 12.0, max_distance: 64 };
/// How far a frame is trusted that only directions were found in.
const QUALITY: f64 = 0.4;

/// A turn on the spot so far.
#[derive(Clone, Debug)]
pub(super) struct Turning {
    /// Where the camera is held, with the rotation of the frame in which that began.
    anchor: RelativePose,
    /// Views along the turn.
    views: Vec<View>,
    /// Rotation of the present frame, and what the last frame added to it.
    now_from_anchor: SO3,
    step: SO3,
    /// Frames since then that could not be followed.
    missed: u32,
}

#[derive(Clone, Debug)]
struct View {
    frame: Arc<Frame>,
    view_from_anchor: SO3,
}

impl Turning {
    fn new(frame: &Arc<Frame>, anchor: RelativePose, step: SO3) -> Self {
        let views = vec![View { frame: frame.clone(), view_from_anchor: SO3::identity() }];
        Turning { anchor, views, now_from_anchor: SO3::identity(), step, missed: 0 }
    }

    /// Finds how far the camera has turned until `frame`; `None` where directions alone do not explain what it sees.
    fn follow(&mut self, frame: &Arc<Frame>, params: &Params) -> Option<SeenRotation> {
        let predicted = (0..=self.missed).fold(self.now_from_anchor, |rotation, _| self.step * rotation);
        self.missed += 1;
        let gap = |view: &View| (predicted * view.view_from_anchor.inverse()).angle();
        // Of equally near views the older one.
        let view = self.views.iter().min_by(|a, b| gap(a).total_cmp(&gap(b)))?;
        let now_from_view = predicted * view.view_from_anchor.inverse();
        let found = turned(&view.frame, frame, &now_from_view, params)?;
        let now_from_anchor = (found.now_from_then * view.view_from_anchor).orthonormalized();
        let is_new = found.now_from_then.angle() > VIEW_SPACING_RAD && self.views.len() < MAX_VIEWS;
        let turn = now_from_anchor * self.now_from_anchor.inverse();
        self.step = SO3::exp(&(turn.log() / f64::from(self.missed)));
        (self.now_from_anchor, self.missed) = (now_from_anchor, 0);
        if is_new {
            self.views.push(View { frame: frame.clone(), view_from_anchor: now_from_anchor });
        }
        Some(found)
    }

    /// The pose of the present frame, its position that of the anchor.
    fn pose(&self, map: &Map) -> RelativePose {
        let anchor = self.anchor.on_living(map);
        let turn = SE3::new(self.now_from_anchor, Vec3::zeros());
        RelativePose::new(map, anchor.keyframe, (turn * anchor.cam_from_keyframe).normalized())
    }
}

/// The rotation between two frames, if the camera did nothing but turn.
fn turned(then: &Frame, now: &Frame, predicted: &SO3, params: &Params) -> Option<SeenRotation> {
    let radii = WIDENINGS.map(|widening| widening * params.camera.motion_radius_px);
    radii
        .into_iter()
        .filter_map(|radius_px| rotation_between(then, now, predicted, radius_px, params))
        .find(|seen| seen.inliers >= MIN_INLIERS && seen.inliers as f64 >= MIN_SHARE * seen.matches as f64)
}

/// What became of a frame.
pub(super) enum Found {
    /// The map tells its pose.
    Local(Box<LocallyTracked>),
    /// The camera turns on the spot: only the rotation is known.
    Held(Box<Tracked>),
    /// It has no pose.
    Lost(Lost),
}

impl Tracker {
    /// The pose of a frame, where need be without its position: while one camera turns on the spot.
    pub(super) fn find_pose_or_turn(
        &mut self,
        frame: &Arc<Frame>,
        world: &World,
        last: Option<&LastFrame>,
        probe: &mut dyn Probe,
    ) -> Found {
        let map = &world.map;
        let mut missed = None;
        if let Some(mut turning) = self.turning.take() {
            let seen = turning.follow(frame, &self.params);
            if let Ok(local) = self.find_from(turning.pose(map), frame, map) {
                return Found::Local(Box::new(local));
            }
            if let Some(seen) = seen {
                return Found::Held(Box::new(self.hold(turning, frame, map, last, seen.inliers)));
            }
            // Blurred, or the camera moves on. What the map shows is out of view: nothing is gained by waiting with a new one.
            self.loss.has_lasted(&self.params);
            missed = (turning.missed <= MAX_MISSED).then_some(turning);
        }
        let found = self.find_pose(frame, world, last, probe);
        let is_weak = found.as_ref().map_or(true, |local| local.matches.len() < MIN_POINTS);
        if is_weak
            && !self.loss.is_lost
            && let Some(mut turning) = last.and_then(|last| self.begin_turn(map, last))
            && let Some(seen) = turning.follow(frame, &self.params)
        {
            return Found::Held(Box::new(self.hold(turning, frame, map, last, seen.inliers)));
        }
        if found.is_err() {
            self.turning = missed;
        }
        found.map_or_else(Found::Lost, |local| Found::Local(Box::new(local)))
    }

    /// A frame of which only the rotation is known.
    fn hold(
        &mut self,
        turning: Turning,
        frame: &Arc<Frame>,
        map: &Map,
        last: Option<&LastFrame>,
        agreeing: usize,
    ) -> Tracked {
        let pose = turning.pose(map);
        self.velocity = last.zip(pose.cam_from_world(map)).map(|(last, cam_from_world)| {
            MotionModel::between(&last.cam_from_world(map), &cam_from_world, last.seconds_to(frame))
        });
        self.turning = Some(turning);
        self.last = Some(LastFrame::new(frame.clone(), pose, &[]));
        self.assessor.forget();
        self.initializer = None;
        self.loss.end();
        let stats = TrackStats { inliers: agreeing, ..TrackStats::default() };
        let reasons = vec![QualityReason::TurningOnTheSpot];
        let assessment = Assessment { quality: QUALITY, reasons, ..Assessment::default() };
        Tracked { pose: Some(pose), stats, assessment, ..Tracked::without_pose(TrackState::Tracked, None) }
    }

    /// Looks for the map's points from where a turning camera is held. Few, at the rim of the image, do not say where it is.
    fn find_from(&self, pose: RelativePose, frame: &Frame, map: &Map) -> Result<LocallyTracked, Lost> {
        let few = |found| Lost::TooFewLocalInliers { found, needed: MIN_POINTS };
        let cam_from_world = pose.cam_from_world(map).ok_or(few(0))?;
        let points = points_around(map, pose.keyframe, NEIGHBORS);
        let searched = search_points(frame, map, &cam_from_world, &points, &[], WINDOW);
        if searched.matches.len() < MIN_POINTS {
            return Err(few(searched.matches.len()));
        }
        let found = refine(frame, map, cam_from_world, &searched.matches, self.params.noise());
        let predicted = Prediction {
            cam_from_world: found.cam_from_world,
            matches: found.inliers,
            attempt: Attempt::ReferenceKeyframe,
            after_loss: false,
        };
        if predicted.matches.len() < MIN_POINTS {
            return Err(few(predicted.matches.len()));
        }
        let local = LocalMap::gather(map, &predicted.matches, pose.keyframe, &self.params.tracking);
        let local = local.track(frame, map, &predicted, &self.params);
        if local.matches.len() >= MIN_POINTS { Ok(local) } else { Err(few(local.matches.len())) }
    }

    /// A turn that begins with the last frame, if one camera has turned over the frames before it and hardly moved, measured in depths of
    /// the points that it sees. It is held in the middle of where it seemed to be.
    fn begin_turn(&self, map: &Map, last: &LastFrame) -> Option<Turning> {
        if !self.params.camera.sensor.is_scale_free() {
            return None;
        }
        let now = last.cam_from_world(map);
        let before: Vec<SE3> = self.assessor.past().map(|past| past.cam_from_world(map)).collect();
        let points = last.matches.iter().filter_map(|&(_, id)| map.point(id));
        let mut depths: Vec<f64> = points.map(|point| (now * point.position).z).collect();
        let (oldest, depth) = (before.first()?, median(&mut depths)?);
        let turn = now.rotation * oldest.rotation.inverse();
        if turn.angle() < MIN_TURN_RAD || (now.center() - oldest.center()).norm() > STILL * depth {
            return None;
        }
        let center = before.iter().map(SE3::center).sum::<Vec3>() / before.len() as f64;
        let anchor = last.pose.on_living(map);
        let held_from_last = SE3::new(SO3::identity(), -(now * center));
        let held = (held_from_last * anchor.cam_from_keyframe).normalized();
        let step = self.velocity.map_or(SO3::identity(), |velocity| velocity.turn());
        Some(Turning::new(&last.frame, RelativePose::new(map, anchor.keyframe, held), step))
    }
}

#[cfg(test)]
#[path = "../../tests/steps/turning.rs"]
mod tests;
