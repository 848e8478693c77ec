//! Files and report of `dsslam places`.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::Result;
use eval::LoopTruth;
use eval::plot::{PrecisionRecallFigure, save};

use super::Outcome;

/// Writes `places.csv`, `curves.csv` and the figure.
pub(super) fn files(folder: &Path, sequence: &str, outcomes: &[Outcome]) -> Result<()> {
    io::write_atomic(&folder.join("places.csv"), answers(outcomes).as_bytes())?;
    io::write_atomic(&folder.join("curves.csv"), curves(outcomes).as_bytes())?;
    let curves = outcomes.iter().map(|o| (o.selection.to_string(), o.by_error.clone())).collect();
    let title = format!("Place recognition: {sequence}");
    save(folder, "precision_recall", &PrecisionRecallFigure { title, curves })
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

/// A line per selection.
pub(super) fn report(outcomes: &[Outcome], truth: &LoopTruth, folder: &Path) -> String {
    let mut text = format!(
        "{} frames, {} show a place again\n{:<10} {:>10} {:>10} {:>13} {:>20} {:>15}\n",
        truth.n_frames(),
        truth.n_queries(),
        "selection",
        "verified",
        "AUC",
        "AUC (inliers)",
        "recall at 100 % prec.",
        "retrieved right"
    );
    for o in outcomes {
        let right = o.answers.iter().filter(|a| a.is_correct).count() as f64 / truth.n_queries() as f64;
        let _ = writeln!(
            text,
            "{:<10} {:>10} {:>10.4} {:>13.4} {:>20.1}% {:>14.1}%",
            o.selection.to_string(),
            o.by_error.n_detections,
            o.by_error.auc,
            o.by_inliers.auc,
            100.0 * o.by_error.recall_at_full_precision,
            100.0 * right
        );
    }
    let _ = writeln!(text, "written to {}", folder.display());
    text
}
