//! What a run tells while it runs. Observers print, draw and count; nothing is read back.

use std::sync::Arc;

use features::{ActivationMap, Frame};
use geometry::{GrayImage, SE3};
use map::{KeyframeId, PointId, RelativePose};
use slam::{Assessment, KeyframeReason, MappingReport, RefinedCalibration, TrackStats, Tracked, World};

use crate::feed::FrameInfo;
use crate::record::{FrameStatus, LoopRecord};
use crate::snapshot::View;

/// What tracking knows of a frame as soon as it is done with it. Later corrections of the map move its pose.
/// Fields may be added.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FrameAnswer {
    /// Number of the frame in its sequence.
    pub index: u32,
    /// Time, seconds.
    pub timestamp_s: f64,
    /// Its outcome.
    pub status: FrameStatus,
    /// Pose in the map that it saw, or that it starts; `None` for a frame without a pose of its own.
    pub world_from_cam: Option<SE3>,
    /// Pose in the camera of the last frame that had one, as both stand in the map that this frame saw: put together, these motions make
    /// an odometry that no correction of the map lets jump. `None` where the two have no map in common.
    pub last_from_cam: Option<SE3>,
    /// The sub-map of that pose, named by the root of its keyframes; `None` without a pose, and for the frame that starts it.
    pub submap: Option<KeyframeId>,
    /// How far the pose is to be trusted, with its covariance.
    pub assessment: Assessment,
    /// Why mapping was asked to make it a keyframe, if it was.
    pub keyframe: Option<KeyframeReason>,
    /// Counts of tracking.
    pub stats: TrackStats,
    /// Features in the frame.
    pub features: usize,
    /// Features with a depth.
    pub with_depth: usize,
    /// Keyframes in the map that it saw.
    pub keyframes: usize,
    /// Points in that map.
    pub points: usize,
    /// Work from the decoded images to the pose, milliseconds.
    pub track_ms: f64,
}

impl FrameAnswer {
    /// The answer to a frame of which nothing but this is known, with the keyframes and points of the map that it saw.
    pub(crate) fn without_pose(
        info: FrameInfo,
        status: FrameStatus,
        (keyframes, points): (usize, usize),
    ) -> Self {
        Self {
            index: info.index,
            timestamp_s: info.timestamp_s,
            status,
            world_from_cam: None,
            last_from_cam: None,
            submap: None,
            assessment: Assessment::default(),
            keyframe: None,
            stats: TrackStats::default(),
            features: 0,
            with_depth: 0,
            keyframes,
            points,
            track_ms: 0.0,
        }
    }
}

