//! One table per metric: rows are sequences, columns our configurations and the published baselines.

use super::{Cell, Row, Table};
use crate::alignment::Alignment;
use crate::baseline::{Baseline, Metric};
use crate::drift::KITTI_LENGTHS_M;
use crate::statistics::median;
use crate::suite::{Results, RunResult, SequencePlan};

/// The table of one metric; `None` when no run has it and there is nothing to compare with.
///
/// Several repeats: the median, with the smallest and the largest in brackets when they differ.
pub fn metric_table(results: &Results, baselines: &[Baseline], metric: Metric) -> Option<Table> {
    let sequences: Vec<&str> = results.plan.sequences.iter().map(|s| s.name.as_str()).collect();
    let baselines = baselines_for(results, baselines, metric);
    let ours = results.plan.configurations.iter();
    let mut columns: Vec<Column> =
        ours.map(|configuration| our_column(results, &configuration.name, &sequences, metric)).collect();
    let have_none = columns.iter().all(|c| c.values.iter().all(Option::is_none));
    // Runs without place recognition need no empty table of it; for the others an empty column says that all failed.
    if have_none && (baselines.is_empty() || metric == Metric::Auc) {
        return None;
    }
    let (comparable, reasons) = comparable_sequences(results, &baselines, metric);
    let baselines = if comparable.iter().all(Option::is_none) { Vec::new() } else { baselines };
    columns.extend(baselines.iter().map(|baseline| baseline_column(baseline, &comparable, metric)));
    let cells = |i: usize| columns.iter().map(|column| column.cells[i].clone()).collect();
    let row = |(i, name): (usize, &&str)| Row { name: (*name).to_owned(), cells: cells(i) };
    let mut rows: Vec<Row> = sequences.iter().enumerate().map(row).collect();
    let mut n_summary_rows = 0;
    if sequences.len() > 1 {
        rows.push(mean_row(&columns, sequences.len()));
        n_summary_rows = 1;
        if let Some(row) = pooled_row(results, &columns, metric) {
            rows.push(row);
            n_summary_rows = 2;
        }
    }
    // Pooled figures are over different segments where runs failed: none of them is marked.
    rows.iter_mut().filter(|row| row.name != "pooled").for_each(|row| mark_best(row, metric));
    let mut notes: Vec<String> = columns.iter().flat_map(|c| c.notes.iter().cloned()).collect();
    notes.extend(reasons);
    notes.extend(baselines.iter().map(|b| format!("{}: {}", b.name, b.source)));
    Some(Table {
        title: format!("{}: {}", results.plan.name, metric.label()),
        corner: "sequence".to_owned(),
        columns: columns.iter().map(|c| c.head.clone()).collect(),
        rows,
        n_summary_rows,
        notes,
    })
}

/// Baselines of the suite's dataset and of a sensor that the suite uses, with a value for one of its sequences.
pub fn baselines_for<'a>(results: &Results, baselines: &'a [Baseline], metric: Metric) -> Vec<&'a Baseline> {
    let plan = &results.plan;
    let fits_sensor = |b: &Baseline| {
        b.sensor == "any"
            || plan.configurations.iter().any(|c| c.sensor.is_none_or(|sensor| sensor.word() == b.sensor))
    };
    let fits = |b: &&Baseline| {
        plan.dataset.as_deref() == Some(&b.dataset)
            && fits_sensor(b)
            && plan.sequences.iter().any(|s| b.value(metric, &s.name).is_some())
    };
    baselines.iter().filter(fits).collect()
}

#[derive(Default)]
struct Column {
    head: String,
    cells: Vec<Cell>,
    values: Vec<Option<f64>>,
    notes: Vec<String>,
    is_ours: bool,
}

