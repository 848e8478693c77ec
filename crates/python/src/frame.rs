//! What tracking says of a frame.

use dsslam::{Assessment, FrameAnswer};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::poses;

/// What tracking made of a frame. Later corrections of the map move its pose; `Finished` has the final ones.
#[pyclass(frozen, module = "dsslam")]
pub(crate) struct Result {
    answer: FrameAnswer,
    /// Time of the frame, nanoseconds.
    #[pyo3(get)]
    t_ns: i64,
}

impl Result {
    pub(crate) fn new(answer: FrameAnswer, t_ns: i64) -> Self {
        Self { answer, t_ns }
    }
}

#[pymethods]
impl Result {
    #[getter]
    fn index(&self) -> u32 {
        self.answer.index
    }

    #[getter]
    fn state(&self) -> &'static str {
        self.answer.status.state().key()
    }

    #[getter]
    fn reason(&self) -> Option<String> {
        self.answer.status.reason()
    }

    #[getter]
    fn is_tracked(&self) -> bool {
        self.answer.status.has_pose()
    }

    #[getter]
    fn pose<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        self.answer.world_from_cam.as_ref().map(|pose| poses::matrix(py, pose)).transpose()
    }

    #[getter]
    fn position<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.answer.world_from_cam.map(|pose| PyArray1::from_slice(py, pose.translation.as_slice()))
    }

    #[getter]
    fn quaternion<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        let quaternion = self.answer.world_from_cam?.rotation.to_quaternion();
        Some(PyArray1::from_slice(py, &[quaternion.i, quaternion.j, quaternion.k, quaternion.w]))
    }

    #[getter]
    fn motion<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        self.answer.last_from_cam.as_ref().map(|pose| poses::matrix(py, pose)).transpose()
    }

    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        self.answer
            .assessment
            .covariance
            .map(|covariance| poses::covariance(py, &covariance.in_camera()))
            .transpose()
    }

    #[getter]
    fn covariance_world<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let turned = self.answer.assessment.covariance.zip(self.answer.world_from_cam);
        turned
            .map(|(covariance, pose)| poses::covariance(py, &covariance.in_parent(&pose.rotation)))
            .transpose()
    }

    #[getter]
    fn quality(&self) -> f64 {
        self.answer.assessment.quality
    }

    #[getter]
    fn quality_reasons(&self) -> Vec<&'static str> {
        reasons(&self.answer.assessment)
    }

    #[getter]
    fn residual_px(&self) -> Option<f64> {
        self.answer.assessment.residual_px
    }

    #[getter]
    fn submap(&self) -> Option<u32> {
        self.answer.submap.map(|root| root.0)
    }

    #[getter]
    fn keyframe(&self) -> bool {
        self.answer.keyframe.is_some()
    }

    #[getter]
    fn keyframe_reason(&self) -> Option<String> {
        self.answer.keyframe.map(|reason| reason.to_string())
    }

    #[getter]
    fn relocalized(&self) -> bool {
        self.answer.stats.relocalized
    }

    #[getter]
    fn inliers(&self) -> usize {
        self.answer.status.inliers().unwrap_or(0)
    }

    #[getter]
    fn matches(&self) -> usize {
        self.answer.stats.matches
    }

    #[getter]
    fn features(&self) -> usize {
        self.answer.features
    }

    #[getter]
    fn with_depth(&self) -> usize {
        self.answer.with_depth
    }

    #[getter]
    fn n_keyframes(&self) -> usize {
        self.answer.keyframes
    }

    #[getter]
    fn n_points(&self) -> usize {
        self.answer.points
    }

    #[getter]
    fn track_ms(&self) -> f64 {
        self.answer.track_ms
    }

    fn __repr__(&self) -> String {
        match self.answer.status.reason() {
            Some(reason) => format!("Result({}: {}, {reason})", self.answer.index, self.state()),
            None => format!("Result({}: {}, {} inliers)", self.answer.index, self.state(), self.inliers()),
        }
    }
}

/// What lowers the quality, in the words of `frames.csv`.
pub(crate) fn reasons(assessment: &Assessment) -> Vec<&'static str> {
    assessment.reasons.iter().map(|reason| reason.key()).collect()
}
