//! The results of a run.

use std::path::PathBuf;
use std::sync::Arc;

use dsslam::runtime::LoopResult;
use dsslam::submaps::of_largest;
use dsslam::trajectories::{own_pose, pose_per_frame};
use dsslam::{FrameStatus, Sensor};
use io::Trajectory;
use numpy::{PyArray1, PyArray3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::error::raised;
use crate::frame::reasons;
use crate::map::Map;
use crate::poses;

/// Final poses, map and loops of a run.
#[pyclass(frozen, module = "dsslam")]
#[derive(Clone)]
pub(crate) struct Finished {
    pub(crate) done: Arc<dsslam::Finished>,
    sensor: Sensor,
    /// What the user should know of how the run was set up.
    #[pyo3(get)]
    pub(crate) notices: Vec<String>,
    /// Errors against the ground truth as JSON, if there is one.
    evaluation: Option<String>,
}

impl Finished {
    pub(crate) fn new(
        done: dsslam::Finished,
        sensor: Sensor,
        notices: Vec<String>,
        evaluation: Option<String>,
    ) -> Self {
        Self { done: Arc::new(done), sensor, notices, evaluation }
    }

    /// Poses of the tracked frames, of the left camera or of the body.
    pub(crate) fn poses(&self, body: bool) -> Trajectory {
        if body { self.done.body_trajectory() } else { self.done.trajectory() }
    }
}

#[pymethods]
impl Finished {
    #[getter]
    fn n_frames(&self) -> usize {
        self.done.outcome.frames.len()
    }

    #[getter]
    fn n_tracked(&self) -> usize {
        self.done.outcome.frames.iter().filter(|frame| frame.status.has_pose()).count()
    }

    #[getter]
    fn sensor(&self) -> &'static str {
        self.sensor.word()
    }

    #[getter]
    fn interrupted(&self) -> bool {
        self.done.outcome.interrupted
    }

    #[getter]
    fn failure(&self) -> Option<String> {
        self.done.outcome.failure.as_ref().map(ToString::to_string)
    }

    #[pyo3(signature = (*, body=false))]
    #[expect(clippy::type_complexity, reason = "a pair of arrays")]
    fn trajectory<'py>(
        &self,
        py: Python<'py>,
        body: bool,
    ) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray3<f64>>)> {
        let poses = self.poses(body).poses;
        let times = PyArray1::from_iter(py, poses.iter().map(|pose| pose.timestamp_s));
        Ok((times, poses::matrices(py, poses.iter().map(|pose| pose.world_from_cam))?))
    }

    #[getter]
    fn frames<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let rows = self.done.outcome.frames.iter().map(|frame| {
            let row = PyDict::new(py);
            row.set_item("index", frame.index)?;
            row.set_item("time_s", frame.timestamp_s)?;
            row.set_item("t_ns", self.done.clock.nanoseconds(frame.timestamp_s))?;
            row.set_item("state", frame.status.state().key())?;
            row.set_item("reason", frame.status.reason())?;
            row.set_item("inliers", frame.status.inliers())?;
            row.set_item("submap", frame.submap.map(|root| root.0))?;
            let (assessment, covariance) = (&frame.assessment, frame.assessment.covariance);
            row.set_item("quality", assessment.quality)?;
            row.set_item("quality_reasons", reasons(assessment))?;
            let covariance = covariance.map(|covariance| poses::covariance(&covariance.in_camera()));
            row.set_item("covariance", covariance)?;
            row.set_item("pose", own_pose(frame).as_ref().map(poses::matrix))?;
            Ok(row)
        });
        PyList::new(py, rows.collect::<PyResult<Vec<_>>>()?)
    }

    #[getter]
    fn loops<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let rows = self.done.outcome.loops.iter().map(|found| {
            let row = PyDict::new(py);
            row.set_item("frame", found.frame)?;
            row.set_item("matched_frame", found.matched_frame)?;
            let (state, reason) = match &found.result {
                LoopResult::Closed { inliers, moved_m, turned_deg, joined } => {
                    row.set_item("inliers", *inliers)?;
                    row.set_item("moved_m", *moved_m)?;
                    row.set_item("turned_deg", *turned_deg)?;
                    row.set_item("joined", *joined)?;
                    ("closed", None)
                }
                LoopResult::Rejected(reason) => ("rejected", Some(reason.clone())),
                LoopResult::Refused(reason) => ("refused", Some(reason.clone())),
                LoopResult::TakenBack { by } => {
                    ("taken back", Some(format!("the loop from frame {by} contradicts it")))
                }
            };
            row.set_item("state", state)?;
            row.set_item("reason", reason)?;
            Ok(row)
        });
        PyList::new(py, rows.collect::<PyResult<Vec<_>>>()?)
    }

    #[getter]
    fn map(&self) -> Map {
        Map(self.done.outcome.map.clone())
    }

    #[getter]
    fn evaluation<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.evaluation.as_ref().map(|text| py.import("json")?.call_method1("loads", (text,))).transpose()
    }

    pub(crate) fn save(&self, py: Python<'_>, file: PathBuf) -> PyResult<String> {
        py.detach(|| self.done.save_map(&file)).map_err(raised)
    }

    fn save_mcap(&self, py: Python<'_>, file: PathBuf) -> PyResult<()> {
        py.detach(|| self.done.save_mcap(&file)).map_err(raised)
    }

    #[pyo3(signature = (file, format="tum", *, body=false))]
    fn save_trajectory(&self, file: PathBuf, format: &str, body: bool) -> PyResult<()> {
        let clock = &self.done.clock;
        match format {
            "tum" => io::write_tum_at(&file, &self.poses(body), clock).map_err(raised),
            "kitti" if !body => {
                let frames = of_largest(&self.done.outcome.frames);
                io::write_kitti(&file, &pose_per_frame(&frames)).map_err(raised)
            }
            "euroc" => io::write_euroc_at(&file, &self.poses(body), clock).map_err(raised),
            "kitti" => Err(PyValueError::new_err("body: KITTI's format has poses of the camera only")),
            _ => Err(PyValueError::new_err(format!(
                "format: found {format:?}, expected \"tum\", \"kitti\" or \"euroc\""
            ))),
        }
    }

    fn __repr__(&self) -> String {
        let map = &self.done.outcome.map;
        let (tracked, frames) = (self.n_tracked(), self.n_frames());
        let lost =
            self.done.outcome.frames.iter().filter(|f| matches!(f.status, FrameStatus::Lost(_))).count();
        format!(
            "Finished({tracked} of {frames} frames with a pose, {lost} lost, {} keyframes, {} points)",
            map.n_keyframes(),
            map.n_points()
        )
    }
}