/// One thing that happened. Where stages run on threads, events of different stages come in any order.
#[derive(Clone, Debug)]
pub enum Event {
    /// The run begins.
    Started {
        /// Frames to come; `None` if that is not known.
        frames: Option<usize>,
    },
    /// The map told that the calibration is off, and it was refined.
    Calibrated {
        /// Number of the frame whose keyframe led to it.
        frame: u32,
        /// What is in force now.
        calibration: Arc<RefinedCalibration>,
    },
    /// A frame went through tracking, or was dropped.
    Frame(Box<FrameAnswer>),
    /// A lost camera, or one in a map from a file, found its place again.
    Relocalized {
        /// Number of the frame in its sequence.
        frame: u32,
        /// The keyframe that its pose refers to.
        keyframe: KeyframeId,
        /// The sub-map of that keyframe, named by its root.
        submap: Option<KeyframeId>,
    },
    /// A keyframe was inserted and its mapping is done.
    Keyframe {
        /// Its id.
        id: KeyframeId,
        /// The frame that it was.
        frame: u32,
        /// Why.
        reason: KeyframeReason,
        /// What mapping did.
        report: MappingReport,
    },
    /// After a lasting loss a new sub-map was started.
    SubmapStarted {
        /// Number of the frame in its sequence.
        frame: u32,
        /// Its keyframe, which is the root of the sub-map.
        keyframe: KeyframeId,
    },
    /// A keyframe sees a place again; the loop will be closed.
    LoopFound {
        /// The keyframe.
        keyframe: KeyframeId,
        /// That of the earlier visit.
        matched: KeyframeId,
        /// Matches that agree with the loop's geometry.
        inliers: usize,
    },
    /// A loop was closed, or rejected.
    Loop(LoopRecord),
    /// A global bundle adjustment was applied.
    GlobalAdopted {
        /// Its cost before and after.
        cost: [f64; 2],
    },
    /// A global bundle adjustment was discarded, since another loop was closed meanwhile.
    GlobalDiscarded,
    /// The map refused a global bundle adjustment.
    GlobalRefused {
        /// Why.
        reason: String,
    },
    /// Everything about a frame that went through tracking with usable images. Only for observers that want details.
    Details(Arc<FrameDetails>),
    /// A state of the world that tracking may see. Only for observers that want details.
    Published(Arc<World>),
    /// Times of stages that ran for a frame beside its tracking. Only for observers that want details.
    Stages {
        /// Number of the frame in its sequence.
        frame: u32,
        /// `(stage, ms)` in the order in which the stages ended.
        stages: Vec<(&'static str, f64)>,
    },
}

/// Listens to a run.
pub trait Observer {
    /// Something happened.
    fn event(&mut self, event: &Event);
    /// Whether details are wanted, which cost memory; asked once before a run. Results never depend on it.
    fn wants_details(&self) -> bool {
        false
    }
}

/// Listens to nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {
    fn event(&mut self, _: &Event) {}
}

/// What the features of a frame were found in.
#[derive(Clone, Debug)]
pub struct SourceImages {
    /// The left image.
    pub image: Arc<GrayImage>,
    /// Its activation map, if a network selects features.
    pub activation: Option<Arc<ActivationMap>>,
}

/// A frame after tracking; shares what the run has.
#[derive(Clone, Debug)]
pub struct FrameDetails {
    /// What was said of it.
    pub answer: FrameAnswer,
    /// The world that tracking saw.
    pub world: Arc<World>,
    /// Its features.
    pub frame: Arc<Frame>,
    /// What they were found in.
    pub images: Option<SourceImages>,
    /// The pose relative to a keyframe of the map as it was then, of a lost frame the last one known; `None` for a frame that
    /// starts a map.
    pub pose: Option<RelativePose>,
    /// Scale of the keyframe in that map.
    pub scale: f64,
    /// Pose in that map; the identity for a frame that starts it.
    pub world_from_cam: SE3,
    /// All matches of features with map points, sorted by feature.
    pub matched: Vec<(u32, PointId)>,
    /// Probability, of all that is known with this frame, that the point of each of them stands still.
    pub trust: Vec<f32>,
    /// Those of them that agree with the pose.
    pub inliers: Vec<(u32, PointId)>,
    /// `(stage, ms)` in the order in which the stages ended.
    pub stages: Vec<(&'static str, f64)>,
}

impl FrameDetails {
    /// Details of a frame that was just tracked; `tracked` loses its matches.
    pub(crate) fn new(
        answer: FrameAnswer,
        (frame, images): (Arc<Frame>, Option<SourceImages>),
        (tracked, trust): (&mut Tracked, Vec<f32>),
        view: &View,
        stages: Vec<(&'static str, f64)>,
    ) -> Self {
        let map = &view.world.map;
        let pose = tracked.pose.map(|pose| pose.on_living(map));
        let cam_from_world = pose.and_then(|pose| pose.cam_from_world(map)).unwrap_or(SE3::identity());
        FrameDetails {
            answer,
            world: view.world.clone(),
            frame,
            images,
            pose,
            scale: pose.map_or(1.0, |pose| map.scale_of(pose.keyframe)),
            world_from_cam: cam_from_world.normalized().inverse(),
            matched: std::mem::take(&mut tracked.matched),
            trust,
            inliers: std::mem::take(&mut tracked.inliers),
            stages,
        }
    }
}