fn our_column(results: &Results, configuration: &str, sequences: &[&str], metric: Metric) -> Column {
    let mut column = Column { head: configuration.to_owned(), is_ours: true, ..Column::default() };
    for sequence in sequences {
        let repeats = results.repeats(sequence, configuration);
        let values: Vec<f64> = repeats.iter().filter_map(|run| value(run, metric)).collect();
        let mut cell = Cell::number(median(&values), digits(metric));
        let (low, high) =
            values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| (l.min(v), h.max(v)));
        let d = digits(metric);
        if values.len() > 1 && format!("{low:.d$}") != format!("{high:.d$}") {
            cell.text = format!("{} [{low:.d$}, {high:.d$}]", cell.text);
        }
        for run in &repeats {
            note_run(run, &mut cell, &mut column.notes);
        }
        column.values.push(cell.value);
        column.cells.push(cell);
    }
    let uses_sim3 =
        |run: &&RunResult| run.evaluation.as_ref().is_some_and(|e| e.alignment == Alignment::Sim3);
    if results.runs.iter().filter(|r| r.id.configuration == configuration).any(|r| uses_sim3(&r)) {
        column.head += " (after Sim3)";
    }
    column
}

/// Marks lost frames and failures in the cell and explains them below the table.
fn note_run(run: &RunResult, cell: &mut Cell, notes: &mut Vec<String>) {
    if let Some(problem) = run.problem() {
        notes.push(format!("{}: {problem}", run.id));
        if cell.value.is_none() {
            cell.text = if run.record.is_some() { "failed".to_owned() } else { "-".to_owned() };
        }
    }
    let Some(summary) = &run.summary else { return };
    let n_without = summary.n_without_pose();
    if let (true, Some(frames)) = (n_without > 0, summary.frames) {
        cell.has_lost_frames = true;
        let percent = 100.0 * (frames.saturating_sub(n_without)) as f64 / frames.max(1) as f64;
        notes.push(format!(
            "\u{2020} {}: {n_without} of {frames} frames without a pose of their own (coverage {percent:.2} %)",
            run.id
        ));
    }
}

/// Sequences that ran as the published figures were made (`None` for the others), and why the others did not: cut short,
/// or drift over other segment lengths.
fn comparable_sequences<'a>(
    results: &'a Results,
    baselines: &[&Baseline],
    metric: Metric,
) -> (Vec<Option<&'a str>>, Vec<String>) {
    let plan = &results.plan;
    let is_drift = matches!(metric, Metric::TRelPercent | Metric::RRelDegPer100m);
    if baselines.is_empty() {
        return (vec![None; plan.sequences.len()], Vec::new());
    }
    if is_drift && plan.lengths_m != KITTI_LENGTHS_M {
        let reason =
            "other segment lengths than 100 to 800 m: no published figure to compare with".to_owned();
        return (vec![None; plan.sequences.len()], vec![reason]);
    }
    let mut reasons = Vec::new();
    let check = |sequence: &'a SequencePlan| {
        let run = results.runs.iter().filter(|r| r.id.sequence == sequence.name);
        let frames = run.filter_map(|r| r.summary.as_ref()?.frames).max();
        let whole = baselines.iter().find_map(|b| b.frames.get(&sequence.name)).copied();
        let is_cut = match (frames, whole) {
            (Some(frames), Some(whole)) => frames < whole,
            _ => sequence.max_frames.is_some(),
        };
        if !is_cut {
            return Some(sequence.name.as_str());
        }
        let of = whole.map(|n| format!(" of {n}")).unwrap_or_default();
        let shown = frames.map_or_else(|| "not all".to_owned(), |n| n.to_string());
        reasons.push(format!("{}: {shown}{of} frames: no published figure to compare with", sequence.name));
        None
    };
    (plan.sequences.iter().map(check).collect(), reasons)
}

fn baseline_column(baseline: &Baseline, sequences: &[Option<&str>], metric: Metric) -> Column {
    let values: Vec<Option<f64>> = sequences.iter().map(|s| baseline.value(metric, (*s)?)).collect();
    let cells = values
        .iter()
        .map(|&value| Cell { text: published(value, metric), value, ..Cell::default() })
        .collect();
    Column { head: baseline.name.clone(), cells, values, ..Column::default() }
}

