//! What the stream is made of. A change of these types is a change of [`VERSION`](crate::VERSION).

use geometry::{PoseCovariance, Sensor};
use serde::{Deserialize, Serialize};

use crate::Pose;
use crate::map_delta::MapDelta;

/// One entry of the stream.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Record {
    /// The first entry: what is going to be run.
    Start(Start),
    /// A frame went through tracking.
    Frame(FrameRecord),
    /// Features of a frame.
    Features(Features),
    /// The image of a frame.
    Image(Image),
    /// The activation map of a frame.
    Activation(ActivationMap),
    /// What changed in the map.
    Map(MapDelta),
    /// Times of stages that ended after the frame's record was written, by frame.
    Stages {
        /// Number of the frame that the work belongs to.
        frame: u32,
        /// Its times.
        stages: Vec<StageTime>,
    },
    /// Something to tell a person.
    Text(Text),
    /// The last entry of a run that came to its end.
    End(End),
}

/// What is going to be run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Start {
    /// Version of the program.
    pub program_version: String,
    /// Name of the sequence.
    pub sequence: String,
    /// Which images a frame has.
    pub sensor: Sensor,
    /// The left camera of the undistorted images.
    pub camera: Camera,
    /// Frames to come.
    pub n_frames: u32,
    /// True positions of the left camera in a frame of their own, in order of the frames; frames without one are skipped.
    pub truth: Vec<TruePosition>,
}

/// A pinhole camera.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// Focal lengths, pixels.
    pub focal: [f64; 2],
    /// Principal point, pixels.
    pub center: [f64; 2],
    /// Width and height, pixels.
    pub size: [u32; 2],
}

/// Where the camera truly was.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TruePosition {
    /// Number of the frame.
    pub frame: u32,
    /// Position, meters.
    pub position: [f64; 3],
}

/// Outcome of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FrameState {
    /// There was no map yet.
    NotReady,
    /// It has a pose.
    Tracked,
    /// Tracking failed.
    Lost,
    /// Its images could not be used.
    Dropped,
}

impl FrameState {
    /// The state with this [`key`](Self::key).
    pub fn of_key(key: &str) -> Option<Self> {
        [Self::NotReady, Self::Tracked, Self::Lost, Self::Dropped]
            .into_iter()
            .find(|state| state.key() == key)
    }

    /// In one word for programs and tables.
    pub fn key(self) -> &'static str {
        match self {
            FrameState::NotReady => "not_ready",
            FrameState::Tracked => "tracked",
            FrameState::Lost => "lost",
            FrameState::Dropped => "dropped",
        }
    }

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            FrameState::NotReady => "not ready",
            other => other.key(),
        }
    }
}

/// A frame's pose relative to a keyframe, which moves it along when the map is corrected.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FramePose {
    /// Id of the keyframe; `None` for a frame that starts a map.
    pub keyframe: Option<u32>,
    /// Pose relative to it.
    pub cam_from_keyframe: Pose,
    /// The keyframe's scale when the pose was found.
    pub scale: f64,
    /// The pose in the map as it was then.
    pub world_from_cam: Pose,
}

/// A frame after tracking.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameRecord {
    /// Number of the frame in its sequence.
    pub index: u32,
    /// Time, seconds.
    pub timestamp_s: f64,
    /// Its outcome.
    pub state: FrameState,
    /// Why it has no pose; empty if it has one.
    pub reason: String,
    /// Its pose, if it has one of its own.
    pub pose: Option<FramePose>,
    /// How far its pose is to be trusted; `None` without one.
    pub trust: Option<Trust>,
    /// Counts of tracking.
    pub counts: Counts,
    /// Times of its stages.
    pub stages: Vec<StageTime>,
}

/// How far a pose is to be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trust {
    /// From 0 to 1.
    pub quality: f32,
    /// Largest standard deviations of the position (m) and the rotation (deg), if they are known.
    pub sigma: Option<[f32; 2]>,
}

impl Trust {
    /// A quality from 0 to 1, and the covariance of the pose if it is known.
    pub fn new(quality: f64, covariance: Option<&PoseCovariance>) -> Self {
        let sigma = covariance.map(|c| [c.sigma_m().max() as f32, c.sigma_deg().max() as f32]);
        Trust { quality: quality as f32, sigma }
    }
}

/// Counts of tracking of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counts {
    /// Features of the frame.
    pub features: u32,
    /// Of those, with depth.
    pub with_depth: u32,
    /// Map points that should be visible.
    pub visible: u32,
    /// Matches before the last optimization.
    pub matches: u32,
    /// Inliers after it.
    pub inliers: u32,
    /// Keyframes in the map that it saw.
    pub keyframes: u32,
    /// Points in that map.
    pub points: u32,
}

/// How long a stage took.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageTime {
    /// Its name.
    pub name: String,
    /// Milliseconds.
    pub ms: f32,
}

/// What tracking made of a feature.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FeatureState {
    /// It shows no known point of the map.
    New,
    /// It shows a point of the map and agrees with the pose.
    Tracked,
    /// It was matched with a point of the map and does not agree with the pose.
    Outlier,
}

/// Features of a frame; all lists have one element per feature.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Features {
    /// Number of the frame.
    pub frame: u32,
    /// Pixels of the full image.
    pub pixels: Vec<[f32; 2]>,
    /// What tracking made of each.
    pub states: Vec<FeatureState>,
    /// Belief in the map point of each, the network's word alone where it shows none, 0 to 255 for 0 to 1.
    pub activations: Vec<u8>,
}

/// An image, made smaller.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Image {
    /// Number of the frame.
    pub frame: u32,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// A JPEG file.
    pub jpeg: Vec<u8>,
}

/// An activation map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ActivationMap {
    /// Number of the frame.
    pub frame: u32,
    /// Width and height, pixels; the map covers the full image.
    pub size: [u32; 2],
    /// Row by row, 0 to 255 for 0 to 1.
    pub values: Vec<u8>,
}

/// How much a text matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Level {
    /// Good to know.
    Info,
    /// Something went wrong.
    Warning,
}

/// Something to tell a person.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Text {
    /// Number of the frame that it is about; `None`: the newest.
    pub frame: Option<u32>,
    /// How much it matters.
    pub level: Level,
    /// The text.
    pub text: String,
}

/// A frame's pose in the final map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FinalPose {
    /// Number of the frame.
    pub frame: u32,
    /// The pose.
    pub world_from_cam: Pose,
    /// Root of its sub-map.
    pub submap: Option<u32>,
}

/// The end of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct End {
    /// Final poses of the frames that have one of their own, in order.
    pub trajectory: Vec<FinalPose>,
    /// The numbers of the run for a person, as Markdown.
    pub summary: String,
    /// Records that were left out, since the writer was behind or the stream was full.
    pub left_out: u64,
}
