//! Files and report of `dsslam eval places`.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::Result;

use super::Outcome;
use eval::LoopTruth;
use eval::plot;

/// Writes `areas.csv`, `places.csv`, `curves.csv` and the figure.
pub(super) fn files(folder: &Path, sequence: &str, outcomes: &[Outcome], truth: &LoopTruth) -> Result<()> {
    io::write_atomic(&folder.join("areas.csv"), areas(outcomes, truth).as_bytes())?;
    io::write_atomic(&folder.join("places.csv"), answers(outcomes).as_bytes())?;
    io::write_atomic(&folder.join("curves.csv"), curves(outcomes).as_bytes())?;
    let curves: Vec<_> = outcomes.iter().map(|o| (o.selection.to_string(), o.by_error.clone())).collect();
    let title = format!("Place recognition: {sequence}");
    plot::save(folder, "precision_recall", &plot::precision_recall(&title, &curves)?)
}

/// A row per query and selection.
fn answers(outcomes: &[Outcome]) -> String {
    let mut text = String::from("selection,query,retrieved,correct,matches,inliers,mean_error_px\n");
    for outcome in outcomes {
        for a in &outcome.answers {
            let (name, correct) = (outcome.selection, u8::from(a.is_correct));
            // Writing to a string cannot fail.
            let _ = write!(text, "{name},{},{},{correct},", a.query, a.retrieved);
            let _ = match a.evidence {
                Some(e) => writeln!(text, "{},{},{:.4}", e.n_matches, e.n_inliers, e.mean_error_px),
                None => writeln!(text, ",,"),
            };
        }
    }
    text
}

/// A row per threshold and selection.
fn curves(outcomes: &[Outcome]) -> String {
    let mut text = String::from("selection,threshold_px,precision,recall\n");
    for outcome in outcomes {
        for p in &outcome.by_error.points {
            let _ =
                writeln!(text, "{},{:.4},{:.6},{:.6}", outcome.selection, p.threshold, p.precision, p.recall);
        }
    }
    text
}

/// A row per selection.
fn areas(outcomes: &[Outcome], truth: &LoopTruth) -> String {
    let mut text = String::from(
        "selection,frames,revisits,verified,retrieved_right,auc,recall_at_full_precision,auc_inliers,\
         recall_at_full_precision_inliers\n",
    );
    for o in outcomes {
        let (error, inliers) = (&o.by_error, &o.by_inliers);
        let (frames, revisits, verified) = (truth.n_frames(), truth.n_queries(), error.n_detections);
        let _ = writeln!(
            text,
            "{},{frames},{revisits},{verified},{},{:.6},{:.6},{:.6},{:.6}",
            o.selection,
            o.n_right(),
            error.auc,
            error.recall_at_full_precision,
            inliers.auc,
            inliers.recall_at_full_precision
        );
    }
    text
}

/// Two tables: what was retrieved, and the curves by both scores.
pub(super) fn report(outcomes: &[Outcome], truth: &LoopTruth, folder: &Path) -> String {
    let mut text = format!(
        "{} frames, {} show a place again\n\
         {:<10} {:>15} {:>9} | by epipolar error {:>27} | by inliers\n{:<36} | {:>8} {:>34} | {:>8} {:>34}\n",
        truth.n_frames(),
        truth.n_queries(),
        "selection",
        "retrieved right",
        "verified",
        "",
        "",
        "AUC",
        "recall at 100 % precision",
        "AUC",
        "recall at 100 % precision"
    );
    for o in outcomes {
        let right = 100.0 * o.n_right() as f64 / truth.n_queries() as f64;
        let name = o.selection.to_string();
        let _ = write!(text, "{name:<10} {right:>14.1}% {:>9}", o.by_error.n_detections);
        for curve in [&o.by_error, &o.by_inliers] {
            let recall = 100.0 * curve.recall_at_full_precision;
            let _ = write!(text, " | {:>8.4} {recall:>33.1}%", curve.auc);
        }
        text.push('\n');
    }
    let _ = writeln!(text, "written to {}", folder.display());
    text
}
