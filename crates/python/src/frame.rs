//! What tracking says of a frame.

use dsslam::{Assessment, FrameAnswer};
use pyo3::prelude::*;

use crate::poses::{self, Array};

/// What tracking made of a frame. Later corrections of the map move its pose; `Finished` has the final ones.
#[pyclass(frozen, get_all, module = "dsslam")]
pub(crate) struct Result {
    /// Time of the frame, nanoseconds.
    t_ns: i64,
    index: u32,
    state: &'static str,
    reason: Option<String>,
    is_tracked: bool,
    pose: Option<Array>,
    position: Option<Array>,
    quaternion: Option<Array>,
    motion: Option<Array>,
    covariance: Option<Array>,
    covariance_world: Option<Array>,
    quality: f64,
    quality_reasons: Vec<&'static str>,
    residual_px: Option<f64>,
    submap: Option<u32>,
    keyframe: bool,
    keyframe_reason: Option<String>,
    relocalized: bool,
    inliers: usize,
    matches: usize,
    features: usize,
    with_depth: usize,
    n_keyframes: usize,
    n_points: usize,
    track_ms: f64,
}

impl Result {
    pub(crate) fn new(answer: &FrameAnswer, t_ns: i64) -> Self {
        let (pose, assessment) = (answer.world_from_cam, &answer.assessment);
        let in_world = |pose: dsslam::SE3| Some(assessment.covariance?.in_parent(&pose.rotation));
        let quaternion = pose.map(|pose| pose.rotation.to_quaternion());
        Self {
            t_ns,
            index: answer.index,
            state: answer.status.state().key(),
            reason: answer.status.reason(),
            is_tracked: answer.status.has_pose(),
            pose: pose.as_ref().map(poses::matrix),
            position: pose.map(|pose| poses::vector(pose.translation.as_slice())),
            quaternion: quaternion.map(|q| poses::vector(&[q.i, q.j, q.k, q.w])),
            motion: answer.last_from_cam.as_ref().map(poses::matrix),
            covariance: assessment.covariance.map(|covariance| poses::covariance(&covariance.in_camera())),
            covariance_world: pose.and_then(in_world).as_ref().map(poses::covariance),
            quality: assessment.quality,
            quality_reasons: reasons(assessment),
            residual_px: assessment.residual_px,
            submap: answer.submap.map(|root| root.0),
            keyframe: answer.keyframe.is_some(),
            keyframe_reason: answer.keyframe.map(|reason| reason.to_string()),
            relocalized: answer.stats.relocalized,
            inliers: answer.status.inliers().unwrap_or(0),
            matches: answer.stats.matches,
            features: answer.features,
            with_depth: answer.with_depth,
            n_keyframes: answer.keyframes,
            n_points: answer.points,
            track_ms: answer.track_ms,
        }
    }
}

#[pymethods]
impl Result {
    fn __repr__(&self) -> String {
        match &self.reason {
            Some(reason) => format!("Result({}: {}, {reason})", self.index, self.state),
            None => format!("Result({}: {}, {} inliers)", self.index, self.state, self.inliers),
        }
    }
}

/// What lowers the quality, in the words of `frames.csv`.
pub(crate) fn reasons(assessment: &Assessment) -> Vec<&'static str> {
    assessment.reasons.iter().map(|reason| reason.key()).collect()
}
