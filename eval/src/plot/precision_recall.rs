//! Precision over recall, one curve per method, with its area in the legend.

use anyhow::{Result, ensure};

use super::axes::{Axes, Frame, colored, header};
use super::canvas::{Canvas, color};
use crate::precision_recall::PrecisionRecallCurve;

/// Precision-recall curves, each with its name.
///
/// # Errors
/// No curve.
pub fn precision_recall(title: &str, curves: &[(String, PrecisionRecallCurve)]) -> Result<Canvas> {
    ensure!(!curves.is_empty(), "no precision-recall curve to draw");
    let names: Vec<String> =
        curves.iter().map(|(name, curve)| format!("{name} (AUC {:.3})", curve.auc)).collect();
    let mut canvas = Canvas::new(800, 760)?;
    let top = header(&mut canvas, title, &colored(names.iter().map(String::as_str), 2.5));
    let below = Frame::below(top, &canvas);
    let frame = Frame { width: below.height.min(685.0), height: below.height.min(685.0), ..below };
    // From 0.5 as in the paper's figure when nothing lies below.
    let lowest = curves.iter().flat_map(|c| &c.1.points).map(|p| p.precision).fold(1.0, f64::min);
    let low = if lowest > 0.5 { 0.5 } else { 0.0 };
    let axes = Axes { frame, x: (0.0, 1.0), y: (low, 1.0 + 0.02 * (1.0 - low)) };
    axes.draw(&mut canvas, "recall", "precision");
    for (i, (_, curve)) in curves.iter().enumerate() {
        let start = curve.points.first().map(|p| axes.at(0.0, p.precision));
        let others = curve.points.iter().map(|p| axes.at(p.recall, p.precision));
        canvas.line(&start.into_iter().chain(others).collect::<Vec<_>>(), color(i), 2.5);
    }
    Ok(canvas)
}
