//! Precision over recall, one curve per method, with its area in the legend.

use anyhow::{Result, ensure};

use super::axes::{Axes, Frame, colored, header};
use super::canvas::{Canvas, Figure, color};
use crate::precision_recall::PrecisionRecallCurve;

/// Precision-recall curves.
#[derive(Clone, Debug)]
pub struct PrecisionRecallFigure {
    /// Title above the plot.
    pub title: String,
    /// Name and curve of each method.
    pub curves: Vec<(String, PrecisionRecallCurve)>,
}

impl Figure for PrecisionRecallFigure {
    fn size(&self) -> (u32, u32) {
        (800, 760)
    }

    fn draw(&self, canvas: &mut Canvas) -> Result<()> {
        ensure!(!self.curves.is_empty(), "no precision-recall curve to draw");
        let names: Vec<String> =
            self.curves.iter().map(|(name, curve)| format!("{name} (AUC {:.3})", curve.auc)).collect();
        let top = header(canvas, 800.0, &self.title, &colored(names.iter().map(String::as_str), 2.5));
        let height = 760.0 - top - 55.0;
        let frame = Frame { left: 90.0, top, width: height.min(685.0), height: height.min(685.0) };
        // From 0.5 as in the paper's figure when nothing lies below.
        let lowest = self.curves.iter().flat_map(|c| &c.1.points).map(|p| p.precision).fold(1.0, f64::min);
        let low = if lowest > 0.5 { 0.5 } else { 0.0 };
        let axes = Axes { frame, x: (0.0, 1.0), y: (low, 1.0 + 0.02 * (1.0 - low)) };
        axes.draw(canvas, "recall", "precision");
        for (i, (_, curve)) in self.curves.iter().enumerate() {
            let start = curve.points.first().map(|p| axes.at(0.0, p.precision));
            let pixels: Vec<(f64, f64)> = start
                .into_iter()
                .chain(curve.points.iter().map(|p| axes.at(p.recall, p.precision)))
                .collect();
            canvas.line(&pixels, color(i), 2.5);
        }
        Ok(())
    }
}
