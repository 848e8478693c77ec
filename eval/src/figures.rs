//! The figures of a suite's results, with their file names and captions.

use anyhow::{Context, Result};
use geometry::Vec3;

use crate::baseline::{Baseline, Metric};
use crate::drift::DriftBin;
use crate::plot::{self, Canvas, DriftAxis, View};
use crate::suite::{Results, RunPaths, RunResult};
use crate::table::{Row, metric_table};

/// A figure with its place.
pub struct NamedFigure {
    /// File name without extension.
    pub name: String,
    /// What it shows.
    pub caption: String,
    /// The figure.
    pub figure: Canvas,
}

/// All figures of the results: of the suite first, then of each run (first repeats); and what could not be drawn.
pub fn result_figures(results: &Results, baselines: &[Baseline]) -> (Vec<NamedFigure>, Vec<String>) {
    let parts = [bars(results, baselines), drifts(results), precision_recalls(results)];
    let first = results.runs.iter().filter(|run| run.id.repeat == 1 && run.is_done());
    let of_runs = first.map(|run| run_figures(results, run).with_context(|| run.id.to_string()));
    let (mut figures, mut problems) = (Vec::new(), Vec::new());
    for part in parts.into_iter().chain(of_runs) {
        match part {
            Ok(part) => figures.extend(part),
            Err(problem) => problems.push(format!("{problem:#}")),
        }
    }
    (figures, problems)
}

/// One chart per metric, from the same table that is printed.
fn bars(results: &Results, baselines: &[Baseline]) -> Result<Vec<NamedFigure>> {
    let chart = |metric: Metric| {
        let table = metric_table(results, baselines, metric)?;
        let has_values =
            |row: &&Row| row.name != "pooled" && row.cells.iter().any(|cell| cell.value.is_some());
        let rows: Vec<&Row> = table.rows.iter().filter(has_values).collect();
        let series: Vec<(String, Vec<Option<f64>>)> = table
            .columns
            .iter()
            .enumerate()
            .map(|(c, name)| (name.clone(), rows.iter().map(|row| row.cells[c].value).collect()))
            .collect();
        series.iter().flat_map(|s| &s.1).flatten().next()?;
        let groups: Vec<String> = rows.iter().map(|row| row.name.clone()).collect();
        Some(plot::bars(&table.title, metric.label(), &groups, &series).map(|figure| NamedFigure {
            name: format!("bars_{}", metric.file_name()),
            caption: format!("{} of each sequence beside published results", metric.label()),
            figure,
        }))
    };
    Metric::ALL.into_iter().filter_map(chart).collect()
}

/// Drift by length and by speed, all sequences together, one curve per configuration.
fn drifts(results: &Results) -> Result<Vec<NamedFigure>> {
    let kinds =
        [("drift_length", DriftAxis::Length, "segment length"), ("drift_speed", DriftAxis::Speed, "speed")];
    let figure = |(name, axis, what): (&str, DriftAxis, &str)| {
        let curve = |configuration: &str| {
            let runs =
                results.runs.iter().filter(|r| r.id.configuration == configuration && r.id.repeat == 1);
            let evaluations = runs.filter_map(|r| r.evaluation.as_ref());
            let bins = evaluations
                .flat_map(|e| if axis == DriftAxis::Length { &e.per_length } else { &e.per_speed });
            pool(bins.copied().collect())
        };
        let names = results.plan.configurations.iter().map(|c| &c.name);
        let curves: Vec<_> =
            names.map(|name| (name.clone(), curve(name))).filter(|c| !c.1.is_empty()).collect();
        let title = format!("{}: drift by {what}, all sequences", results.plan.name);
        (!curves.is_empty()).then(|| {
            let caption = format!("Drift by {what}, segments of all sequences together");
            let figure = plot::drift(&title, axis, &curves)?;
            Ok(NamedFigure { name: name.to_owned(), caption, figure })
        })
    };
    kinds.into_iter().filter_map(figure).collect()
}

/// Bins at the same place merged, weighted by their segments.
fn pool(mut bins: Vec<DriftBin>) -> Vec<DriftBin> {
    bins.sort_by(|a, b| a.at.total_cmp(&b.at));
    let merged = bins.chunk_by(|a, b| a.at == b.at).map(|group| {
        let n: usize = group.iter().map(|b| b.n).sum();
        let mean =
            |value: fn(&DriftBin) -> f64| group.iter().map(|b| value(b) * b.n as f64).sum::<f64>() / n as f64;
        DriftBin {
            at: group[0].at,
            n,
            t_rel_percent: mean(|b| b.t_rel_percent),
            r_rel_deg_per_100m: mean(|b| b.r_rel_deg_per_100m),
        }
    });
    merged.collect()
}

/// One figure per sequence that has curves.
fn precision_recalls(results: &Results) -> Result<Vec<NamedFigure>> {
    let mut figures = Vec::new();
    for sequence in &results.plan.sequences {
        let mut curves = Vec::new();
        for run in results.runs.iter().filter(|r| r.id.sequence == sequence.name && r.id.repeat == 1) {
            if let Some(curve) = run.precision_recall()? {
                curves.push((run.id.configuration.clone(), curve));
            }
        }
        if !curves.is_empty() {
            let title = format!("{} {}: place recognition", results.plan.name, sequence.name);
            figures.push(NamedFigure {
                name: format!("precision_recall_{}", sequence.name),
                caption: format!("Precision over recall on {}", sequence.name),
                figure: plot::precision_recall(&title, &curves)?,
            });
        }
    }
    Ok(figures)
}

/// Name, caption and figure of a path seen from above and from the side, and of its error where there is a ground truth.
pub(crate) fn path_figures(
    title: &str,
    estimate: &[Option<Vec3>],
    ground_truth: &[Vec3],
) -> Result<Vec<(&'static str, &'static str, Canvas)>> {
    let path = |view| plot::trajectory(title, estimate, ground_truth, view);
    let mut figures = vec![("top", "top view", path(View::Top)?), ("side", "side view", path(View::Side)?)];
    if !ground_truth.is_empty() {
        let error = plot::error(title, estimate, ground_truth)?;
        figures.push(("error", "error along the path, after alignment", error));
    }
    Ok(figures)
}

/// Top view, side view and error of one run.
fn run_figures(results: &Results, run: &RunResult) -> Result<Vec<NamedFigure>> {
    let paths = RunPaths::of(run)?;
    let run_name = format!("{}_{}", run.id.sequence, run.id.configuration);
    let title = format!("{} {}, {}", results.plan.name, run.id.sequence, run.id.configuration);
    let named = |(what, caption, figure): (&str, &str, Canvas)| NamedFigure {
        name: format!("{run_name}_{what}"),
        caption: format!("{title}: {caption}"),
        figure,
    };
    Ok(path_figures(&title, &paths.estimate, &paths.ground_truth)?.into_iter().map(named).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pooling_weighs_by_segments() {
        let bin = |at, n, t| DriftBin { at, n, t_rel_percent: t, r_rel_deg_per_100m: 2.0 * t };
        let pooled = pool(vec![bin(200.0, 1, 1.0), bin(100.0, 5, 3.0), bin(200.0, 3, 2.0)]);
        assert_eq!(pooled, [bin(100.0, 5, 3.0), bin(200.0, 4, 1.75)]);
    }
}
