//! Where the algorithms say which stage they are in; a clock, if there is one, belongs to the caller.

/// The named stages of tracking, mapping and loop closing, in the order in which a frame passes through them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Prediction by the motion model, the reference keyframe or recovery.
    Predict,
    /// Search of local map points and the final motion-only optimization.
    LocalMap,
    /// The keyframe decision.
    Decide,
    /// The covariance of the pose and its quality.
    Assess,
    /// Insertion of a keyframe and its stereo points.
    Insert,
    /// Culling of young points.
    CullPoints,
    /// Triangulation with covisible keyframes.
    Triangulate,
    /// Fusion of duplicate points.
    Fuse,
    /// Local bundle adjustment.
    LocalBundle,
    /// Culling of redundant keyframes.
    CullKeyframes,
    /// Refinement of the calibration.
    Calibrate,
    /// The places that look like a new keyframe.
    LoopDetect,
    /// Geometry of a loop candidate.
    LoopVerify,
    /// Test and pose graph of a loop.
    PoseGraph,
    /// Correction of the map and fusion across a loop.
    LoopClose,
    /// Global bundle adjustment.
    GlobalBundle,
}

impl Stage {
    /// The stage's name in tables and files.
    pub fn name(self) -> &'static str {
        match self {
            Stage::Predict => "predict",
            Stage::LocalMap => "local_map",
            Stage::Decide => "decide",
            Stage::Assess => "assess",
            Stage::Insert => "insert",
            Stage::CullPoints => "cull_points",
            Stage::Triangulate => "triangulate",
            Stage::Fuse => "fuse",
            Stage::LocalBundle => "local_bundle",
            Stage::CullKeyframes => "cull_keyframes",
            Stage::Calibrate => "calibrate",
            Stage::LoopDetect => "loop_detect",
            Stage::LoopVerify => "loop_verify",
            Stage::PoseGraph => "pose_graph",
            Stage::LoopClose => "loop_close",
            Stage::GlobalBundle => "global_bundle",
        }
    }
}

/// Told when a stage begins and ends. Nothing is read back by the algorithms.
pub trait Probe {
    /// `stage` begins.
    fn begin(&mut self, stage: Stage);
    /// `stage` ends.
    fn end(&mut self, stage: Stage);
}

/// A probe that does nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoProbe;

impl Probe for NoProbe {
    fn begin(&mut self, _: Stage) {}
    fn end(&mut self, _: Stage) {}
}

/// Runs `work` between the begin and the end of `stage`.
pub fn staged<T>(probe: &mut dyn Probe, stage: Stage, work: impl FnOnce() -> T) -> T {
    probe.begin(stage);
    let result = work();
    probe.end(stage);
    result
}
