//! Errors of a trajectory against its ground truth.

use std::path::PathBuf;

use eval::{Alignment, Association, Estimate, Evaluation, EvaluationOptions, TIMESTAMP_TOLERANCE_S};
use io::{StampedPose, Stamps, Trajectory};
use numpy::{PyReadonlyArray1, PyReadonlyArray3};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use crate::arguments;
use crate::error::raised;
use crate::finished::Finished;
use crate::poses;

/// A trajectory as Python gives it, and whether its stamps are times.
fn trajectory(given: &Bound<'_, PyAny>, name: &str) -> PyResult<(Trajectory, bool)> {
    if let Ok(finished) = given.cast::<Finished>() {
        return Ok((finished.get().poses(false), true));
    }
    if let Ok((times, matrices)) = given.extract::<(PyReadonlyArray1<'_, f64>, PyReadonlyArray3<'_, f64>)>() {
        let (times, poses) = (times.as_array().to_vec(), poses::of_array(&matrices, name)?);
        if times.len() != poses.len() || !times.is_sorted() {
            let (n_times, n_poses) = (times.len(), poses.len());
            return Err(PyValueError::new_err(format!(
                "{name}: found {n_times} times and {n_poses} poses, expected as many of both, sorted by time"
            )));
        }
        let stamped = times.into_iter().zip(poses);
        let poses = stamped.map(|(timestamp_s, world_from_cam)| StampedPose { timestamp_s, world_from_cam });
        return Ok((Trajectory { poses: poses.collect() }, true));
    }
    let Ok(file) = given.extract::<PathBuf>() else {
        let found = given.get_type().name()?;
        return Err(PyTypeError::new_err(format!(
            "{name}: found {found}, expected a file, a pair (times, poses) or what a run returns"
        )));
    };
    let read = io::read_trajectory(&file, None).map_err(raised)?;
    let has_times = read.stamps == Stamps::Times;
    Ok((read.trajectory, has_times))
}

/// ATE, drift and the rest of `est` against `gt`.
#[pyfunction]
#[pyo3(signature = (est, gt, *, alignment="se3", lengths_m=None))]
pub(crate) fn evaluate<'py>(
    py: Python<'py>,
    est: &Bound<'py, PyAny>,
    gt: &Bound<'py, PyAny>,
    alignment: &str,
    lengths_m: Option<Vec<f64>>,
) -> PyResult<Bound<'py, PyAny>> {
    let alignments = [("se3", Alignment::Se3), ("sim3", Alignment::Sim3), ("none", Alignment::None)];
    let alignment = arguments::choice("alignment", alignment, alignments)?;
    let (est, est_has_times) = trajectory(est, "est")?;
    let (gt, gt_has_times) = trajectory(gt, "gt")?;
    let association = if est_has_times && gt_has_times {
        Association::Timestamp { tolerance_s: TIMESTAMP_TOLERANCE_S }
    } else {
        Association::Index
    };
    let mut options = EvaluationOptions { alignment, association, ..EvaluationOptions::default() };
    if let Some(lengths_m) = lengths_m {
        options.lengths_m = lengths_m;
    }
    let estimate = Estimate::new(est.poses.iter().map(|pose| (pose.timestamp_s, Some(pose.world_from_cam))));
    let estimate = Estimate { has_times: est_has_times, ..estimate };
    let evaluation = py
        .detach(|| Evaluation::of(&estimate, &gt, &options).map_err(|error| format!("{error:#}")))
        .map_err(raised)?;
    let text = serde_json::to_string(&evaluation).map_err(raised)?;
    py.import("json")?.call_method1("loads", (text,))
}
