//! A results folder read back: the plan, and what there is of each run.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use super::plan::{Plan, RunId};
use super::record::{RunRecord, RunState, RunSummary, read_json};
use crate::detections::read_detections;
use crate::evaluation::Evaluation;
use crate::precision_recall::{PrecisionRecallCurve, precision_recall};

/// Everything known of a suite's runs.
#[derive(Clone, Debug)]
pub struct Results {
    /// The folder.
    pub folder: PathBuf,
    /// What was to be run.
    pub plan: Plan,
    /// All runs of the plan, in its order.
    pub runs: Vec<RunResult>,
}

/// What there is of one run.
#[derive(Clone, Debug)]
pub struct RunResult {
    /// Which run.
    pub id: RunId,
    /// Its folder.
    pub folder: PathBuf,
    /// How it ended; `None` while it has not.
    pub record: Option<RunRecord>,
    /// The program's numbers.
    pub summary: Option<RunSummary>,
    /// Figures against the ground truth; `None` without ground truth, and for runs of versions that wrote others.
    pub evaluation: Option<Evaluation>,
}

impl RunResult {
    /// Whether it ended with a result.
    pub fn is_done(&self) -> bool {
        self.record.as_ref().is_some_and(|r| r.state == RunState::Done)
    }

    /// Curve of the run's place recognition, if its folder holds a `detections.csv`.
    ///
    /// # Errors
    /// The file cannot be parsed.
    pub fn precision_recall(&self) -> Result<Option<PrecisionRecallCurve>> {
        let path = self.folder.join("detections.csv");
        if !path.is_file() {
            return Ok(None);
        }
        let (detections, n_events) = read_detections(&path)?;
        precision_recall(&detections, n_events).map(Some).with_context(|| format!("{}", path.display()))
    }

    /// Why there is no result, or none to compare; `None` when all is well.
    pub fn problem(&self) -> Option<String> {
        match &self.record {
            None => Some("has not been run".to_owned()),
            Some(RunRecord { state: RunState::Failed { reason }, .. }) => Some(format!("failed: {reason}")),
            Some(RunRecord { evaluation_problem: Some(problem), .. }) => {
                Some(format!("cannot be evaluated: {problem}"))
            }
            Some(_) => {
                let is_compared = self.summary.as_ref().is_some_and(|summary| summary.ate_rmse_m.is_some());
                (is_compared && self.evaluation.is_none()).then(|| {
                    "no evaluation.json of this version, so the figures are those of summary.json".to_owned()
                })
            }
        }
    }
}

impl Results {
    /// Reads the results folder of a suite.
    ///
    /// # Errors
    /// The folder holds no `suite.json`, or a file in it cannot be parsed.
    pub fn read(folder: &Path) -> Result<Results> {
        let plan_file = folder.join("suite.json");
        let plan: Plan = read_json(&plan_file)
            .with_context(|| format!("{} is not a results folder of 'dsslam eval run'", folder.display()))?;
        let runs: Result<Vec<RunResult>> = plan.runs().into_iter().map(|id| read_run(folder, id)).collect();
        Ok(Results { folder: folder.to_owned(), runs: runs?, plan })
    }

    /// Runs of one sequence and configuration, in order of repeats.
    pub fn repeats(&self, sequence: &str, configuration: &str) -> Vec<&RunResult> {
        self.runs
            .iter()
            .filter(|r| r.id.sequence == sequence && r.id.configuration == configuration)
            .collect()
    }
}

fn read_run(results: &Path, id: RunId) -> Result<RunResult> {
    let folder = id.folder(results);
    let record: Option<RunRecord> = read_optional(&folder.join("run.json"))?;
    // Files of a run that has not ended are not to be trusted.
    let is_done = record.as_ref().is_some_and(|r| r.state == RunState::Done);
    let (summary, evaluation) = if is_done {
        // One of an older version is not trusted: it may compare the left camera with the body.
        (read_optional(&folder.join("summary.json"))?, read_json(&folder.join("evaluation.json")).ok())
    } else {
        (None, None)
    };
    Ok(RunResult { id, folder, record, summary, evaluation })
}

fn read_optional<T: for<'a> serde::Deserialize<'a>>(path: &Path) -> Result<Option<T>> {
    if path.is_file() { read_json(path).map(Some) } else { Ok(None) }
}