/// As many digits as were published: shortest form, trailing zeros of the metric's usual precision kept.
fn published(value: Option<f64>, metric: Metric) -> String {
    let Some(value) = value else { return "-".to_owned() };
    let usual = match metric {
        Metric::TRelPercent | Metric::RRelDegPer100m => 2,
        Metric::AteRmseM => 1,
        Metric::Auc => 3,
    };
    let shortest = value.to_string();
    let decimals = shortest.split_once('.').map_or(0, |(_, d)| d.len());
    format!("{value:.digits$}", digits = decimals.max(usual))
}

/// The metric of one run: of the evaluation, else of the program's own summary.
pub(crate) fn value(run: &RunResult, metric: Metric) -> Option<f64> {
    let (e, s) = (run.evaluation.as_ref(), run.summary.as_ref());
    match metric {
        Metric::TRelPercent => e.map_or_else(|| s?.t_rel_percent, |e| e.t_rel_percent),
        Metric::RRelDegPer100m => e.map_or_else(|| s?.r_rel_deg_per_100m, |e| e.r_rel_deg_per_100m),
        Metric::AteRmseM => e.map_or_else(|| s?.ate_rmse_m, |e| Some(e.ate_m.rmse)),
        Metric::Auc => run.precision_recall().ok().flatten().map(|curve| curve.auc),
    }
}

fn digits(metric: Metric) -> usize {
    match metric {
        Metric::TRelPercent | Metric::RRelDegPer100m => 4,
        Metric::AteRmseM | Metric::Auc => 3,
    }
}

/// Mean of the sequences that have a value; how many, where some have none.
fn mean_row(columns: &[Column], n_sequences: usize) -> Row {
    let cells = columns.iter().map(|column| {
        let values: Vec<f64> = column.values.iter().flatten().copied().collect();
        if values.is_empty() {
            return Cell::text("-");
        }
        let mut cell = Cell::number(Some(values.iter().sum::<f64>() / values.len() as f64), 4);
        if values.len() < n_sequences {
            cell.text = format!("{} ({} of {n_sequences})", cell.text, values.len());
            // A mean over fewer sequences does not compete.
            cell.value = None;
        }
        cell
    });
    Row { name: "mean".to_owned(), cells: cells.collect() }
}

/// All segments of all sequences in one pot, as the KITTI benchmark ranks; first repeats.
fn pooled_row(results: &Results, columns: &[Column], metric: Metric) -> Option<Row> {
    if !matches!(metric, Metric::TRelPercent | Metric::RRelDegPer100m) {
        return None;
    }
    let cells = columns.iter().map(|column| {
        if !column.is_ours {
            return Cell::text("-");
        }
        let name = column.head.trim_end_matches(" (after Sim3)");
        let (mut sum, mut n) = (0.0, 0.0);
        for run in results.runs.iter().filter(|r| r.id.configuration == name && r.id.repeat == 1) {
            if let (Some(e), Some(v)) = (&run.evaluation, value(run, metric)) {
                sum += v * e.n_segments as f64;
                n += e.n_segments as f64;
            }
        }
        let mut cell = Cell::number((n > 0.0).then(|| sum / n), 4);
        if n > 0.0 {
            cell.text = format!("{} ({n} segments)", cell.text);
        }
        cell
    });
    Some(Row { name: "pooled".to_owned(), cells: cells.collect() })
}

fn mark_best(row: &mut Row, metric: Metric) {
    let sign = if metric.larger_is_better() { -1.0 } else { 1.0 };
    let values: Vec<f64> = row.cells.iter().filter_map(|c| c.value).map(|v| sign * v).collect();
    if values.len() < 2 {
        return;
    }
    let best = values.iter().copied().fold(f64::INFINITY, f64::min);
    for cell in &mut row.cells {
        cell.is_best = cell.value.is_some_and(|v| sign * v == best);
    }
}
