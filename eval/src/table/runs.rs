//! Every run on a line of its own: counts, errors, times, memory.

use super::build::value;
use super::{Cell, Row, Table};
use crate::baseline::Metric;
use crate::suite::{Results, RunResult};

/// All runs with their counts and times.
pub fn runs_table(results: &Results) -> Table {
    let columns = [
        "frames",
        "lost",
        "not ready",
        "dropped",
        "ATE [m]",
        "t_rel [%]",
        "r_rel [deg/100 m]",
        "keyframes",
        "points",
        "loops",
        "track [ms]",
        "wall [s]",
        "memory [MB]",
    ];
    let mut notes = Vec::new();
    let rows = results.runs.iter().map(|run| {
        notes.extend(run.problem().map(|problem| format!("{}: {problem}", run.id)));
        Row { name: run.id.to_string(), cells: cells(run) }
    });
    let rows = rows.collect();
    Table {
        title: format!("{}: runs", results.plan.name),
        corner: "run".to_owned(),
        columns: columns.map(str::to_owned).to_vec(),
        rows,
        n_summary_rows: 0,
        notes,
    }
}

fn cells(run: &RunResult) -> Vec<Cell> {
    let s = run.summary.clone().unwrap_or_default();
    let count = |value: Option<usize>| Cell::number(value.map(|v| v as f64), 0);
    let metric = |m: Metric, digits| Cell::number(value(run, m), digits);
    vec![
        count(s.frames),
        count(s.lost),
        count(s.not_ready),
        count(s.dropped),
        metric(Metric::AteRmseM, 3),
        metric(Metric::TRelPercent, 4),
        metric(Metric::RRelDegPer100m, 4),
        count(s.keyframes),
        count(s.points),
        count(s.loops),
        Cell::number(s.track_ms_median, 1),
        Cell::number(s.wall_s, 1),
        Cell::number(s.peak_rss_mb, 0),
    ]
}

/// One line per run with every number in full precision, for other programs.
pub fn runs_csv(results: &Results) -> String {
    let mut text = String::from(
        "sequence,configuration,repeat,state,frames,lost,not_ready,dropped,coverage_percent,alignment,association,\
         poses_used,ate_rmse_m,ate_mean_m,ate_median_m,ate_max_m,t_rel_percent,t_rms_percent,t_std_percent,\
         r_rel_deg_per_100m,segments,rpe_rmse_m,rpe_rmse_deg,scale_drift_percent_per_100m,auc,keyframes,points,loops,\
         track_ms_median,wall_s,cpu_s,peak_rss_mb,trajectory_sha256,version\n",
    );
    for run in &results.runs {
        text.push_str(&csv_line(run).join(","));
        text.push('\n');
    }
    text
}

fn csv_line(run: &RunResult) -> Vec<String> {
    let s = run.summary.clone().unwrap_or_default();
    let e = run.evaluation.as_ref();
    let count = |value: Option<usize>| value.map(|v| v.to_string()).unwrap_or_default();
    let number = |value: Option<f64>| value.map(|v| v.to_string()).unwrap_or_default();
    let coverage =
        s.frames.filter(|&n| n > 0).map(|n| 100.0 * n.saturating_sub(s.n_without_pose()) as f64 / n as f64);
    let state = match (&run.record, run.is_done()) {
        (None, _) => "pending",
        (Some(_), true) => "done",
        (Some(_), false) => "failed",
    };
    vec![
        run.id.sequence.clone(),
        run.id.configuration.clone(),
        run.id.repeat.to_string(),
        state.to_owned(),
        count(s.frames),
        count(s.lost),
        count(s.not_ready),
        count(s.dropped),
        number(coverage),
        e.map(|e| e.alignment.to_string()).or(s.alignment.clone()).unwrap_or_default(),
        e.map(|e| e.association.clone()).unwrap_or_default(),
        count(e.map(|e| e.n_used)),
        number(value(run, Metric::AteRmseM)),
        number(e.map(|e| e.ate_m.mean)),
        number(e.map(|e| e.ate_m.median)),
        number(e.map(|e| e.ate_m.max)),
        number(value(run, Metric::TRelPercent)),
        number(e.and_then(|e| e.t_rms_percent)),
        number(e.and_then(|e| e.t_std_percent)),
        number(value(run, Metric::RRelDegPer100m)),
        count(e.map(|e| e.n_segments)),
        number(e.and_then(|e| e.rpe_m).map(|r| r.rmse)),
        number(e.and_then(|e| e.rpe_deg).map(|r| r.rmse)),
        number(e.and_then(|e| e.scale_drift_percent_per_100m)),
        number(value(run, Metric::Auc)),
        count(s.keyframes),
        count(s.points),
        count(s.loops),
        number(s.track_ms_median),
        number(s.wall_s),
        number(s.cpu_s),
        number(s.peak_rss_mb),
        s.trajectory_sha256.unwrap_or_default(),
        s.version.unwrap_or_default(),
    ]
}
