//! Position error along the path.

use anyhow::{Result, ensure};
use geometry::Vec3;

use super::axes::{Axes, Frame, Key, Margin, header, range};
use super::canvas::{Canvas, INK, PALETTE};

/// Position error of each frame over the true path traveled: aligned positions `estimate` against `ground_truth`, meters, element by
/// element; `None` where the frame was lost.
///
/// # Errors
/// No frame has a pose.
pub fn error(title: &str, estimate: &[Option<Vec3>], ground_truth: &[Vec3]) -> Result<Canvas> {
    let mut traveled = 0.0;
    let mut points = Vec::with_capacity(ground_truth.len());
    for (i, (est, gt)) in estimate.iter().zip(ground_truth).enumerate() {
        traveled += if i > 0 { (gt - ground_truth[i - 1]).norm() } else { 0.0 };
        points.push((traveled, est.map(|e| (e - gt).norm())));
    }
    let errors: Vec<f64> = points.iter().filter_map(|p| p.1).collect();
    ensure!(!errors.is_empty(), "no frame has a pose: no error to draw");
    let rmse = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    let rmse_name = format!("RMSE {rmse:.3} m");
    let keys = [
        Key { text: "position error", color: PALETTE[1], width: 2.5 },
        Key { text: &rmse_name, color: INK, width: 1.5 },
    ];
    let mut canvas = Canvas::new(800, 420)?;
    let top = header(&mut canvas, title, &keys);
    let axes = Axes {
        frame: Frame::below(top, &canvas),
        x: range(points.iter().map(|p| p.0), Margin::Tight),
        y: range(errors.iter().copied(), Margin::FromZero),
    };
    axes.draw(&mut canvas, "path traveled [m]", "position error [m]");
    canvas.line(&[axes.at(axes.x.0, rmse), axes.at(axes.x.1, rmse)], INK, 1.5);
    for run in points.split(|p| p.1.is_none()) {
        let pixels: Vec<(f64, f64)> = run.iter().filter_map(|&(x, y)| Some(axes.at(x, y?))).collect();
        canvas.line(&pixels, PALETTE[1], 2.5);
    }
    Ok(canvas)
}
