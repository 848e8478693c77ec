//! The report of a suite: one HTML file with its tables and figures, without anything to load.

use anyhow::Result;

use crate::baseline::{Baseline, Metric};
use crate::figures::NamedFigure;
use crate::plot::svg;
use crate::suite::Results;
use crate::table::{escape, metric_table, runs_table};

const STYLE: &str = include_str!("report.css");

/// The report's text. `problems`: what could not be drawn.
///
/// # Errors
/// A figure cannot be drawn.
pub fn html_report(
    results: &Results,
    baselines: &[Baseline],
    figures: &[NamedFigure],
    problems: &[String],
) -> Result<String> {
    let name = escape(&results.plan.name);
    let mut text = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>{name}</title>\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{name}</h1>\n"
    );
    text += &introduction(results);
    for metric in Metric::ALL {
        if let Some(table) = metric_table(results, baselines, metric) {
            text += &table.to_html();
        }
    }
    text += &runs_table(results).to_html();
    text += "<h2>Figures</h2>\n";
    for figure in figures {
        let caption = escape(&figure.caption);
        text +=
            &format!("<figure>\n{}\n<figcaption>{caption}</figcaption>\n</figure>\n", svg(&figure.figure)?);
    }
    if !problems.is_empty() {
        text += "<h2>Not drawn</h2>\n<ul>\n";
        problems.iter().for_each(|p| text += &format!("<li>{}</li>\n", escape(p)));
        text += "</ul>\n";
    }
    Ok(text + "</body>\n</html>\n")
}

/// What was run, and how the figures are defined.
fn introduction(results: &Results) -> String {
    let plan = &results.plan;
    let n_done = results.runs.iter().filter(|r| r.is_done()).count();
    let versions: Vec<&str> =
        results.runs.iter().filter_map(|r| r.summary.as_ref()?.version.as_deref()).collect();
    let version = versions.first().map(|v| format!(" of version {}", escape(v))).unwrap_or_default();
    let lengths: Vec<String> = plan.lengths_m.iter().map(f64::to_string).collect();
    format!(
        "<p>{n_done} of {} runs{version} have a result: {} sequences, {} configurations, {} repeats.</p>\n\
         <p>t_rel and r_rel: KITTI's drift over segments of {} m of the ground truth, starts at every tenth frame, no \
         alignment (monocular: after Sim3), lost frames filled with the last relative motion; <i>mean</i>: of the sequences, \
         <i>pooled</i>: over all segments. ATE: root mean square of positions after Umeyama's alignment over the frames with \
         a pose of their own. \u{2020}: frames were lost, counted below the table. Several repeats: median [smallest, \
         largest].</p>\n",
        results.runs.len(),
        plan.sequences.len(),
        plan.configurations.len(),
        plan.repeats,
        lengths.join(", ")
    )
}
