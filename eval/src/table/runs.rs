//! Every run on a line of its own: counts, errors, times, memory.

use super::build::value;
use super::{Cell, Row, Table};
use crate::baseline::Metric;
use crate::evaluation::Evaluation;
use crate::suite::{Results, RunResult, RunSummary};

/// Head of a column, and what stands in it.
type Column<T> = (&'static str, fn(&Run<'_>) -> T);

/// What columns are made of.
struct Run<'a> {
    run: &'a RunResult,
    summary: RunSummary,
    evaluation: Option<&'a Evaluation>,
}

impl<'a> Run<'a> {
    fn of(run: &'a RunResult) -> Self {
        let summary = run.summary.clone().unwrap_or_default();
        Self { run, summary, evaluation: run.evaluation.as_ref() }
    }
}

/// The columns of [`runs_table`].
const COLUMNS: [Column<Cell>; 13] = [
    ("frames", |r| count(r.summary.frames)),
    ("lost", |r| count(r.summary.lost)),
    ("not ready", |r| count(r.summary.not_ready)),
    ("dropped", |r| count(r.summary.dropped)),
    ("ATE [m]", |r| Cell::number(value(r.run, Metric::AteRmseM), 3)),
    ("t_rel [%]", |r| Cell::number(value(r.run, Metric::TRelPercent), 4)),
    ("r_rel [deg/100 m]", |r| Cell::number(value(r.run, Metric::RRelDegPer100m), 4)),
    ("keyframes", |r| count(r.summary.keyframes)),
    ("points", |r| count(r.summary.points)),
    ("loops", |r| count(r.summary.loops)),
    ("track [ms]", |r| Cell::number(r.summary.track_ms_median, 1)),
    ("wall [s]", |r| Cell::number(r.summary.wall_s, 1)),
    ("memory [MB]", |r| Cell::number(r.summary.peak_rss_mb, 0)),
];

fn count(value: Option<usize>) -> Cell {
    Cell::number(value.map(|v| v as f64), 0)
}

/// All runs with their counts and times.
pub fn runs_table(results: &Results) -> Table {
    let row = |run: &RunResult| {
        let cells = COLUMNS.map(|(_, cell)| cell(&Run::of(run))).to_vec();
        Row { name: run.id.to_string(), cells }
    };
    let note = |run: &RunResult| run.problem().map(|problem| format!("{}: {problem}", run.id));
    Table {
        title: format!("{}: runs", results.plan.name),
        corner: "run".to_owned(),
        columns: COLUMNS.map(|(head, _)| head.to_owned()).to_vec(),
        rows: results.runs.iter().map(row).collect(),
        n_summary_rows: 0,
        notes: results.runs.iter().filter_map(note).collect(),
    }
}

/// The columns of [`runs_csv`].
const FIELDS: [Column<Option<String>>; 34] = [
    ("sequence", |r| text(&r.run.id.sequence)),
    ("configuration", |r| text(&r.run.id.configuration)),
    ("repeat", |r| text(r.run.id.repeat)),
    ("state", |r| text(state(r.run))),
    ("frames", |r| text(r.summary.frames?)),
    ("lost", |r| text(r.summary.lost?)),
    ("not_ready", |r| text(r.summary.not_ready?)),
    ("dropped", |r| text(r.summary.dropped?)),
    ("coverage_percent", |r| text(coverage_percent(&r.summary)?)),
    ("alignment", |r| r.evaluation.map(|e| e.alignment.to_string()).or(r.summary.alignment.clone())),
    ("association", |r| text(&r.evaluation?.association)),
    ("poses_used", |r| text(r.evaluation?.n_used)),
    ("ate_rmse_m", |r| text(value(r.run, Metric::AteRmseM)?)),
    ("ate_mean_m", |r| text(r.evaluation?.ate_m.mean)),
    ("ate_median_m", |r| text(r.evaluation?.ate_m.median)),
    ("ate_max_m", |r| text(r.evaluation?.ate_m.max)),
    ("t_rel_percent", |r| text(value(r.run, Metric::TRelPercent)?)),
    ("t_rms_percent", |r| text(r.evaluation?.t_rms_percent?)),
    ("t_std_percent", |r| text(r.evaluation?.t_std_percent?)),
    ("r_rel_deg_per_100m", |r| text(value(r.run, Metric::RRelDegPer100m)?)),
    ("segments", |r| text(r.evaluation?.n_segments)),
    ("rpe_rmse_m", |r| text(r.evaluation?.rpe_m?.rmse)),
    ("rpe_rmse_deg", |r| text(r.evaluation?.rpe_deg?.rmse)),
    ("scale_drift_percent_per_100m", |r| text(r.evaluation?.scale_drift_percent_per_100m?)),
    ("auc", |r| text(value(r.run, Metric::Auc)?)),
    ("keyframes", |r| text(r.summary.keyframes?)),
    ("points", |r| text(r.summary.points?)),
    ("loops", |r| text(r.summary.loops?)),
    ("track_ms_median", |r| text(r.summary.track_ms_median?)),
    ("wall_s", |r| text(r.summary.wall_s?)),
    ("cpu_s", |r| text(r.summary.cpu_s?)),
    ("peak_rss_mb", |r| text(r.summary.peak_rss_mb?)),
    ("trajectory_sha256", |r| r.summary.trajectory_sha256.clone()),
    ("version", |r| r.summary.version.clone()),
];

fn text(value: impl ToString) -> Option<String> {
    Some(value.to_string())
}

fn state(run: &RunResult) -> &'static str {
    match (&run.record, run.is_done()) {
        (None, _) => "pending",
        (Some(_), true) => "done",
        (Some(_), false) => "failed",
    }
}

fn coverage_percent(s: &RunSummary) -> Option<f64> {
    let n = s.frames.filter(|&n| n > 0)?;
    Some(100.0 * n.saturating_sub(s.n_without_pose()) as f64 / n as f64)
}

/// One line per run with every number in full precision, for other programs.
pub fn runs_csv(results: &Results) -> String {
    let line = |run: &RunResult| FIELDS.map(|(_, field)| field(&Run::of(run)).unwrap_or_default()).join(",");
    let lines = std::iter::once(FIELDS.map(|(head, _)| head).join(",")).chain(results.runs.iter().map(line));
    lines.map(|line| line + "\n").collect()
}
